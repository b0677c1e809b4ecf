"""Shapes with exact signed distances: disk, sphere, ellipse, box, slotted disk, and others."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from levelset.naca import Naca
from levelset.polygon import Polygon
from levelset.shape import (
    Array,
    Bounds,
    Difference,
    Intersection,
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
from remesh.errors import InputError

__all__ = [
    "Box",
    "Difference",
    "Disk",
    "Ellipse",
    "Intersection",
    "Moved",
    "Naca",
    "Polygon",
    "Shape",
    "SlottedDisk",
    "Sphere",
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
    def perimeter(self) -> float:
        """Length of the boundary, 2 pi r [L]."""
        return 2.0 * math.pi * self.radius

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

    def bounds(self) -> Bounds:
        """Its own corners."""
        return box_around(self.center or (), tuple(0.5 * side for side in self.size))

    def _distance(self, points: Array) -> Array:
        half = seen_from(np.zeros_like(points), tuple(-0.5 * side for side in self.size))
        beyond = np.abs(seen_from(points, self.center or ())) - half
        outside = length_of(np.maximum(beyond, 0.0))
        return np.asarray(outside + np.minimum(beyond.max(axis=0), 0.0))


@dataclass(frozen=True)
class Ellipse(Shape):
    """An ellipse with half axes along x and y; exact by Newton on the foot point, in double.

    With ``s > 0`` the root of ``(e0 p0/(s + e0^2 - e1^2))^2 + (e1 p1/s)^2 = 1`` for e0 >= e1, the
    nearest point is ``(e0^2 p0/(s + e0^2 - e1^2), e1^2 p1/s)``; the left side is convex and falls,
    so Newton from the lower bound max(e1 p1, e0 p0 - e0^2 + e1^2) climbs to the root without fail.
    """

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

    def bounds(self) -> Bounds:
        """The rectangle around it."""
        return box_around(self.center, self.axes)

    def _distance(self, points: Array) -> Array:
        x, y = np.abs(seen_from(points.astype(np.float64), self.center))
        major, minor = (0, 1) if self.axes[0] >= self.axes[1] else (1, 0)
        e0, e1 = self.axes[major], self.axes[minor]
        p0 = (x, y)[major]
        p1 = np.maximum((x, y)[minor], 1e-30 * e1)  # off the axis: the foot point stays unique
        gap = (e0 - e1) * (e0 + e1)
        s = np.maximum(e1 * p1, e0 * p0 - gap)
        for _ in range(60):
            first, second = e0 * p0 / (s + gap), e1 * p1 / s
            slope = first * first / (s + gap) + second * second / s
            grown = 0.5 * (first * first + second * second - 1.0) / slope
            s = s + np.maximum(grown, 0.0)
            if np.all(grown <= 1e-15 * s):
                break
        away = np.hypot(p0 - e0 * e0 * p0 / (s + gap), p1 - e1 * e1 * p1 / s)
        inside = (p0 / e0) ** 2 + (p1 / e1) ** 2 < 1.0
        return np.asarray(np.where(inside, -away, away))


@dataclass(frozen=True)
class SlottedDisk(Shape):
    """A disk with a slot cut upward from its lowest point; Zalesak's disk by default.

    Exact everywhere: the nearest of the arc, the two walls and the slot's end.
    Source: S. T. Zalesak, J. Comput. Phys. 31 (1979) 335: radius 15, slot 5 wide and 25 deep.
    """

    radius: float = 15.0  # [L]
    width: float = 5.0  # of the slot [L]
    depth: float = 25.0  # from the disk's lowest point to the slot's end [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # of the disk [L]

    def __post_init__(self) -> None:
        """Refuse a slot that is wider than the disk, or does not end inside it."""
        store_lengths(self, "radius", "width", "depth")
        store_vector(self, "center", 2)
        half = 0.5 * self.width
        if (
            half >= self.radius
            or math.hypot(half, self._end) >= self.radius
            or self._end <= -(self._reach)
        ):
            raise InputError(
                f"SlottedDisk: the slot ({self.width} wide, {self.depth} deep) must end inside "
                f"the disk of radius {self.radius}",
                hint="a slot narrower than the disk and shallower than its diameter",
            )

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def _end(self) -> float:
        """Height of the slot's end above the centre."""
        return self.depth - self.radius

    @property
    def _reach(self) -> float:
        """Depth of the slot's mouth below the centre."""
        return math.sqrt(self.radius**2 - 0.25 * self.width**2)

    @property
    def volume(self) -> float:
        """Area: the disk less the slot."""
        half = 0.5 * self.width
        arc = half * self._reach + self.radius**2 * math.asin(half / self.radius)
        return math.pi * self.radius**2 - self.width * self._end - arc

    @property
    def perimeter(self) -> float:
        """Length of the boundary: arc, two walls and the slot's end [L]."""
        mouth = 2.0 * self.radius * math.asin(0.5 * self.width / self.radius)
        walls = 2.0 * (self._end + self._reach) + self.width
        return 2.0 * math.pi * self.radius - mouth + walls

    def bounds(self) -> Bounds:
        """The square around the disk."""
        return box_around(self.center, (self.radius, self.radius))

    def _distance(self, points: Array) -> Array:
        x, y = seen_from(points, self.center)
        x, half = np.abs(x), 0.5 * self.width
        radius = np.hypot(x, y)
        corner = np.hypot(x - half, y + self._reach)
        over_mouth = (y < 0.0) & (x * self._reach <= -y * half)  # the nearest arc is cut away
        arc = np.where(over_mouth, corner, np.abs(radius - self.radius))
        wall = np.hypot(x - half, y - np.clip(y, -self._reach, self._end))
        end = np.hypot(np.maximum(x - half, 0.0), y - self._end)
        inside = (radius < self.radius) & ((x > half) | (y > self._end))
        away = np.minimum(np.minimum(arc, wall), end)
        return np.asarray(np.where(inside, -away, away))
