"""Bodies that follow the fluid: their free coordinates, their momenta, and where they go next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.hold import Freedom
from pmesh.bodies.mask import Mask, put_mode
from pmesh.bodies.motion import Free, coordinates
from pmesh.bodies.pose import Pose
from pmesh.bodies.spring import grip, likely_inertia, own_inertia, speeds, spring_impulse
from pmesh.bodies.turning import turned_on

Array = NDArray[np.floating[Any]]
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
    """A pose dt later at constant acceleration, that of the step before but for springs.

    In space it turns by the spin in mid step.
    """
    past = pose.time - before.time
    speed = speeds(pose)
    gain = (dt / past if past > 0 else 0.0) * (speed - speeds(before))
    if isinstance(body.motion, Free) and body.motion.spring is not None:
        inertia, hold = likely_inertia(body, pose), grip(body, dt)
        if past > 0:  # what the spring did in the step before is no guide
            pulled = spring_impulse(body, before, past)
            pulled -= grip(body, past) * (speed - speeds(before))
            gain = gain - dt / past * np.linalg.solve(inertia, pulled)
        push = inertia @ gain + spring_impulse(body, pose, dt)
        gain = np.asarray(np.linalg.solve(inertia + np.diag(hold), push), np.float64)
    n, way = len(pose.center), dt * (speed + 0.5 * gain)
    speed = speed + gain
    return Pose(
        time=pose.time + dt,
        center=_plain(pose.center + way[:n]),
        angle=turned_on(pose.angle, way[n:]),
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
        for axis, name in enumerate(coordinates(body.ndim))
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

    ``impulses`` (bodies, m): force and torque times dt [L^(ndim+2)/T, L^(ndim+3)/T] that each body
    is given beside the fluid's at the end of a step of dt [T], and beside the grip of its spring.
    What turns keeps its angular momentum in world axes: I(after) spin = I(poses) spin + torque dt,
    which is Euler's equation with its gyroscopic term.
    """
    wanted = free_coordinates(bodies)
    if not wanted:
        return None
    cell = mask.grid.cell_volume
    modes = _modes(wanted, after, mask)
    inertia, push = np.zeros((len(wanted), len(wanted))), np.zeros(len(wanted))
    likely = np.zeros(len(wanted))
    for number in dict.fromkeys(number for number, _ in wanted):
        rows = [row for row, (owner, _) in enumerate(wanted) if owner == number]
        axes = [axis for owner, axis in wanted if owner == number]
        body, drift = bodies[number], np.asarray(mask.drift[number])
        excess, hold = excess_inertia(body, after[number]), grip(body, dt)
        speed = speeds(poses[number])
        momentum = excess_inertia(body, poses[number]) @ speed + excess @ drift
        given = momentum + hold * (speed + drift) + impulses[number]
        inertia[np.ix_(rows, rows)] = (excess + np.diag(hold))[np.ix_(axes, axes)] / cell
        push[rows] = given[axes] / cell
        likely[rows] = (speeds(after[number]) + drift)[axes]
    return Freedom(modes, inertia, push, likely)


def _modes(wanted: Sequence[tuple[int, int]], poses: Sequence[Pose], mask: Mask) -> Array:
    """Unit motions (m, ndim, *shape) along some coordinates, each on its body's own nodes."""
    grid, points = mask.grid, mask.grid.points()
    result = np.zeros((len(wanted), grid.ndim, *grid.shape))
    for mode, (number, axis) in zip(result, wanted, strict=True):
        put_mode(mode, axis, points, poses[number])
        if len(mask.drift) > 1:
            mode *= mask.owner == number
    return result


def excess_inertia(body: Body, pose: Pose) -> Values:
    """The body's masses and moments of inertia (m, m) less those of the fluid in its place."""
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    return (density - 1.0) * own_inertia(body, pose)


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
            found[number] = np.zeros(len(coordinates(body.ndim)))
    for (number, axis), value in zip(free_coordinates(bodies), values, strict=True):
        found[number][axis] = value
    poses = []
    for pose, speed, drift in zip(after, found, mask.drift, strict=True):
        total = [float(x) for x in speed - drift]
        n = len(pose.center)
        poses.append(replace(pose, velocity=tuple(total[:n]), spin=tuple(total[n:])))
    return tuple(poses)


def outer_impulses(bodies: Sequence[Body], poses: Sequence[Pose], dt: float) -> Values:
    """Impulse of gravity and springs over a step, (bodies, m), per unit fluid density.

    Of springs what they do to a body that keeps its velocity: the rest is their `grip`.
    """
    result = np.zeros((len(bodies), len(coordinates(bodies[0].ndim)) if bodies else 0))
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        if not isinstance(body.motion, Free):
            continue
        result[number] += spring_impulse(body, pose, dt)
        if body.motion.gravity:
            weight = (body.motion.density - 1.0) * body.measure.volume
            result[number, : body.ndim] += dt * weight * np.asarray(body.motion.gravity)
    return result
