"""Compiled loops that lay a box around each block: its nodes, and ghosts from around it.

Blocks are ``(n, bx, b, b)`` with ``bx`` = b, or 1 in 2-D: an axis of one node has no ghosts and is
even. ``around`` and ``under`` are rows of the tables of `Blocks`, ``side`` tells along each axis
which half of the coarser block a block lies on. Box node i is node ``i - before`` of the block.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.multires.blocks import ABSENT, OUTSIDE


@njit(cache=True, nogil=True)
def span(offset, size, before, after):
    """Where a neighbour lies in a box along an axis, and the first node that is read of it."""
    if offset < 0:
        return 0, before, size - before
    if offset == 0:
        return before, before + size, 0
    return before + size, before + size + after, 0


@njit(cache=True, nogil=True)
def has_jump(around):
    """Whether a neighbour is absent."""
    absent = 0
    for number in around:
        absent += number == ABSENT
    return absent > 0


@njit(cache=True, nogil=True)
def copy(values, around, before, after, box, blank):
    """The values of the level's blocks into a box; zeros beyond ends; and all else if ``blank``."""
    _, bx, by, bz = values.shape
    deep = 1 if bx > 1 else 0
    k = 0
    for ox in range(-deep, deep + 1):
        x0, x1, xs = span(ox, bx, deep * before, deep * after)
        for oy in range(-1, 2):
            y0, y1, ys = span(oy, by, before, after)
            for oz in range(-1, 2):
                z0, z1, zs = span(oz, bz, before, after)
                number = around[k]
                k += 1
                if number >= 0:
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            source = values[number, xs + x - x0, ys + y - y0]
                            target = box[x, y]
                            for z in range(z0, z1):
                                target[z] = source[zs + z - z0]
                elif blank or number == OUTSIDE:
                    box[x0:x1, y0:y1, z0:z1] = 0


@njit(cache=True, nogil=True)
def overlap(offset, half, first, size):
    """Where the even nodes of a neighbour lie in a lattice along an axis, and which is first."""
    start = max(0, first + offset * half)
    stop = min(size, first + (offset + 1) * half)
    return start, stop, start - first - offset * half


@njit(cache=True, nogil=True)
def lattice(values, coarse, around, under, side, first, nodes):
    """The even nodes around a block: of its level where blocks are, else the ``coarse`` values.

    Node i of the lattice is node ``2 * (i - first)`` of the block; zeros farther out than the
    neighbours reach.
    """
    _, bx, by, bz = values.shape
    deep = 1 if bx > 1 else 0
    hx, hy, hz = (bx + 1) // 2, by // 2, bz // 2
    sx, sy, sz = nodes.shape
    nodes[:] = 0
    k = -1
    for ox in range(-deep, deep + 1):
        x0, x1, xs = overlap(ox, hx, deep * first, sx)
        for oy in range(-1, 2):
            y0, y1, ys = overlap(oy, hy, first, sy)
            for oz in range(-1, 2):
                z0, z1, zs = overlap(oz, hz, first, sz)
                k += 1
                number = around[k]
                if number >= 0:
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            source = values[number, 2 * (xs + x - x0), 2 * (ys + y - y0)]
                            for z in range(z0, z1):
                                nodes[x, y, z] = source[2 * (zs + z - z0)]
                elif number == ABSENT:
                    ax = xs + deep * ((side[0] + ox) & 1) * hx
                    ay = ys + ((side[1] + oy) & 1) * hy
                    az = zs + ((side[2] + oz) & 1) * hz
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            source = coarse[under[k], ax + x - x0, ay + y - y0]
                            for z in range(z0, z1):
                                nodes[x, y, z] = source[az + z - z0]


@njit(cache=True, nogil=True, fastmath={"contract"})
def predict_rows(nodes, first, before, weights, result):
    """Prediction along the middle axis of (outer, nodes, inner), inner as long as ``nodes``'s."""
    reach = weights.size // 2 - 1
    inner = nodes.shape[2]
    for x in range(result.shape[0]):
        for i in range(result.shape[1]):
            fine = i - before
            k = (fine >> 1) + first
            target = result[x, i]
            if fine & 1:
                source = nodes[x, k - reach]
                for z in range(inner):
                    target[z] = weights[0] * source[z]
                for t in range(1, weights.size):
                    source = nodes[x, k - reach + t]
                    for z in range(inner):
                        target[z] += weights[t] * source[z]
            else:
                source = nodes[x, k]
                for z in range(inner):
                    target[z] = source[z]


@njit(cache=True, nogil=True, fastmath={"contract"})
def predict_line(nodes, first, before, weights, result):
    """Prediction along the last axis."""
    reach = weights.size // 2 - 1
    for x in range(result.shape[0]):
        for y in range(result.shape[1]):
            source = nodes[x, y]
            target = result[x, y]
            for i in range(before & 1, target.size, 2):
                target[i] = source[((i - before) >> 1) + first]
            for i in range(1 - (before & 1), target.size, 2):
                k = ((i - before) >> 1) + first - reach
                total = weights[0] * source[k]
                for t in range(1, weights.size):
                    total += weights[t] * source[k + t]
                target[i] = total


@njit(cache=True, nogil=True)
def subdivide(nodes, first, before, weights, slab, plane, box):
    """Fill a box by tensor prediction of its even nodes; ``slab`` and ``plane`` are scratch.

    Node i of the box along an axis is node i - ``before``, node i of ``nodes`` 2 (i - ``first``).
    """
    if nodes.shape[0] > 1:
        sx, sy, sz = nodes.shape
        flat = slab.reshape(1, box.shape[0], sy * sz)
        predict_rows(nodes.reshape(1, sx, sy * sz), first, before[0], weights, flat)
        predict_rows(slab, first, before[1], weights, plane)
    else:
        predict_rows(nodes, first, before[1], weights, plane)
    predict_line(plane, first, before[2], weights, box)


@njit(cache=True, nogil=True)
def lattice_size(size, before, after, reach):
    """Nodes of the lattice before the block, and in all, that predictions in a box read."""
    first = (before + 1) // 2 + reach - 1
    return first, first + (size + after - 1) // 2 + reach + 1


@njit(cache=True, nogil=True)
def scratch(values, before, after, reach):
    """A lattice and what `subdivide` needs, for boxes around such blocks."""
    _, bx, b, _ = values.shape
    first, nodes = lattice_size(b, before, after, reach)
    size = before + b + after
    nx = nodes if bx > 1 else 1
    sx = size if bx > 1 else 1
    grid = np.empty((nx, nodes, nodes), values.dtype)
    slab = np.empty((sx, nodes, nodes), values.dtype)
    plane = np.empty((sx, size, nodes), values.dtype)
    return first, grid, slab, plane


@njit(cache=True, nogil=True)
def at_end(around):
    """Whether an unbounded end lies at a block: then a neighbour across a face is beyond it."""
    middle, step, found = around.size // 2, 1, False
    while step < around.size:
        found |= around[middle - step] == OUTSIDE or around[middle + step] == OUTSIDE
        step *= 3
    return found


@njit(cache=True, nogil=True)
def extend(nodes, around, before, half):
    """Go on beyond unbounded ends by cubics, one axis after the other.

    ``nodes``: a lattice on which a block has the ``half`` nodes from ``before`` on along each axis.
    """
    middle = around.size // 2
    low, high = before, before + half - 1
    if nodes.shape[0] > 1:
        go_on(nodes, low, high, around[middle - 9] == OUTSIDE, around[middle + 9] == OUTSIDE)
    for plane in nodes:
        go_on(plane, low, high, around[middle - 3] == OUTSIDE, around[middle + 3] == OUTSIDE)
        turned = plane.T
        go_on(turned, low, high, around[middle - 1] == OUTSIDE, around[middle + 1] == OUTSIDE)


@njit(cache=True, nogil=True)
def go_on(rows, low, high, below, above):
    """Rows before ``low`` and after ``high`` by cubics through the four next to them."""
    if below:
        for i in range(low - 1, -1, -1):
            rows[i] = 4 * (rows[i + 1] + rows[i + 3]) - 6 * rows[i + 2] - rows[i + 4]
    if above:
        for i in range(high + 1, rows.shape[0]):
            rows[i] = 4 * (rows[i - 1] + rows[i - 3]) - 6 * rows[i - 2] - rows[i - 4]


@njit(cache=True, nogil=True)
def hold(box, around, width):
    """The last nodes' values beyond unbounded ends, one axis after the other."""
    middle = around.size // 2
    if box.shape[0] > 1:
        repeat(box, width, around[middle - 9] == OUTSIDE, around[middle + 9] == OUTSIDE)
    for plane in box:
        repeat(plane, width, around[middle - 3] == OUTSIDE, around[middle + 3] == OUTSIDE)
        turned = plane.T
        repeat(turned, width, around[middle - 1] == OUTSIDE, around[middle + 1] == OUTSIDE)


@njit(cache=True, nogil=True)
def repeat(rows, width, below, above):
    """The first and the last row of a block again and again, ``width`` times."""
    last = rows.shape[0] - width - 1
    for i in range(width):
        if below:
            rows[i] = rows[width]
        if above:
            rows[last + 1 + i] = rows[last]


@njit(cache=True, nogil=True)
def pad(first, pieces, step, values, around, under, sides, weights, width, last, out):
    """Each block with ``width`` ghosts on each side; ``last``: values go on beyond ends."""
    start, nodes, slab, plane = scratch(values[0], width, width, weights.size // 2)
    for n in range(first, pieces, step):
        jump = has_jump(around[n])
        goes_on = last and at_end(around[n])
        for c in range(values.shape[0]):
            box = out[c, n]
            if jump:
                lattice(values[c], values[c], around[n], under[n], sides[n], start, nodes)
                if goes_on:
                    extend(nodes, around[n], start, values.shape[4] // 2)
                subdivide(nodes, start, (width, width, width), weights, slab, plane, box)
            copy(values[c], around[n], width, width, box, False)
            if goes_on:
                hold(box, around[n], width)
