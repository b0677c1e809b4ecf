"""Compiled loops of the spectral solves: plain arrays in, plain arrays out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def scale(
    spectrum: NDArray[Any],
    table: NDArray[Any],
    signs: NDArray[Any],
    turned: bool,
    add: bool,
    out: NDArray[Any],
) -> None:
    """out (+)= [i] * table * spectrum, where the table holds the non-negative wavenumbers only.

    ``signs``: overall sign, and the parity (+1, -1) of the table along rows and along columns.
    """
    rows, columns = spectrum.shape
    half_rows, half_columns = table.shape
    for row in range(rows):
        near = row if row < half_rows else rows - row
        sign = signs[0] if row < half_rows else signs[0] * signs[1]
        mirrored = sign * signs[2]
        if turned:
            for c in range(half_columns):
                t = sign * table[near, c]
                z = spectrum[row, c]
                w = complex(-t * z.imag, t * z.real)
                out[row, c] = out[row, c] + w if add else w
            for c in range(half_columns, columns):
                t = mirrored * table[near, columns - c]
                z = spectrum[row, c]
                w = complex(-t * z.imag, t * z.real)
                out[row, c] = out[row, c] + w if add else w
        else:
            for c in range(half_columns):
                w = sign * table[near, c] * spectrum[row, c]
                out[row, c] = out[row, c] + w if add else w
            for c in range(half_columns, columns):
                w = mirrored * table[near, columns - c] * spectrum[row, c]
                out[row, c] = out[row, c] + w if add else w


@njit(cache=True, nogil=True)
def to_modes(rows: NDArray[Any], modes: NDArray[Any]) -> None:
    """modes[k, j, i] = rows[i, j, k]."""
    for k in range(rows.shape[2]):
        for j in range(rows.shape[1]):
            for i in range(rows.shape[0]):
                modes[k, j, i] = rows[i, j, k]


@njit(cache=True, nogil=True)
def to_rows(modes: NDArray[Any], rows: NDArray[Any]) -> None:
    """rows[i, j, k] = modes[k, j, i]."""
    for k in range(rows.shape[2]):
        for j in range(rows.shape[1]):
            for i in range(rows.shape[0]):
                rows[i, j, k] = modes[k, j, i]


@njit(cache=True, nogil=True)
def transpose(source: NDArray[Any], target: NDArray[Any]) -> None:
    """target[c, r] = source[r, c], in strips that fit the cache."""
    rows, columns = source.shape
    for start in range(0, rows, 16):
        stop = min(start + 16, rows)
        for c in range(columns):
            for r in range(start, stop):
                target[c, r] = source[r, c]


@njit(cache=True, nogil=True)
def screened_integrals(
    x: NDArray[np.float64], a: float, nodes: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Integrals over s in (0, inf) of exp(-a e^s - x e^-s) and of the same times e^-s, for every x.

    ``nodes`` and ``weights`` are of a Gauss rule on (0, 1), used panel by panel of unit length.
    """
    first = np.zeros(x.size)
    second = np.zeros(x.size)
    panels = int(np.ceil(max(1.0, np.log(42.0 / a)))) if a < 42.0 else 0
    for q in range(x.size):
        if 4.0 * a * x[q] > 1764.0:  # exp(-2 sqrt(a x)) < 1e-18
            continue
        for panel in range(panels):
            for i in range(nodes.size):
                grown = np.exp(panel + nodes[i])
                value = weights[i] * np.exp(-a * grown - x[q] / grown)
                first[q] += value
                second[q] += value / grown
    return first, second
