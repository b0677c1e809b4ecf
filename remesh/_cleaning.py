"""Compiled loops of divergence cleaning: the divergence, and its gradient added to the field."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows, _stretching
from remesh._rows import any_value, row_of
from remesh._stretching import pad
from remesh.compiled import drop_stale

drop_stale(__file__, _rows.__file__, _stretching.__file__)


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_times(row, weight, out):
    """out += weight row."""
    for k in range(out.size):
        out[k] += weight * row[k]


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_along(row, line, weights, wraps, out):
    """out += the difference of a row along itself; ``line`` is scratch with room at both ends."""
    reach = weights.size
    nodes = row.size
    pad(row, wraps, False, line)
    for m in range(reach):
        ahead = line[reach + m + 1 : reach + m + 1 + nodes]
        behind = line[reach - m - 1 : reach - m - 1 + nodes]
        w = weights[m]
        for k in range(nodes):
            out[k] += w * (ahead[k] - behind[k])


@njit(cache=True, nogil=True)
def add_across(field, i, j, axis, weights, wraps, out):
    """out += the difference of a scalar field across row i, j along the first or middle axis."""
    nodes = field.shape[axis]
    for m in range(weights.size):
        for side in (1, -1):
            a = row_of((i if axis == 0 else j) + side * (m + 1), nodes, wraps, False)
            if a < 0:
                continue
            row = field[a, j] if axis == 0 else field[i, a]
            if any_value(row):
                add_times(row, side * weights[m], out)


@njit(cache=True, nogil=True)
def diverge(first, pieces, step, rows, field, weights, periodic, out):
    """Pieces of rows of the divergence of a vector field."""
    _, nx, ny, nz = field.shape
    line = np.empty(nz + 2 * weights.size, field.dtype)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * ny)):
            i, j = row // ny, row % ny
            target = out[i, j]
            target[:] = 0
            add_across(field[0], i, j, 0, weights, periodic[0], target)
            add_across(field[1], i, j, 1, weights, periodic[1], target)
            if any_value(field[2, i, j]):
                add_along(field[2, i, j], line, weights, periodic[2], target)


@njit(cache=True, nogil=True)
def descend(first, pieces, step, rows, scalar, weights, periodic, field):
    """Pieces of rows of a vector field, plus the gradient of a scalar."""
    _, nx, ny, nz = field.shape
    line = np.empty(nz + 2 * weights.size, field.dtype)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * ny)):
            i, j = row // ny, row % ny
            add_across(scalar, i, j, 0, weights, periodic[0], field[0, i, j])
            add_across(scalar, i, j, 1, weights, periodic[1], field[1, i, j])
            if any_value(scalar[i, j]):
                add_along(scalar[i, j], line, weights, periodic[2], field[2, i, j])
