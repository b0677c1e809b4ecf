"""Bodies that follow the fluid: their free coordinates, their momenta, and where they go next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.mask import Mask, rigid_modes
from pmesh.bodies.motion import COORDINATES, Free
from pmesh.bodies.hold import Freedom
from pmesh.bodies.pose import Pose

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
        after.append(_glided(before, pose, dt))
    return tuple(after)


def _glided(before: Pose, pose: Pose, dt: float) -> Pose:
    """A pose dt later at constant acceleration, that of the step before."""
    past = pose.time - before.time
    share = dt / past if past > 0 else 0.0
    speed, spin = np.asarray(pose.velocity), np.asarray(pose.spin)
    gain, turn = share * (speed - before.velocity), share * (spin - before.spin)
    return Pose(
        time=pose.time + dt,
        center=_plain(pose.center + dt * (speed + 0.5 * gain)),
        angle=_plain(pose.angle + dt * (spin + 0.5 * turn)),
        velocity=_plain(speed + gain),
        spin=_plain(spin + turn),
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
) -> Freedom | None:
    """The free coordinates on a mask of the ``after`` poses; None if no body is free.

    ``impulses`` (bodies, 3): force and torque times dt [L^4/T, L^5/T] that each body is given
    beside the fluid's at the end of the step.
    """
    wanted = free_coordinates(bodies)
    if not wanted:
        return None
    cell = mask.grid.cell_volume
    points = mask.grid.points()
    modes, inertia, push, likely = [], [], [], []
    for number, axis in wanted:
        body, own = bodies[number], mask.owner == number
        excess = excess_inertia(body, axis)
        modes.append(np.where(own, rigid_modes(points, after[number])[axis], 0.0))
        inertia.append(excess / cell)
        drift = mask.drift[number][axis]
        speed = (*poses[number].velocity, *poses[number].spin)[axis] + drift
        push.append((excess * speed + impulses[number, axis]) / cell)
        likely.append((*after[number].velocity, *after[number].spin)[axis] + drift)
    return Freedom(np.stack(modes), np.array(inertia), np.array(push), np.array(likely))


def excess_inertia(body: Body, axis: int) -> float:
    """The body's mass (moment of inertia for the angle) less that of the fluid in its place."""
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    measure = body.measure
    return (density - 1.0) * (measure.inertia if axis == 2 else measure.volume)


def arrived(
    bodies: Sequence[Body], after: Sequence[Pose], mask: Mask, values: Sequence[float]
) -> tuple[Pose, ...]:
    """The ``after`` poses with the velocities that were found.

    The matter moves with the found velocity and the deformation less its drift on the mesh: so
    the shape, which has all of the deformation, moves with the found velocity less the drift.
    """
    speeds = [np.array([*pose.velocity, *pose.spin]) for pose in after]
    for number, body in enumerate(bodies):
        if isinstance(body.motion, Free):
            speeds[number] = np.zeros(len(COORDINATES))
    for (number, axis), value in zip(free_coordinates(bodies), values, strict=True):
        speeds[number][axis] = value
    poses = []
    for pose, speed, drift in zip(after, speeds, mask.drift, strict=True):
        total = [float(x) for x in speed - drift]
        n = len(pose.center)
        poses.append(replace(pose, velocity=tuple(total[:n]), spin=tuple(total[n:])))
    return tuple(poses)


def outer_impulses(
    bodies: Sequence[Body], poses: Sequence[Pose], after: Sequence[Pose], dt: float
) -> Values:
    """Impulse of gravity and springs over a step, (bodies, 3), per unit fluid density."""
    result = np.zeros((len(bodies), len(COORDINATES)))
    for number, (body, old, new) in enumerate(zip(bodies, poses, after, strict=True)):
        if not isinstance(body.motion, Free):
            continue
        motion, placed = body.motion, body.placed()
        if motion.gravity:
            result[number, :2] += dt * excess_inertia(body, 0) * np.asarray(motion.gravity)
        if motion.spring is None:
            continue
        spring = motion.spring
        shift = 0.5 * (np.asarray(old.center) + np.asarray(new.center)) - placed.center
        turn = 0.5 * (old.angle[0] + new.angle[0]) - placed.angle[0]
        result[number, :2] -= dt * np.asarray(spring.stiffness or (0.0, 0.0)) * shift
        result[number, :2] -= dt * np.asarray(spring.damping or (0.0, 0.0)) * old.velocity
        result[number, 2] -= dt * (spring.torsion * turn + spring.twist_damping * old.spin[0])
    return result
