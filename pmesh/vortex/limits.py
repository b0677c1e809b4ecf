"""What bodies ask of a time step."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free, Prescribed
from pmesh.bodies.pose import Pose
from pmesh.bodies.spring import ellipsoid_like, likely_inertia, spring_constants
from pmesh.vortex.state import FlowState
from remesh.limit import Limit

LAW = 0.05  # of the scale of a law of motion, at most
BEAT = 0.01  # of the period of a deforming body
FALL = 0.25  # spacings that a body falls from rest
DROP = 0.0625  # the same in the first step, which does not know the acceleration
SWING = 0.5  # radians of a spring's swing


def body_limits(bodies: Sequence[Body], state: FlowState, viscosity: float) -> list[Limit]:
    """What bodies ask of a step: see `VortexFlow.limit`."""
    if not bodies:
        return []
    size = min(map(thickness, bodies))
    limits = [
        Limit(ratio(0.1 * size, state.speed), "body"),
        Limit(0.01 * size**2 / viscosity, "diffusion"),
    ]
    for body, pose in zip(bodies, state.poses, strict=True):
        motion, dt = body.motion, BEAT * body.period
        if isinstance(motion, Prescribed):
            dt = min(dt, LAW * motion.scale)
        if isinstance(motion, Free):
            fall = state.grid.spacing * (FALL if state.step else DROP)
            dt = min(dt, _falling(motion, body.ndim, fall))
            dt = min(dt, math.inf if motion.spring is None else _swinging(body, pose))
        limits.append(Limit(dt, "motion"))
    return limits


def thickness(body: Body) -> float:
    """The shortest axis [L] of the ellipse with a body's area and inertia, however it is turned.

    In space of the ellipsoid with its volume and the proportions of its second moments.
    """
    if body.ndim == 3:
        squares, _ = ellipsoid_like(body, body.placed())
        mean = math.sqrt(float(np.prod(squares)) ** (1 / 3))
        radius = (0.75 * body.measure.volume / math.pi) ** (1 / 3)
        return 2.0 * math.sqrt(float(squares.min())) * float(radius) / mean
    second = 4.0 * body.measure.inertia / body.measure.volume
    area = body.measure.volume / math.pi
    rest = math.sqrt(max(second**2 - 4.0 * area**2, 0.0))
    return 2.0 * area * math.sqrt(2.0 / (second + rest))


def _falling(motion: Free, ndim: int, fall: float) -> float:
    """Time [T] in which a body with the added mass of a disk or ball falls so far [L] from rest."""
    pull = abs(motion.density - 1.0) * math.hypot(*motion.gravity)
    carried = motion.density + (1.0 if ndim == 2 else 0.5)
    return math.sqrt(2.0 * fall * carried / pull) if pull > 0 else math.inf


def _swinging(body: Body, pose: Pose) -> float:
    """Time [T] in which the stiffest of a body's springs swings half a radian."""
    stiffness, _ = spring_constants(body)
    rates = np.linalg.eigvals(np.linalg.solve(likely_inertia(body, pose), np.diag(stiffness)))
    fastest = float(np.max(rates.real))
    return ratio(SWING, math.sqrt(fastest))


def ratio(allowed: float, rate: float) -> float:
    """The step at which a rate uses up what is allowed."""
    return allowed / rate if rate > 0 else math.inf
