"""Many explicit stages in one long step of a stiff dissipative law: super-time-stepping."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple


class Stage(NamedTuple):
    """Weights of a stage: of the last value, the one before, the first; of their rates, dt aside.

    ``Y = last Y1 + before Y2 + first Y0 + dt (rate M(Y1) + start M(Y0))``.
    """

    last: float
    before: float
    first: float
    rate: float
    start: float


def stage_count(ratio: float) -> int:
    """The least odd number of stages, 3 or more, for a step of ``ratio`` explicit ones."""
    least = 0.5 * (math.sqrt(9.0 + 16.0 * ratio) - 1.0)
    count = max(3, math.ceil(least - 1e-9))
    return count + 1 - count % 2


@lru_cache(maxsize=64)
def stages(count: int) -> tuple[Stage, ...]:
    """The stages of RKL2: of order 2, stable on the negative real axis, damping all of it.

    ``count`` stages reach ``(count^2 + count - 2)/4`` explicit steps; between 0 and there no wave
    grows, whatever the step.
    Source: Meyer, Balsara & Aslam, J. Comput. Phys. 257 (2014) 594, equations 14 to 18.
    """
    b = [1 / 3, 1 / 3] + [(j * j + j - 2) / (2 * j * (j + 1)) for j in range(2, count + 1)]
    w = 4.0 / (count * count + count - 2)
    result = [Stage(1.0, 0.0, 0.0, b[1] * w, 0.0)]
    for j in range(2, count + 1):
        last = (2 * j - 1) / j * b[j] / b[j - 1]
        before = -(j - 1) / j * b[j] / b[j - 2]
        rate = last * w
        result.append(Stage(last, before, 1.0 - last - before, rate, -(1.0 - b[j - 1]) * rate))
    return tuple(result)
