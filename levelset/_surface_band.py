"""Compiled loops over nodes: values at points of a surface, and the embedded Laplacian.

Meshes are ``(nx, nm, nc)``; in 2-D the middle axis has one node. Points are in node units. A point
is read by the cubics through the four nodes around it: ``taps`` (n, 3, 4) holds their places along
each axis as parts of a flat index, ``shares`` (n, 3, 4) their weights.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

from levelset import _interpolant
from levelset._interpolant import beside, four, weights
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__)


@njit(cache=True, nogil=True)
def place(first, pieces, step, rows, points, shape, wraps, taps, shares):
    """Nodes and weights with which each of the points (n, 3) is read."""
    strides = (shape[1] * shape[2], shape[2], 1)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(points))):
            for axis in range(3):
                if shape[axis] == 1:
                    taps[m, axis, :] = 0
                    shares[m, axis, :] = 0.0
                    shares[m, axis, 0] = 1.0
                    continue
                a, b, c, d, u, _ = four(points[m, axis], shape[axis], wraps[axis])
                taps[m, axis, 0] = a * strides[axis]
                taps[m, axis, 1] = b * strides[axis]
                taps[m, axis, 2] = c * strides[axis]
                taps[m, axis, 3] = d * strides[axis]
                w = weights(u)
                for k in range(4):
                    shares[m, axis, k] = w[k]


@njit(cache=True, nogil=True)
def read(first, pieces, step, rows, field, taps, shares, middle, out):
    """The flat field at the points; ``middle``: taps along the middle axis, 1 or 4."""
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(out))):
            total = 0.0
            for i in range(4):
                across = 0.0
                for j in range(middle):
                    base = taps[m, 0, i] + taps[m, 1, j]
                    line = 0.0
                    for k in range(4):
                        line += shares[m, 2, k] * field[base + taps[m, 2, k]]
                    across += shares[m, 1, j] * line
                total += shares[m, 0, i] * across
            out[m] = total


@njit(cache=True, nogil=True)
def mark(taps, middle, marks):
    """Mark the nodes that any of the points is read from."""
    for m in range(len(taps)):
        for i in range(4):
            for j in range(middle):
                for k in range(4):
                    marks[taps[m, 0, i] + taps[m, 1, j] + taps[m, 2, k]] = 1


@njit(cache=True, nogil=True)
def neighbours(nodes, marks, known, shape, wraps, inner, around):
    """The marked nodes and the six (four) around each; how many, or -1 where one is not known."""
    strides = (shape[1] * shape[2], shape[2], 1)
    count = 0
    for n in nodes:
        if not marks[n]:
            continue
        inner[count] = n
        spot = (n // strides[0], n // strides[1] % shape[1], n % shape[2])
        k = 0
        for axis in range(3):
            if shape[axis] == 1:
                continue
            for way in (-1, 1):
                i = beside(spot[axis], way, shape[axis], wraps[axis])
                other = n + (i - spot[axis]) * strides[axis]
                if i < 0 or not known[other]:
                    return -1
                around[count, k] = other
                k += 1
        count += 1
    return count


@njit(cache=True, nogil=True)
def spread_sum(first, pieces, step, rows, field, inner, around, out):
    """h^2 lap + 2 ndim, the sum over the nodes around, at the inner nodes of a flat field."""
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(inner))):
            total = 0.0
            for k in range(0, around.shape[1], 2):
                total += field[around[m, k]] + field[around[m, k + 1]]
            out[inner[m]] = total
