"""Integrals of a plane vorticity field: what a flow keeps, and what bodies change."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

Array = NDArray[np.floating[Any]]


def circulation(vorticity: Array, grid: Grid) -> float:
    """Sum of vorticity, ``int w dV`` [L^2/T]."""
    return float(np.sum(vorticity, dtype=np.float64)) * grid.cell_volume


def impulse(vorticity: Array, grid: Grid) -> tuple[float, float]:
    """Linear impulse ``int (y w, -x w) dV`` [L^3/T]; the momentum of the fluid at rest far away."""
    x, y = grid.axes()
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_y @ y) * grid.cell_volume, -float(along_x @ x) * grid.cell_volume


def angular_moment(vorticity: Array, grid: Grid) -> float:
    """Second moment ``int (x^2 + y^2) w dV`` about the origin [L^4/T]."""
    x, y = grid.axes()
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_x @ x**2 + along_y @ y**2) * grid.cell_volume


def enstrophy(vorticity: Array, grid: Grid) -> float:
    """``int w^2 dV`` [L^2/T^2]."""
    flat = vorticity.reshape(-1)
    return float(np.dot(flat, flat)) * grid.cell_volume
