"""Contact: pushes only, equal and opposite; what touches stops or bounces, and nothing overlaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipse, Naca, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.contact import ContactLaw, contacts, resolve
from pmesh.bodies.motion import Fixed, Free, Prescribed
from pmesh.bodies.swimmer import Swimmer
from pmesh.bodies.turning import turned_on
from remesh.errors import InputError

H = 1 / 24  # spacing
VACUUM = ContactLaw(added=0.0)


def glided(body, pose, dt, gravity=(0.0, 0.0)):
    """A step of free flight."""
    if not isinstance(body.motion, Free):
        return body.motion.pose(body.start(), pose.time + dt)
    velocity = tuple(v + dt * g for v, g in zip(pose.velocity, gravity, strict=True))
    center = tuple(x + dt * v for x, v in zip(pose.center, velocity, strict=True))
    angle = (pose.angle[0] + dt * pose.spin[0],)
    return replace(pose, time=pose.time + dt, center=center, velocity=velocity, angle=angle)


def fly(bodies, steps, *, dt=0.04, law=VACUUM, gravity=(0.0, 0.0), poses=None):
    """Free flight with contacts: the last poses, the least gap in spacings, all impulses."""
    poses = tuple(poses or (body.start() for body in bodies))
    least, told = np.inf, []
    for _ in range(steps):
        after = [glided(b, p, dt, gravity) for b, p in zip(bodies, poses, strict=True)]
        poses, impulses = resolve(bodies, poses, after, law, H)
        near = contacts(bodies, poses, law.reach * H)
        least = min(least, min((c.gap for c in near), default=np.inf) / H)
        told.append(impulses)
    return poses, least, np.array(told)


def momentum(bodies, poses):
    """Momentum along x and y, and about the origin, of the bodies in vacuum."""
    total = np.zeros(3)
    for body, pose in zip(bodies, poses, strict=True):
        if isinstance(body.motion, Free):
            mass = body.motion.density * body.measure.volume
            (x, y), (u, v) = pose.center, pose.velocity
            turn = body.motion.density * body.measure.inertia * pose.spin[0]
            total += [mass * u, mass * v, mass * (x * v - y * u) + turn]
    return total


def energy(bodies, poses):
    total = 0.0
    for body, pose in zip(bodies, poses, strict=True):
        if isinstance(body.motion, Free):
            m = body.measure
            speed = float(np.dot(pose.velocity, pose.velocity))
            total += body.motion.density * (m.volume * speed + m.inertia * pose.spin[0] ** 2) / 2
    return total


def disk(x, y=0.0, u=0.0, v=0.0, density=1.0, radius=0.5):
    motion = Free(density=density, velocity=(u, v))
    return RigidBody(Disk(radius, center=(x, y)), motion=motion)


@pytest.mark.parametrize("restitution", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("density", [0.1, 1.0, 30.0])
def test_disks_head_on_part_by_the_restitution_and_keep_their_momentum(restitution, density):
    bodies = [disk(-0.8, u=1.0, density=density), disk(0.8, u=-0.5)]
    law = replace(VACUUM, restitution=restitution)
    poses, least, told = fly(bodies, 25, law=law)
    one, two = (pose.velocity[0] for pose in poses)
    assert two - one == pytest.approx(restitution * 1.5, abs=1e-6)
    assert momentum(bodies, poses)[0] == pytest.approx(np.pi / 4 * (density - 0.5), rel=1e-12)
    assert abs(poses[0].velocity[1]) + abs(poses[0].spin[0]) < 1e-5
    assert least > 1.0 - 2e-3
    assert np.abs(told.sum(axis=1)[:, :2]).max() < 1e-12  # equal and opposite
    mass = density / (1 + density) * np.pi / 4
    assert -told[:, 0, 0].sum() == pytest.approx(mass * 1.5 * (1 + restitution), rel=1e-6)


def test_the_masses_that_meet_hold_the_stated_added_mass():
    (pair, wall) = disk(0.0, 0.6, v=-1.0), RigidBody(Box((6.0, 1.0), center=(0.0, -0.5)))
    for added in (0.0, 1.0, 2.0):
        told = fly([pair, wall], 5, law=ContactLaw(added=added))[2]
        assert told[:, 0, 1].sum() == pytest.approx((1 + added) * np.pi / 4, rel=1e-6)


def test_a_disk_lands_on_a_floor_at_the_gap_and_rests():
    bodies = [disk(0.1, 1.0), RigidBody(Box((6.0, 1.0), center=(0.0, -0.5)))]
    poses, least, told = fly(bodies, 80, gravity=(0.0, -1.0))
    assert poses[0].center == pytest.approx((0.1, 0.5 + H), abs=2e-3 * H)
    assert np.abs(poses[0].velocity).max() < 1e-6
    assert least > 1.0 - 2e-3
    assert told[-1, 0] == pytest.approx((0.0, np.pi / 4 * 0.04, 0.0), abs=1e-6)  # carries it
    assert poses[1] == replace(bodies[1].start(), time=poses[1].time)


def test_a_bounce_keeps_what_the_restitution_says_of_the_height():
    bodies = [disk(0.0, 1.5 + H), RigidBody(Box((6.0, 1.0), center=(0.0, -0.5)))]
    poses, heights = tuple(body.start() for body in bodies), []
    for _ in range(520):
        after = [glided(b, p, 0.005, (0.0, -1.0)) for b, p in zip(bodies, poses, strict=True)]
        poses, _ = resolve(bodies, poses, after, replace(VACUUM, restitution=0.5), H)
        heights.append(poses[0].center[1] - 0.5 - H)
    landed = int(np.argmin(heights))
    assert max(heights[landed:]) == pytest.approx(0.25, abs=0.02)  # e^2 of 1


@pytest.mark.parametrize("restitution", [0.0, 1.0])
def test_three_in_a_row_pass_on_the_momentum(restitution):
    bodies = [disk(-1.5, u=1.0), disk(0.0), disk(1.0 + H)]
    law = replace(VACUUM, restitution=restitution)
    poses, least, _ = fly(bodies, 40, law=law)
    speeds = [pose.velocity[0] for pose in poses]
    assert sum(speeds) == pytest.approx(1.0, rel=1e-12)
    assert least > 1.0 - 2e-3
    if restitution == 0.0:
        assert speeds == pytest.approx([1 / 3, 1 / 3, 1 / 3], abs=1e-6)
    assert np.diff(speeds).min() > -1e-9  # none runs into the next


def test_an_off_centre_hit_turns_a_box_and_keeps_the_angular_momentum():
    box = RigidBody(Box((0.4, 2.0)), motion=Free(density=2.0))
    bodies = [disk(-1.2, 0.7, u=1.0), box]
    for restitution in (0.0, 1.0):
        law = replace(VACUUM, restitution=restitution)
        poses, least, told = fly(bodies, 20, law=law)
        before = momentum(bodies, [body.start() for body in bodies])
        assert poses[1].spin[0] < -0.1  # hit above the centre from the left: clockwise
        assert momentum(bodies, poses)[:2] == pytest.approx(before[:2], abs=1e-12)
        assert momentum(bodies, poses)[2] == pytest.approx(before[2], abs=2e-3)
        assert least > 1.0 - 2e-3
        assert told[:, 1, 2].sum() == pytest.approx(
            2.0 * box.measure.inertia * poses[1].spin[0], rel=1e-12
        )
        lost = 1 - energy(bodies, poses) / energy(bodies, [b.start() for b in bodies])
        if restitution == 1.0:
            assert abs(lost) < 1e-9
        else:
            assert lost > 0.05


def test_a_tilted_box_falls_flat_on_a_floor():
    box = RigidBody(Box((1.0, 0.4)).moved((0.0, 0.8), 0.4), motion=Free())
    bodies = [box, RigidBody(Box((6.0, 1.0), center=(0.0, -0.5)))]
    poses, least, told = fly(bodies, 110, gravity=(0.0, -1.0))
    assert poses[0].angle[0] + 0.4 == pytest.approx(0.0, abs=1e-3)
    assert poses[0].center[1] == pytest.approx(0.2 + H, abs=0.01 * H)
    assert abs(poses[0].center[0]) < 0.1 * H  # without friction nothing pushes it sideways
    assert least > 1.0 - 2e-3
    assert told[-1, 0, 1] == pytest.approx(0.4 * 0.04, rel=1e-3)


def test_what_is_locked_does_not_move_and_a_wall_takes_no_part():
    tied = RigidBody(Disk(0.5), motion=Free(locked=("x", "angle")))
    bodies = [disk(-1.2, 0.3, u=1.0), tied]
    poses, least, _ = fly(bodies, 30)
    assert poses[1].center[0] == 0.0
    assert poses[1].angle == (0.0,)
    assert poses[1].velocity[1] < -0.01
    assert least > 1.0 - 2e-3


def test_a_led_piston_pushes_a_free_disk_and_crushing_it_goes_on():
    piston = RigidBody(
        Box((0.2, 1.0), center=(-1.0, 0.0)), motion=Prescribed(shift=lambda t: (t, 0.0))
    )
    wall = RigidBody(Box((0.2, 4.0), center=(1.2, 0.0)))
    bodies = [piston, disk(0.0, radius=0.3), wall]
    poses, least, _ = fly(bodies, 20)
    assert poses[1].velocity[0] == pytest.approx(1.0, abs=1e-6)
    assert least > 1.0 - 2e-3
    poses, _, told = fly(bodies, 38)  # now there is no room: both gaps shrink alike
    assert np.isfinite(told).all()
    left = poses[1].center[0] - 0.3 - (poses[0].center[0] + 0.1)
    assert left == pytest.approx(1.1 - (poses[1].center[0] + 0.3), abs=0.2 * H)


@pytest.mark.parametrize("dt", [0.04, 0.6])
def test_steps_of_many_spacings_do_not_pass_through_a_thin_wall(dt):
    wall = RigidBody(Box((2 * H, 4.0)))
    bodies = [disk(-1.0, u=3.0, radius=0.2), wall]
    poses, least, _ = fly(bodies, 3 if dt > 0.1 else 20, dt=dt)
    assert poses[0].center[0] == pytest.approx(-0.2 - 2 * H, abs=2e-3 * H)
    assert least > 1.0 - 2e-3


def test_what_touches_nothing_is_left_as_it_was():
    bodies = [disk(-3.0, u=1.0), disk(3.0), RigidBody(Box((9.0, 1.0), center=(0.0, -3.0)))]
    before = [body.start() for body in bodies]
    after = [glided(b, p, 0.1) for b, p in zip(bodies, before, strict=True)]
    poses, impulses = resolve(bodies, before, after, ContactLaw(), H)
    assert all(a is b for a, b in zip(poses, after, strict=True))
    assert impulses.shape == (3, 3)
    assert not impulses.any()


def test_bodies_that_begin_too_near_part_slowly_and_without_speed():
    bodies = [disk(-0.5), disk(0.5)]  # a gap of 0
    gaps = []
    poses = tuple(body.start() for body in bodies)
    for _ in range(30):
        after = [glided(b, p, 0.04) for b, p in zip(bodies, poses, strict=True)]
        poses, _ = resolve(bodies, poses, after, VACUUM, H)
        gaps.append((poses[1].center[0] - poses[0].center[0] - 1.0) / H)
    assert np.all(np.diff([0.0, *gaps]) < 0.06)
    assert gaps[-1] == pytest.approx(1.0, abs=2e-3)
    assert max(abs(v) for pose in poses for v in pose.velocity) < 1e-9


def crowd(seed):
    """Six light and heavy bodies of several shapes between four walls."""
    rng = np.random.default_rng(seed)
    spots = [(x, y) for x in (-1.2, 0.0, 1.2) for y in (-1.2, 0.0, 1.2)]
    bodies = []
    for k in rng.permutation(9)[:6]:
        sides = tuple(rng.uniform(0.2, 0.7, 2))
        shapes = (Disk(rng.uniform(0.2, 0.5)), Box(sides), Ellipse(sides), Naca("2412"))
        motion = Free(
            density=float(10 ** rng.uniform(-1.5, 2)),
            velocity=tuple(rng.uniform(-1, 1, 2)),
            spin=float(rng.uniform(-2, 2)),
        )
        shape = shapes[rng.integers(4)].moved(spots[k], rng.uniform(0, 6))
        bodies.append(RigidBody(shape, motion=motion))
    for sign in (-1, 1):
        bodies.append(RigidBody(Box((6.0, 1.0), center=(0.0, sign * 2.5))))
        bodies.append(RigidBody(Box((1.0, 6.0), center=(sign * 2.5, 0.0))))
    return bodies


@pytest.mark.parametrize("seed", range(3))
def test_a_crowd_never_overlaps_and_gains_no_energy(seed):
    bodies = crowd(seed)
    law = replace(VACUUM, restitution=(0.0, 0.5, 1.0)[seed])
    start = energy(bodies, [body.start() for body in bodies])
    poses, least, told = fly(bodies, 30, dt=0.03, law=law)
    assert least > 0.98
    assert energy(bodies, poses) < start * 1.02
    assert all(max(map(abs, pose.center)) < 2.0 for pose in poses[:6])
    assert np.abs(told.sum(axis=1)[:, :2]).max() < 1e-9 * max(1.0, np.abs(told).max())


def mirrored(pose):
    (x, y), (u, v) = pose.center, pose.velocity
    return replace(
        pose, center=(x, -y), velocity=(u, -v), angle=(-pose.angle[0],), spin=(-pose.spin[0],)
    )


def test_the_mirrored_start_has_the_mirrored_end():
    box = RigidBody(Box((0.8, 0.5)), motion=Free(density=3.0))
    oval = RigidBody(Ellipse((0.5, 0.3)), motion=Free())
    bodies = [box, oval, RigidBody(Box((6.0, 0.5), center=(0.0, 0.0)))]
    bodies[2] = RigidBody(Disk(0.4))
    starts = [
        replace(box.start(), center=(-1.2, 0.3), velocity=(1.0, 0.0), angle=(0.3,), spin=(0.5,)),
        replace(oval.start(), center=(0.8, 0.9), velocity=(-0.8, -0.9), spin=(-1.0,)),
        bodies[2].start(),
    ]
    there = fly(bodies, 30, poses=starts)[0]
    back = fly(bodies, 30, poses=[mirrored(pose) for pose in starts])[0]
    for one, two in zip(there, map(mirrored, back), strict=True):
        assert one.center == pytest.approx(two.center, abs=1e-4 * H)
        assert one.velocity == pytest.approx(two.velocity, abs=1e-4)
        assert one.angle + one.spin == pytest.approx(two.angle + two.spin, abs=1e-4)


def test_swimmers_do_not_pass_through_each_other_or_a_wall():
    here = Swimmer.carling(length=1.0, period=1.0)
    there = replace(here, position=(-0.6, 0.4), heading=2.5)
    bodies = [here, there, RigidBody(Box((1.0, 0.2), center=(-1.5, 0.0)))]
    starts = [body.start() for body in bodies]
    starts[0] = replace(starts[0], velocity=(-1.0, 0.0))
    starts[1] = replace(starts[1], velocity=(-0.3, -0.4), spin=(1.0,))
    _, least, told = fly(bodies, 30, law=ContactLaw(), poses=starts)
    assert told.any()
    assert least > 0.98


def test_a_law_that_cannot_hold_is_refused():
    for given, said in (
        ({"gap": 0.0}, "0 < gap < reach asked, got gap 0"),
        ({"gap": 3.0}, "0 < gap < reach asked, got gap 3, reach 2"),
        ({"restitution": 1.5}, "restitution must be 0 to 1, got 1.5"),
        ({"restitution": float("nan")}, "restitution must be 0 to 1"),
        ({"added": -1.0}, "added must not be negative"),
        ({"reach": "far"}, "ContactLaw reach must be a number"),
    ):
        with pytest.raises(InputError, match=said):
            ContactLaw(**given)


def test_a_body_in_space_that_is_held_has_no_contacts():
    ball = RigidBody(Sphere(0.5), motion=Fixed())
    poses, impulses = resolve([ball], [ball.start()], [ball.start()], ContactLaw(), H)
    assert poses == (ball.start(),)
    assert impulses.shape == (1, 6)
    assert not impulses.any()


def balls(*places, density=1.0):
    """Balls of radius 1/2 at places (x, y, z, u, v, w), and their first poses."""
    return [
        RigidBody(Sphere(0.5, center=place[:3]), motion=Free(density=density, velocity=place[3:]))
        for place in places
    ]


def in_flight(pose, dt):
    """A body in free flight."""
    center = tuple(x + dt * v for x, v in zip(pose.center, pose.velocity, strict=True))
    angle = turned_on(pose.angle, np.multiply(dt, pose.spin))
    return replace(pose, time=pose.time + dt, center=center, angle=angle)


@pytest.mark.parametrize("restitution", [0.0, 1.0])
def test_balls_that_meet_askew_part_along_their_line_and_keep_their_momentum(restitution):
    bodies = balls((-0.7, 0.0, 0.1, 1.0, 0.0, 0.0), (0.7, 0.3, -0.1, -0.5, 0.2, 0.0))
    poses = tuple(body.start() for body in bodies)
    before, law = np.sum([pose.velocity for pose in poses], axis=0), replace(VACUUM)
    law = replace(law, restitution=restitution)
    for _ in range(20):
        after = [in_flight(pose, 0.04) for pose in poses]
        met, impulses = resolve(bodies, poses, after, law, H)
        if impulses.any():
            arm = np.subtract(met[0].center, met[1].center)
            way = arm / np.linalg.norm(arm)
            old, new = (
                np.dot(way, np.subtract(*(p.velocity for p in pair))) for pair in (poses, met)
            )
            assert new == pytest.approx(-restitution * old, abs=1e-6)
            np.testing.assert_allclose(impulses[0, :3], -impulses[1, :3], atol=1e-13)
            np.testing.assert_allclose(np.cross(impulses[0, :3], way), 0.0, atol=1e-4)
            assert np.linalg.norm(arm) == pytest.approx(1.0 + H, abs=2e-3 * H)
            break
        poses = met
    else:
        pytest.fail("they never met")
    np.testing.assert_allclose(np.sum([p.velocity for p in met], axis=0), before, atol=1e-13)


def test_a_rod_in_space_that_is_hit_off_its_centre_turns_and_keeps_its_angular_momentum():
    rod = RigidBody(Box((0.4, 2.0, 0.3)), motion=Free(density=2.0))
    (ball,) = balls((-1.2, 0.7, 0.05, 1.0, 0.0, 0.0))
    bodies, poses = [ball, rod], (ball.start(), rod.start())

    def angular():
        return sum(
            body.motion.density
            * (
                body.measure.volume * np.cross(pose.center, pose.velocity)
                + body.inertia(pose) @ pose.spin
            )
            for body, pose in zip(bodies, poses, strict=True)
        )

    before = angular()
    for _ in range(20):
        after = [in_flight(pose, 0.04) for pose in poses]
        after[1] = replace(after[1], spin=tuple(np.linalg.solve(
            rod.inertia(after[1]), rod.inertia(poses[1]) @ poses[1].spin
        )))  # fmt: skip
        poses, _ = resolve(bodies, poses, after, VACUUM, H)
    assert poses[1].spin[2] < -0.1  # hit above the centre from the left
    assert abs(poses[1].spin[1]) > 1e-3
    np.testing.assert_allclose(angular(), before, atol=3e-3)
