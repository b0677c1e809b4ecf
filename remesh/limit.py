"""The largest time step that something allows, and the rule that set it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from remesh.errors import InputError, as_number


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


def check_step(dt: float) -> float:
    """The step dt [T] as a plain float; refuses what is not a positive, finite number."""
    step = as_number("dt", dt, hint="flow.limit(state).dt")
    if not (math.isfinite(step) and step > 0):
        raise InputError(f"dt must be positive and finite, got {step}", hint="flow.limit(state).dt")
    return step
