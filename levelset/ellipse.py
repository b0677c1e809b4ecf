"""The ellipse and the ellipsoid, with their exact signed distances."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from levelset.shape import (
    Array,
    Bounds,
    Moments,
    Point,
    Shape,
    box_around,
    seen_from,
    store_sides,
    store_vector,
)


@dataclass(frozen=True)
class Ellipse(Shape):
    """An ellipse with half axes along x and y; exact by Newton on the foot point, in double."""

    axes: tuple[float, float]  # half axes along x and y [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse half axes that are not two positive lengths."""
        store_sides(self, "axes", 2)
        store_vector(self, "center", 2)

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def volume(self) -> float:
        """Area pi a b."""
        return math.pi * self.axes[0] * self.axes[1]

    @property
    def surface(self) -> float:
        """Length of the boundary, 4 a E(1 - (b/a)^2): a complete elliptic integral."""
        from scipy.special import ellipe

        major, minor = max(self.axes), min(self.axes)
        return float(4.0 * major * ellipe((1.0 - minor / major) * (1.0 + minor / major)))

    def bounds(self) -> Bounds:
        """The rectangle around it."""
        return box_around(self.center, self.axes)

    def _moments(self) -> Moments:
        return self.volume, self.center, self.volume * sum(a * a for a in self.axes) / 4

    def _distance(self, points: Array) -> Array:
        return _distance(points, self.center, self.axes)


@dataclass(frozen=True)
class Ellipsoid(Shape):
    """An ellipsoid with half axes along x, y, z; exact by Newton on the foot point, in double."""

    axes: tuple[float, float, float]  # half axes along x, y and z [L]
    center: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse half axes that are not three positive lengths."""
        store_sides(self, "axes", 3)
        store_vector(self, "center", 3)

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    @property
    def volume(self) -> float:
        """Volume 4/3 pi a b c."""
        return 4.0 / 3.0 * math.pi * math.prod(self.axes)

    @property
    def surface(self) -> float:
        """Area of the boundary, 4 pi R_G(a^2 b^2, b^2 c^2, c^2 a^2).

        Source: B. C. Carlson's symmetric integral of the second kind, DLMF 19.33.1.
        """
        from scipy.special import elliprg

        a, b, c = (axis * axis for axis in self.axes)
        return float(4.0 * math.pi * elliprg(a * b, b * c, c * a))

    def bounds(self) -> Bounds:
        """The cuboid around it."""
        return box_around(self.center, self.axes)

    def _moments(self) -> Moments:
        return self.volume, self.center, self.volume * sum(a * a for a in self.axes) / 5

    def _distance(self, points: Array) -> Array:
        return _distance(points, self.center, self.axes)


def _distance(points: Array, center: Point, axes: Point) -> Array:
    """Signed distance, in double."""
    from levelset._curves import ellipsoid

    seen = seen_from(points.astype(np.float64), center).reshape(len(axes), -1)
    out = np.empty(seen.shape[1])
    ellipsoid(np.ascontiguousarray(seen), np.array(axes), out)
    return out.reshape(points.shape[1:])
