"""The profile that particles carry: the distance near the interface, level far from it.

``p(d) = w (x - 2 x^3 / 3 + x^5 / 5)`` with ``x = d / w`` up to the half width w of the band,
constant beyond: slope ``(1 - x^2)^2``, two continuous derivatives at the band's edge. What is level
needs no particles, and kernels of high order see no kink where the band ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
LEVEL = 8 / 15  # of the half width: the profile's value beyond it


def profile(distance: Array, width: float) -> Array:
    """The profile of signed distances [L], for a half width of ``width`` [L]."""
    x = np.clip(np.asarray(distance) / width, -1.0, 1.0)
    square = x * x
    return np.asarray(width * x * (1.0 + square * (-2.0 / 3.0 + 0.2 * square)))


def distance_of(values: Array, width: float) -> Array:
    """The signed distances [L] with these values of the profile, at most ``width``; its inverse.

    To round-off, but near the level part, where the profile is flat: 1e-5 of the width there.
    """
    level = np.clip(np.asarray(values, np.float64) / (LEVEL * width), -1.0, 1.0)
    left = 1.0 - np.abs(level)  # near the edge it goes with the cube of what is left
    x = np.where(left > 0.5, LEVEL * (1.0 - left), 1.0 - np.cbrt(0.4 * left))
    target = LEVEL * (1.0 - left)
    for _ in range(30):
        square = x * x
        slope = np.maximum((1.0 - square) ** 2, 1e-18)
        change = (x * (1.0 + square * (-2.0 / 3.0 + 0.2 * square)) - target) / slope
        x = np.where(left > 1e-12, np.clip(x - change, 0.0, 1.0), 1.0)
        if np.abs(change[left > 1e-9]).max(initial=0.0) < 1e-15:
            break
    return np.asarray(np.copysign(x * width, level))
