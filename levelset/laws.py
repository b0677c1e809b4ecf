"""Velocity laws u(x, t) that carry level sets: rigid motion, shear and reversed vortices."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Bounds, Point, rotation, vector
from remesh.errors import InputError, as_number
from remesh.layout import precision, split
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Matrix = NDArray[np.float64]


class Law(ABC):
    """A velocity known everywhere: ``law(time, positions)``, and what bounds the time step."""

    @property
    @abstractmethod
    def ndim(self) -> int:
        """Number of dimensions, 2 or 3."""

    @abstractmethod
    def max_speed(self, time: float = 0.0, bounds: Bounds | None = None) -> float:
        """Largest |u| [L/T] in the box ``bounds`` (lower and upper corner), else anywhere."""

    @abstractmethod
    def max_gradient(self, time: float = 0.0) -> float:
        """Largest row sum max_i sum_j |du_i/dx_j| [1/T] anywhere: dt times it is the LCFL."""

    @abstractmethod
    def _velocity(self, time: float, positions: Array, result: Array, threads: int) -> None:
        """Write the velocity at positions that were checked."""

    def __call__(self, time: float, positions: Array, *, threads: int | None = None) -> Array:
        """Velocity [L/T] at ``positions`` ``(n, ndim)`` [L], of the same shape; keeps float32.

        Same bits for any number of threads. Refuses positions of another shape; places that are
        not finite have velocities that are not.
        """
        places = np.asarray(positions)
        if places.ndim != 2 or places.shape[1] != self.ndim:
            raise InputError(
                f"positions must have shape (n, {self.ndim}), got {places.shape}",
                hint="positions.T" if places.shape[:1] == (self.ndim,) else "one row per particle",
            )
        places = np.ascontiguousarray(places, precision(places))
        now = as_number("time", time)
        if not math.isfinite(now):
            raise InputError(f"time must be finite, got {time}", hint="time=0.0")
        result = np.empty_like(places)
        if len(places):
            self._velocity(now, places, result, thread_count(threads))
        return result


class _Affine(Law):
    """u = matrix (x - center) + drift: its flow is known exactly."""

    @abstractmethod
    def _terms(self) -> tuple[Matrix, Point, Point]:
        """Matrix [1/T], center [L] and drift [L/T]."""

    @abstractmethod
    def flow(self, positions: Array, start: float, end: float) -> Array:
        """Where particles seen at ``positions`` (n, ndim) at time ``start`` are at ``end`` [L].

        Exact. With ``end < start`` it goes back: ``phi(x, t) = phi_0(flow(x, t, 0))``.
        """

    def _velocity(self, time: float, positions: Array, result: Array, threads: int) -> None:
        from levelset import _laws

        matrix, center, drift = self._terms()
        wide = np.zeros((3, 3), positions.dtype)
        wide[: self.ndim, : self.ndim] = matrix
        size, pieces = split(len(positions))
        share(
            _laws.affine, pieces, threads, size, positions, wide,
            np.array(center, positions.dtype), np.array(drift, positions.dtype), result,
        )  # fmt: skip

    def max_speed(self, time: float = 0.0, bounds: Bounds | None = None) -> float:
        """Largest |u| [L/T] in the box, found at a corner; without a box infinite if u grows."""
        matrix, center, drift = self._terms()
        if bounds is None:
            return math.inf if matrix.any() else math.hypot(*drift)
        corners = np.array(list(itertools.product(*zip(*bounds, strict=True))), np.float64)
        speeds = (corners - np.asarray(center)) @ matrix.T + np.asarray(drift)
        return float(np.sqrt((speeds**2).sum(axis=1)).max())

    def max_gradient(self, time: float = 0.0) -> float:
        """Largest row sum of the matrix [1/T], the same everywhere."""
        return float(np.abs(self._terms()[0]).sum(axis=1).max())


@dataclass(frozen=True, kw_only=True)
class Uniform(_Affine):
    """The same velocity everywhere."""

    velocity: Point  # [L/T]; two or three numbers

    def __post_init__(self) -> None:
        """Refuse a velocity that is not two or three finite numbers."""
        object.__setattr__(self, "velocity", vector("Uniform: velocity", self.velocity, 2, 3))

    @property
    def ndim(self) -> int:
        """As many as the velocity has components."""
        return len(self.velocity)

    def _terms(self) -> tuple[Matrix, Point, Point]:
        return np.zeros((self.ndim, self.ndim)), (0.0,) * self.ndim, self.velocity

    def flow(self, positions: Array, start: float, end: float) -> Array:
        """Positions (n, ndim) shifted by velocity * (end - start)."""
        return np.asarray(positions + (end - start) * np.asarray(self.velocity, positions.dtype))


@dataclass(frozen=True, kw_only=True)
class Rotation(_Affine):
    """Rigid rotation about ``center``: anticlockwise in the plane for a positive ``rate``.

    In 3-D the rate is the vector of angular velocity w, and u = w x (x - center).
    Zalesak's disk: ``Rotation(center=(50, 50), rate=2 * pi / 628)``.
    """

    center: Point  # [L]; two or three numbers
    rate: float | Point  # [rad/T]; one number in 2-D, a vector in 3-D

    def __post_init__(self) -> None:
        """Refuse a center or a rate that do not fit a dimension."""
        object.__setattr__(self, "center", vector("Rotation: center", self.center, 2, 3))
        if self.ndim == 2:
            rate: float | Point = as_number("Rotation: rate", self.rate, hint="rate=1.0")
            vector("Rotation: rate", (rate,), 1)
        else:
            rate = vector("Rotation: rate", self.rate, 3)
        object.__setattr__(self, "rate", rate)

    @property
    def ndim(self) -> int:
        """As many as the center has coordinates."""
        return len(self.center)

    @property
    def period(self) -> float:
        """Time of one turn [T]."""
        speed = math.hypot(*self._rate())
        return 2.0 * math.pi / speed if speed else math.inf

    def _rate(self) -> Point:
        return self.rate if isinstance(self.rate, tuple) else (self.rate,)

    def _terms(self) -> tuple[Matrix, Point, Point]:
        if self.ndim == 2:
            (w,) = self._rate()
            matrix = np.array([[0.0, -w], [w, 0.0]])
        else:
            x, y, z = self._rate()
            matrix = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return matrix, self.center, (0.0,) * self.ndim

    def flow(self, positions: Array, start: float, end: float) -> Array:
        """Positions (n, ndim) turned about the center by rate * (end - start)."""
        turn = rotation([w * (end - start) for w in self._rate()])
        center = np.asarray(self.center)
        return np.asarray(center + (positions - center) @ turn.T, precision(positions))


@dataclass(frozen=True, kw_only=True)
class Shear(_Affine):
    """Plane shear: the velocity along axis ``along`` is rate * (x[across] - center[across])."""

    rate: float  # [1/T]
    center: Point = (0.0, 0.0)  # [L]; where nothing moves; its length is the dimension
    along: int = 0
    across: int = 1

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite and axes that are not two different ones."""
        object.__setattr__(self, "center", vector("Shear: center", self.center, 2, 3))
        object.__setattr__(self, "rate", as_number("Shear: rate", self.rate, hint="rate=1.0"))
        vector("Shear: rate", (self.rate,), 1)
        if self.along == self.across or not {self.along, self.across} <= set(range(self.ndim)):
            raise InputError(
                f"along and across must be two different axes below {self.ndim}, "
                f"got {self.along} and {self.across}",
                hint="along=0, across=1",
            )

    @property
    def ndim(self) -> int:
        """As many as the center has coordinates."""
        return len(self.center)

    def _terms(self) -> tuple[Matrix, Point, Point]:
        matrix = np.zeros((self.ndim, self.ndim))
        matrix[self.along, self.across] = self.rate
        return matrix, self.center, (0.0,) * self.ndim

    def flow(self, positions: Array, start: float, end: float) -> Array:
        """Positions (n, ndim) sheared by rate * (end - start)."""
        moved = np.array(positions, precision(np.asarray(positions)))
        height = moved[:, self.across] - self.center[self.across]
        moved[:, self.along] += self.rate * (end - start) * height
        return moved


class _Reversed(Law):
    """A steady field of the unit box times cos(pi t / period): at t = period all is back.

    Beyond the box the field goes on with period 1; no velocity crosses the box's faces.
    """

    period: float

    def __post_init__(self) -> None:
        """Refuse a period that is not positive; it may be infinite."""
        name = f"{type(self).__name__}: period"
        object.__setattr__(self, "period", as_number(name, self.period, hint="period=8.0"))
        if not self.period > 0:
            raise InputError(f"{name} must be positive, got {self.period}", hint="period=8.0")

    def swing(self, time: float) -> float:
        """cos(pi t / period), the factor in front of the steady field; 1 for an infinite period."""
        return math.cos(math.pi * time / self.period)

    def _velocity(self, time: float, positions: Array, result: Array, threads: int) -> None:
        from levelset import _laws

        kind = positions.dtype.type
        size, pieces = split(len(positions))
        share(
            _laws.vortices, pieces, threads, size, positions, kind(0.5), *_series(positions.dtype),
            kind(self.swing(time)), result,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class SingleVortex(_Reversed):
    """The vortex that draws a disk out into a spiral, and back.

    ``u = sin^2(pi x) sin(2 pi y) g, v = -sin^2(pi y) sin(2 pi x) g, g = cos(pi t/period)``, the
    curl of psi = sin^2(pi x) sin^2(pi y) g / pi: anticlockwise at first. Papers differ in the sense
    of turning; the picture is then mirrored (x -> 1 - x), no error changes. The disk of radius 0.15
    about (0.5, 0.75) returns at t = period = 8. ``period=math.inf`` never turns back: the large
    deformation that shows what remeshing is for. Source: Bell, Colella & Glaz, J. Comput.
    Phys. 85 (1989) 257; with the cosine LeVeque, SIAM J. Numer. Anal. 33 (1996) 627.
    """

    period: float = 8.0  # [T]

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    def max_speed(self, time: float = 0.0, bounds: Bounds | None = None) -> float:
        """|g|, at (1/2, 1/4) and the three places like it; a box is not looked at."""
        return abs(self.swing(time))

    def max_gradient(self, time: float = 0.0) -> float:
        """2 pi |g|: pi (|sin a sin b| + (1 - cos a)|cos b|) is largest at a = pi, b = 0."""
        return 2.0 * math.pi * abs(self.swing(time))


@dataclass(frozen=True, kw_only=True)
class Deformation(_Reversed):
    """The 3-D field that draws a sphere out into a thin sheet, and back.

    ``u = 2 sin^2(pi x) sin(2 pi y) sin(2 pi z) g, v = -sin(2 pi x) sin^2(pi y) sin(2 pi z) g,
    w = -sin(2 pi x) sin(2 pi y) sin^2(pi z) g``, ``g = cos(pi t/period)``. The sphere of
    radius 0.15 about (0.35, 0.35, 0.35) returns at t = period = 3.
    Source: LeVeque, SIAM J. Numer. Anal. 33 (1996) 627; Enright et al., J. Comput. Phys. 183
    (2002) 83.
    """

    period: float = 3.0  # [T]

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    def max_speed(self, time: float = 0.0, bounds: Bounds | None = None) -> float:
        """2 |g|, at (1/2, 1/4, 1/4) and places like it; a box is not looked at."""
        return 2.0 * abs(self.swing(time))

    def max_gradient(self, time: float = 0.0) -> float:
        """13.401 |g|, of the row of u: the largest over a = pi x and b = 2 pi y = 2 pi z.

        That row is 4 pi sin a (cos a sin^2 b + sin a sin 2b), which over b is at most
        2 pi sin a (cos a + sqrt(4 - 3 cos^2 a)), and largest at cos^2 a = (4 - sqrt 13)/6.
        """
        square = (4.0 - math.sqrt(13.0)) / 6.0
        row = math.sqrt(1.0 - square) * (math.sqrt(square) + math.sqrt(4.0 - 3.0 * square))
        return 2.0 * math.pi * row * abs(self.swing(time))


@lru_cache(maxsize=2)
def _series(dtype: np.dtype[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Taylor's coefficients in x^2 of sin(pi x)/x and cos(pi x): round-off for |x| <= 1/2."""
    terms = [(-1) ** (n // 2) * math.pi**n / math.factorial(n) for n in range(22)]
    return tuple(map(dtype.type, terms[1::2])), tuple(map(dtype.type, terms[0::2]))
