"""The springs of bodies that follow the fluid, and the mass with which those answer.

A step changes a momentum by the mean force. That of a spring (stiffness k, damping c) from a place
x off its rest, with velocity V before and V' after, is taken at the middle of the step,

    s = -k (x + dt (V + V')/4) - c (V + V')/2 = s0 - (V' - V) grip/dt,
    s0 = -k (x + dt V/2) - c V,    grip = dt (c/2 + k dt/4):

s0 is known, and the grip joins the inertia in the equation for V': order two. The places are
foreseen before V' is found, by the same law with the mass that an ellipse would have. With that
mass the energy of a spring stays, and any k and c are stable; so they are with up to 1.8 times it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free, coordinates
from pmesh.bodies.pose import Pose
from pmesh.bodies.turning import turn_between

Values = NDArray[np.float64]


def spring_impulse(body: Body, pose: Pose, dt: float) -> Values:
    """Impulse (m,) of its spring over a step dt [T] on a body that keeps its velocity.

    The torque about a turn is that of an energy which knows its angle alone, |turn|^2 torsion / 2.
    """
    stiffness, damping = spring_constants(body)
    away = _away(body.placed(), pose) + 0.5 * dt * speeds(pose)
    return np.asarray(-dt * (stiffness * away + damping * speeds(pose)))


def grip(body: Body, dt: float) -> Values:
    """Impulse (m,) by which its spring resists a unit change of the velocity in a step dt [T]."""
    stiffness, damping = spring_constants(body)
    return np.asarray(dt * (0.5 * damping + 0.25 * dt * stiffness))


def spring_constants(body: Body) -> tuple[Values, Values]:
    """Stiffness and damping (m,) of a body's spring along its coordinates; zeros if it has none."""
    ndim = body.ndim
    turns = len(coordinates(ndim)) - ndim
    spring = body.motion.spring if isinstance(body.motion, Free) else None
    if spring is None:
        return np.zeros(ndim + turns), np.zeros(ndim + turns)
    none = (0.0,) * ndim
    return (
        np.array([*(spring.stiffness or none), *(spring.torsion,) * turns]),
        np.array([*(spring.damping or none), *(spring.twist_damping,) * turns]),
    )


def likely_inertia(body: Body, pose: Pose) -> Values:
    """Masses and moments of inertia (m, m) of a free body with the fluid that it likely carries.

    In the plane that of an ellipse as long and as wide, in space that of the ellipsoid with the
    body's volume and second moments.
    """
    density = body.motion.density if isinstance(body.motion, Free) else 1.0
    if body.ndim == 3:
        return density * own_inertia(body, pose) + ellipsoid_added(body, pose)
    low, high = body.bounds(replace(pose, angle=(0.0,) * len(pose.angle)))
    a, b = (0.5 * (end - begin) for begin, end in zip(low, high, strict=True))
    return np.diag(math.pi * _ellipse_added(a, b, pose.angle[0])) + density * own_inertia(
        body, pose
    )


def own_inertia(body: Body, pose: Pose) -> Values:
    """Volume along each axis and second moments about each (m, m), in world axes."""
    turning = np.atleast_2d(body.inertia(pose))
    n, m = body.ndim, body.ndim + len(turning)
    result = np.zeros((m, m))
    result[:n, :n] = body.measure.volume * np.eye(n)
    result[n:, n:] = turning
    return result


def _ellipse_added(a: float, b: float, angle: float) -> Values:
    """Added masses (3,) over pi of an ellipse of axes 2a and 2b.

    b^2 along a, a^2 along b, (a^2 - b^2)^2 / 8 (H. Lamb, *Hydrodynamics*, 6th ed., art. 71).
    """
    c, s = math.cos(angle) ** 2, math.sin(angle) ** 2
    return np.array([c * b * b + s * a * a, s * b * b + c * a * a, (a * a - b * b) ** 2 / 8])


def ellipsoid_added(body: Body, pose: Pose) -> Values:
    """Added masses and moments (6, 6), world axes, of the ellipsoid like a body in space.

    With A_i = abc int ds / ((a_i^2 + s) D), D = sqrt((a^2 + s)(b^2 + s)(c^2 + s)), over the volume:
    A_i / (2 - A_i) along an axis, and about one, with the other two axes j and k,
    d^2 (A_k - A_j) / (5 (2 d - t (A_k - A_j))), d = a_j^2 - a_k^2, t = a_j^2 + a_k^2; 0 where those
    are equal (H. Lamb, *Hydrodynamics*, 6th ed., art. 114, 115).
    """
    squares, turn = ellipsoid_like(body, pose)
    root = math.sqrt(math.prod(squares))
    shares = [
        2.0 / 3.0 * root * float(elliprd(*np.delete(squares, i), squares[i])) for i in range(3)
    ]
    along = [share / (2.0 - share) for share in shares]
    about = []
    for j, k in ((1, 2), (2, 0), (0, 1)):
        d, t, gap = squares[j] - squares[k], squares[j] + squares[k], shares[k] - shares[j]
        about.append(0.2 * d * d * gap / (2.0 * d - t * gap) if abs(d) > 1e-9 * t else 0.0)
    result = np.zeros((6, 6))
    result[:3, :3] = (turn * along) @ turn.T
    result[3:, 3:] = (turn * about) @ turn.T
    return body.measure.volume * result


def ellipsoid_like(body: Body, pose: Pose) -> tuple[Values, Values]:
    """Squared half axes (3,) of the ellipsoid with a body's second moments over its volume, and
    their ways as columns (3, 3)."""
    inertia = np.asarray(body.inertia(pose))
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    values, turn = np.linalg.eigh(second)
    return np.asarray(5.0 * values / body.measure.volume), np.asarray(turn)


def speeds(pose: Pose) -> Values:
    """Velocity and spin as one row."""
    return np.array([*pose.velocity, *pose.spin])


def _away(rest: Pose, pose: Pose) -> Values:
    """How far a centre is shifted, and a body turned, as one row."""
    shift = np.subtract(pose.center, rest.center)
    return np.array([*shift, *turn_between(rest.angle, pose.angle)])
