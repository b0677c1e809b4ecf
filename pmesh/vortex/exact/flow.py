"""What exact flows share: their protocol, coordinates about a drifting centre, refusals."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Pair = tuple[float, float]


class ExactFlow(Protocol):
    """A plane flow that can be asked for its fields at any points (2, ...) and any time."""

    @property
    def circulation(self) -> float:
        """Integral of the vorticity [L^2/T]."""

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` (2, ...) [L]; the result has shape ``points.shape[1:]``."""

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T] at ``points`` (2, ...) [L]; the result has the shape of ``points``."""


def relative(points: Array, center: Pair, drift: Pair, time: float) -> Array:
    """Points seen from a centre that drifts; refuses points that are not (2, ...)."""
    points = np.asarray(points)
    if points.ndim < 1 or points.shape[0] != 2:
        raise InputError(
            f"points must have shape (2, ...), got {points.shape}", hint="grid.points()"
        )
    if not np.issubdtype(points.dtype, np.floating):
        points = points.astype(np.float64)
    now = tuple(c + d * time for c, d in zip(center, drift, strict=True))
    return as_array(points - column(now, points))


def column(pair: Pair | tuple[float, ...], like: Array) -> Array:
    """A vector shaped to be added to a field of vectors."""
    return np.asarray(pair, like.dtype).reshape(2, *(1,) * (like.ndim - 1))


def as_array(values: Any) -> Array:
    """The values as the array type that the signatures promise."""
    return np.asarray(values)


def check(flow: object, positive: tuple[str, ...], not_negative: tuple[str, ...]) -> None:
    """Refuse parameters outside their range, naming flow and parameter."""
    for names, low, word in ((positive, 1e-300, "positive"), (not_negative, 0, "not negative")):
        for name in names:
            value = getattr(flow, name)
            if not (math.isfinite(value) and value >= low):
                raise InputError(
                    f"{type(flow).__name__}: {name} must be {word}, got {value}",
                    hint=f"{type(flow).__name__}({name}=1)",
                )


def check_axes(axes: Pair) -> None:
    """Refuse half axes that are not two positive numbers."""
    if len(axes) != 2 or not all(math.isfinite(a) and a > 0 for a in axes):
        raise InputError(f"axes must be two positive half axes, got {axes}", hint="axes=(2, 1)")
