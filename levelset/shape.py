"""What a shape is: a signed distance (negative inside), and the algebra and motion of shapes."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Point = tuple[float, ...]
Bounds = tuple[tuple[float, ...], tuple[float, ...]]


class Shape(ABC):
    """A solid in 2-D or 3-D, given by its signed distance.

    ``a | b`` unites, ``a & b`` intersects, ``a - b`` cuts b out of a, ``a.moved(...)``
    shifts and turns.
    """

    @property
    @abstractmethod
    def ndim(self) -> int:
        """Number of dimensions, 2 or 3."""

    @property
    @abstractmethod
    def volume(self) -> float | None:
        """Area (2-D) or volume (3-D) [L^ndim]; None where no closed form is known."""

    @abstractmethod
    def bounds(self) -> Bounds:
        """Lower and upper corner of a box that holds the shape [L]."""

    @abstractmethod
    def _distance(self, points: Array) -> Array:
        """The signed distance, from points that were checked."""

    def distance(self, points: Array) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...); keeps float32.

        Refuses points whose first axis is not ``ndim`` long.
        """
        points = np.asarray(points)
        if points.ndim < 1 or points.shape[0] != self.ndim:
            raise InputError(
                f"points must have shape ({self.ndim}, ...), got {points.shape}",
                hint="grid.points()",
            )
        if not np.issubdtype(points.dtype, np.floating):
            points = points.astype(np.float64)
        return np.asarray(self._distance(points), points.dtype)

    @property
    def area(self) -> float | None:
        """Another word for ``volume``, for plane shapes."""
        return self.volume

    def __or__(self, other: Shape) -> Shape:
        """The union."""
        return Union(self, other)

    def __and__(self, other: Shape) -> Shape:
        """The intersection."""
        return Intersection(self, other)

    def __sub__(self, other: Shape) -> Shape:
        """The difference."""
        return Difference(self, other)

    def moved(
        self, shift: Sequence[float] | None = None, angle: float | Sequence[float] = 0.0
    ) -> Shape:
        """The shape turned about the origin by ``angle`` [rad], then shifted by ``shift`` [L].

        In 3-D the angle is a rotation vector: its direction is the axis, its length the angle.
        """
        turn = (float(angle),) if isinstance(angle, int | float) else tuple(angle)
        if self.ndim == 3 and turn == (0.0,):
            turn = (0.0, 0.0, 0.0)
        return Moved(self, (0.0,) * self.ndim if shift is None else tuple(shift), turn)


@dataclass(frozen=True)
class _Pair(Shape):
    """Two shapes of one dimension."""

    first: Shape
    second: Shape

    def __post_init__(self) -> None:
        """Refuse what is not a shape, and shapes of different dimensions."""
        for shape in (self.first, self.second):
            if not isinstance(shape, Shape):
                raise InputError(
                    f"set algebra joins shapes, got {type(shape).__name__}",
                    hint="Disk(0.5) | Disk(0.5, center=(1, 0))",
                )
        if self.first.ndim != self.second.ndim:
            raise InputError(
                f"shapes of {self.first.ndim} and {self.second.ndim} dimensions cannot be joined",
                hint="shapes of one dimension",
            )

    @property
    def ndim(self) -> int:
        """Number of dimensions of both."""
        return self.first.ndim

    @property
    def volume(self) -> float | None:
        """None: it depends on how the two overlap."""
        return None


class Union(_Pair):
    """``a | b``: the smaller distance. Exact outside; inside, |distance| is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.minimum(self.first._distance(points), self.second._distance(points))

    def bounds(self) -> Bounds:
        """The box around both boxes."""
        (low, high), (other_low, other_high) = self.first.bounds(), self.second.bounds()
        return tuple(map(min, low, other_low)), tuple(map(max, high, other_high))


class Intersection(_Pair):
    """``a & b``: the larger distance. Exact inside; outside, the distance is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.maximum(self.first._distance(points), self.second._distance(points))

    def bounds(self) -> Bounds:
        """The overlap of both boxes; refuses shapes whose boxes do not meet."""
        (low, high), (other_low, other_high) = self.first.bounds(), self.second.bounds()
        lower, upper = tuple(map(max, low, other_low)), tuple(map(min, high, other_high))
        if any(a > b for a, b in zip(lower, upper, strict=True)):
            raise InputError("the intersection is empty", hint="shapes that overlap")
        return lower, upper


class Difference(_Pair):
    """``a - b``: max(a, -b). The zero set is exact; elsewhere |distance| is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.maximum(self.first._distance(points), -self.second._distance(points))

    def bounds(self) -> Bounds:
        """The box of the first."""
        return self.first.bounds()


@dataclass(frozen=True)
class Moved(Shape):
    """A shape turned about the origin, then shifted; as exact as the shape it moves."""

    shape: Shape
    shift: tuple[float, ...]
    angle: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse a shift or an angle of the wrong length, or not finite."""
        for name, given, count in (
            ("shift", self.shift, self.ndim),
            ("angle", self.angle, 1 if self.ndim == 2 else 3),
        ):
            if len(given) != count or not all(math.isfinite(x) for x in given):
                raise InputError(
                    f"{name} must hold {count} finite number(s) in {self.ndim}-D, got {given}",
                    hint=f"{name}={0.0 if count == 1 else (0.0,) * count}",
                )

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return self.shape.ndim

    @property
    def volume(self) -> float | None:
        """That of the shape: motion keeps it."""
        return self.shape.volume

    def _distance(self, points: Array) -> Array:
        shift = np.asarray(self.shift, points.dtype).reshape(-1, *(1,) * (points.ndim - 1))
        turn = rotation(self.angle).T.astype(points.dtype)
        return self.shape._distance(np.tensordot(turn, points - shift, axes=1))

    def bounds(self) -> Bounds:
        """The box around the turned and shifted box (not always the smallest)."""
        corners = np.array(list(itertools.product(*zip(*self.shape.bounds(), strict=True))))
        turned = corners @ rotation(self.angle).T + np.asarray(self.shift)
        return tuple(turned.min(axis=0).tolist()), tuple(turned.max(axis=0).tolist())


def rotation(angle: Sequence[float]) -> NDArray[np.float64]:
    """Matrix that turns by ``angle`` [rad]: one number in 2-D, a rotation vector in 3-D."""
    if len(angle) == 1:
        cos, sin = math.cos(angle[0]), math.sin(angle[0])
        return np.array([[cos, -sin], [sin, cos]])
    x, y, z = angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = math.hypot(x, y, z)
    if turn == 0.0:
        return np.eye(3)
    haversine = 2.0 * (math.sin(0.5 * turn) / turn) ** 2
    return np.asarray(np.eye(3) + math.sin(turn) / turn * cross + haversine * cross @ cross)


def seen_from(points: Array, center: Point) -> Array:
    """Points seen from a centre."""
    return points - np.asarray(center, points.dtype).reshape(-1, *(1,) * (points.ndim - 1))


def length_of(vectors: Array) -> Array:
    """Euclidean length of vectors (ndim, ...)."""
    return np.asarray(np.sqrt(np.einsum("i...,i...->...", vectors, vectors)))


def box_around(center: Point, half: Point) -> Bounds:
    """Corners of the box with these half sides."""
    lower = tuple(c - a for c, a in zip(center, half, strict=True))
    return lower, tuple(c + a for c, a in zip(center, half, strict=True))


def refuse_not_positive(shape: Shape, **lengths: float) -> None:
    """Refuse lengths that are not positive."""
    for name, value in lengths.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"{type(shape).__name__}: {name} must be a positive length, got {value}",
                hint=f"{type(shape).__name__}(...) with lengths above zero",
            )


def plain_vector(shape: Shape, name: str, count: int) -> None:
    """Store a vector as plain floats; refuse one of the wrong length or not finite."""
    given = getattr(shape, name)
    if len(given) != count or not all(math.isfinite(x) for x in given):
        raise InputError(
            f"{type(shape).__name__}: {name} must hold {count} finite numbers, got {given}",
            hint=f"{name}={(0.0,) * count}",
        )
    object.__setattr__(shape, name, tuple(float(x) for x in given))
