"""Runge-Kutta schemes as tables, and the paths of points in a velocity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Velocity = Callable[[float, Array], Array]


@dataclass(frozen=True)
class Scheme:
    """An explicit Runge-Kutta scheme: ``rows[k]`` weighs the slopes before stage k + 1."""

    name: str
    order: int
    rows: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    source: str


SCHEMES: dict[str, Scheme] = {
    scheme.name: scheme
    for scheme in (
        Scheme("RK2", 2, ((1 / 2,),), (0.0, 1.0), "midpoint rule"),
        Scheme("RK3", 3, ((1 / 2,), (0.0, 3 / 4)), (2 / 9, 1 / 3, 4 / 9), "Ralston 1962"),
        Scheme(
            "RK4", 4, ((1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)), (1 / 6, 1 / 3, 1 / 3, 1 / 6),
            "Kutta 1901",
        ),
    )
}  # fmt: skip


def get_scheme(name: str, option: str = "time_scheme") -> Scheme:
    """The scheme of this name; refuses others, by the name of the option it was given as."""
    if name not in SCHEMES:
        raise InputError(
            f"{option} must be one of {', '.join(SCHEMES)}, got {name!r}", hint=f"{option}='RK4'"
        )
    return SCHEMES[name]


def travel(positions: Array, velocity: Velocity, time: float, dt: float, scheme: Scheme) -> Array:
    """Where points (n, ndim) are after dt in ``velocity(time, positions)``; dt < 0 goes back."""
    slopes = [velocity(time, positions)]
    for row in scheme.rows:
        stage = moved(positions, slopes, row, dt)
        slopes.append(velocity(time + sum(row) * dt, stage))
    return moved(positions, slopes, scheme.weights, dt)


def moved(
    base: Array | None, slopes: Sequence[Array], weights: Sequence[float], dt: float
) -> Array:
    """base + dt * sum of weighted slopes; without a base the sum alone."""
    used = [(weight, slope) for weight, slope in zip(weights, slopes, strict=True) if weight]
    (weight, slope), *others = used
    total = slope * slope.dtype.type(dt * weight)
    for weight, slope in others:
        total += slope * slope.dtype.type(dt * weight)
    if base is not None:
        total += base
    return total
