"""Integrals of a plane vorticity field: what a flow keeps, and what bodies change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

Array = NDArray[np.floating[Any]]


def circulation(vorticity: Array, grid: Grid) -> float:
    """Sum of vorticity, ``int w dV`` [L^2/T]."""
    return float(np.sum(vorticity, dtype=np.float64)) * grid.cell_volume


def impulse(vorticity: Array, grid: Grid) -> tuple[float, float]:
    """Linear impulse ``int (y w, -x w) dV`` [L^3/T]; the momentum of the fluid at rest far away.

    NaN where the lever is a periodic coordinate, which has no origin.
    """
    x, y = _levers(grid)
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_y @ y) * grid.cell_volume, -float(along_x @ x) * grid.cell_volume


def angular_moment(vorticity: Array, grid: Grid) -> float:
    """Second moment ``int (x^2 + y^2) w dV`` about the origin [L^4/T]; NaN on periodic axes."""
    x, y = _levers(grid)
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_x @ x**2 + along_y @ y**2) * grid.cell_volume


def enstrophy(vorticity: Array, grid: Grid) -> float:
    """``int w^2 dV`` [L^2/T^2]."""
    return float(np.sum(np.square(vorticity), dtype=np.float64)) * grid.cell_volume


def impulse_force(
    before: Array, after: Array, grid: Grid, dt: float, freestream: Sequence[float]
) -> tuple[float, float]:
    """Force on all bodies [L^3/T^2], mean over dt, from the change of the linear impulse.

    The free stream (U, V) carries a circulation's impulse along at the rate (V, -U) times it.
    """
    old, new = impulse(before, grid), impulse(after, grid)
    total = 0.5 * (circulation(before, grid) + circulation(after, grid))
    along, across = freestream
    return across * total - (new[0] - old[0]) / dt, -along * total - (new[1] - old[1]) / dt


def cut(before: Array, after: Array, grid: Grid) -> float:
    """Circulation that left the mesh between two fields [L^2/T]."""
    if before is after or all(grid.periodic):
        return 0.0
    return circulation(before, grid) - circulation(after, grid)


def _levers(grid: Grid) -> list[NDArray[np.float64]]:
    """Coordinates along each axis; NaN along periodic ones."""
    return [
        np.full_like(axis, np.nan) if wraps else axis
        for axis, wraps in zip(grid.axes(), grid.periodic, strict=True)
    ]
