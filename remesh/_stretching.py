"""Compiled loop of vortex stretching with differences of order 6, a few nodes at a time.

Rows are read at their neighbours along the first two axes; along the last one from copies with
three nodes more on each side.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call, call-arg, var-annotated"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _lanes, _rows
from remesh._lanes import load, plus, product, store
from remesh._rows import row_of
from remesh.compiled import drop_stale

REACH = 3  # nodes that the difference reads on each side

drop_stale(__file__, _lanes.__file__, _rows.__file__)


@njit(cache=True, nogil=True)
def extents(first, pieces, step, rows, field, low, high):
    """The columns between which each row of any component holds more than zeros."""
    parts, nx, nm, nc = field.shape
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            low[row] = nc
            high[row] = 0
            for p in range(parts):
                line = field[p, row // nm, row % nm]
                a = 0
                while a < nc and line[a] == 0:
                    a += 1
                if a < nc:
                    b = nc
                    while line[b - 1] == 0:
                        b -= 1
                    low[row] = min(low[row], a)
                    high[row] = max(high[row], b)


@njit(cache=True, nogil=True)
def pad(line, wraps, clamps, padded):
    """A copy of a row with three nodes more on each side: wrapped, of the edge's value, or zero."""
    nc = line.size
    padded[REACH : REACH + nc] = line
    for k in range(REACH):
        before = row_of(k - REACH, nc, wraps, clamps)
        after = row_of(nc + k, nc, wraps, clamps)
        padded[k] = line[before] if before >= 0 else 0
        padded[REACH + nc + k] = line[after] if after >= 0 else 0


@njit(cache=True, nogil=True)
def neighbours(i, m, shape, periodic, clamps, weights, places, factors):
    """Places of the rows that a node's differences read, x first; their factors, 0 for none."""
    nx, nm, nc = shape
    for s in range(REACH):
        for side in range(2):
            shift = s + 1 if side == 0 else -s - 1
            weight = weights[s] if side == 0 else -weights[s]
            x = row_of(i + shift, nx, periodic[0], clamps)
            y = row_of(m + shift, nm, periodic[1], clamps)
            e = 2 * s + side
            places[e] = (x * nm + m) * nc if x >= 0 else -1
            places[e + 2 * REACH] = (i * nm + y) * nc if y >= 0 else -1
            factors[e] = weight
            factors[e + 2 * REACH] = weight


@njit(cache=True, nogil=True, fastmath={"contract"})
def stretch(
    first, pieces, step, rows, strengths, displacement, weights, periodic, conserves, lanes,
    low, high, out,
):  # fmt: skip
    """Strengths plus sum_j D_j (w_j d), or plus sum_j w_j (D_j d)."""
    _, nx, nm, nc = strengths.shape
    w = strengths.reshape(3, nx * nm * nc)
    d = displacement.reshape(3, nx * nm * nc)
    result = out.reshape(3, nx * nm * nc)
    places = np.empty(4 * REACH, np.int64)
    factors = np.empty(4 * REACH, w.dtype)
    length = nc + 2 * REACH
    along = np.empty(length, w.dtype)
    moves = np.empty((3, length), w.dtype)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            own = row * nc
            neighbours(
                row // nm, row % nm, (nx, nm, nc), periodic, not conserves, weights, places, factors
            )
            start = low[row]
            stop = high[row]
            if conserves:
                for place in places:
                    if place >= 0:
                        start = min(start, low[place // nc])
                        stop = max(stop, high[place // nc])
                if start < stop:
                    start -= REACH
                    stop += REACH
                    if periodic[2] and (start < 0 or stop > nc):
                        start, stop = 0, nc
            for c in range(3):
                result[c, own : own + nc] = 0
            start = max(start, 0)
            stop = min(stop, nc)
            if start >= stop:
                continue
            pad(w[2, own : own + nc], periodic[2], False, along)
            for c in range(3):
                pad(d[c, own : own + nc], periodic[2], not conserves, moves[c])
            for block in range(start, stop, len(lanes)):
                k = min(block, nc - len(lanes))
                one = load(w[0], own + k, lanes)
                two = load(w[1], own + k, lanes)
                three = load(w[2], own + k, lanes)
                for e in range(4 * REACH):
                    place = places[e]
                    if place < 0:
                        continue
                    source = place if conserves else own
                    given = load(w[0 if e < 2 * REACH else 1], source + k, lanes)
                    one = plus(one, product(given, load(d[0], place + k, lanes)), factors[e])
                    two = plus(two, product(given, load(d[1], place + k, lanes)), factors[e])
                    three = plus(three, product(given, load(d[2], place + k, lanes)), factors[e])
                for e in range(2 * REACH):
                    place = k + REACH + (e // 2 + 1) * (1 - 2 * (e % 2))
                    source = place if conserves else k + REACH
                    given = load(along, source, lanes)
                    one = plus(one, product(given, load(moves[0], place, lanes)), factors[e])
                    two = plus(two, product(given, load(moves[1], place, lanes)), factors[e])
                    three = plus(three, product(given, load(moves[2], place, lanes)), factors[e])
                store(one, result[0], own + k)
                store(two, result[1], own + k)
                store(three, result[2], own + k)
