"""A sphere in a stream: the law of its first drag, published numbers, the velocity on its axis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.cylinder_wake import Published
from pmesh.cases.reference import read_table
from remesh.grid import Grid

Values = NDArray[np.float64]


def stokes_drag(reynolds: float, begin: Values, end: Values) -> Values:
    """Mean drag coefficients from T = ``begin`` to ``end`` of a sphere set in motion at once.

    Of unsteady Stokes flow, exact: 24/Re (1 + sqrt(Re / (pi T)) / 2), friction, its history and
    the pressure; the impulse at T = 0, the added mass, is no part of it. Inertia changes it by a
    part of order T^2, because reversing the stream reverses the force; of a cylinder's drag it is
    2.6 T^2 at Re = 100, T = 0.1. Source: A. B. Basset, A treatise on hydrodynamics 2 (1888),
    chapter 22.
    """
    root = 2.0 / (np.sqrt(end) + np.sqrt(begin))  # the mean of 1 / sqrt(T)
    return np.asarray(24 / reynolds * (1 + 0.5 * math.sqrt(reynolds / math.pi) * root))


def published(reynolds: float) -> dict[str, Published]:
    """Published numbers at a Reynolds number; none at most."""
    return {
        row["quantity"]: Published(
            float(row["value"]), float(row["tolerance"]), row["grade"], row["source"]
        )
        for row in read_table("sphere.csv")
        if float(row["reynolds"]) == reynolds
    }


def axis_velocity(velocity: NDArray[Any], grid: Grid) -> tuple[Values, Values]:
    """x and the velocity along it on the line y = z = 0, cubic through the nodes about it."""
    values = np.asarray(velocity[0], np.float64)
    for axis in (2, 1):
        values = _at_zero(values, grid.axes()[axis], grid.spacing)
    return np.asarray(grid.axes()[0], np.float64), values


def _at_zero(values: Values, places: NDArray[Any], spacing: float) -> Values:
    """Values along the last axis at the place zero, cubic through the four about it."""
    row = int(np.searchsorted(places, 0.0))
    t = float(-places[row - 1] / spacing)
    weights = (-t * (t - 1) * (t - 2) / 6, (t * t - 1) * (t - 2) / 2,
               -t * (t + 1) * (t - 2) / 2, t * (t * t - 1) / 6)  # fmt: skip
    return np.asarray(values[..., row - 2 : row + 2] @ np.array(weights), np.float64)
