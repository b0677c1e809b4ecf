"""The smooth star, with its exact signed distance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from levelset.shape import (
    Array,
    Bounds,
    Moments,
    Point,
    Shape,
    seen_from,
    store_lengths,
    store_vector,
)
from remesh.errors import InputError, as_number

ANGLES = 4096  # at which a star is looked at for its length and its box


@dataclass(frozen=True)
class Star(Shape):
    """A smooth star, r = radius (1 + amplitude cos(arms angle)), with an arm along x.

    Exact to rounding: the nearest point is the least of all, found by intervals that miss none.
    Refuses an amplitude below 0 or not below 1, and fewer than one arm.
    """

    radius: float = 1.0  # mean radius [L]
    amplitude: float = field(default=0.3, kw_only=True)  # of the radius, relative
    arms: int = field(default=5, kw_only=True)
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse a star that meets itself."""
        store_lengths(self, "radius")
        store_vector(self, "center", 2)
        amplitude = as_number("Star: amplitude", self.amplitude, hint="amplitude=0.3")
        object.__setattr__(self, "amplitude", amplitude)
        if not 0.0 <= amplitude < 1.0:
            raise InputError(
                f"Star: amplitude must be at least 0 and below 1, got {amplitude}",
                hint="amplitude=0.3",
            )
        arms = as_number("Star: arms", self.arms, hint="arms=5")
        if not (math.isfinite(arms) and arms >= 1 and arms % 1 == 0):
            raise InputError(
                f"Star: arms must be a whole number >= 1, got {self.arms}", hint="arms=5"
            )
        object.__setattr__(self, "arms", int(arms))

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def volume(self) -> float:
        """Area pi r^2 (1 + a^2/2)."""
        return math.pi * self.radius**2 * (1.0 + 0.5 * self.amplitude**2)

    @property
    def surface(self) -> float:
        """Length of the boundary: the trapezoid rule over a period, exact to rounding."""
        angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES  # of a period: every arm is the same
        r = 1.0 + self.amplitude * np.cos(angle)
        slope = self.amplitude * self.arms * np.sin(angle)
        return float(2.0 * math.pi * self.radius * np.hypot(r, slope).mean())

    def bounds(self) -> Bounds:
        """The rectangle around it, within 1e-5 of the radius for five arms."""
        low, high = _corners(self.amplitude, self.arms)
        return tuple(
            tuple(c + self.radius * x for c, x in zip(self.center, corner, strict=True))
            for corner in (low, high)
        )  # type: ignore[return-value]

    def _moments(self) -> Moments:
        a, area = self.amplitude, self.volume
        inertia = 0.5 * math.pi * self.radius**4 * (1.0 + 3.0 * a**2 + 0.375 * a**4)
        arm = self.radius * (a + 0.25 * a**3) / (1.0 + 0.5 * a**2) if self.arms == 1 else 0.0
        x, y = self.center
        return area, (x + arm, y), inertia - area * arm**2

    def _distance(self, points: Array) -> Array:
        from levelset._curves import star

        x, y = seen_from(points.astype(np.float64), self.center).reshape(2, -1)
        out = np.empty(x.size)
        star(x, y, self.radius, self.amplitude, self.arms, out)
        return out.reshape(points.shape[1:])


@lru_cache(maxsize=64)
def _corners(amplitude: float, arms: int) -> tuple[Point, Point]:
    """Corners of the box around a star of mean radius 1, never inside it."""
    angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    edge = (1.0 + amplitude * np.cos(arms * angle)) * np.stack([np.cos(angle), np.sin(angle)])
    bend = 1.0 + amplitude * (1.0 + arms) ** 2  # largest second derivative along an axis
    slack = bend * (np.pi / ANGLES) ** 2 / 2
    return tuple((edge.min(axis=1) - slack).tolist()), tuple((edge.max(axis=1) + slack).tolist())
