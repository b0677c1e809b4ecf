"""The divergence-free part of a vector field in space, for the central difference of order 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.spectral.convolve import Term
from pmesh.spectral.symbols import Box
from remesh.stencils import weights


@dataclass(frozen=True)
class _Entry:
    """Entry (i, j) of the projection, made part by part of the last axis: nothing is stored.

    delta_ij - S_i S_j / sum S_k^2, i S_k the symbol of the difference along axis k; where all of
    them vanish (the mean, and waves that change sign from node to node) delta_ij.
    """

    symbols: tuple[NDArray[np.float64], ...]
    pair: tuple[int, int]
    dtype: np.dtype[Any]

    def __getitem__(self, part: slice) -> NDArray[Any]:
        """The table for these wavenumbers of the last axis, axes reversed."""
        first, middle, last = self.symbols
        lines = (first, middle[:, None], last[part, None, None])
        square = lines[0] ** 2 + lines[1] ** 2 + lines[2] ** 2
        square[square == 0] = 1.0
        i, j = self.pair
        table = (-lines[i] * lines[j]) / square
        if i == j:
            table += 1.0
        return table.astype(self.dtype)


def projection(box: Box, dtype: np.dtype[Any]) -> list[list[Term]]:
    """out_i = sum_j P_ij w_j, so that the difference of order 6 finds no divergence in ``out``."""
    symbols = tuple(_symbol(box, axis) for axis in range(3))

    def term(i: int, j: int) -> Term:
        parity = tuple(((axis == i) + (axis == j)) % 2 for axis in range(3))
        return Term(j, _Entry(symbols, (i, j), dtype), parity)

    return [[term(i, j) for j in range(3)] for i in range(3)]


def _symbol(box: Box, axis: int) -> NDArray[np.float64]:
    """S with i S the symbol of the difference of order 6 along the axis [1/L], exact zeros kept."""
    angle = box.wavenumbers(axis) * box.spacing
    ahead = weights(1, tuple(range(-3, 4)))[4:]
    waves = [2 * float(w) * np.sin(s * angle) for s, w in enumerate(ahead, start=1)]
    symbol = np.asarray(sum(waves), dtype=np.float64) / box.spacing
    if box.padded[axis] % 2 == 0:
        symbol[-1] = 0.0
    return symbol
