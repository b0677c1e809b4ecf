"""Springs on free bodies: where they pull, their order, and that they never feed the motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.shape import rotation
from levelset.shapes import Disk, Ellipse, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.freedom import outer_impulses, predicted
from pmesh.bodies.motion import Free, Spring
from pmesh.bodies.pose import Pose
from pmesh.bodies.spring import ellipsoid_added, grip, likely_inertia

AREA, INERTIA = math.pi / 4, math.pi / 32


def free(**options):
    return RigidBody(Disk(0.5), motion=Free(**options))


def pose(time=0.0, center=(0.0, 0.0), angle=0.0, velocity=(0.0, 0.0), spin=0.0):
    return Pose(time=time, center=center, angle=(angle,), velocity=velocity, spin=(spin,))


def test_springs_pull_to_where_the_body_was_placed_from_the_middle_of_the_step():
    """-k x - c V at mid-step: a part known before, and a grip on the change of the velocity."""
    spring = Spring(stiffness=(2.0, 3.0), damping=(0.5, 0.0), torsion=4.0, twist_damping=1.0)
    body, dt = free(spring=spring), 0.1
    old, then = pose(0.0, (0.1, 0.0), 0.2, (1.0, 1.0), 0.5), np.array([3.0, -2.0, 1.5])
    now, place = np.array([1.0, 1.0, 0.5]), np.array([0.1, 0.0, 0.2])
    middle, speed = place + dt / 4 * (now + then), (now + then) / 2
    asked = -dt * (np.array([2.0, 3.0, 4.0]) * middle + np.array([0.5, 0.0, 1.0]) * speed)
    (known,) = outer_impulses([body], [old], dt)
    np.testing.assert_allclose(known - grip(body, dt) * (then - now), asked, rtol=1e-13)


def swung(spring, share, dt, steps, speed=1.0):
    """Places and speeds along y of a disk on a spring; share: of the mass over the one foreseen."""
    body = free(spring=spring)
    mass = share * likely_inertia(body, pose())[1, 1]
    earlier, there, rows = [], [pose(velocity=(0.0, speed))], []
    for _ in range(steps):
        (ahead,) = predicted([body], earlier, there, dt)
        (push,) = outer_impulses([body], there, dt)
        hold, old = grip(body, dt)[1], there[0].velocity[1]
        found = (mass * old + hold * old + push[1]) / (mass + hold)
        earlier, there = there, [replace(ahead, velocity=(0.0, found))]
        rows.append((ahead.center[1], found))
    return mass, np.array(rows)


def test_a_spring_is_followed_to_second_order():
    """y = sin(omega t) / omega; the mass that was foreseen need not be the right one."""
    wrong = []
    for steps in (40, 80, 160):
        mass, rows = swung(Spring(stiffness=(0.0, 60.0)), 1.2, 1.0 / steps, steps)
        omega = math.sqrt(60.0 / mass)
        wrong.append(abs(rows[-1, 0] - math.sin(omega) / omega))
    assert math.log2(wrong[1] / wrong[2]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("share", [1.0, 1.25, 1.8])
@pytest.mark.parametrize(
    "spring",
    [
        Spring(stiffness=(0.0, 5e3)),
        Spring(stiffness=(0.0, 5e6)),
        Spring(damping=(0.0, 200.0)),
        Spring(stiffness=(0.0, 5e3), damping=(0.0, 200.0)),
    ],
)
def test_stiff_springs_and_strong_dampers_never_feed_the_motion(spring, share):
    """Steps of 0.04 where the period is 0.11 or 0.0035, and dampers act within 0.01."""
    mass, rows = swung(spring, share, 0.04, 2000)
    energy = 0.5 * mass * rows[:, 1] ** 2 + 0.5 * (spring.stiffness or (0, 0))[1] * rows[:, 0] ** 2
    assert energy[-500:].max() <= 0.5 * mass * (1 + 1e-9)
    if spring.damping:
        assert np.abs(rows[-1, 1]) < 1e-6


def test_the_mass_foreseen_is_that_of_an_ellipse_with_the_fluid_it_carries():
    """Lamb: pi b^2 along the axis a; broadside it is pi a^2; a disk turns with no more than own."""
    disk = likely_inertia(free(density=2.0), pose())
    np.testing.assert_allclose(np.diag(disk), [3 * AREA, 3 * AREA, 2 * INERTIA], rtol=1e-12)
    body = RigidBody(Ellipse((1.0, 0.2)), motion=Free())
    own = body.measure
    added = np.array([0.04, 1.0, 0.96**2 / 8]) * math.pi
    mass = np.array([own.volume, own.volume, own.inertia])
    np.testing.assert_allclose(likely_inertia(body, pose()), np.diag(mass + added), rtol=1e-6)
    turned = likely_inertia(body, pose(angle=math.pi / 2))
    np.testing.assert_allclose(turned, np.diag(mass + added[[1, 0, 2]]), rtol=1e-6)


def test_an_ellipsoid_carries_the_fluid_that_lamb_says():
    """A ball half of its own; a disk-like one of axes a >> c edge on and broadside, and about it:
    8/3 a^3 and 16/45 a^5 (Lamb, art. 102, 108, 114-115), here within a few per cent."""
    ball = RigidBody(Sphere(0.5), motion=Free())
    volume = ball.measure.volume
    expected = np.diag([0.5 * volume] * 3 + [0.0] * 3)
    np.testing.assert_allclose(ellipsoid_added(ball, ball.start()), expected, atol=1e-12)
    flat = RigidBody(Ellipsoid((1.0, 1.0, 0.002)), motion=Free())
    found = np.diag(ellipsoid_added(flat, flat.start()))
    assert found[2] == pytest.approx(8 / 3, rel=5e-3)
    assert found[3:5] == pytest.approx([16 / 45] * 2, rel=1e-2)
    assert found[[0, 1, 5]] == pytest.approx([0.0] * 3, abs=1e-4)


def test_the_carried_fluid_turns_with_an_ellipsoid():
    body = RigidBody(Ellipsoid((0.5, 0.3, 0.2)), motion=Free(density=2.0))
    pose = body.start()
    turn = (0.3, -0.5, 0.8)
    own, turned = (likely_inertia(body, replace(pose, angle=angle)) for angle in ((0.0,) * 3, turn))
    np.testing.assert_allclose(own, np.diag(np.diag(own)), atol=1e-12)
    matrix = np.kron(np.eye(2), rotation(turn))
    np.testing.assert_allclose(turned, matrix @ own @ matrix.T, atol=1e-12)
    assert own[2, 2] > own[0, 0] > 2 * body.measure.volume  # broadside carries most
