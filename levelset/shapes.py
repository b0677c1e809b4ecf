"""Shapes with exact signed distances: disk, sphere and box; the others are reached from here."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from levelset.blend import SmoothDifference, SmoothIntersection, SmoothUnion
from levelset.ellipse import Ellipse, Ellipsoid
from levelset.naca import Naca
from levelset.polygon import Polygon
from levelset.sampled import Sampled
from levelset.shape import (
    Array,
    Bounds,
    Difference,
    Intersection,
    Moments,
    Moved,
    Point,
    Shape,
    Union,
    box_around,
    length_of,
    seen_from,
    store_lengths,
    store_sides,
    store_vector,
)
from levelset.slotted import SlottedDisk, SlottedSphere
from levelset.solids import Capsule, Dumbbell, Torus
from levelset.star import Star
from levelset.triangle_mesh import TriangleMesh

__all__ = [
    "Box",
    "Capsule",
    "Difference",
    "Disk",
    "Dumbbell",
    "Ellipse",
    "Ellipsoid",
    "Intersection",
    "Moved",
    "Naca",
    "Polygon",
    "Sampled",
    "Shape",
    "SlottedDisk",
    "SlottedSphere",
    "SmoothDifference",
    "SmoothIntersection",
    "SmoothUnion",
    "Sphere",
    "Star",
    "Torus",
    "TriangleMesh",
    "Union",
]


@dataclass(frozen=True)
class Disk(Shape):
    """A disk: |x - center| - radius."""

    radius: float  # [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive and a centre of another dimension."""
        store_lengths(self, "radius")
        store_vector(self, "center", 2)

    @property
    def ndim(self) -> int:
        """2."""
        return len(self.center)

    @property
    def volume(self) -> float:
        """Area pi r^2."""
        return math.pi * self.radius**2

    @property
    def surface(self) -> float:
        """Length of the boundary, 2 pi r."""
        return 2.0 * math.pi * self.radius

    def _moments(self) -> Moments:
        return self.volume, self.center, self.volume * self.radius**2 / 2

    def bounds(self) -> Bounds:
        """The square around it."""
        return box_around(self.center, (self.radius,) * self.ndim)

    def _distance(self, points: Array) -> Array:
        return length_of(seen_from(points, self.center)) - self.radius


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball: |x - center| - radius."""

    radius: float  # [L]
    center: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive and a centre of another dimension."""
        store_lengths(self, "radius")
        store_vector(self, "center", 3)

    @property
    def ndim(self) -> int:
        """3."""
        return len(self.center)

    @property
    def volume(self) -> float:
        """Volume 4/3 pi r^3."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    @property
    def surface(self) -> float:
        """Area of the boundary, 4 pi r^2."""
        return 4.0 * math.pi * self.radius**2

    def _moments(self) -> Moments:
        return self.volume, self.center, self.volume * self.radius**2 * 3 / 5

    def bounds(self) -> Bounds:
        """The cube around it."""
        return box_around(self.center, (self.radius,) * self.ndim)

    def _distance(self, points: Array) -> Array:
        return length_of(seen_from(points, self.center)) - self.radius


@dataclass(frozen=True)
class Box(Shape):
    """A rectangle or a cuboid with its sides along the axes; exact at its corners too."""

    size: Point  # full side lengths [L]; their number is the dimension
    center: Point | None = field(default=None, kw_only=True)  # [L]; the origin if None

    def __post_init__(self) -> None:
        """Refuse sides that are not 2 or 3 positive lengths."""
        store_sides(self, "size", 2, 3)
        if self.center is None:
            object.__setattr__(self, "center", (0.0,) * len(self.size))
        store_vector(self, "center", len(self.size))

    @property
    def ndim(self) -> int:
        """2 or 3, as many as there are sides."""
        return len(self.size)

    @property
    def volume(self) -> float:
        """Product of the sides."""
        return math.prod(self.size)

    @property
    def surface(self) -> float:
        """Of all sides or faces."""
        return sum(2.0 * self.volume / side for side in self.size)

    def _moments(self) -> Moments:
        inertia = self.volume * sum(side * side for side in self.size) / 12
        return self.volume, self.center or (), inertia

    def bounds(self) -> Bounds:
        """Its own corners."""
        return box_around(self.center or (), tuple(0.5 * side for side in self.size))

    def _distance(self, points: Array) -> Array:
        half = seen_from(np.zeros_like(points), tuple(-0.5 * side for side in self.size))
        beyond = np.abs(seen_from(points, self.center or ())) - half
        outside = length_of(np.maximum(beyond, 0.0))
        return np.asarray(outside + np.minimum(beyond.max(axis=0), 0.0))
