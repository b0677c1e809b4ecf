"""Bodies in a flow: where they are and how they move."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from remesh.errors import InputError

Array = NDArray[np.floating[Any]]


class Body(Protocol):
    """What a flow asks of a body: its distance, its velocity, and a box that holds it.

    A value: equal bodies are the same body, so it must be hashable (a frozen dataclass).
    """

    @property
    def ndim(self) -> int:
        """Number of dimensions."""

    @property
    def moving(self) -> bool:
        """Whether its place, shape or velocity depends on the time."""

    def bounds(self, time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper corner of a box that holds the body at this time [L]."""

    def distance(self, points: Array, time: float) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...)."""

    def velocity(self, points: Array, time: float) -> Array:
        """Velocity of the body's matter [L/T] at ``points`` (ndim, ...), of the same shape."""


@dataclass(frozen=True)
class Fixed:
    """No motion."""

    def velocity(self, points: Array, time: float) -> Array:
        """Zero [L/T] at ``points`` (ndim, ...)."""
        return np.zeros_like(points)


@dataclass(frozen=True)
class RigidBody:
    """A solid of a given shape, held in place: ``RigidBody(levelset.shapes.Disk(radius=0.5))``.

    Refuses what is not a shape, and a motion other than `Fixed`.
    """

    shape: Shape
    motion: Fixed = field(default=Fixed(), kw_only=True)

    def __post_init__(self) -> None:
        """Refuse what is not a shape or not a motion."""
        if not isinstance(self.shape, Shape):
            raise InputError(
                f"a RigidBody needs a shape, got {type(self.shape).__name__}",
                hint="levelset.shapes.Disk(radius=0.5)",
            )
        if not isinstance(self.motion, Fixed):
            raise InputError(
                f"motion must be Fixed(), got {self.motion!r}", hint="motion=pmesh.Fixed()"
            )

    @property
    def ndim(self) -> int:
        """Number of dimensions of the shape."""
        return self.shape.ndim

    @property
    def moving(self) -> bool:
        """False: it is held in place."""
        return False

    def bounds(self, time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper corner of a box that holds the body [L]."""
        return self.shape.bounds()

    def distance(self, points: Array, time: float) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...)."""
        return self.shape.distance(points)

    def velocity(self, points: Array, time: float) -> Array:
        """Velocity of the body's matter [L/T] at ``points`` (ndim, ...)."""
        return self.motion.velocity(points, time)
