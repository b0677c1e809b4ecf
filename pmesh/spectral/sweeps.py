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

    Plane by plane. ``signs``: overall, and parity (+1, -1) of the table along rows and columns.
    """
    planes, rows, columns = spectrum.shape
    half_rows, half_columns = table.shape[1:]
    for p in range(planes):
        for row in range(rows):
            near = row if row < half_rows else rows - row
            sign = signs[0] if row < half_rows else signs[0] * signs[1]
            mirrored = sign * signs[2]
            if turned:
                for c in range(half_columns):
                    t = sign * table[p, near, c]
                    z = spectrum[p, row, c]
                    w = complex(-t * z.imag, t * z.real)
                    out[p, row, c] = out[p, row, c] + w if add else w
                for c in range(half_columns, columns):
                    t = mirrored * table[p, near, columns - c]
                    z = spectrum[p, row, c]
                    w = complex(-t * z.imag, t * z.real)
                    out[p, row, c] = out[p, row, c] + w if add else w
            else:
                for c in range(half_columns):
                    w = sign * table[p, near, c] * spectrum[p, row, c]
                    out[p, row, c] = out[p, row, c] + w if add else w
                for c in range(half_columns, columns):
                    w = mirrored * table[p, near, columns - c] * spectrum[p, row, c]
                    out[p, row, c] = out[p, row, c] + w if add else w


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
    """target[p, c, r] = source[p, r, c], strip by strip; zero beyond the rows of source."""
    planes, rows, columns = source.shape
    for p in range(planes):
        for start in range(0, rows, 16):
            stop = min(start + 16, rows)
            for c in range(columns):
                for r in range(start, stop):
                    target[p, c, r] = source[p, r, c]
        for c in range(columns):
            for r in range(rows, target.shape[2]):
                target[p, c, r] = 0


@njit(cache=True, nogil=True)
def pad(source: NDArray[Any], target: NDArray[Any]) -> None:
    """Copy the lines of source to the start of those of target, zeros after them."""
    length = source.shape[2]
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            for k in range(length):
                target[i, j, k] = source[i, j, k]
            for k in range(length, target.shape[2]):
                target[i, j, k] = 0


@njit(cache=True, nogil=True)
def crop(source: NDArray[Any], factor: Any, shift: Any, target: NDArray[Any]) -> None:
    """target = factor * source + shift, for the lines and the part of them that target holds."""
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            for k in range(target.shape[2]):
                target[i, j, k] = factor * source[i, j, k] + shift


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
