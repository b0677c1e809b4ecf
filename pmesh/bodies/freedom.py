"""Bodies that follow the fluid: their free coordinates, their momenta, and where they go next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.hold import Freedom
from pmesh.bodies.mask import Mask, rigid_modes
from pmesh.bodies.motion import COORDINATES, Free
from pmesh.bodies.pose import Pose
from pmesh.bodies.spring import grip, likely_inertia, places, speeds, spring_impulse

Values = NDArray[np.float64]


def predicted(
    bodies: Sequence[Body], earlier: Sequence[Pose], poses: Sequence[Pose], dt: float
) -> tuple[Pose, ...]:
    """The poses dt [T] later: laws of time exactly, free bodies by Adams-Bashforth of order 2."""
    after = []
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        if not isinstance(body.motion, Free):
            after.append(body.motion.pose(body.placed(), pose.time + dt))
            continue
        before = earlier[number] if earlier else pose
        after.append(_glided(body, before, pose, dt))
    return tuple(after)


def _glided(body: Body, before: Pose, pose: Pose, dt: float) -> Pose:
    """A pose dt later at constant acceleration, that of the step before but for springs."""
    past = pose.time - before.time
    speed = speeds(pose)
    gain = (dt / past if past > 0 else 0.0) * (speed - speeds(before))
    if isinstance(body.motion, Free) and body.motion.spring is not None:
        inertia, hold = likely_inertia(body, pose), grip(body, dt)
        if past > 0:  # what the spring did in the step before is no guide
            pulled = spring_impulse(body, before, past)
            pulled -= grip(body, past) * (speed - speeds(before))
            gain -= dt / past * pulled / inertia
        gain = (gain + spring_impulse(body, pose, dt) / inertia) / (1.0 + hold / inertia)
    n, place = len(pose.center), places(pose) + dt * (speed + 0.5 * gain)
    speed = speed + gain
    return Pose(
        time=pose.time + dt,
        center=_plain(place[:n]),
        angle=_plain(place[n:]),
        velocity=_plain(speed[:n]),
        spin=_plain(speed[n:]),
    )


def _plain(values: Values) -> tuple[float, ...]:
    return tuple(float(x) for x in values)


def free_coordinates(bodies: Sequence[Body]) -> list[tuple[int, int]]:
    """(body, coordinate) of all that follow the fluid."""
    return [
        (number, axis)
        for number, body in enumerate(bodies)
        if isinstance(body.motion, Free)
        for axis, name in enumerate(COORDINATES)
        if name not in body.motion.locked
    ]


def freedom_of(
    bodies: Sequence[Body],
    poses: Sequence[Pose],
    after: Sequence[Pose],
    mask: Mask,
    impulses: Values,
    dt: float,
) -> Freedom | None:
    """The free coordinates on a mask of the ``after`` poses; None if no body is free.

    ``impulses`` (bodies, 3): force and torque times dt [L^4/T, L^5/T] that each body is given
    beside the fluid's at the end of a step of dt [T], and beside the grip of its spring.
    """
    wanted = free_coordinates(bodies)
    if not wanted:
        return None
    cell = mask.grid.cell_volume
    points = mask.grid.points()
    modes, inertia, push, likely = [], [], [], []
    for number, axis in wanted:
        body, own = bodies[number], mask.owner == number
        excess, hold = excess_inertia(body, axis, after[number]), grip(body, dt)[axis]
        modes.append(np.where(own, rigid_modes(points, after[number])[axis], 0.0))
        inertia.append((excess + hold) / cell)
        drift, speed = mask.drift[number][axis], speeds(poses[number])[axis]
        momentum = excess_inertia(body, axis, poses[number]) * speed + excess * drift
        push.append((momentum + hold * (speed + drift) + impulses[number, axis]) / cell)
        likely.append(speeds(after[number])[axis] + drift)
    return Freedom(np.stack(modes), np.array(inertia), np.array(push), np.array(likely))


def excess_inertia(body: Body, axis: int, pose: Pose) -> float:
    """The body's mass (moment of inertia for the angle) less that of the fluid in its place."""
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    return (density - 1.0) * (body.inertia(pose) if axis == 2 else body.measure.volume)


def arrived(
    bodies: Sequence[Body], after: Sequence[Pose], mask: Mask, values: Sequence[float]
) -> tuple[Pose, ...]:
    """The ``after`` poses with the velocities that were found.

    The matter moves with the found velocity and the deformation less its drift on the mesh: so
    the shape, which has all of the deformation, moves with the found velocity less the drift.
    """
    found = [speeds(pose) for pose in after]
    for number, body in enumerate(bodies):
        if isinstance(body.motion, Free):
            found[number] = np.zeros(len(COORDINATES))
    for (number, axis), value in zip(free_coordinates(bodies), values, strict=True):
        found[number][axis] = value
    poses = []
    for pose, speed, drift in zip(after, found, mask.drift, strict=True):
        total = [float(x) for x in speed - drift]
        n = len(pose.center)
        poses.append(replace(pose, velocity=tuple(total[:n]), spin=tuple(total[n:])))
    return tuple(poses)


def outer_impulses(bodies: Sequence[Body], poses: Sequence[Pose], dt: float) -> Values:
    """Impulse of gravity and springs over a step, (bodies, 3), per unit fluid density.

    Of springs what they do to a body that keeps its velocity: the rest is their `grip`.
    """
    result = np.zeros((len(bodies), len(COORDINATES)))
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        if not isinstance(body.motion, Free):
            continue
        result[number] += spring_impulse(body, pose, dt)
        if body.motion.gravity:
            weight = excess_inertia(body, 0, pose)
            result[number, :2] += dt * weight * np.asarray(body.motion.gravity)
    return result
