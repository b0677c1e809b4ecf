"""Solids about an axis: torus, capsule and dumbbell, with their exact signed distances."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

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
from remesh.errors import InputError, as_number

GAUSS = 40  # points on each piece of a profile: trigonometric polynomials, exact to rounding


@dataclass(frozen=True)
class Torus(Shape):
    """A ring around the z axis, of a round tube: exact everywhere."""

    radius: float  # from the axis to the middle of the tube [L]
    tube: float  # radius of the tube, less than that [L]
    center: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse a tube that closes the hole."""
        store_lengths(self, "radius", "tube")
        store_vector(self, "center", 3)
        if self.tube >= self.radius:
            raise InputError(
                f"Torus: the tube ({self.tube}) must be thinner than the ring ({self.radius})",
                hint="Torus(1.0, 0.3)",
            )

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    @property
    def volume(self) -> float:
        """Volume 2 pi^2 R r^2."""
        return 2.0 * math.pi**2 * self.radius * self.tube**2

    @property
    def surface(self) -> float:
        """Area of the boundary, 4 pi^2 R r."""
        return 4.0 * math.pi**2 * self.radius * self.tube

    def bounds(self) -> Bounds:
        """The cuboid around it."""
        wide = self.radius + self.tube
        return box_around(self.center, (wide, wide, self.tube))

    def _moments(self) -> Moments:
        return self.volume, self.center, self.volume * (self.radius**2 + self.tube**2)

    def _distance(self, points: Array) -> Array:
        x, y, z = seen_from(points, self.center)
        return np.asarray(np.hypot(np.hypot(x, y) - self.radius, z) - self.tube)


@dataclass(frozen=True)
class Capsule(Shape):
    """All points within a radius of a segment, in 2-D or 3-D: exact everywhere."""

    start: Point  # of the segment [L]; its length is the dimension
    end: Point  # [L]
    radius: float  # [L]

    def __post_init__(self) -> None:
        """Refuse ends of different dimensions, and ends that are one point."""
        store_lengths(self, "radius")
        store_vector(self, "start", 2, 3)
        store_vector(self, "end", len(self.start))
        if self.start == self.end:
            raise InputError(
                f"Capsule: start and end are one point, {self.start}",
                hint="Disk or Sphere, or ends that are apart",
            )

    @property
    def ndim(self) -> int:
        """2 or 3, as many as a point has coordinates."""
        return len(self.start)

    @property
    def length(self) -> float:
        """Of the segment [L]."""
        return math.dist(self.start, self.end)

    @property
    def volume(self) -> float:
        """2 r l + pi r^2 in the plane, pi r^2 l + 4/3 pi r^3 in space."""
        return sum(self._parts())

    @property
    def surface(self) -> float:
        """2 l + 2 pi r in the plane, 2 pi r l + 4 pi r^2 in space."""
        around = 2.0 if self.ndim == 2 else 2.0 * math.pi * self.radius
        round_ends = math.pi * self.radius * (2.0 if self.ndim == 2 else 4.0 * self.radius)
        return around * self.length + round_ends

    def bounds(self) -> Bounds:
        """The box around both ends."""
        ends = list(zip(self.start, self.end, strict=True))
        lower = tuple(min(pair) - self.radius for pair in ends)
        return lower, tuple(max(pair) + self.radius for pair in ends)

    def _parts(self) -> tuple[float, float]:
        """Volume of the straight part and of both ends."""
        r, straight = self.radius, self.length
        if self.ndim == 2:
            return 2.0 * r * straight, math.pi * r**2
        return math.pi * r**2 * straight, 4.0 / 3.0 * math.pi * r**3

    def _moments(self) -> Moments:
        bar, ends = self._parts()
        r, half = self.radius, 0.5 * self.length
        center = tuple(0.5 * (a + b) for a, b in zip(self.start, self.end, strict=True))
        if self.ndim == 2:
            inertia = bar * (r**2 + half**2) / 3
            inertia += ends * (r**2 / 2 + half**2 + half * r * 8 / (3 * math.pi))
        else:
            inertia = bar * (r**2 / 2 + half**2 / 3)
            inertia += ends * (r**2 * 3 / 5 + half**2 + half * r * 3 / 4)
        return bar + ends, center, inertia

    def _distance(self, points: Array) -> Array:
        seen = seen_from(points, self.start)
        way = np.subtract(self.end, self.start).astype(points.dtype)
        along = np.clip(np.tensordot(way, seen, axes=1) / (way @ way), 0.0, 1.0)
        return length_of(seen - np.multiply.outer(way, along)) - self.radius


@dataclass(frozen=True)
class Dumbbell(Shape):
    """Two balls (disks) on the x axis joined by a bar, in 2-D or 3-D: exact everywhere.

    ``fillet``: radius of the round that joins bar and balls smoothly, 0 for a sharp corner. A
    point, its mirror images and its turns about the axis are equally far, so all is done in half
    a meridian plane: the nearest of bar, fillet and ball. Refuses balls that cover the bar.
    """

    radius: float = 1.0  # of the balls [L]
    separation: float = field(default=4.0, kw_only=True)  # of their centres [L]
    bar: float = field(default=0.4, kw_only=True)  # half the bar's width, its radius in 3-D [L]
    fillet: float = field(default=0.0, kw_only=True)  # [L]
    center: Point = field(default=(0.0, 0.0, 0.0), kw_only=True)  # [L]; its length: the dimension

    def __post_init__(self) -> None:
        """Refuse a bar as wide as the balls, and one that the balls or fillets cover."""
        store_lengths(self, "radius", "separation", "bar")
        store_vector(self, "center", 2, 3)
        fillet = as_number("Dumbbell: fillet", self.fillet, hint="fillet=0.2")
        object.__setattr__(self, "fillet", fillet)
        if not (math.isfinite(fillet) and fillet >= 0.0):
            raise InputError(f"Dumbbell: fillet must be >= 0, got {fillet}", hint="fillet=0.2")
        if self.bar >= self.radius:
            raise InputError(
                f"Dumbbell: the bar ({self.bar}) must be thinner than the balls ({self.radius})",
                hint="a Capsule, or a thinner bar",
            )
        if self._foot < 0.0:
            raise InputError(
                f"Dumbbell: no bar is left between balls of radius {self.radius} whose centres are "
                f"{self.separation} apart, with a fillet of {fillet}",
                hint=f"separation={2.5 * (self.radius + fillet):g}, or a smaller fillet",
            )

    @property
    def ndim(self) -> int:
        """2 or 3, as many as the centre has coordinates."""
        return len(self.center)

    @property
    def _foot(self) -> float:
        """Where the bar's straight edge ends; above it is the middle of the fillet."""
        reach, high = self.radius + self.fillet, self.bar + self.fillet
        return 0.5 * self.separation - math.sqrt((reach - high) * (reach + high))

    @property
    def volume(self) -> float:
        """Area or volume: a Gauss rule on the profile, exact to rounding."""
        return self._moments()[0]

    @property
    def surface(self) -> float:
        """Length or area of the boundary: a Gauss rule on the profile, exact to rounding."""
        _, y, _, arc = self._profile()
        return float(4.0 * np.sum(arc if self.ndim == 2 else math.pi * y * arc))

    def bounds(self) -> Bounds:
        """The box around both balls."""
        across = (self.radius,) * (self.ndim - 1)
        return box_around(self.center, (0.5 * self.separation + self.radius, *across))

    def _profile(self) -> NDArray[np.float64]:
        """Places x, y and steps dx, ds (4, n) of a quadrature along a quarter of the outline."""
        half, foot, middle = 0.5 * self.separation, self._foot, self.bar + self.fillet
        lean = math.atan2(middle, half - foot)  # of the line from the fillet's middle to the ball
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
        share, weights = 0.5 * (nodes + 1.0), 0.5 * weights
        bar = np.stack([foot * share, self.bar + 0 * share, foot * weights, foot * weights])
        pieces = [bar]
        for x, y, r, a, b in (
            (foot, middle, self.fillet, -0.5 * math.pi, -lean),
            (half, 0.0, self.radius, math.pi - lean, 0.0),
        ):
            angle, step = a + (b - a) * share, (b - a) * weights
            cos, sin = r * np.cos(angle), r * np.sin(angle)
            pieces.append(np.stack([x + cos, y + sin, -sin * step, r * np.abs(step)]))
        return np.concatenate(pieces, axis=1)

    def _moments(self) -> Moments:
        x, y, dx, _ = self._profile()
        if self.ndim == 2:
            volume = 4.0 * np.sum(y * dx)
            inertia = 4.0 * np.sum((x * x * y + y**3 / 3) * dx)
        else:
            volume = 2.0 * math.pi * np.sum(y**2 * dx)
            inertia = 2.0 * math.pi * np.sum((x * x * y**2 + y**4 / 2) * dx)
        return float(volume), self.center, float(inertia)

    def _distance(self, points: Array) -> Array:
        seen = seen_from(points, self.center)
        x, y = np.abs(seen[0]), np.abs(seen[1]) if self.ndim == 2 else np.hypot(seen[1], seen[2])
        half, foot, middle = 0.5 * self.separation, self._foot, self.bar + self.fillet
        from_ball, to_ball = np.hypot(x - half, y), math.hypot(half - foot, middle)
        # which side of the line from the fillet's middle to the ball's
        over = (x - half) * middle + y * (half - foot) >= 0.0
        corner = (half - (half - foot) * self.radius / to_ball, middle * self.radius / to_ball)
        ball = np.where(
            over, np.abs(from_ball - self.radius), np.hypot(x - corner[0], y - corner[1])
        )
        away = np.minimum(ball, np.hypot(x - np.minimum(x, foot), y - self.bar))
        facing = (x >= foot) & ~over  # of the fillet
        from_fillet = np.hypot(x - foot, y - middle)
        if self.fillet > 0.0:
            round_ = np.where(facing, np.abs(from_fillet - self.fillet), np.inf)
            away = np.minimum(away, round_)
        inside = (from_ball < self.radius) | ((x <= foot) & (y < self.bar))
        inside |= facing & (from_fillet > self.fillet) & (x <= half)
        return np.asarray(np.where(inside, -away, away))
