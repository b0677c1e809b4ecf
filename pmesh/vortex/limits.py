"""The largest time step a state allows, and the rule that set it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free, Prescribed
from pmesh.vortex.state import State
from remesh.errors import InputError

LAW = 0.05  # of the scale of a law of motion, at most
BEAT = 0.01  # of the period of a deforming body


@dataclass(frozen=True)
class Limit:
    """A largest time step [T] and the name of the rule that set it."""

    dt: float
    rule: str


def tightest(*limits: Limit) -> Limit:
    """The limit with the smallest step; of equal ones the first. A step that is NaN wins."""
    if not limits:
        raise InputError(
            "tightest() compares limits, got none", hint="tightest(Limit(0.1, 'body'))"
        )
    return min(limits, key=lambda limit: (limit.dt == limit.dt, limit.dt))


def body_limits(bodies: Sequence[Body], state: State, viscosity: float) -> list[Limit]:
    """What bodies ask of a step: see `VortexFlow.limit`."""
    if not bodies:
        return []
    size = min(
        b - a
        for body, pose in zip(bodies, state.poses, strict=True)
        for a, b in zip(*body.bounds(pose), strict=True)
    )
    limits = [
        Limit(ratio(0.1 * size, state.speed), "body"),
        Limit(0.01 * size**2 / viscosity, "diffusion"),
    ]
    for body in bodies:
        motion, dt = body.motion, BEAT * body.period
        if isinstance(motion, Prescribed):
            dt = min(dt, LAW * motion.scale)
        if isinstance(motion, Free) and motion.gravity and motion.density != 1.0:
            pull = abs(motion.density - 1.0) * math.hypot(*motion.gravity)
            dt = min(dt, math.sqrt(2.0 * state.grid.spacing * (motion.density + 1.0) / pull))
        limits.append(Limit(dt, "motion"))
    return limits


def ratio(allowed: float, rate: float) -> float:
    """The step at which a rate uses up what is allowed."""
    return allowed / rate if rate > 0 else math.inf
