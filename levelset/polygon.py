"""The polygon, with its exact signed distance."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from levelset.shape import Array, Bounds, Shape, vector
from remesh.errors import InputError

Corner = tuple[float, float]


@dataclass(frozen=True)
class Polygon(Shape):
    """A simple polygon from its corners in order, either way round.

    Exact everywhere; costs corners times points.
    """

    corners: tuple[Corner, ...]  # [L]

    def __post_init__(self) -> None:
        """Refuse fewer than 3 corners, repeated ones, and sides that meet."""
        given = list(self.corners) if isinstance(self.corners, Iterable) else []
        corners = [vector(f"Polygon: corner {i}", corner, 2) for i, corner in enumerate(given)]
        if len(corners) < 3:
            raise InputError(
                f"Polygon: needs at least 3 corners, got {self.corners!r}",
                hint="Polygon(((0, 0), (1, 0), (0, 1)))",
            )
        object.__setattr__(self, "corners", tuple(corners))
        sides = self._sides()
        if any(a == b for a, b in sides) or self.volume == 0.0:
            raise InputError("Polygon: repeated corners or no area", hint="each corner once")
        count = len(sides)
        for i in range(count):
            for j in range(i + 2, count - (i == 0)):
                if _meet(*sides[i], *sides[j]):
                    raise InputError(
                        f"Polygon: sides {i} and {j} meet", hint="corners in order around the edge"
                    )

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    def _sides(self) -> list[tuple[Corner, Corner]]:
        """Pairs of neighbouring corners."""
        return list(zip(self.corners, self.corners[1:] + self.corners[:1], strict=True))

    @property
    def volume(self) -> float:
        """Area, by the shoelace formula."""
        return abs(0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in self._sides()))

    @property
    def perimeter(self) -> float:
        """Length of the boundary [L]."""
        return sum(math.dist(a, b) for a, b in self._sides())

    def bounds(self) -> Bounds:
        """The rectangle around the corners."""
        xs, ys = zip(*self.corners, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))

    def _distance(self, points: Array) -> Array:
        x, y = points
        nearest = np.full(x.shape, np.inf, points.dtype)
        inside = np.zeros(x.shape, np.bool_)
        for (ax, ay), (bx, by) in self._sides():
            ex, ey, px, py = bx - ax, by - ay, x - ax, y - ay
            along = np.clip((px * ex + py * ey) / (ex * ex + ey * ey), 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(px - along * ex, py - along * ey))
            spans = (ay <= y) != (by <= y)
            left = ex * py > ey * px
            inside ^= spans & (left == (by > ay))
        return np.asarray(np.where(inside, -nearest, nearest))


def _meet(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Whether the segments ab and cd share a point."""

    def side(p: Corner, q: Corner, r: Corner) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    boxes_meet = all(
        max(min(a[i], b[i]), min(c[i], d[i])) <= min(max(a[i], b[i]), max(c[i], d[i]))
        for i in (0, 1)
    )
    astride = side(a, b, c) * side(a, b, d) <= 0 and side(c, d, a) * side(c, d, b) <= 0
    return boxes_meet and astride
