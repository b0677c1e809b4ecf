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

from remesh.errors import InputError, as_number

Array = NDArray[np.floating[Any]]
Point = tuple[float, ...]
Bounds = tuple[tuple[float, ...], tuple[float, ...]]
Moments = tuple[float, Point, float]  # volume, centre, polar second moment about it


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

    @property
    def surface(self) -> float | None:
        """Length (2-D) or area (3-D) of the boundary [L^(ndim-1)]; None where no form is known."""
        return None

    @property
    def perimeter(self) -> float | None:
        """Another word for ``surface``, for plane shapes."""
        return self.surface

    def reach(self, distance: float) -> Bounds:
        """A box that holds all points whose signed distance is at most ``distance`` >= 0 [L]."""
        return grown(self.bounds(), distance)

    def _moments(self) -> Moments | None:
        """Volume [L^ndim], centre [L] and polar second moment about it [L^(ndim+2)], if known."""
        return None

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
        given = (angle,) if isinstance(angle, int | float | np.number) else angle
        turn = vector("angle", given, 1, 3)
        if self.ndim == 3 and turn == (0.0,):
            turn = (0.0, 0.0, 0.0)
        way = vector("shift", (0.0,) * self.ndim if shift is None else shift, self.ndim)
        return Moved(self, way, turn)


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

    def bounds(self) -> Bounds:
        """A box that holds it, from those of both."""
        return self.reach(0.0)


class Union(_Pair):
    """``a | b``: the smaller distance. Exact outside; inside, |distance| is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.minimum(self.first._distance(points), self.second._distance(points))

    def reach(self, distance: float) -> Bounds:
        """The box around both boxes."""
        return around(self.first.reach(distance), self.second.reach(distance))


class Intersection(_Pair):
    """``a & b``: the larger distance. Exact inside; outside, the distance is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.maximum(self.first._distance(points), self.second._distance(points))

    def reach(self, distance: float) -> Bounds:
        """The overlap of both boxes; refuses shapes whose boxes do not meet."""
        return overlap(self.first.reach(distance), self.second.reach(distance))


class Difference(_Pair):
    """``a - b``: max(a, -b). The zero set is exact; elsewhere |distance| is a lower bound."""

    def _distance(self, points: Array) -> Array:
        return np.maximum(self.first._distance(points), -self.second._distance(points))

    def reach(self, distance: float) -> Bounds:
        """The box of the first."""
        return self.first.reach(distance)


@dataclass(frozen=True)
class Moved(Shape):
    """A shape turned about the origin, then shifted; as exact as the shape it moves."""

    shape: Shape
    shift: tuple[float, ...]
    angle: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse a shift or an angle of the wrong length, or not finite."""
        store_vector(self, "shift", self.ndim)
        store_vector(self, "angle", 1 if self.ndim == 2 else 3)

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return self.shape.ndim

    @property
    def volume(self) -> float | None:
        """That of the shape: motion keeps it."""
        return self.shape.volume

    @property
    def surface(self) -> float | None:
        """That of the shape: motion keeps it."""
        return self.shape.surface

    def _distance(self, points: Array) -> Array:
        shift = np.asarray(self.shift, points.dtype).reshape(-1, *(1,) * (points.ndim - 1))
        turn = rotation(self.angle).T.astype(points.dtype)
        return self.shape._distance(np.tensordot(turn, points - shift, axes=1))

    def bounds(self) -> Bounds:
        """The box around the turned and shifted box (not always the smallest)."""
        return self.reach(0.0)

    def reach(self, distance: float) -> Bounds:
        """The box around the turned and shifted box (not always the smallest)."""
        corners = np.array(list(itertools.product(*zip(*self.shape.reach(distance), strict=True))))
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


def grown(bounds: Bounds, margin: float) -> Bounds:
    """A box grown on all sides."""
    return tuple(x - margin for x in bounds[0]), tuple(x + margin for x in bounds[1])


def around(first: Bounds, second: Bounds) -> Bounds:
    """The smallest box that holds both."""
    return tuple(map(min, first[0], second[0])), tuple(map(max, first[1], second[1]))


def overlap(first: Bounds, second: Bounds) -> Bounds:
    """What two boxes share; refuses boxes that do not meet."""
    lower, upper = tuple(map(max, first[0], second[0])), tuple(map(min, first[1], second[1]))
    if any(a > b for a, b in zip(lower, upper, strict=True)):
        raise InputError("the intersection is empty", hint="shapes that overlap")
    return lower, upper


def vector(name: str, given: Any, *counts: int) -> Point:
    """The given numbers as plain floats; refuses all but as many finite ones as asked."""
    asked = f"{name} must hold {' or '.join(map(str, counts))} finite number"
    asked += "" if counts == (1,) else "s"
    hint = f"{0.0 if counts == (1,) else (0.0,) * counts[0]}"
    try:
        parts = tuple(given)
    except TypeError as error:
        raise InputError(f"{asked}, got {given!r}", hint=hint) from error
    numbers = tuple(as_number(f"{name}[{i}]", part, hint=hint) for i, part in enumerate(parts))
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise InputError(f"{asked}, got {given}", hint=hint)
    return numbers


def store_vector(shape: Shape, name: str, *counts: int) -> None:
    """Store a vector as plain floats: shapes of equal numbers are equal, and can be hashed."""
    given = getattr(shape, name)
    object.__setattr__(shape, name, vector(f"{type(shape).__name__}: {name}", given, *counts))


def store_lengths(shape: Shape, *names: str) -> None:
    """Store lengths as plain floats; refuses what is not positive."""
    for name in names:
        told, hint = f"{type(shape).__name__}: {name}", f"{name}=0.5"
        object.__setattr__(shape, name, as_number(told, getattr(shape, name), hint=hint))
        _refuse_not_positive(told, getattr(shape, name), hint)


def store_sides(shape: Shape, name: str, *counts: int) -> None:
    """Store a vector of lengths as plain floats; refuses what is not positive."""
    store_vector(shape, name, *counts)
    for i, side in enumerate(getattr(shape, name)):
        _refuse_not_positive(f"{type(shape).__name__}: {name}[{i}]", side, f"{name}=(2.0, 1.0)")


def _refuse_not_positive(told: str, length: float, hint: str) -> None:
    if not (math.isfinite(length) and length > 0):
        raise InputError(f"{told} must be a positive length, got {length}", hint=hint)
