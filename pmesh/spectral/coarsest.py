"""Velocity on the coarsest level, over the whole domain: matched kernels, by transforms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pmesh.spectral.checks import Field, check_field, check_freestream, check_mean, output
from pmesh.spectral.convolve import Convolver, Term
from pmesh.spectral.greens import hej
from pmesh.spectral.matched import kernel_values
from pmesh.spectral.symbols import Box, Derivative, Greens, multipliers
from remesh.grid import Grid

_SMOOTH = Greens(kernel="HEJ", order=2, radius=2.0)
_REACH = 32  # beyond, smooth and matched kernels are the same to round-off of the table


class CoarsestSolver:
    """Velocity of vorticity on one uniform grid, as scaling functions of ``order`` around nodes.

    Sizes, units and refusals as `VelocitySolver`; any axis may be periodic. The kernel is the
    Gaussian-smoothed one, which knows about periodic axes, plus a table of what the matched one has
    beyond it near a node.
    """

    def __init__(self, grid: Grid, *, order: int, dtype: DTypeLike, threads: int) -> None:
        self.grid = grid
        self.dtype = np.dtype(dtype)
        self.box = Box.around(grid)
        self._convolver = Convolver(self.box, dtype=self.dtype, threads=threads)
        firsts = [_first(grid.ndim, axis) for axis in range(grid.ndim)]
        smooth = multipliers(self.box, _SMOOTH, firsts, np.float64)
        tables = [
            (table * _blur(self.box) + _near(self.box, axis, order)).astype(self.dtype)
            for axis, table in enumerate(smooth)
        ]
        self._outputs = _curl(tables, firsts)

    def velocity(self, vorticity: Field, freestream: Sequence[float] | None = None) -> Field:
        """Velocity ``(ndim, *shape)`` [L/T] of vorticity ``shape`` or ``(3, *shape)`` [1/T]."""
        shape, ndim = self.grid.shape, self.grid.ndim
        components = shape if ndim == 2 else (3, *shape)
        field = check_field(vorticity, components, self.dtype, "vorticity")
        sources = [field] if ndim == 2 else list(field)
        out = output(None, (ndim, *shape), self.dtype)
        periodic = all(self.grid.periodic)
        self._convolver.run(
            sources, self._outputs, list(out),
            shifts=check_freestream(freestream, ndim),
            check=lambda means: check_mean(means, sources, periodic=periodic),
        )  # fmt: skip
        return out


def _first(ndim: int, axis: int) -> Derivative:
    return tuple(int(axis == other) for other in range(ndim))


def _curl(tables: list[NDArray[Any]], firsts: list[Derivative]) -> list[list[Term]]:
    """u = curl(G * w): in 2-D (d_1 G, -d_0 G) * w, else d_j G * w_k - d_k G * w_j."""

    def term(source: int, axis: int, sign: int) -> Term:
        return Term(source, tables[axis], firsts[axis], 1 if sign > 0 else 3)

    if len(tables) == 2:
        return [[term(0, 1, 1)], [term(0, 0, -1)]]
    cycles = ((1, 2), (2, 0), (0, 1))
    return [[term(k, j, 1), term(j, k, -1)] for j, k in cycles]


def _blur(box: Box) -> NDArray[np.float64]:
    """Transform of the smoothing, which fully periodic tables come without; axes reversed."""
    if not all(box.periodic):
        return np.ones(())
    sigma = _SMOOTH.radius * box.spacing
    squares = [box.along(axis, box.wavenumbers(axis) ** 2) for axis in range(len(box.shape))]
    return np.exp(np.asarray(sum(squares)) * (-(sigma**2) / 2)).T


def _near(box: Box, axis: int, order: int) -> NDArray[np.float64]:
    """Table of the matched kernel less the smooth one, d_axis G; axes reversed."""
    ndim = len(box.shape)
    span = np.arange(-_REACH, _REACH + 1)
    offsets = np.meshgrid(*(span,) * ndim, indexing="ij", sparse=True)
    r2 = np.asarray(sum(x**2.0 for x in offsets))
    slope = hej(r2, np.zeros((1,) * ndim), ndim, sigma=_SMOOTH.radius, order=2)[1]
    values = kernel_values(order, ndim, _REACH) - offsets[0] * slope
    values = np.swapaxes(values, 0, axis) * box.spacing
    folded = np.zeros(box.padded)
    np.add.at(folded, np.ix_(*_places(box, span)), _cut(box, values, span))
    table = np.fft.fftn(folded).imag
    return np.asarray(table[tuple(slice(0, h) for h in box.half)].T)


def _places(box: Box, span: NDArray[Any]) -> list[NDArray[Any]]:
    return [span % padded for padded in box.padded]


def _cut(box: Box, values: NDArray[Any], span: NDArray[Any]) -> NDArray[Any]:
    """Zero at offsets that no two nodes of an unbounded axis have."""
    for axis, wraps in enumerate(box.periodic):
        if not wraps:
            values = values * box.along(axis, np.abs(span) < box.shape[axis])
    return values
