"""Bodies that follow the fluid: their free coordinates, their momenta, and where they go next.

A step changes a momentum by the mean force. That of a spring (stiffness k, damping c) from a place
x off its rest, with velocity V before and V' after, is taken at the middle of the step,

    s = -k (x + dt (V + V')/4) - c (V + V')/2 = s0 - (V' - V) grip/dt,
    s0 = -k (x + dt V/2) - c V,    grip = dt (c/2 + k dt/4):

s0 is known, and the grip joins the inertia in the equation for V'. So it is of order two, keeps the
energy of a spring, and is stable for any k and c. The places must know it too, as they are foreseen
before V' is found: there the mass that the fluid adds is that of an ellipse.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.hold import Freedom
from pmesh.bodies.mask import Mask, rigid_modes
from pmesh.bodies.motion import COORDINATES, Free
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
        after.append(_glided(body, before, pose, dt))
    return tuple(after)


def _glided(body: Body, before: Pose, pose: Pose, dt: float) -> Pose:
    """A pose dt later at constant acceleration, that of the step before but for springs."""
    past = pose.time - before.time
    speed = _speeds(pose)
    gain = (dt / past if past > 0 else 0.0) * (speed - _speeds(before))
    if isinstance(body.motion, Free) and body.motion.spring is not None:
        inertia, hold = likely_inertia(body, pose), grip(body, dt)
        if past > 0:  # what the spring did in the step before is no guide
            pulled = spring_impulse(body, before, past)
            pulled -= grip(body, past) * (speed - _speeds(before))
            gain -= dt / past * pulled / inertia
        gain = (gain + spring_impulse(body, pose, dt) / inertia) / (1.0 + hold / inertia)
    n, place = len(pose.center), _places(pose) + dt * (speed + 0.5 * gain)
    speed = speed + gain
    return Pose(
        time=pose.time + dt,
        center=_plain(place[:n]),
        angle=_plain(place[n:]),
        velocity=_plain(speed[:n]),
        spin=_plain(speed[n:]),
    )


def _speeds(pose: Pose) -> Values:
    return np.array([*pose.velocity, *pose.spin])


def _places(pose: Pose) -> Values:
    return np.array([*pose.center, *pose.angle])


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
        drift, speed = mask.drift[number][axis], _speeds(poses[number])[axis]
        momentum = excess_inertia(body, axis, poses[number]) * speed + excess * drift
        push.append((momentum + hold * (speed + drift) + impulses[number, axis]) / cell)
        likely.append(_speeds(after[number])[axis] + drift)
    return Freedom(np.stack(modes), np.array(inertia), np.array(push), np.array(likely))


def excess_inertia(body: Body, axis: int, pose: Pose) -> float:
    """The body's mass (moment of inertia for the angle) less that of the fluid in its place."""
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    return (density - 1.0) * (body.inertia(pose) if axis == 2 else body.measure.volume)


def likely_inertia(body: Body, pose: Pose) -> Values:
    """Masses along x and y and moment of inertia (3,) of a free body with the fluid it carries.

    The added ones are those of an ellipse as long and as wide, of axes 2a and 2b: pi b^2 along a,
    pi a^2 along b, pi/8 (a^2 - b^2)^2 (H. Lamb, *Hydrodynamics*, 6th ed., art. 71).
    """
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    low, high = body.bounds(replace(pose, angle=(0.0,) * len(pose.angle)))
    a, b = (0.5 * (end - begin) for begin, end in zip(low, high, strict=True))
    c, s = math.cos(pose.angle[0]) ** 2, math.sin(pose.angle[0]) ** 2
    along = np.array([c * b * b + s * a * a, s * b * b + c * a * a, (a * a - b * b) ** 2 / 8])
    volume = body.measure.volume
    return np.asarray(math.pi * along + density * np.array([volume, volume, body.inertia(pose)]))


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


def spring_impulse(body: Body, pose: Pose, dt: float) -> Values:
    """Impulse (3,) of its spring over a step dt [T] on a body that keeps its velocity."""
    stiffness, damping = _constants(body)
    away = _places(pose) - _places(body.placed()) + 0.5 * dt * _speeds(pose)
    return np.asarray(-dt * (stiffness * away + damping * _speeds(pose)))


def grip(body: Body, dt: float) -> Values:
    """Impulse (3,) by which its spring resists a unit change of the velocity in a step dt [T]."""
    stiffness, damping = _constants(body)
    return np.asarray(dt * (0.5 * damping + 0.25 * dt * stiffness))


def _constants(body: Body) -> tuple[Values, Values]:
    """Stiffness and damping (3,) of a body's spring along x, y and angle; zeros without one."""
    spring = body.motion.spring if isinstance(body.motion, Free) else None
    if spring is None:
        return np.zeros(3), np.zeros(3)
    return (
        np.array([*(spring.stiffness or (0.0, 0.0)), spring.torsion]),
        np.array([*(spring.damping or (0.0, 0.0)), spring.twist_damping]),
    )
