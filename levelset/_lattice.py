"""Compiled loops over the cells between particles: the gradient of their map.

Meshes are ``(nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node, so that
one text serves 2-D and 3-D. ``pair`` (a cell's corners along the middle axis) is a tuple whose
length, a constant to the compiler, is what counts.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, inline="always")
def wrapped(index, size, periodic):
    """The index on a periodic axis; -1 outside an unbounded one."""
    if 0 <= index < size:
        return index
    return index % size if periodic else -1


@njit(cache=True, nogil=True)
def invert(matrix, inverse):
    """Inverse of the upper 3 x 3 part of a matrix; returns its determinant."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    g, h, i = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if volume != 0.0:
        one = 1.0 / volume
        inverse[0, 0], inverse[0, 1] = one * (e * i - f * h), one * (c * h - b * i)
        inverse[0, 2], inverse[1, 0] = one * (b * f - c * e), one * (f * g - d * i)
        inverse[1, 1], inverse[1, 2] = one * (a * i - c * g), one * (c * d - a * f)
        inverse[2, 0], inverse[2, 1] = one * (d * h - e * g), one * (b * g - a * h)
        inverse[2, 2] = one * (a * e - b * d)
    return volume


@njit(cache=True, nogil=True)
def corners(node, i, m, c, shape, periodic, marks, pair, nodes):
    """Flat indices of a cell's corners, lowest first; False unless all hold particles."""
    columns, row = shape[2], shape[1] * shape[2]
    deep = len(pair) > 1
    if i + 1 < shape[0] and c + 1 < columns and (not deep or m + 1 < shape[1]):
        for a in range(2):
            for b in range(len(pair)):
                start = node + a * row + b * columns
                if marks[start] < 2:
                    return False
                nodes[(a * len(pair) + b) * 2] = start
                nodes[(a * len(pair) + b) * 2 + 1] = start + 1
        return True
    for a in range(2):
        x = wrapped(i + a, shape[0], periodic[0])
        for b in range(len(pair)):
            y = wrapped(m + b, shape[1], periodic[1]) if deep else 0
            for d in range(2):
                z = wrapped(c + d, columns, periodic[2])
                if x < 0 or y < 0 or z < 0 or marks[x * row + y * columns + z] == 0:
                    return False
                nodes[(a * len(pair) + b) * 2 + d] = x * row + y * columns + z
    return True


@njit(cache=True, nogil=True)
def stretch(flat, nodes, i, m, c, pair, matrix, center, half):
    """Image of a cell: ``center``, ``matrix`` (its fourth row: of the value), ``half`` its sides.

    Returns how far a corner is from where these take it.
    """
    deep = len(pair) > 1
    matrix[:] = 0.0
    matrix[1, 1] = 0.0 if deep else 1.0
    center[1], half[1] = m, 0.0
    off = 0.0
    for part in range(4 if deep else 3):
        axis = part if deep else (0, 2, 3)[part]
        if deep:
            a, b = flat[nodes[0], part], flat[nodes[1], part]
            c0, d = flat[nodes[2], part], flat[nodes[3], part]
            e, f = flat[nodes[4], part], flat[nodes[5], part]
            g, h = flat[nodes[6], part], flat[nodes[7], part]
            along0 = 0.25 * ((e + f + g + h) - (a + b + c0 + d))
            along1 = 0.25 * ((c0 + d + g + h) - (a + b + e + f))
            along2 = 0.25 * ((b + d + f + h) - (a + c0 + e + g))
            middle = 0.125 * (a + b + c0 + d + e + f + g + h)
            mixed = abs((a + b) - (c0 + d) - (e + f) + (g + h))
            mixed += abs((a + c0) - (b + d) - (e + g) + (f + h))
            mixed += abs((a + e) - (b + f) - (c0 + g) + (d + h))
            mixed += abs((a - b) - (c0 - d) - (e - f) + (g - h))
            mixed *= 0.125
        else:
            a, b = flat[nodes[0], part], flat[nodes[1], part]
            c0, d = flat[nodes[2], part], flat[nodes[3], part]
            along0, along1, along2 = 0.5 * (c0 + d - a - b), 0.0, 0.5 * (b + d - a - c0)
            middle = 0.25 * (a + b + c0 + d)
            mixed = 0.25 * abs(a - b - c0 + d)
        matrix[axis, 0], matrix[axis, 1], matrix[axis, 2] = along0, along1, along2
        if axis < 3:
            matrix[axis, axis] += 1.0
            place = i if axis == 0 else (m if axis == 1 else c)
            center[axis] = place + 0.5 + middle
            half[axis] = 0.5 * (
                abs(matrix[axis, 0])
                + (abs(matrix[axis, 1]) if deep else 0.0)
                + abs(matrix[axis, 2])
            )
            off = max(off, mixed)
    return off


@njit(cache=True, nogil=True)
def principal(first, pieces, step, size, nodes, shape, periodic, known, fields, pair, grams, folds):
    """Cauchy-Green tensors of the map in the cells between particles, and how many are folded."""
    marks = known.reshape(known.size)
    flat = fields.reshape(known.size, fields.shape[-1])
    row, columns = shape[1] * shape[2], shape[2]
    edge = np.empty(4 * len(pair), np.int64)
    matrix, inverse = np.empty((4, 3)), np.empty((3, 3))
    center, half = np.empty(3), np.empty(3)
    for piece in range(first, pieces, step):
        folded = 0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            for a in range(3):
                for b in range(3):
                    grams[p, a, b] = 1.0 if a == b else 0.0
            i, m, c = nodes[p] // row, (nodes[p] // columns) % shape[1], nodes[p] % columns
            if not corners(nodes[p], i, m, c, shape, periodic, marks, pair, edge):
                continue
            stretch(flat, edge, i, m, c, pair, matrix, center, half)
            folded += not invert(matrix, inverse) > 0.0
            for a in range(3):
                for b in range(3):
                    total = 0.0
                    for k in range(3):
                        total += matrix[k, a] * matrix[k, b]
                    grams[p, a, b] = total
        folds[piece] = folded


@njit(cache=True, nogil=True)
def strain(
    first, pieces, step, size, nodes, shape, periodic, known, fields, rates, pair, largest
):  # fmt: skip
    """Largest row sum of |du_i/dx_j| in each piece; ``rates`` hold velocities as displacements."""
    marks = known.reshape(known.size)
    flat = fields.reshape(known.size, fields.shape[-1])
    speeds = rates.reshape(known.size, rates.shape[-1])
    row, columns = shape[1] * shape[2], shape[2]
    edge = np.empty(4 * len(pair), np.int64)
    matrix, inverse, growth = np.empty((4, 3)), np.empty((3, 3)), np.empty((4, 3))
    center, half = np.empty(3), np.empty(3)
    for piece in range(first, pieces, step):
        top = 0.0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            i, m, c = nodes[p] // row, (nodes[p] // columns) % shape[1], nodes[p] % columns
            if not corners(nodes[p], i, m, c, shape, periodic, marks, pair, edge):
                continue
            stretch(flat, edge, i, m, c, pair, matrix, center, half)
            if not invert(matrix, inverse) > 0.0:
                continue
            stretch(speeds, edge, i, m, c, pair, growth, center, half)
            for a in range(3):
                growth[a, a] -= 1.0
                total = 0.0
                for b in range(3):
                    part = 0.0
                    for k in range(3):
                        part += growth[a, k] * inverse[k, b]
                    total += abs(part)
                top = max(top, total)
        largest[piece] = top
