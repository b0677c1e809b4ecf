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

from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free
from pmesh.bodies.pose import Pose

Values = NDArray[np.float64]


def spring_impulse(body: Body, pose: Pose, dt: float) -> Values:
    """Impulse (3,) of its spring over a step dt [T] on a body that keeps its velocity."""
    stiffness, damping = spring_constants(body)
    away = places(pose) - places(body.placed()) + 0.5 * dt * speeds(pose)
    return np.asarray(-dt * (stiffness * away + damping * speeds(pose)))


def grip(body: Body, dt: float) -> Values:
    """Impulse (3,) by which its spring resists a unit change of the velocity in a step dt [T]."""
    stiffness, damping = spring_constants(body)
    return np.asarray(dt * (0.5 * damping + 0.25 * dt * stiffness))


def spring_constants(body: Body) -> tuple[Values, Values]:
    """Stiffness and damping (3,) of a body's spring along x, y and angle; zeros if it has none."""
    spring = body.motion.spring if isinstance(body.motion, Free) else None
    if spring is None:
        return np.zeros(3), np.zeros(3)
    return (
        np.array([*(spring.stiffness or (0.0, 0.0)), spring.torsion]),
        np.array([*(spring.damping or (0.0, 0.0)), spring.twist_damping]),
    )


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


def speeds(pose: Pose) -> Values:
    """Velocity and spin as one row."""
    return np.array([*pose.velocity, *pose.spin])


def places(pose: Pose) -> Values:
    """Centre and angle as one row."""
    return np.array([*pose.center, *pose.angle])
