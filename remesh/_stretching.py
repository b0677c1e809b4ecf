"""Compiled loops of the stretching law: one row of nodes along the last axis at a time."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh._rows import any_value

REACH = 3  # nodes of a sixth-order central difference to each side


@njit(cache=True, nogil=True)
def row_at(place, nodes, wraps, clamps):
    """The row of an index that may lie beyond an end; -1 where nothing is."""
    if 0 <= place < nodes:
        return place
    if wraps:
        return place % nodes
    if clamps:
        return min(max(place, 0), nodes - 1)
    return -1


@njit(cache=True, nogil=True, fastmath={"contract"})
def padded(source, factor, times, wraps, clamps, target):
    """A row, times another if asked, with REACH nodes more at each end."""
    nodes = source.size
    inner = target[REACH : REACH + nodes]
    if times:
        for k in range(nodes):
            inner[k] = source[k] * factor[k]
    else:
        for k in range(nodes):
            inner[k] = source[k]
    for m in range(REACH):
        if wraps:
            target[m] = inner[(m - REACH) % nodes]
            target[REACH + nodes + m] = inner[m % nodes]
        elif clamps:
            target[m] = inner[0]
            target[REACH + nodes + m] = inner[nodes - 1]
        else:
            target[m] = 0
            target[REACH + nodes + m] = 0


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_products(a, b, c, d, weight, out):
    """out += weight (a b - c d)."""
    for k in range(out.size):
        out[k] += weight * (a[k] * b[k] - c[k] * d[k])


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_product(a, b, weight, out):
    """out += weight a b."""
    for k in range(out.size):
        out[k] += weight * (a[k] * b[k])


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_change(factor, ahead, behind, weight, out):
    """out += weight factor (ahead - behind)."""
    for k in range(out.size):
        out[k] += weight * factor[k] * (ahead[k] - behind[k])


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_along(line, weights, out):
    """out += the difference of a padded row along itself."""
    w0, w1, w2 = weights[0], weights[1], weights[2]
    for k in range(out.size):
        out[k] += (
            w0 * (line[k + 4] - line[k + 2])
            + w1 * (line[k + 5] - line[k + 1])
            + w2 * (line[k + 6] - line[k])
        )


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_along_times(line, factor, weights, out):
    """out += factor times the difference of a padded row along itself."""
    w0, w1, w2 = weights[0], weights[1], weights[2]
    for k in range(out.size):
        out[k] += factor[k] * (
            w0 * (line[k + 4] - line[k + 2])
            + w1 * (line[k + 5] - line[k + 1])
            + w2 * (line[k + 6] - line[k])
        )


@njit(cache=True, nogil=True, fastmath={"contract"})
def stretch(first, pieces, step, rows, w, d, weights, periodic, conservative, out):
    """Pieces of ``rows`` rows of w + (w . grad) d, or of w + div(w d)."""
    _, nx, ny, nz = w.shape
    line = np.empty(nz + 2 * REACH, w.dtype)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * ny)):
            i, j = row // ny, row % ny
            for c in range(3):
                target = out[c, i, j]
                for k in range(nz):
                    target[k] = w[c, i, j, k]
            across(w, d, i, j, 0, weights, periodic, conservative, out)
            across(w, d, i, j, 1, weights, periodic, conservative, out)
            along = w[2, i, j]
            if not any_value(along):
                continue
            for c in range(3):
                padded(d[c, i, j], along, conservative, periodic[2], not conservative, line)
                if conservative:
                    add_along(line, weights, out[c, i, j])
                else:
                    add_along_times(line, along, weights, out[c, i, j])


@njit(cache=True, nogil=True, fastmath={"contract"})
def across(w, d, i, j, axis, weights, periodic, conservative, out):
    """The part of one row that comes from differences along the first or the middle axis."""
    _, nx, ny, _ = w.shape
    own = w[axis, i, j]
    if not conservative and not any_value(own):
        return
    for m in range(REACH):
        if axis == 0:
            ia = row_at(i + m + 1, nx, periodic[0], not conservative)
            ib = row_at(i - m - 1, nx, periodic[0], not conservative)
            ja, jb = j, j
        else:
            ja = row_at(j + m + 1, ny, periodic[1], not conservative)
            jb = row_at(j - m - 1, ny, periodic[1], not conservative)
            ia, ib = i, i
        has_a, has_b = ia >= 0 and ja >= 0, ib >= 0 and jb >= 0
        if not conservative:
            for c in range(3):
                add_change(own, d[c, ia, ja], d[c, ib, jb], weights[m], out[c, i, j])
            continue
        has_a = has_a and any_value(w[axis, ia, ja])
        has_b = has_b and any_value(w[axis, ib, jb])
        for c in range(3):
            if has_a and has_b:
                add_products(
                    w[axis, ia, ja], d[c, ia, ja], w[axis, ib, jb], d[c, ib, jb], weights[m],
                    out[c, i, j],
                )  # fmt: skip
            elif has_a:
                add_product(w[axis, ia, ja], d[c, ia, ja], weights[m], out[c, i, j])
            elif has_b:
                add_product(w[axis, ib, jb], d[c, ib, jb], -weights[m], out[c, i, j])
