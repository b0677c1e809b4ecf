"""Smooth set algebra: union, intersection and difference with a rounded seam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from levelset.shape import Array, Bounds, _Pair, around, overlap, store_lengths


@dataclass(frozen=True)
class _Blend(_Pair):
    """Two shapes whose seam is rounded where both distances differ by less than ``radius``.

    |value| is a lower bound of the distance everywhere (the slope is at most 1). Where the
    distances of both shapes differ by ``radius`` or more it is what the sharp algebra gives,
    as exact as that; the seam itself is twice continuously differentiable, and moves by
    ``radius``/6 at most.
    """

    radius: float  # [L]

    def __post_init__(self) -> None:
        """Refuse what cannot be joined, and a radius that is not positive."""
        super().__post_init__()
        store_lengths(self, "radius")

    def _rounding(self, first: Array, second: Array) -> Array:
        """What the seam is moved by."""
        near = np.maximum(1.0 - np.abs(first - second) / self.radius, 0.0)
        return np.asarray(near**3 * (self.radius / 6.0))


class SmoothUnion(_Blend):
    """``a | b`` with its inner corners filled: smooth, and never less than the union."""

    def _distance(self, points: Array) -> Array:
        a, b = self.first._distance(points), self.second._distance(points)
        return np.asarray(np.minimum(a, b) - self._rounding(a, b))

    def reach(self, distance: float) -> Bounds:
        """The box around both boxes, grown by what the seam may add."""
        far = distance + self.radius / 6.0
        return around(self.first.reach(far), self.second.reach(far))


class SmoothIntersection(_Blend):
    """``a & b`` with its edges rounded off: smooth, and never more than the intersection."""

    def _distance(self, points: Array) -> Array:
        a, b = self.first._distance(points), self.second._distance(points)
        return np.asarray(np.maximum(a, b) + self._rounding(a, b))

    def reach(self, distance: float) -> Bounds:
        """The overlap of both boxes; refuses shapes whose boxes do not meet."""
        return overlap(self.first.reach(distance), self.second.reach(distance))


class SmoothDifference(_Blend):
    """``a - b`` with the edges of the cut rounded off: smooth, never more than the difference."""

    def _distance(self, points: Array) -> Array:
        a, b = self.first._distance(points), -self.second._distance(points)
        return np.asarray(np.maximum(a, b) + self._rounding(a, b))

    def reach(self, distance: float) -> Bounds:
        """The box of the first."""
        return self.first.reach(distance)
