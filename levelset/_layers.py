"""Compiled loops over nodes in a band: which belong to it, the layers around them, their order.

Meshes are ``(nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node, so that
one text serves 2-D and 3-D.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from levelset import _lattice
from levelset._lattice import wrapped
from remesh.compiled import drop_stale

FLAT = 0.9999  # of the level value: what is above is flat

drop_stale(__file__, _lattice.__file__)


@njit(cache=True, nogil=True)
def moves_to(shape, diagonal, steps):
    """Steps in the flat index to the nodes around one, along the axes or with ``diagonal`` all."""
    row, columns = shape[1] * shape[2], shape[2]
    count = 0
    for a in range(-1, 2):
        for b in range(-1, 2) if shape[1] > 1 else range(1):
            for d in range(-1, 2):
                moves = abs(a) + abs(b) + abs(d)
                if moves == 1 or (diagonal and moves > 1):
                    steps[count] = a * row + b * columns + d
                    count += 1
    return count


@njit(cache=True, nogil=True)
def far_from_edges(nodes, count, layers, shape):
    """Whether so many layers around the nodes stay off all ends of the mesh."""
    row, columns = shape[1] * shape[2], shape[2]
    deep = shape[1] > 1
    for k in range(count):
        i = nodes[k] // row
        rest = nodes[k] - i * row
        m = rest // columns if deep else 0
        c = rest - m * columns
        if i < layers or i >= shape[0] - layers or c < layers or c >= columns - layers:
            return False
        if deep and (m < layers or m >= shape[1] - layers):
            return False
    return True


@njit(cache=True, nogil=True)
def neighbours(node, shape, periodic, diagonal, out):
    """Nodes around one, those along the axes or with ``diagonal`` all; returns how many."""
    row, columns = shape[1] * shape[2], shape[2]
    i, c = node // row, node % columns
    m = (node - i * row) // columns
    deep = shape[1] > 1
    inside = 0 < i < shape[0] - 1 and 0 < c < columns - 1 and (not deep or 0 < m < shape[1] - 1)
    count = 0
    for a in range(-1, 2):
        for b in range(-1, 2) if deep else range(1):
            for d in range(-1, 2):
                moves = abs(a) + abs(b) + abs(d)
                if moves == 0 or not (diagonal or moves == 1):
                    continue
                if inside:
                    out[count] = node + a * row + b * columns + d
                    count += 1
                    continue
                x = wrapped(i + a, shape[0], periodic[0])
                y = wrapped(m + b, shape[1], periodic[1])
                z = wrapped(c + d, columns, periodic[2])
                if x >= 0 and y >= 0 and z >= 0:
                    out[count] = x * row + y * columns + z
                    count += 1
    return count


@njit(cache=True, nogil=True)
def select(nodes, level, marks, bound, shape, periodic, core):
    """Nodes within a bound, or inside beside one outside, into ``core``; returns how many."""
    near = np.empty(27, np.int64)
    count = 0
    for k in range(nodes.size):
        value = level[nodes[k]]
        taken = abs(value) < bound
        if value <= -bound:  # a level set may be steep enough to change side from node to node
            for n in range(neighbours(nodes[k], shape, periodic, False, near)):
                taken |= marks[near[n]] != 0 and level[near[n]] >= 0
        if taken:
            core[count] = nodes[k]
            count += 1
    return count


@njit(cache=True, nogil=True)
def widen(core, count, layers, shape, periodic, marks, level, flat, least, nodes):
    """The core and so many layers of nodes around it, into ``nodes``; returns how many.

    ``marks``: 1 where ``level`` is known, 2 where a node was taken. A node that is not known takes
    the value of the one from which it was reached, and at least the part ``least`` of ``flat``.
    Layers reach along the axes and to all sides in turn, which makes them nearly round. -1: no
    room.
    """
    near, steps = np.empty(27, np.int64), np.empty(27, np.int64)
    plain = far_from_edges(core, count, layers, shape)
    for k in range(count):
        marks[core[k]] = 2
        nodes[k] = core[k]
    total = count
    start = 0
    for layer in range(layers):
        stop = total
        diagonal = layer % 2 == 1
        around = moves_to(shape, diagonal, steps)
        for k in range(start, stop):
            if not plain:
                around = neighbours(nodes[k], shape, periodic, diagonal, near)
            for n in range(around):
                node = nodes[k] + steps[n] if plain else near[n]
                if marks[node] == 2:
                    continue
                if total == nodes.size:
                    return -1
                if marks[node] == 0:
                    value = max(abs(level[nodes[k]]), least * flat)
                    value = flat if value > FLAT * flat else value
                    level[node] = value if level[nodes[k]] > 0 else -value
                marks[node] = 2
                nodes[total] = node
                total += 1
        start = stop
    return total


@njit(cache=True, nogil=True)
def order(nodes, count, columns, starts, result):
    """Nodes in ascending order: counted by rows, then sorted within each; ``starts`` all zero."""
    for k in range(count):
        starts[nodes[k] // columns + 1] += 1
    for row in range(starts.size - 1):
        starts[row + 1] += starts[row]
    for k in range(count):
        row = nodes[k] // columns
        result[starts[row]] = nodes[k]
        starts[row] += 1
    begin = 0
    for row in range(starts.size - 1):
        end = starts[row]
        if end - begin > 1:
            result[begin:end].sort()
        begin = end
