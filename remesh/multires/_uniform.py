"""Compiled copies between blocks and boxes of nodes of one level; blocks as in `_ghosts`."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

from remesh.multires.blocks import OUTSIDE


@njit(cache=True, nogil=True)
def part(place, size, first, total):
    """Where a block lies in a box along an axis, and the first of its nodes that does."""
    start = place * size - first
    return max(start, 0), min(start + size, total), max(-start, 0)


@njit(cache=True, nogil=True)
def paste(values, numbers, corner, first, stride, box):
    """Every ``stride``-th node of blocks into a box (c, x, y, z); zeros beyond unbounded ends.

    ``numbers``: the blocks at the places from ``corner`` on. The box begins at node ``first`` of
    the mesh of those nodes.
    """
    parts, _, bx, b, _ = values.shape
    wide = max(bx // stride, 1)
    size = b // stride
    for i in range(numbers.shape[0]):
        x0, x1, xs = part(corner[0] + i, wide, first[0], box.shape[1])
        for j in range(numbers.shape[1]):
            y0, y1, ys = part(corner[1] + j, size, first[1], box.shape[2])
            for k in range(numbers.shape[2]):
                z0, z1, zs = part(corner[2] + k, size, first[2], box.shape[3])
                number = numbers[i, j, k]
                if number == OUTSIDE:
                    box[:, x0:x1, y0:y1, z0:z1] = 0
                if number < 0:
                    continue
                for c in range(parts):
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            row = values[c, number, (xs + x - x0) * stride, (ys + y - y0) * stride]
                            for z in range(z0, z1):
                                box[c, x, y, z] = row[(zs + z - z0) * stride]
