"""Which step comes next: a function of the state and of fixed parameters, never of history."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pmesh.run.protocols import LANDING
from remesh.limit import Limit


def next_stop(time: float, until: float, every: Sequence[float]) -> float:
    """The first time after ``time`` to land on: a multiple of an ``every``, or the end."""
    stop = until
    for pace in every:
        k = math.floor(time / pace)
        while k * pace <= time + LANDING * pace:
            k += 1
        if k * pace < stop - LANDING * pace:
            stop = k * pace
    return stop


def next_step(time: float, stop: float, limit: Limit) -> Limit:
    """The step towards ``stop``: as many equal ones as the limit asks for, so none is tiny."""
    remaining = stop - time
    steps = max(1, math.ceil(remaining / limit.dt * (1 - LANDING)))
    dt = remaining / steps
    return Limit(dt, limit.rule if steps > 1 or dt >= 0.999 * limit.dt else "landing")


def arrives(time: float, stop: float, dt: float) -> bool:
    """Whether a step that ends at ``time`` was meant to end at ``stop`` exactly."""
    return abs(stop - time) <= LANDING * dt
