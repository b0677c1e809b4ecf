"""Loads on bodies: sums of the impulse, its work, the inertia of the fluid in a body's place."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erfcx, kv

from levelset.shapes import Disk, Ellipse, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.mask import mask_of
from pmesh.bodies.motion import Fixed, Free, Prescribed
from pmesh.bodies.pose import Pose
from pmesh.bodies.swimmer import Swimmer
from pmesh.cases.unsteady_stokes import inverse_laplace
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.loads import (
    inertia_force,
    inertia_torque,
    kinetic_energy,
    load_columns,
    loads_of,
    moments,
    spin_gained,
    work,
)
from remesh.grid import Grid

H = 1 / 16
GRID = Grid((64, 40), H, (-31.5 * H, -19.5 * H))
AREA = math.pi / 4
PAIR = (
    RigidBody(Disk(0.5, center=(-1.0, 0.0)), motion=Free()),
    RigidBody(Ellipse((0.6, 0.3)).moved((0.9, 0.2)), motion=Free()),
)
FISH = Swimmer.carling(motion=Free(density=1.0))


def pose(center=(0.0, 0.0), velocity=(0.0, 0.0), spin=0.0, time=0.0):
    return Pose(time=time, center=center, angle=(0.0,), velocity=velocity, spin=(spin,))


def drawn(bodies, poses, grid=GRID):
    return mask_of(tuple(bodies), tuple(poses), grid, 1.5 * grid.spacing, 0.0)


def impulse_of(mask, dtype=np.float64):
    """Some impulse density where the bodies are."""
    return (np.random.default_rng(5).normal(size=(2, *mask.grid.shape)) * mask.chi).astype(dtype)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_impulses_are_summed_over_each_bodys_own_nodes_and_about_its_centre(dtype):
    poses = [body.start() for body in PAIR]
    mask = drawn(PAIR, poses)
    impulse = impulse_of(mask, dtype)
    sums = moments(impulse, mask, poses)
    cell, (x, y) = H**2, GRID.points()
    np.testing.assert_allclose(sums[:, :2].sum(axis=0), impulse.sum(axis=(1, 2)) * cell, rtol=1e-5)
    for number, one in enumerate(poses):
        own = mask.owner == number
        arm = (x - one.center[0]) * impulse[1] - (y - one.center[1]) * impulse[0]
        assert sums[number, 2] == pytest.approx(float(arm[own].sum()) * cell, rel=1e-5)


def test_the_work_on_a_rigid_motion_is_momentum_times_velocity():
    poses = [
        replace(body.start(), velocity=v, spin=(w,))
        for body, v, w in zip(PAIR, ((1.0, -2.0), (0.3, 0.1)), (3.0, -0.7), strict=True)
    ]
    mask = drawn(PAIR, poses)
    impulse = impulse_of(mask)
    sums = moments(impulse, mask, poses)
    motion = np.array([[*one.velocity, *one.spin] for one in poses])
    np.testing.assert_allclose(
        work(impulse, mask, poses, PAIR), np.sum(sums * motion, axis=1), rtol=1e-12
    )
    still = tuple(replace(body, motion=Fixed()) for body in PAIR)
    assert not work(impulse, mask, poses, still).any()


def test_the_fluid_in_a_bodys_place_is_not_the_outer_fluids_doing():
    """Without an impulse the load is the gain of momentum, and the power feeds the energy."""
    body, dt = PAIR[0], 0.1
    old, new = pose(velocity=(1.0, 0.0), spin=2.0), pose(velocity=(1.5, -0.5), spin=2.5)
    energy = 0.5 * AREA * (2.5 - 1.0) + 0.5 * AREA / 8 * (2.5**2 - 2.0**2)
    (load,) = loads_of([body], [old], [new], np.zeros((1, 3)), np.zeros(1), np.array([energy]), dt)
    assert load.force == pytest.approx((AREA * 5.0, -AREA * 5.0))
    assert load.torque == pytest.approx((AREA / 8 * 5.0,))
    middle = (1.25, -0.25), 2.25
    given = np.dot(load.force, middle[0]) + load.torque[0] * middle[1]
    assert load.power == pytest.approx(-given)
    total = inertia_force([body, body], [old, old], [new, new], dt)
    np.testing.assert_allclose(total, [2 * AREA * 5.0, -2 * AREA * 5.0])


def test_loads_are_against_the_impulse_on_the_fluid():
    sums, still = np.array([[0.3, -0.1, 0.2]]), pose()
    (load,) = loads_of([PAIR[0]], [still], [still], sums, np.array([0.7]), np.zeros(1), 0.1)
    assert load.force == pytest.approx((-3.0, 1.0))
    assert (*load.torque, load.power) == pytest.approx((-2.0, 7.0))


def test_a_bending_body_gains_angular_momentum_at_constant_spin():
    """d(I spin)/dt, with I of each instant: a rigid one gains none."""
    old, new = (pose(spin=2.0, time=t) for t in (0.5, 1.3))
    gained = spin_gained(FISH, old, new)
    assert gained == pytest.approx(2.0 * (FISH.inertia(new) - FISH.inertia(old)), rel=1e-12)
    assert abs(gained) > 1e-3 * FISH.inertia(old)
    assert spin_gained(PAIR[1], old, new) == 0.0
    (load,) = loads_of([FISH], [old], [new], np.zeros((1, 3)), np.zeros(1), np.zeros(1), 0.8)
    assert load.torque == pytest.approx((float(gained[0]) / 0.8,))


def walled(*bodies):
    """The wall that holds bodies where they start, on a mesh around the origin."""
    grid = Grid((160, 80), 1 / 128, (-79.5 / 128, -39.5 / 128))
    flow = VortexFlow(grid=grid, viscosity=0.01, bodies=bodies, threads=1)
    return flow.engine.wall(flow.start())


def test_kinetic_energy_is_that_of_translation_spin_and_bending():
    moved = pose(velocity=(1.0, -2.0), spin=3.0, time=1.2)
    disk = RigidBody(Disk(0.2), motion=Free())
    mass, inertia = disk.measure.volume, disk.measure.inertia
    (found,) = kinetic_energy(walled(disk), [moved])
    assert found == pytest.approx(0.5 * mass * 5.0 + 0.5 * inertia * 9.0)
    wall = walled(FISH)
    wall = wall.at((replace(moved, velocity=(0.0, 0.0), spin=(0.0,)),))
    (bending,), (all_of_it,) = (kinetic_energy(wall, [one]) for one in (wall.poses[0], moved))
    assert bending > 0
    rest = 0.5 * FISH.measure.volume * 5.0 + 0.5 * FISH.inertia(moved) * 9.0
    assert all_of_it - bending == pytest.approx(rest, rel=1e-12)
    assert not kinetic_energy(walled(RigidBody(Disk(0.2))), [moved]).any()


def spun(law, spin, steps, dt, viscosity=0.02):
    """Poses, torque and power of a disk that spins by a law in still fluid."""
    nodes, cells = 24, 24
    grid = Grid((2 * cells,) * 2, 1 / nodes, ((0.5 - cells) / nodes,) * 2)
    body = RigidBody(Disk(0.5), motion=Prescribed(angle=law, spin=spin))
    flow = VortexFlow(grid=grid, viscosity=viscosity, bodies=(body,), domain="follow", threads=1)
    state, rows = flow.start(), []
    for _ in range(steps):
        state = flow.step(state, dt)
        load = state.loads[0]
        rows.append((state.time, *load.torque, load.power, *load.force))
    return np.array(rows).T


def test_a_spinning_disk_feels_the_torque_of_its_vortex_layer():
    """T(s) = -2 pi nu a^2 Omega z K2(z) / (s K1(z)), z = a sqrt(s/nu): exact, as it is circular."""
    viscosity, rate, dt = 0.02, 2.0, 0.02
    time, torque, power, *force = spun(lambda t: rate * t, lambda t: rate, 40, dt)

    def law(s):
        z = 0.5 * np.sqrt(s / viscosity)
        return -2 * math.pi * viscosity * 0.25 * rate * z * kv(2, z) / (s * kv(1, z))

    late = time > 0.3
    exact = inverse_laplace(law, time - 0.5 * dt)
    np.testing.assert_allclose(torque[late], exact[late], rtol=0.02)
    np.testing.assert_allclose(power, -rate * torque, rtol=1e-9)
    assert np.abs(force).max() < 1e-3 * np.abs(torque).max()


def test_what_a_disk_gives_to_the_fluid_is_its_torque_times_its_spin():
    """While the spin changes too: power = -torque * mean spin, to the second order of a step."""
    wrong = []
    for dt, steps in ((0.04, 10), (0.02, 20)):
        time, torque, power, *_ = spun(lambda t: 1 - math.cos(t), math.sin, steps, dt)
        mean = 0.5 * (np.sin(time) + np.sin(time - dt))
        wrong.append(abs(power + torque * mean)[-1] / abs(power[-1]))
    assert wrong[1] < 0.01
    assert wrong[1] < 0.6 * wrong[0]


SOLIDS = (
    RigidBody(Sphere(0.3, center=(-0.4, 0.0, 0.1)), motion=Free()),
    RigidBody(Ellipsoid((0.4, 0.2, 0.3)).moved((0.5, 0.1, 0.0), (0.2, 0.5, -0.3)), motion=Free()),
)
BLOCK = Grid((40, 24, 24), 1 / 16, (-19.5 / 16, -11.5 / 16, -11.5 / 16))


def solid_impulse():
    """Poses that move, a mask of two solids, and some impulse density on them."""
    rng = np.random.default_rng(7)
    poses = [
        replace(body.start(), velocity=tuple(rng.normal(size=3)), spin=tuple(rng.normal(size=3)))
        for body in SOLIDS
    ]
    mask = drawn(SOLIDS, poses, BLOCK)
    return poses, mask, rng.normal(size=(3, *BLOCK.shape)) * mask.chi


def test_impulses_in_space_are_summed_and_turned_about_each_bodys_centre():
    poses, mask, impulse = solid_impulse()
    sums = moments(impulse, mask, poses)
    for number, one in enumerate(poses):
        own = np.where(mask.owner == number, impulse, 0.0)
        arm = BLOCK.points() - np.array(one.center).reshape(3, 1, 1, 1)
        exact = [*own.sum(axis=(1, 2, 3)), *np.cross(arm, own, axis=0).sum(axis=(1, 2, 3))]
        np.testing.assert_allclose(sums[number], np.array(exact) * BLOCK.cell_volume, rtol=1e-11)


def test_the_work_in_space_is_force_times_velocity_and_torque_times_spin():
    poses, mask, impulse = solid_impulse()
    sums = moments(impulse, mask, poses)
    motion = np.array([[*one.velocity, *one.spin] for one in poses])
    found = work(impulse, mask, poses, SOLIDS)
    np.testing.assert_allclose(found, np.sum(sums * motion, axis=1), rtol=1e-11)


def test_the_inertia_of_the_fluid_in_a_solids_place_is_its_tensor():
    body, dt = SOLIDS[1], 0.1
    old = replace(body.start(), velocity=(1.0, 0.0, 0.5), spin=(1.0, 2.0, -0.5))
    new = replace(old, center=(0.7, 0.3, 0.2), angle=(0.4, 0.0, 0.9), spin=(0.0, 1.0, 0.3))
    volume = body.measure.volume
    gained = body.inertia(new) @ new.spin - body.inertia(old) @ old.spin
    np.testing.assert_allclose(spin_gained(body, old, new), gained)
    (load,) = loads_of([body], [old], [new], np.zeros((1, 6)), np.zeros(1), np.zeros(1), dt)
    np.testing.assert_allclose(load.torque, gained / dt)
    np.testing.assert_allclose(load.force, np.zeros(3), atol=1e-15)
    orbit = volume * np.cross(np.subtract(new.center, old.center), old.velocity)
    np.testing.assert_allclose(
        inertia_torque([body], [old], [new], dt), (gained + orbit) / dt, rtol=1e-12
    )
    names = {f"body0_{name}" for name in (
        "force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z", "power", "x", "y",
        "z", "turn_x", "turn_y", "turn_z", "u", "v", "w", "spin_x", "spin_y", "spin_z",
    )}  # fmt: skip
    columns = load_columns([body], [load], [new])
    assert set(columns) == names
    assert (columns["body0_turn_z"], columns["body0_spin_y"]) == (0.9, 1.0)


def test_angular_momentum_in_the_plane_counts_the_orbit_too():
    body = PAIR[0]
    old, new = pose((1.0, 2.0), (0.0, 3.0), 1.0), pose((1.5, 2.0), (0.0, 4.0), 2.0)
    found = inertia_torque([body], [old], [new], 0.5)
    np.testing.assert_allclose(found, [(AREA * (6.0 - 3.0) + AREA / 8) / 0.5])


def test_a_spinning_ball_feels_the_torque_of_its_vortex_layer():
    """-(8 pi nu a^3 W / 3) [3 + a/sqrt(pi nu t) - exp(nu t/a^2) erfc(sqrt(nu t)/a)]."""
    viscosity, rate, dt, radius = 0.02, 0.2, 0.02, 0.5
    spin = Prescribed(angle=lambda t: (0.0, rate * t, 0.0), spin=lambda t: (0.0, rate, 0.0))
    grid = Grid((32,) * 3, 1 / 12, (-15.5 / 12,) * 3)
    body = RigidBody(Sphere(radius), motion=spin)
    flow = VortexFlow(
        grid=grid, viscosity=viscosity, bodies=(body,), domain="follow", threads=1,
        freestream=(0.0, 0.0, 0.0),
    )  # fmt: skip
    state = flow.start()
    for _ in range(7):
        state = flow.step(state, dt)
    when = viscosity * (state.time - 0.5 * dt)
    layer = 3 + radius / math.sqrt(math.pi * when) - float(erfcx(math.sqrt(when) / radius))
    exact = -8 * math.pi / 3 * viscosity * radius**3 * rate * layer
    load = state.loads[0]
    np.testing.assert_allclose(load.torque, [0.0, exact, 0.0], atol=0.02 * abs(exact))
    assert load.power == pytest.approx(-rate * load.torque[1], rel=1e-9)
