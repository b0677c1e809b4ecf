"""The largest time step that something allows, and the rule that set it."""

from __future__ import annotations

from dataclasses import dataclass

from remesh.errors import InputError


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
