"""Compiled loops that tell which blocks details ask for, and carry details to other blocks.

Blocks are laid out as in `_ghosts`; cells are parts of blocks of 4 nodes along each axis.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.compiled import drop_stale
from remesh.multires import _hashing, _pyramid
from remesh.multires._hashing import fold
from remesh.multires._pyramid import quadrant
from remesh.multires.blocks import ABSENT
from remesh.multires.mesh import CELL

drop_stale(__file__, _hashing.__file__, _pyramid.__file__)


@njit(cache=True, nogil=True)
def largest(first, pieces, step, values, children, result):
    """Largest absolute value over the active nodes of each block, (c, n); not a number if one."""
    side = np.empty(3, np.int8)
    for n in range(first, pieces, step):
        for c in range(values.shape[0]):
            most = values.dtype.type(0)
            check = values.dtype.type(0)
            for k in range(children.shape[1]):
                if children[n, k] == ABSENT:
                    side[0], side[1], side[2] = k >> 2, (k >> 1) & 1, k & 1
                    part = quadrant(values[c, n], side)
                    for x in range(part.shape[0]):
                        for y in range(part.shape[1]):
                            for z in range(part.shape[2]):
                                most = max(most, abs(part[x, y, z]))
                                check += part[x, y, z] - part[x, y, z]
            result[c, n] = most + check


@njit(cache=True, nogil=True)
def weigh(first, pieces, step, details, inverse, cells):
    """Largest detail in each cell over all fields, each relative to its scale."""
    parts, _, bx, by, bz = details.shape
    for n in range(first, pieces, step):
        cells[n] = 0
        for c in range(parts):
            factor = inverse[c]
            for x in range(bx):
                for y in range(by):
                    line = details[c, n, x, y]
                    row = cells[n, x // CELL, y // CELL]
                    for k in range(bz // CELL):
                        most = abs(line[CELL * k])
                        for i in range(1, CELL):
                            most = max(most, abs(line[CELL * k + i]))
                        row[k] = max(row[k], factor * most)


@njit(cache=True, nogil=True)
def sides(cell, size, buffer):
    """First and last of the neighbours along an axis within a buffer of a cell's nodes."""
    if size == 1:
        return 0, 0
    low = -1 if CELL * cell < buffer else 0
    return low, 1 if CELL * (cell + 1) > size - buffer else 0


@njit(cache=True, nogil=True)
def halves(cell, size, buffer):
    """First and last of the finer places along an axis within a buffer of a cell's nodes."""
    if size == 1:
        return 0, 0
    half = size // 2
    return (CELL * cell - buffer) // half, (CELL * (cell + 1) - 1 + buffer) // half


@njit(cache=True, nogil=True)
def flag(cells, bx, b, low, high, buffers, near, fine):
    """Mark the neighbours and the finer places that the cells of a block ask for."""
    near[:] = False
    fine[:] = False
    any_near, any_fine = False, False
    cx, cy, cz = cells.shape
    for x in range(cx):
        for y in range(cy):
            for z in range(cz):
                if cells[x, y, z] > low:
                    any_near = True
                    x0, x1 = sides(x, bx, buffers[0])
                    y0, y1 = sides(y, b, buffers[0])
                    z0, z1 = sides(z, b, buffers[0])
                    near[x0 + 1 : x1 + 2, y0 + 1 : y1 + 2, z0 + 1 : z1 + 2] = True
                if cells[x, y, z] > high:
                    any_fine = True
                    x0, x1 = halves(x, bx, buffers[1])
                    y0, y1 = halves(y, b, buffers[1])
                    z0, z1 = halves(z, b, buffers[1])
                    fine[x0 + 1 : x1 + 2, y0 + 1 : y1 + 2, z0 + 1 : z1 + 2] = True
    return any_near, any_fine


@njit(cache=True, nogil=True)
def note(place, counts, periodic, offset, keys, count):
    """Add the key of a place to a list, if there is one."""
    key = fold(place, counts, periodic)
    if key >= 0:
        keys[count] = key + offset
        count += 1
    return count


@njit(cache=True, nogil=True)
def mark(cells, size, places, levels, layout, low, high, buffers):
    """Keys of the blocks that the cells ask for: they themselves, buffers around, finer ones.

    ``layout``: places on each axis of each level, which axes are periodic, what keys add. Keys may
    come more than once.
    """
    counts, periodic, offsets = layout
    ndim = counts.shape[1]
    bx = size if ndim == 3 else 1
    near = np.empty((3, 3, 3), np.bool_)
    fine = np.empty((4, 4, 4), np.bool_)
    place = np.empty(ndim, np.int64)
    keys = np.empty(64, np.int64)
    count = 0
    for n in range(cells.shape[0]):
        level = levels[n]
        keep, split = flag(cells[n], bx, size, low, high, buffers, near, fine)
        if not keep:
            continue
        if count + 91 > keys.size:
            keys = np.concatenate((keys, np.empty(keys.size + 91, np.int64)))
        own = places[n]
        for k in range(27):
            if near[k // 9, k // 3 % 3, k % 3]:
                place[ndim - 1] = own[ndim - 1] + k % 3 - 1
                place[ndim - 2] = own[ndim - 2] + k // 3 % 3 - 1
                if ndim == 3:
                    place[0] = own[0] + k // 9 - 1
                count = note(place, counts[level], periodic, offsets[level], keys, count)
        if not split or level + 1 == counts.shape[0]:
            continue
        for k in range(64):
            if fine[k // 16, k // 4 % 4, k % 4]:
                place[ndim - 1] = 2 * own[ndim - 1] + k % 4 - 1
                place[ndim - 2] = 2 * own[ndim - 2] + k // 4 % 4 - 1
                if ndim == 3:
                    place[0] = 2 * own[0] + k // 16 - 1
                count = note(place, counts[level + 1], periodic, offsets[level + 1], keys, count)
    return keys[:count]


@njit(cache=True, nogil=True)
def edge(offset, size, reach):
    """The nodes of a block along an axis that are within reach of a neighbour."""
    if size == 1 or offset == 0:
        return 0, size
    return (0, reach) if offset < 0 else (size - reach, size)


@njit(cache=True, nogil=True)
def carry(first, pieces, step, details, numbers, around, reach, result):
    """Details on other blocks: none on new ones, none within reach of a place without a block."""
    parts, _, bx, b, _ = details.shape
    deep = 1 if bx > 1 else 0
    for n in range(first, pieces, step):
        for c in range(parts):
            target = result[c, n]
            if numbers[n] < 0:
                target[:] = 0
                continue
            target[:] = details[c, numbers[n]]
            for k in range(around.shape[1]):
                if around[n, k] == ABSENT:
                    x0, x1 = edge(k // 9 - 1 if deep else 0, bx, reach)
                    y0, y1 = edge(k // 3 % 3 - 1, b, reach)
                    z0, z1 = edge(k % 3 - 1, b, reach)
                    target[x0:x1, y0:y1, z0:z1] = 0
