"""Pressure and shear along an outline, on exact flows and past a penalised cylinder."""

from __future__ import annotations

import math

import numpy as np
import pytest
from stokes_flows import Shaking, Twisting

from levelset.contour import contour, even
from levelset.shapes import Disk, Ellipse
from pmesh.bodies.control_volume import box_of, momentum_balance
from pmesh.bodies.traction import Traction, traction
from remesh.errors import InputError
from remesh.grid import Grid

NU, START, DT = 0.1, 0.4, 0.02
TIMES = (START, START + DT)


def mesh(nodes, reach=2.2):
    count = round(2 * reach * nodes) + 1
    return Grid((count, count), 1 / nodes, (-reach + 0.13 / nodes, -reach - 0.2 / nodes))


def circle(count, turn=0.0, center=(0.0, 0.0)):
    angle = 2 * np.pi * np.arange(count) / count + turn
    return np.stack([center[0] + np.cos(angle), center[1] + np.sin(angle)], axis=1)


def mean(law):
    """The mean of a law of time over the step."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    return sum(w * law(START + 0.5 * DT * (1 + x)) for x, w in zip(nodes, weights, strict=True)) / 2


def shaken(nodes, dtype=np.float64):
    """The law on a shaken cylinder, and the exact pressure, shear and force."""
    flow, grid, count = Shaking(1e-4, 1.0, NU), mesh(nodes), 12 * nodes
    points = grid.points()
    found = traction(
        tuple(circle(count, center=(1e-4 * math.sin(t), 0.0)) for t in TIMES),
        tuple(flow.velocity(points, t).astype(dtype) for t in TIMES),
        tuple(flow.vorticity(points, t).astype(dtype) for t in TIMES),
        grid, dt=DT, viscosity=NU, center=(0.1, 0.3),
        moving=tuple(np.tile([1e-4 * math.cos(t), 0.0], (count, 1)) for t in TIMES),
    )  # fmt: skip
    angle = 2 * np.pi * np.arange(count) / count
    return (
        found, mean(lambda t: flow.pressure(angle, t)), mean(lambda t: flow.shear(angle, t)),
        mean(flow.force),
    )  # fmt: skip


def test_a_shaken_cylinder_shows_stokes_pressure_and_shear_to_second_order():
    errors = []
    for nodes in (24, 48):
        found, pressure, shear, force = shaken(nodes)
        assert found.force[0] == pytest.approx(force, rel=25 / nodes**2)
        assert abs(found.force[1]) < 2e-3 * abs(force)
        assert found.torque == pytest.approx(0.3 * force, rel=25 / nodes**2)
        assert found.closure < 1e-3 * np.ptp(pressure)
        errors.append(
            [np.abs(found.pressure - pressure).max() / np.ptp(pressure),
             np.abs(found.shear - shear).max() / np.ptp(shear)]
        )  # fmt: skip
    assert max(errors[1]) < 3e-3
    assert np.log2(np.divide(*errors)).min() > 1.7


def test_single_precision_is_enough_for_the_drag():
    found, _, _, force = shaken(24, np.float32)
    assert found.force[0] == pytest.approx(force, rel=0.05)


@pytest.mark.parametrize("drift", [(0.0, 0.0), (1.0, -0.5)])
def test_a_spinning_cylinder_feels_the_torque_of_its_shear_at_rest_or_carried_along(drift):
    flow, grid, count, spin = Twisting(0.3, 0.0, NU), mesh(32, 2.6), 400, 0.3
    centers = [np.multiply(drift, t - START) for t in TIMES]
    points = [grid.points() - center[:, None, None] for center in centers]
    stream = np.reshape(drift, (2, 1, 1))
    found = traction(
        tuple(circle(count, spin * t, c) for t, c in zip(TIMES, centers, strict=True)),
        tuple(flow.velocity(p, START) + stream for p in points),
        tuple(flow.vorticity(p, START) for p in points),
        grid, dt=DT, viscosity=NU, center=0.5 * (centers[0] + centers[1]),
    )  # fmt: skip
    assert found.torque == pytest.approx(-4 * math.pi * NU * spin, rel=3e-3)
    assert np.abs(found.force).max() < 2e-3 * abs(found.torque)
    assert np.ptp(found.shear) < 2e-2 * np.abs(found.shear).mean()


@pytest.mark.parametrize("slopes", [((0.7, 0.0), (0.0, -0.7)), ((0.2, 1.1), (-0.4, -0.2))])
def test_matter_that_deforms_with_a_linear_flow_feels_its_stress(slopes):
    rate, grid = np.array(slopes), mesh(32)
    velocity = np.einsum("ij,jxy->ixy", rate, grid.points())
    vorticity = np.full(grid.shape, rate[1, 0] - rate[0, 1])
    middle = even(contour(Ellipse((1.2, 0.8), center=(0.3, -0.2)))[0], 1 / 64)
    squared = rate @ rate
    half = [np.eye(2) + s * DT / 2 * rate + DT**2 / 8 * squared for s in (-1, 1)]
    outline = tuple(middle @ step.T for step in half)
    found = traction(
        outline, (velocity, velocity), (vorticity, vorticity), grid, dt=DT, viscosity=NU,
        center=(0.3, -0.2), moving=tuple(points @ rate.T for points in outline),
    )  # fmt: skip
    points = found.points
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    shear = NU * np.einsum("ni,ij,nj->n", tangent, rate + rate.T, normal)
    np.testing.assert_allclose(found.shear, shear, atol=2e-3 * np.abs(shear).max())
    pressure = 0.5 * np.linalg.det(rate) * (points**2).sum(axis=1)
    gap = found.pressure - pressure
    assert np.ptp(gap) < 2e-3 * np.ptp(pressure)
    mass = math.pi * 1.2 * 0.8
    np.testing.assert_allclose(found.force, mass * squared @ (0.3, -0.2), rtol=3e-3, atol=1e-4)


def past_a_cylinder(until=1.5):
    """A penalised cylinder of 40 nodes across at Re = 40: two successive states, one mesh."""
    from pmesh.bodies.body import RigidBody
    from pmesh.vortex.flow import VortexFlow

    grid = Grid((160, 128), 1 / 20, (-2.8, -3.175))
    flow = VortexFlow(
        grid=grid, viscosity=0.05, freestream=(1.0, 0.0), bodies=(RigidBody(Disk(radius=1.0)),),
        domain="fixed",
    )  # fmt: skip
    last = state = flow.start()
    while state.time < until:
        last, state = state, flow.step(state, flow.limit(state).dt)
    return flow, last, state


def test_past_a_penalised_cylinder_all_routes_tell_one_drag():
    flow, last, state = past_a_cylinder()
    grid, dt = state.grid, state.time - last.time
    drag = flow.forces(state)["body0_force_x"]
    velocity = (flow.velocity(last), flow.velocity(state))
    vorticity = (last.vorticity, state.vorticity)
    bounds = ((-1.0, -1.0), (1.0, 1.0))
    box = box_of(bounds, bounds, [], grid)
    assert box is not None
    balance = momentum_balance(
        velocity, vorticity, grid, box, dt=dt, viscosity=0.05, center=(0.0, 0.0)
    )
    assert balance.force[0] == pytest.approx(drag, rel=1e-3)
    assert abs(balance.mismatch) < 1e-3 * drag
    outline = even(contour(Disk(radius=1.0))[0], 0.5 * grid.spacing)
    found = traction(
        (outline, outline), velocity, vorticity, grid, dt=dt, viscosity=0.05, center=(0.0, 0.0)
    )
    assert found.force[0] == pytest.approx(drag, rel=0.01)
    assert max(abs(found.force[1]), abs(found.torque)) < 1e-3 * drag
    assert found.points[np.argmax(found.pressure)] == pytest.approx((-1.0, 0.0), abs=0.1)


def test_even_points_are_evenly_spread_on_the_line():
    rough = contour(Ellipse((1.0, 0.5)))[0]
    points = even(rough, 0.02)
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert np.ptp(steps) < 1e-3 * steps.mean()
    assert steps.mean() == pytest.approx(0.02, rel=0.01)
    np.testing.assert_allclose(points[:, 0] ** 2 + 4 * points[:, 1] ** 2, 1, atol=1e-3)


def test_coefficients_are_over_the_dynamic_pressure():
    found = Traction(np.zeros((1, 2)), *np.ones((3, 1)), (0.0, 0.0), 0.0, 0.0)
    pressure, friction = found.coefficients(2.0)
    assert (pressure[0], friction[0]) == (0.5, 0.5)


def test_what_the_law_cannot_use_is_refused():
    grid, ring = mesh(12, 3.0), circle(40)
    field, scalar = np.zeros((2, *grid.shape)), np.zeros(grid.shape)

    def ask(first=ring, last=ring, u=field, mesh=grid, dt=0.1, **options):
        return traction(
            (first, last), (u, u), (scalar, scalar), mesh, dt=dt, viscosity=1.0, center=(0, 0),
            **options,
        )  # fmt: skip

    assert ask().force == (0.0, 0.0)
    with pytest.raises(InputError, match="law of the plane"):
        ask(mesh=Grid((8, 8, 8), 0.1))
    with pytest.raises(InputError, match="must run anticlockwise") as caught:
        ask(ring[::-1], ring[::-1])
    assert caught.value.hint == "points[::-1]"
    with pytest.raises(InputError, match="same points"):
        ask(last=ring[1:])
    with pytest.raises(InputError, match="nearer than 6 spacings and its lines to the edge"):
        ask(2.5 * ring, 2.5 * ring)
    with pytest.raises(InputError, match="must have the grid's shape"):
        ask(u=scalar)
    with pytest.raises(InputError, match="dt must be positive"):
        ask(dt=math.nan)
    with pytest.raises(InputError, match="at two positive distances"):
        ask(lines=(4.0,))
    with pytest.raises(InputError, match="moving must hold velocities"):
        ask(moving=(ring[1:], ring[1:]))
