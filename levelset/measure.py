"""Volume, centre and second moments of a shape."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from levelset.contour import contour
from levelset.shape import Point, Shape
from remesh.errors import InputError

Values = NDArray[np.float64]
CELLS = 1024  # along the longest side of the box from which a plane shape is measured


@dataclass(frozen=True, kw_only=True)
class Measure:
    """Volume [L^ndim], centre [L] and second moment about it [L^(ndim+2)] (plane: polar)."""

    volume: float
    center: Point
    inertia: float


@lru_cache(maxsize=64)
def measure(shape: Shape) -> Measure:
    """The moments of a shape, from its zero contour: exact for the polygon, which is of order 2.

    About 1e-6 relative for a smooth plane shape; refuses a shape that the contour does not see.
    """
    volume = 0.0
    first, second = np.zeros(2), 0.0
    for line in contour(shape, cells=CELLS):
        one, two, three = _polygon(line)
        volume, first, second = volume + one, first + two, second + three
    if not volume > 0:
        raise InputError("the shape has no inside", hint="a shape of positive volume")
    center = first / volume
    return Measure(
        volume=volume,
        center=tuple(float(x) for x in center),
        inertia=second - volume * float(center @ center),
    )


def _polygon(line: Values) -> tuple[float, Values, float]:
    """Area, first moments and polar moment about the origin of a closed line (n, 2)."""
    here, there = line, np.roll(line, -1, axis=0)
    cross = here[:, 0] * there[:, 1] - there[:, 0] * here[:, 1]
    area = 0.5 * cross.sum()
    first = (cross[:, None] * (here + there)).sum(axis=0) / 6
    second = (cross[:, None] * (here**2 + here * there + there**2)).sum() / 12
    return float(area), first, float(second)
