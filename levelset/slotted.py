"""Zalesak's bodies: the slotted disk and the slotted sphere, with their exact signed distances."""

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
    length_of,
    seen_from,
    store_lengths,
    store_vector,
)
from remesh.errors import InputError

GAUSS = 200  # points of the quadrature of a slot's moments


@dataclass(frozen=True)
class _Slotted(Shape):
    """A disk or a ball with a slot cut upward from its lowest point."""

    radius: float = 15.0  # [L]
    width: float = 5.0  # of the slot, along x [L]
    depth: float = 25.0  # from the lowest point to the slot's end [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse a slot that is wider than the body, or does not end inside it."""
        store_lengths(self, "radius", "width", "depth")
        store_vector(self, "center", self.ndim)
        _refuse_open_slot(self)

    @property
    def _end(self) -> float:
        """Height of the slot's end above the centre."""
        return self.depth - self.radius

    @property
    def _reach(self) -> float:
        """Depth of the slot's mouth below the centre; a wall's plane cuts a ball in this radius."""
        return math.sqrt(self.radius**2 - 0.25 * self.width**2)


@dataclass(frozen=True)
class SlottedDisk(_Slotted):
    """A disk with a slot cut upward from its lowest point; Zalesak's disk by default.

    Exact everywhere: the nearest of the arc, the two walls and the slot's end.
    Source: S. T. Zalesak, J. Comput. Phys. 31 (1979) 335: radius 15, slot 5 wide and 25 deep.
    """

    radius: float = 15.0  # [L]
    width: float = 5.0  # of the slot [L]
    depth: float = 25.0  # from the disk's lowest point to the slot's end [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # of the disk [L]

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def volume(self) -> float:
        """Area: the disk less the slot."""
        half = 0.5 * self.width
        arc = half * self._reach + self.radius**2 * math.asin(half / self.radius)
        return math.pi * self.radius**2 - self.width * self._end - arc

    @property
    def surface(self) -> float:
        """Length of the boundary: arc, two walls and the slot's end."""
        mouth = 2.0 * self.radius * math.asin(0.5 * self.width / self.radius)
        walls = 2.0 * (self._end + self._reach) + self.width
        return 2.0 * math.pi * self.radius - mouth + walls

    def _moments(self) -> Moments:
        r, h, e = self.radius, 0.5 * self.width, self._end
        turn = math.asin(h / r)
        first = h * (e**2 - r**2) + h**3 / 3  # of the slot, along y
        second = 2.0 / 3.0 * h * e * (h**2 + e**2) + r**4 * (
            turn / 2 + math.sin(2 * turn) / 6 - math.sin(4 * turn) / 24
        )
        area, (x, y) = self.volume, self.center
        arm = -first / area
        inertia = 0.5 * math.pi * r**4 - second - area * arm**2
        return area, (x, y + arm), inertia

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


@dataclass(frozen=True)
class SlottedSphere(_Slotted):
    """A ball with a slot cut upward from its lowest point; Zalesak's sphere by default.

    The slot is |x - x0| < width/2 below its end, ``depth`` above the lowest point, open along y
    and z: radius 15, 5 wide, 12.5 deep leaves the volume 12757.888. Exact everywhere: the nearest
    of the sphere's rest, its rims, the two walls and the slot's end.
    The default sizes are remembered (grade C) from D. Enright et al., J. Comput. Phys. 183 (2002)
    83; the volume is exact.
    """

    radius: float = 15.0  # [L]
    width: float = 5.0  # of the slot, along x [L]
    depth: float = 12.5  # from the lowest point to the slot's end, along z [L]
    center: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)  # of the ball [L]

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    @property
    def volume(self) -> float:
        """The ball less the slot, the slot's sections integrated across it in closed form."""
        r, h, e = self.radius, 0.5 * self.width, self._end
        square = r * r - e * e
        root = math.sqrt(square - h * h)
        lean, turn, corner = self._angles()
        slot = 2.0 * (r * r * h - h**3 / 3) * (0.5 * math.pi + lean)
        slot += e * (h * root + square * turn)
        slot -= e / 3 * (square * turn - h * root)
        slot += 4.0 / 3.0 * r * (r * e * turn - r * r * corner)
        return 4.0 / 3.0 * math.pi * r**3 - slot

    @property
    def surface(self) -> float:
        """Area of the boundary: the sphere less the slot's mouth, two walls and the slot's end."""
        r, h, e = self.radius, 0.5 * self.width, self._end
        square = r * r - e * e
        root = math.sqrt(square - h * h)
        lean, turn, corner = self._angles()
        mouth = 2.0 * r * (math.pi * h + 2.0 * (h * lean + e * turn - r * corner))
        wall = self._reach**2 * (0.5 * math.pi + lean) + e * root
        end = 2.0 * (h * root + square * turn)
        return 4.0 * math.pi * r * r - mouth + 2.0 * wall + end

    def _angles(self) -> tuple[float, float, float]:
        """Of the end's edge seen in a wall, across the end, and of their corner."""
        h, e = 0.5 * self.width, self._end
        root = math.sqrt(self.radius**2 - e * e - h * h)
        return math.atan2(e, root), math.atan2(h, root), math.atan2(h * e, self.radius * root)

    def bounds(self) -> Bounds:
        """The cube around the ball."""
        return box_around(self.center, (self.radius,) * 3)

    def _moments(self) -> Moments:
        r, h, e = self.radius, 0.5 * self.width, self._end
        wide = math.sqrt(r * r - e * e)
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        end = math.asin(h / wide)  # x = wide sin(turn): no root at the rim
        x, root = wide * np.sin(end * nodes), wide * np.cos(end * nodes)
        weights = end * weights * root
        square, lean = r * r - x * x, np.arctan2(e, root)
        area = square * (0.5 * np.pi + lean) + e * root
        polar = square**2 * (
            0.25 * np.pi + 0.5 * lean + np.sin(2 * lean) / 6 - np.sin(4 * lean) / 24
        )
        first = -2.0 / 3.0 * float(np.sum(weights * root**3))
        second = float(np.sum(weights * (x * x * area + polar)))
        volume, (cx, cy, cz) = self.volume, self.center
        arm = -first / volume
        inertia = 0.8 * math.pi * r**5 - second - volume * arm**2
        return volume, (cx, cy, cz + arm), inertia

    def _distance(self, points: Array) -> Array:
        x, y, z = seen_from(points, self.center)
        x, y, half, end = np.abs(x), np.abs(y), 0.5 * self.width, self._end
        wide = math.sqrt(self.radius**2 - end**2)
        corner = math.sqrt(wide**2 - half**2)  # how far along y the end's edges go
        radius = length_of(np.stack([x, y, z]))
        # the sphere, where its nearest point was left standing
        in_slot = (x < half) & (z < end)
        cut = (x * self.radius < half * radius) & (z * self.radius < end * radius)
        away = np.where(cut, np.inf, np.abs(radius - self.radius))
        # a wall: a circle's segment, else its rim
        across = np.hypot(y, z)
        in_wall = (z <= end) & (across <= self._reach)
        rim = z * self._reach <= end * across
        away = np.minimum(away, np.where(in_wall, np.abs(x - half), np.inf))
        off_rim = np.hypot(x - half, across - self._reach)
        away = np.minimum(away, np.where(rim, off_rim, np.inf))
        # the end: a strip of a circle, else its rim
        around = np.hypot(x, y)
        on_end = (x <= half) & (around <= wide)
        away = np.minimum(away, np.where(on_end, np.abs(z - end), np.inf))
        off_end = np.hypot(z - end, around - wide)
        away = np.minimum(away, np.where(x * wide <= half * around, off_end, np.inf))
        # the edge between them, and its corners on the sphere
        edge = length_of(np.stack([x - half, np.maximum(y - corner, 0.0), z - end]))
        away = np.minimum(away, edge)
        inside = (radius < self.radius) & ~in_slot
        return np.asarray(np.where(inside, -away, away))


def _refuse_open_slot(shape: _Slotted) -> None:
    """Refuse a slot that splits the shape, or misses it."""
    half, radius, end = 0.5 * shape.width, shape.radius, shape.depth - shape.radius
    if half >= radius or math.hypot(half, end) >= radius or end <= -shape._reach:
        name, word = type(shape).__name__, "disk" if shape.ndim == 2 else "ball"
        raise InputError(
            f"{name}: the slot ({shape.width} wide, {shape.depth} deep) must end inside "
            f"the {word} of radius {radius}",
            hint=f"a slot narrower than the {word} and shallower than its diameter",
        )
