"""The control volume: the load that momentum and the flow on a box's faces tell."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stokes_flows import Shaking, Twisting

from pmesh.bodies.control_volume import CLEAR, REACH, box_of, momentum_balance
from pmesh.vortex.exact.viscous import LambOseen, TaylorGreen
from remesh.errors import InputError
from remesh.grid import Grid

NU, START, DT = 0.1, 0.4, 0.02


def mesh(nodes, *, reach=2.2):
    """A mesh with so many nodes per unit length and the box two nodes inside its edges."""
    count = round(2 * reach * nodes) + 1
    grid = Grid((count, count), 1 / nodes, (-reach + 0.13 / nodes, -reach - 0.2 / nodes))
    return grid, (slice(2, count - 2), slice(3, count - 2))


def balance(flow, grid, box, *, center=(0.0, 0.0), dt=DT, frame=None, dtype=np.float64):
    """The law on an exact flow, seen from a frame that moves with a velocity along x."""
    points, times = grid.points(), (START, START + dt)
    velocity = [flow.velocity(points, time) for time in times]
    for field, time in zip(velocity, times, strict=True):
        field[0] -= 0.0 if frame is None else frame(time)
    vorticity = [flow.vorticity(points, time) for time in times]
    return momentum_balance(
        tuple(u.astype(dtype) for u in velocity),
        tuple(w.astype(dtype) for w in vorticity),
        grid, box, dt=dt, viscosity=NU, center=center,
    )  # fmt: skip


def mean(law, dt=DT):
    """The mean of a law of time over the step."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    return float(weights @ [law(START + 0.5 * dt * (1 + x)) for x in nodes]) / 2


def test_a_shaken_cylinder_feels_stokes_force_less_what_its_inside_takes():
    flow = Shaking(1e-7, 1.0, NU)
    force = mean(lambda t: flow.force(t) - math.pi * flow.acceleration(t))
    off = []
    for nodes in (12, 24, 48):
        found = balance(flow, *mesh(nodes), center=(0.1, 0.3))
        assert abs(found.force[1]) < 2e-3 * abs(force)
        assert found.torque == pytest.approx(0.3 * force, rel=30 / nodes**2)
        off.append(abs(found.force[0] / force - 1))
    assert off[-1] < 2e-4
    assert math.log2(off[1] / off[2]) > 1.8  # the kink of the velocity at the wall


def test_the_force_is_the_same_in_an_accelerated_frame():
    flow = Shaking(1e-7, 1.0, NU)
    grid, box = mesh(24)
    still = balance(flow, grid, box)
    moving = balance(flow, grid, box, frame=lambda t: 3e-7 * math.cos(t))
    taken = mean(lambda t: -3e-7 * math.sin(t)) * (box[0].stop - box[0].start - 1) / 24
    taken *= (box[1].stop - box[1].start - 1) / 24  # the fluid of the box, pushed by the pressure
    assert abs(taken) > abs(still.force[0])
    np.testing.assert_allclose(moving.force, still.force, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_a_twisted_cylinder_feels_the_torque_of_the_shear(rate):
    flow = Twisting(1e-7, rate, NU)
    torque = mean(lambda t: flow.torque(t) - math.pi / 2 * flow.acceleration(t))
    found = balance(flow, *mesh(24), center=(-0.2, 0.4))
    assert found.torque == pytest.approx(torque, rel=1e-6 if rate == 0 else 1e-3)
    if rate == 0:
        assert torque == pytest.approx(-4 * math.pi * NU * 1e-7)
    assert np.abs(found.force).max() < 1e-3 * abs(torque)


def passing(nodes, dt, dtype=np.float64):
    """Largest force, torque or mismatch of a box that a Lamb-Oseen vortex is leaving."""
    flow = LambOseen(core=0.5, viscosity=NU, drift=(1.0, 0.5), center=(0.5, 0.3))
    grid, _ = mesh(nodes, reach=2.0)
    cut = slice(nodes // 2, 3 * nodes + 1)
    found = balance(flow, grid, (cut, cut), dt=dt, dtype=dtype)
    return max(*np.abs(found.force), abs(found.torque), abs(found.mismatch))


def test_a_vortex_that_leaves_pushes_nothing_to_fourth_order_in_space_and_second_in_time():
    assert passing(16, 1e-3) < 3e-5
    assert passing(16, 1e-3, np.float32) < 2e-3
    assert abs(math.log2(passing(8, 1e-3) / passing(16, 1e-3)) - 4) < 0.2
    assert abs(math.log2(passing(32, 0.08) / passing(32, 0.04)) - 2) < 0.2


def test_a_box_anywhere_in_decaying_vortices_feels_nothing():
    flow = TaylorGreen(viscosity=NU)
    grid = Grid((64, 64), 1 / 64, boundary="periodic")
    box = (slice(5, 40), slice(9, 61))
    found = balance(flow, grid, box, dt=1e-3)
    assert max(*np.abs(found.force), abs(found.torque), abs(found.mismatch)) < 2e-4


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-1, 1), st.floats(-1, 1), st.floats(-2.5, 2.5), st.floats(-2.5, 2.5),
    st.integers(CLEAR, 24),
)  # fmt: skip
def test_a_box_holds_its_body_alone_and_stays_on_the_mesh(x, y, other_x, other_y, margin):
    grid = Grid((121, 121), 0.05, (-3.0, -3.0))

    def bounds(a, b):
        return (a - 0.3, b - 0.3), (a + 0.3, b + 0.3)

    box = box_of(bounds(x, y), bounds(x + 0.04, y), [bounds(other_x, other_y)], grid, margin)
    if box is None:
        gap = max(abs(other_x - x) - 0.04, abs(other_y - y)) - 0.6
        assert gap < (2 * CLEAR + 3) * 0.05
        return
    room = CLEAR * 0.05 - 1e-9
    ends = [(axis[part][0], axis[part][-1]) for axis, part in zip(grid.axes(), box, strict=True)]
    for (low, high), first, last in zip(ends, (x, y), (x + 0.04, y), strict=True):
        assert low <= first - 0.3 - room
        assert high >= last + 0.3 + room
    apart = [
        b - 0.3 - high >= room or low - b - 0.3 >= room
        for (low, high), b in zip(ends, (other_x, other_y), strict=True)
    ]
    assert any(apart)
    assert all(part.start >= REACH and part.stop <= 121 - REACH for part in box)


def test_without_room_there_is_no_box():
    grid = Grid((40, 40), 0.1)
    body = ((1.5, 1.5), (2.5, 2.5))
    assert box_of(body, body, [], grid) == (slice(2, 38), slice(2, 38))
    assert box_of(body, body, [((3.0, 1.5), (3.5, 2.5))], grid) is None
    near = ((0.5, 1.5), (1.5, 2.5))
    assert box_of(near, near, [], grid) is None
    with pytest.raises(InputError, match="needs 8 nodes around the body, got 3"):
        box_of(body, body, [], grid, 3)


def test_what_the_law_cannot_use_is_refused():
    grid = Grid((20, 20), 0.1)
    field, scalar = np.zeros((2, 20, 20)), np.zeros((20, 20))
    box = (slice(4, 16), slice(4, 16))

    def ask(u=field, w=scalar, mesh=grid, box=box, dt=0.1):
        return momentum_balance((u, u), (w, w), mesh, box, dt=dt, viscosity=1.0, center=(0, 0))

    assert ask().force == (0.0, 0.0)
    with pytest.raises(InputError, match="law of the plane"):
        ask(mesh=Grid((8, 8, 8), 0.1))
    with pytest.raises(
        InputError, match=r"velocity before and after must have shape \(2, 20, 20\)"
    ):
        ask(u=scalar)
    with pytest.raises(InputError, match="vorticity before and after"):
        ask(w=field)
    with pytest.raises(InputError, match="nodes 1 to 15"):
        ask(box=(slice(1, 16), slice(4, 16)))
    with pytest.raises(InputError, match="dt must be positive"):
        ask(dt=0.0)


def test_a_box_that_follows_a_shaken_penalised_cylinder_tells_its_load():
    from levelset.shapes import Disk
    from pmesh.bodies.body import RigidBody
    from pmesh.bodies.motion import Prescribed
    from pmesh.vortex.flow import VortexFlow

    motion = Prescribed(
        shift=lambda t: (0.5 * math.cos(2 * t) - 0.5, 0.0), velocity=lambda t: (-math.sin(2 * t), 0)
    )
    body = RigidBody(Disk(radius=1.0), motion=motion)
    grid = Grid((128, 112), 1 / 16, (-4.6, -3.47))
    flow = VortexFlow(grid=grid, viscosity=0.05, bodies=(body,), domain="fixed")
    state, off, size = flow.start(), [], []
    while state.time < 0.6:
        last, state = state, flow.step(state, 0.04)
        poses = [motion.pose(body.start(), one.time) for one in (last, state)]
        box = box_of(*(body.bounds(pose) for pose in poses), [], grid)
        assert box is not None
        found = momentum_balance(
            (flow.velocity(last), flow.velocity(state)),
            (last.vorticity, state.vorticity),
            grid, box, dt=state.time - last.time, viscosity=0.05, center=poses[1].center,
        )  # fmt: skip
        gain = (poses[1].velocity[0] - poses[0].velocity[0]) / (state.time - last.time)
        size.append(flow.forces(state)["body0_force_x"])
        off.append(found.force[0] + math.pi * gain - size[-1])
    assert np.abs(off[1:]).max() < 1e-3 * np.abs(size).max()
