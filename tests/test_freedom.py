"""Bodies that follow the fluid: where they are foreseen, what they weigh, what else pushes them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipj

from levelset.shape import rotation
from levelset.shapes import Box, Disk, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.freedom import (
    arrived,
    excess_inertia,
    free_coordinates,
    freedom_of,
    outer_impulses,
    predicted,
)
from pmesh.bodies.mask import Mask, mask_of
from pmesh.bodies.motion import Fixed, Free, Prescribed, Spring
from pmesh.bodies.pose import Pose
from pmesh.bodies.swimmer import Swimmer
from remesh.grid import Grid

DISK = Disk(0.5)
AREA, INERTIA = math.pi / 4, math.pi / 32


def free(**options):
    return RigidBody(DISK, motion=Free(**options))


def pose(time=0.0, center=(0.0, 0.0), angle=0.0, velocity=(0.0, 0.0), spin=0.0):
    return Pose(time=time, center=center, angle=(angle,), velocity=velocity, spin=(spin,))


def mask(bodies, poses):
    grid = Grid((64, 64), 1 / 24, (-31.5 / 24,) * 2)
    return mask_of(tuple(bodies), tuple(poses), grid, 1.5 / 24, 0.0)


def test_a_free_body_is_foreseen_exactly_at_constant_acceleration_whatever_the_steps():
    """x = x0 + v t + a t^2 / 2: Adams-Bashforth of order 2 with steps of unlike length."""

    def at(t):
        return pose(t, (1 + 2 * t - 1.5 * t**2, 3 * t**2), 0.1 + t**2, (2 - 3 * t, 6 * t), 2 * t)

    (found,) = predicted([free()], [at(0.2)], [at(0.5)], 0.8)
    ours = (found.time, *found.center, *found.angle)
    exact = at(1.3)
    assert ours == pytest.approx((exact.time, *exact.center, *exact.angle), rel=1e-14)


def test_without_an_earlier_pose_a_free_body_goes_on_straight():
    (found,) = predicted([free()], [], [pose(1.0, (1.0, 2.0), 0.3, (0.5, -1.0), 2.0)], 0.1)
    assert (*found.center, *found.angle) == pytest.approx((1.05, 1.9, 0.5))
    assert (found.velocity, found.spin) == ((0.5, -1.0), (2.0,))


def test_laws_of_time_are_followed_exactly_and_what_is_fixed_stays():
    law = Prescribed(shift=lambda t: (math.sin(t), t**3), angle=lambda t: t)
    bodies = [RigidBody(DISK, motion=law), RigidBody(DISK, motion=Fixed())]
    led, still = predicted(bodies, [], [body.start() for body in bodies], 0.7)
    assert led.center == pytest.approx((math.sin(0.7), 0.343))
    assert led.angle == pytest.approx((0.7,))
    assert (still.center, still.time) == (bodies[1].start().center, 0.7)


@pytest.mark.parametrize("kind", ["rigid", "swimmer"])
def test_a_law_that_begins_away_from_zero_is_counted_once(kind):
    """shift(0) and angle(0) place the body at the start; they are not added again in a step."""
    law = Prescribed(
        shift=lambda t: (0.3 * math.cos(t), 0.1 + t),
        angle=lambda t: 0.5 * math.cos(2 * t),
        velocity=lambda t: (-0.3 * math.sin(t), 1.0),
        spin=lambda t: -math.sin(2 * t),
    )
    if kind == "rigid":
        body, heading = RigidBody(DISK.moved((1.0, 2.0)), motion=law), 0.0
    else:
        body = Swimmer.carling(position=(1.0, 2.0), heading=0.7, motion=law)
        heading = body.heading
    start = body.start()
    assert (body.placed().center, body.placed().angle) == ((1.0, 2.0), (heading,))
    assert start.center == pytest.approx((1.3, 2.1), rel=1e-15)
    assert start.angle == pytest.approx((heading + 0.5,))
    there = start
    for t in (0.1, 0.7):
        (there,) = predicted([body], [], [there], t - there.time)
        assert there.center == pytest.approx((1 + 0.3 * math.cos(t), 2.1 + t))
        assert there.angle == pytest.approx((heading + 0.5 * math.cos(2 * t),))
        assert there.velocity == pytest.approx((-0.3 * math.sin(t), 1.0))


def test_free_coordinates_are_those_of_free_bodies_that_are_not_locked():
    bodies = [RigidBody(DISK), free(locked=("x", "angle")), free()]
    assert free_coordinates(bodies) == [(1, 1), (2, 0), (2, 1), (2, 2)]


@pytest.mark.parametrize("density", [0.1, 1.0, 3.0])
def test_the_inertia_that_counts_is_that_of_the_body_less_the_fluids(density):
    body = free(density=density)
    expected = (density - 1) * np.diag([AREA, AREA, INERTIA])
    np.testing.assert_allclose(excess_inertia(body, pose()), expected, rtol=1e-12)


def test_a_swimmer_that_bends_keeps_its_angular_momentum_not_its_spin():
    """What is left of (I_body - I_fluid)(t) spin is pushed on, with the moment of each instant."""
    fish = Swimmer.carling(motion=Free(density=3.0))
    old, new = (replace(fish.start(), time=t, spin=(2.0,)) for t in (0.0, 1.3))
    straight, bent = fish.inertia(old), fish.inertia(new)
    assert bent < 0.999 * straight
    grid = Grid((72, 24), 1 / 64, (-35.5 / 64, -11.5 / 64))
    seen = mask_of((fish,), (new,), grid, 1.5 / 64, 0.0)
    found = freedom_of([fish], [old], [new], seen, np.zeros((1, 3)), 0.1)
    (spin,) = np.array(found.push[2:]) / found.inertia[2, 2:] - seen.drift[0][2:]
    assert spin == pytest.approx(2.0 * straight / bent, rel=1e-12)


def test_gravity_acts_on_the_difference_of_the_densities_alone():
    bodies = [free(density=d, gravity=(0.0, -2.0)) for d in (0.5, 1.0, 3.0)]
    bodies.append(RigidBody(DISK))
    poses = [body.start() for body in bodies]
    found = outer_impulses(bodies, poses, 0.25)
    expected = [[0, 0.25 * AREA, 0], [0, 0, 0], [0, -AREA, 0], [0, 0, 0]]
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_bodies_that_follow_nothing_have_no_freedom():
    bodies = [RigidBody(DISK)]
    poses = [bodies[0].start()]
    assert freedom_of(bodies, poses, poses, mask(bodies, poses), np.zeros((1, 3)), 0.1) is None


def test_the_modes_are_unit_motions_on_the_bodys_own_nodes():
    bodies = [free(density=2.0), RigidBody(Box((0.3, 0.3)).moved((1.0, 0.0)))]
    poses = [body.start() for body in bodies]
    seen = mask(bodies, poses)
    found = freedom_of(bodies, poses, poses, seen, np.zeros((2, 3)), 0.1)
    own, (x, y) = seen.owner == 0, seen.grid.points()
    assert found.modes.shape == (3, 2, *seen.grid.shape)
    np.testing.assert_array_equal(found.modes[0], np.stack([own, 0 * own]))
    np.testing.assert_array_equal(found.modes[1], np.stack([0 * own, own]))
    np.testing.assert_allclose(found.modes[2], np.stack([-y, x]) * own, atol=1e-15)
    expected = np.diag([AREA, AREA, INERTIA]) / seen.grid.cell_volume
    np.testing.assert_allclose(found.inertia, expected, rtol=1e-12)


def test_the_push_is_the_momentum_at_the_start_and_what_is_given():
    body = free(density=3.0)
    start = pose(0.0, (0.0, 0.0), 0.0, (0.5, -1.0), 2.0)
    given = np.array([[0.1, 0.2, 0.3]])
    seen = mask([body], [start])
    found = freedom_of([body], [start], [start], seen, given, 0.1)
    momentum = np.array([2 * AREA * 0.5, -2 * AREA, 2 * INERTIA * 2.0])
    np.testing.assert_allclose(found.push * seen.grid.cell_volume, momentum + given[0], rtol=1e-12)


def test_found_velocities_reach_free_coordinates_and_locked_ones_are_at_rest():
    bodies = [free(locked=("y",)), RigidBody(DISK.moved((3.0, 0.0)))]
    poses = [pose(0.1, velocity=(7.0, 7.0), spin=7.0), bodies[1].start()]
    seen = mask(bodies, poses)
    moved, still = arrived(bodies, poses, seen, (1.5, -0.5))
    assert (moved.velocity, moved.spin) == ((1.5, 0.0), (-0.5,))
    assert (still.velocity, still.spin) == ((0.0, 0.0), (0.0,))
    assert moved.center == poses[0].center


def test_a_shape_moves_with_what_its_deformation_lost_on_the_mesh():
    """Matter moves with the found velocity and the deformation less its drift; so must the edge."""
    bodies = (free(),)
    seen = mask(bodies, [pose()])._replace(drift=(np.array([0.3, -0.2, 0.7]),))
    (there,) = arrived(bodies, [pose(time=0.1)], seen, (1.0, 2.0, 3.0))
    np.testing.assert_allclose(there.velocity, (0.7, 2.2))
    np.testing.assert_allclose(there.spin, (2.3,))


def space(time=0.0, angle=(0.0,) * 3, velocity=(0.0,) * 3, spin=(0.0,) * 3):
    return Pose(time=time, center=(0.0,) * 3, angle=angle, velocity=velocity, spin=spin)


CUBE = Grid((6, 6, 6), 0.5, (-1.25,) * 3)


def unseen(bodies, grid=CUBE):
    """A mask of no fluid: the laws of the bodies alone."""
    nothing = np.zeros(grid.shape)
    drift = tuple(np.zeros(6) for _ in bodies)
    owner = np.zeros(grid.shape, np.int64)
    return Mask(grid, nothing, nothing, owner, np.zeros((3, *grid.shape)), drift)


def flown(body, start, dt, steps):
    """Poses of a body on which no fluid acts; every step ends as the solve would end it."""
    before, here, poses = [], [start], [start]
    for _ in range(steps):
        after = predicted([body], before, here, dt)
        found = freedom_of([body], here, after, unseen([body]), np.zeros((1, 6)), dt)
        values = np.linalg.solve(found.inertia, found.push)
        before, here = here, arrived([body], after, unseen([body]), values)
        poses.append(here[0])
    return poses


def euler_top(inertia, first, third, time):
    """Spins (3, n) in the body's axes of a top that begins in the plane of the axes 1 and 3.

    L. D. Landau and E. M. Lifshitz, *Mechanics* (1976), sec. 37, for I3 > I2 > I1 and
    M^2 > 2 E I2.
    """
    one, two, three = inertia
    energy = one * first**2 + three * third**2  # twice
    square = (one * first) ** 2 + (three * third) ** 2
    low, high = energy * three - square, square - energy * one
    m = (two - one) * low / ((three - two) * high)
    sn, cn, dn, _ = ellipj(time * math.sqrt((three - two) * high / (one * two * three)), m)
    return np.array(
        [
            math.sqrt(low / (one * (three - one))) * cn,
            math.sqrt(low / (two * (three - two))) * sn,
            math.sqrt(high / (three * (three - one))) * dn,
        ]
    )


def test_an_asymmetric_top_turns_as_eulers_equations_say_and_keeps_its_angular_momentum():
    """Exact by Jacobi's elliptic functions; second order in dt, the momentum to round-off."""
    body = RigidBody(Ellipsoid((0.9, 0.7, 0.3)), motion=Free(density=2.0))
    inertia = np.diag(body.inertia(body.start()))
    spin = (1.0, 0.0, 1.5)
    wrong = []
    for steps in (100, 200, 400):
        poses = flown(body, space(spin=spin), 6.0 / steps, steps)
        momenta = np.array([body.inertia(pose) @ pose.spin for pose in poses])
        np.testing.assert_allclose(momenta, momenta[:1].repeat(steps + 1, 0), atol=1e-12)
        own = [rotation(pose.angle).T @ pose.spin for pose in poses]
        time = np.array([pose.time for pose in poses])
        exact = euler_top(inertia, spin[0], spin[2], time).T
        wrong.append(np.abs(np.array(own) - exact).max())
    assert np.ptp(exact[:, 1]) > 1.0  # it tumbles
    assert wrong[-1] < 0.01
    assert math.log2(wrong[1] / wrong[2]) == pytest.approx(2.0, abs=0.2)


def test_coordinates_in_space_are_three_shifts_and_three_turns():
    ball = RigidBody(Sphere(0.5), motion=Free(locked=("y", "turn_z")))
    assert free_coordinates([ball]) == [(0, 0), (0, 2), (0, 3), (0, 4)]
    start = space(0.1, spin=(1.0, 2.0, 0.0), velocity=(3.0, 0.0, 4.0))
    found = freedom_of([ball], [start], [start], unseen([ball]), np.zeros((1, 6)), 0.1)
    assert found.modes.shape == (4, 3, 6, 6, 6)
    (there,) = arrived([ball], [start], unseen([ball]), (1.0, 2.0, 3.0, 4.0))
    assert (there.velocity, there.spin) == ((1.0, 0.0, 2.0), (3.0, 4.0, 0.0))


def test_gravity_in_space_acts_along_its_own_axis():
    ball = RigidBody(Sphere(0.5), motion=Free(density=3.0, gravity=(0.0, 0.0, -2.0)))
    (found,) = outer_impulses([ball], [ball.start()], 0.25)
    np.testing.assert_allclose(found, [0, 0, -math.pi / 6, 0, 0, 0], atol=1e-15)


def test_a_ball_on_a_torsion_spring_swings_back_through_its_rest():
    """T = -k theta about a leaning axis: cos(omega t), omega^2 = k / I, dt^2 apart."""
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    spring = Spring(torsion=3.0)
    body = RigidBody(Sphere(0.5), motion=Free(density=2.0, spring=spring))
    (inertia,) = {round(float(x), 12) for x in 2 * np.diag(body.inertia(body.start()))}
    omega = math.sqrt(3.0 / inertia)
    before, here, dt, steps = [], [space(angle=tuple(0.4 * axis))], 0.5 * math.pi / omega / 40, 40
    for _ in range(steps):
        after = predicted([body], before, here, dt)
        push = outer_impulses([body], here, dt)
        found = freedom_of([body], here, after, unseen([body]), push, dt)
        extra = np.diag([0, 0, 0, 1, 1, 1]) * inertia / 2 / CUBE.cell_volume  # the fluid in it
        given = found.push + extra @ [*here[0].velocity, *here[0].spin]
        values = np.linalg.solve(found.inertia + extra, given)
        before, here = here, arrived([body], after, unseen([body]), values)
    assert np.abs(here[0].angle).max() < 2e-3
    np.testing.assert_allclose(here[0].spin, -0.4 * omega * axis, rtol=2e-3)
