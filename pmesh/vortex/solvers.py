"""The velocity solvers of a flow, kept between steps for their spectra and buffers."""

from __future__ import annotations

from functools import lru_cache

from pmesh.spectral.velocity import VelocitySolver
from remesh.grid import Boundary, Grid


def solver_for(
    grid: Grid, *, order: int, radius: float, dtype: str, threads: int | None
) -> VelocitySolver:
    """The solver of a mesh of this shape, wherever it lies; an earlier one if there is."""
    return _solver(grid.shape, grid.spacing, grid.boundary, order, radius, dtype, threads)


@lru_cache(maxsize=12)
def _solver(
    shape: tuple[int, ...],
    spacing: float,
    boundary: tuple[Boundary, ...],
    order: int,
    radius: float,
    dtype: str,
    threads: int | None,
) -> VelocitySolver:
    grid = Grid(shape, spacing, None, boundary)
    return VelocitySolver(grid, order=order, radius=radius, dtype=dtype, threads=threads)
