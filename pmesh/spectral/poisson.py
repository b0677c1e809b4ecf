"""The two laws of a spectral solve: the Poisson equation, and the velocity of a vorticity field."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Literal, overload

import numpy as np

from pmesh.spectral.checks import Field
from pmesh.spectral.velocity import VelocitySolver
from remesh.grid import Grid


def poisson(
    rhs: Field,
    grid: Grid,
    *,
    order: int | None = None,
    kernel: str = "HEJ",
    threads: int | None = None,
) -> Field:
    """Solution psi of laplace(psi) = rhs, of the shape of ``rhs``.

    ``rhs``: ``grid.shape``, or any number of them stacked in front; the unit of psi is that of rhs
    times [L^2]. Unbounded axes: the free-space solution, -> ln(r) / (2 pi) or -1 / (4 pi r) of the
    total; periodic axes: zero mean of what has no unbounded axis. Order of accuracy as ``order``
    (see VelocitySolver); spectral when all axes are periodic. Refuses what VelocitySolver refuses.
    """
    return _solver(grid, kernel, order, _precision(rhs), threads).poisson(rhs)


@overload
def velocity(
    vorticity: Field,
    grid: Grid,
    freestream: Sequence[float] | None = None,
    *,
    order: int | None = None,
    kernel: str = "HEJ",
    gradient: Literal[False] = False,
    threads: int | None = None,
) -> Field: ...


@overload
def velocity(
    vorticity: Field,
    grid: Grid,
    freestream: Sequence[float] | None = None,
    *,
    order: int | None = None,
    kernel: str = "HEJ",
    gradient: Literal[True],
    threads: int | None = None,
) -> tuple[Field, Field]: ...


def velocity(
    vorticity: Field,
    grid: Grid,
    freestream: Sequence[float] | None = None,
    *,
    order: int | None = None,
    kernel: str = "HEJ",
    gradient: bool = False,
    threads: int | None = None,
) -> Field | tuple[Field, Field]:
    """Velocity curl(psi), laplace(psi) = -vorticity, plus the free stream; (ndim, *shape) [L/T].

    ``vorticity``: ``grid.shape`` in 2-D (dv/dx - du/dy), ``(3, *grid.shape)`` in 3-D [1/T]. With
    ``gradient=True`` also ``[i, j] = d u_i / d x_j``, shape ``(ndim, ndim, *shape)`` [1/T]. Order,
    cost, refusals as VelocitySolver. float32 in, float32 out; all else is float64.
    """
    solver = _solver(grid, kernel, order, _precision(vorticity), threads)
    if gradient:
        return solver.velocity_and_gradient(vorticity, freestream=freestream)
    return solver.velocity(vorticity, freestream=freestream)


def _precision(field: Field) -> str:
    return "f4" if np.asarray(field).dtype == np.float32 else "f8"


@lru_cache(maxsize=2)
def _solver(
    grid: Grid, kernel: str, order: int | None, dtype: str, threads: int | None
) -> VelocitySolver:
    """The last two solvers: their buffers and plans serve the next call."""
    return VelocitySolver(grid, kernel=kernel, order=order, dtype=dtype, threads=threads)
