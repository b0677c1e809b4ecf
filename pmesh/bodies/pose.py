"""Where a body is and how it moves, at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.shape import rotation, seen_from

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class Pose:
    """The place and rigid motion of a body; its centre of mass is what is followed.

    Angles and spins hold one number in the plane, three in space.
    """

    time: float  # [T]; a body's deformation is a law of it
    center: tuple[float, ...]  # of mass [L]
    angle: tuple[float, ...]  # turned by, from its own axes [rad]
    velocity: tuple[float, ...]  # of the centre [L/T]
    spin: tuple[float, ...]  # [rad/T]

    def seen(self, points: Array) -> Array:
        """World points (ndim, ...) in the body's own axes, from its centre."""
        moved = seen_from(points, self.center)
        return np.tensordot(self._turn().T.astype(points.dtype), moved, axes=1)

    def placed(self, points: Array) -> Array:
        """Points (ndim, ...) in the body's own axes, from its centre, in the world."""
        return self.turned(points) + _column(self.center, points)

    def turned(self, vectors: Array) -> Array:
        """Vectors (ndim, ...) in the body's axes, in world axes."""
        return np.tensordot(self._turn().astype(vectors.dtype), vectors, axes=1)

    def rigid(self, points: Array) -> Array:
        """Velocity [L/T] of the rigid motion at world points (ndim, ...)."""
        arm = seen_from(points, self.center)
        spin = np.asarray(self.spin, points.dtype)
        base = np.zeros_like(points) + _column(self.velocity, points)
        if len(self.spin) == 1:
            base[0] -= spin[0] * arm[1]
            base[1] += spin[0] * arm[0]
            return base
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            base[i] += spin[j] * arm[k] - spin[k] * arm[j]
        return base

    def _turn(self) -> NDArray[np.float64]:
        return rotation(self.angle)


def still(center: tuple[float, ...], time: float = 0.0) -> Pose:
    """A body at rest at its centre, not turned."""
    turns = (0.0,) * (1 if len(center) == 2 else 3)
    return Pose(time=time, center=center, angle=turns, velocity=(0.0,) * len(center), spin=turns)


def _column(vector: tuple[float, ...], points: Array) -> Array:
    return np.asarray(vector, points.dtype).reshape(-1, *(1,) * (points.ndim - 1))
