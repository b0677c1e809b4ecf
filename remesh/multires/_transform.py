"""Compiled lifting steps along one axis of a field, in place, details at their own nodes.

Even nodes go on, odd ones become details, but for the last of a line with ends (`lines.Split`).

``predict`` and ``update`` are the arguments of `lifting.Rows`: weights (an even number of them),
shift, first and last plain row, then the special rows by number, starts, columns and weights.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

CHUNK = 64  # columns lifted together, packed: they stay in the cache between two steps


@njit(cache=True, nogil=True, fastmath={"contract"})
def lift(target, source, width, factor, rows):
    """``target`` += factor * rows of ``source``; flat halves of a line, ``width`` values a node."""
    weights, shift, first, last, index, starts, columns, values = rows
    size = (last - first) * width
    out = target[first * width : last * width]
    done = 0
    while done < weights.size:
        start = (first + shift + done) * width
        w0, w1 = factor * weights[done], factor * weights[done + 1]
        a = source[start : start + size]
        b = source[start + width : start + width + size]
        if weights.size - done >= 4:
            w2, w3 = factor * weights[done + 2], factor * weights[done + 3]
            c = source[start + 2 * width : start + 2 * width + size]
            d = source[start + 3 * width : start + 3 * width + size]
            for i in range(out.size):
                out[i] += w0 * a[i] + w1 * b[i] + w2 * c[i] + w3 * d[i]
            done += 4
        else:
            for i in range(out.size):
                out[i] += w0 * a[i] + w1 * b[i]
            done += 2
    for r in range(index.size):
        out = target[index[r] * width : (index[r] + 1) * width]
        for m in range(starts[r], starts[r + 1]):
            weight = factor * values[m]
            row = source[columns[m] * width : (columns[m] + 1) * width]
            for i in range(width):
                out[i] += weight * row[i]


@njit(cache=True, nogil=True)
def both(even, odd, width, predict, update, forward):
    """Predict and update, or undo them in the other order."""
    one = even.dtype.type(1)
    if forward:
        lift(odd, even, width, -one, predict)
        lift(even, odd, width, one, update)
    else:
        lift(even, odd, width, -one, update)
        lift(odd, even, width, one, predict)


@njit(cache=True, nogil=True)
def across(first, pieces, step, coarse, values, predict, update, forward):
    """Lift along the middle axis of ``values`` (outer, nodes, inner), chunks of columns each."""
    _, nodes, inner = values.shape
    chunks = -(-inner // CHUNK)
    even = np.empty(coarse * CHUNK, values.dtype)
    odd = np.empty((nodes - coarse) * CHUNK, values.dtype)
    rest = 2 * (nodes - coarse)
    for piece in range(first, pieces, step):
        part = values[piece // chunks]
        start = piece % chunks * CHUNK
        width = min(CHUNK, inner - start)
        for n in range(nodes):
            if n < rest and n % 2:
                for i in range(width):
                    odd[n // 2 * width + i] = part[n, start + i]
            else:
                m = min(n, rest) // 2 + max(n - rest, 0)
                for i in range(width):
                    even[m * width + i] = part[n, start + i]
        both(even, odd, width, predict, update, forward)
        for n in range(nodes):
            if n < rest and n % 2:
                for i in range(width):
                    part[n, start + i] = odd[n // 2 * width + i]
            else:
                m = min(n, rest) // 2 + max(n - rest, 0)
                for i in range(width):
                    part[n, start + i] = even[m * width + i]


@njit(cache=True, nogil=True)
def along(first, pieces, step, block, coarse, values, predict, update, forward):
    """Lift along the last axis of ``values`` (lines, nodes), a block of lines each."""
    lines, nodes = values.shape
    even = np.empty(coarse, values.dtype)
    odd = np.empty(nodes - coarse, values.dtype)
    rest = 2 * odd.size
    for piece in range(first, pieces, step):
        for n in range(piece * block, min((piece + 1) * block, lines)):
            line = values[n]
            for i in range(odd.size):
                even[i] = line[2 * i]
                odd[i] = line[2 * i + 1]
            for i in range(rest, nodes):
                even[odd.size + i - rest] = line[i]
            both(even, odd, 1, predict, update, forward)
            for i in range(odd.size):
                line[2 * i] = even[i]
                line[2 * i + 1] = odd[i]
            for i in range(rest, nodes):
                line[i] = even[odd.size + i - rest]
