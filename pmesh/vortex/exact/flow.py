"""What exact flows share: their protocol, coordinates about a moving centre, refusals."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Pair = tuple[float, float]
Triple = tuple[float, float, float]


class ExactFlow(Protocol):
    """A flow that can be asked for its fields at any points (ndim, ...) and any time.

    Vorticity is a scalar in the plane and a vector in space. This is the face of plane flows; those
    in space have the same laws of points, most a velocity, and none a circulation of all.
    """

    @property
    def circulation(self) -> float:
        """Integral of the vorticity [L^2/T]."""

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` [L]: ``points.shape[1:]``, in space ``points.shape``."""

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T] at ``points`` (ndim, ...) [L]; the result has the shape of ``points``."""


def relative(points: Array, center: Pair | Triple, drift: Pair | Triple, time: float) -> Array:
    """Points seen from a centre that drifts; refuses points not of the centre's dimensions."""
    points = np.asarray(points)
    if points.ndim < 1 or points.shape[0] != len(center):
        raise InputError(
            f"points must have shape ({len(center)}, ...), got {points.shape}",
            hint="grid.points()",
        )
    if not np.issubdtype(points.dtype, np.floating):
        points = points.astype(np.float64)
    now = tuple(c + d * time for c, d in zip(center, drift, strict=True))
    return as_array(points - column(now, points))


def column(pair: Pair | tuple[float, ...], like: Array) -> Array:
    """A vector shaped to be added to a field of vectors."""
    return np.asarray(pair, like.dtype).reshape(len(pair), *(1,) * (like.ndim - 1))


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


def check_start(flow: object, time: float) -> None:
    """Refuse any time but zero of a flow that is known as a start only."""
    if time != 0.0:
        raise InputError(
            f"{type(flow).__name__} is known exactly at time 0 only, got {time}",
            hint="start a VortexFlow from vorticity(points) and run it",
        )


def check_triple(flow: object, *names: str) -> None:
    """Refuse vectors that are not three finite numbers, naming flow and parameter."""
    for name in names:
        vector = getattr(flow, name)
        if np.shape(vector) != (3,) or not np.isfinite(vector).all():
            raise InputError(
                f"{type(flow).__name__}: {name} must be three numbers, got {vector}",
                hint=f"{type(flow).__name__}({name}=(0, 0, 1))",
            )


def frame(axis: Triple) -> Array:
    """Right-handed unit vectors (3, 3), one per row, the last along ``axis`` (any length but 0).

    The axis (0, 0, 1) gives x, y, z themselves.
    """
    length = math.hypot(*axis)
    if not (math.isfinite(length) and length > 0.0):
        raise InputError(f"axis must be a direction, got {axis}", hint="axis=(0, 0, 1)")
    along = np.asarray(axis, float) / length
    seed = np.array([1.0, 0.0, 0.0] if abs(along[0]) < 0.9 else [0.0, 1.0, 0.0])
    first = seed - along * (seed @ along)
    first /= math.sqrt(first @ first)
    return np.stack([first, np.cross(along, first), along])
