"""Compiled lifting steps of the blocks of one level; see `_ghosts` for the layout.

``work`` holds, between the two steps of a level, even nodes' values and details as they are then.
``tables`` are the neighbours, the coarser blocks and the sides of all blocks.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.compiled import drop_stale
from remesh.multires import _ghosts
from remesh.multires._ghosts import copy, has_jump, lattice, scratch, span, subdivide
from remesh.multires.blocks import ABSENT

drop_stale(__file__, _ghosts.__file__)


@njit(cache=True, nogil=True)
def extent(this, axis, total, size, before, odd, upward):
    """Nodes of a box along ``this`` axis that are lifted or go along when ``axis`` is lifted."""
    if total == 1:
        return 0, 1
    if this == axis:
        return before + odd, before + size
    if this < axis if upward else this > axis:  # done already, ghosts are not read again
        return before, before + size
    return 0, total


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_two(target, weights, factor, a, b):
    """``target`` += factor * (weights times two rows)."""
    w0, w1 = factor * weights[0], factor * weights[1]
    for i in range(target.size):
        target[i] += w0 * a[i] + w1 * b[i]


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_four(target, weights, factor, a, b, c, d):
    """``target`` += factor * (weights times four rows)."""
    w0, w1 = factor * weights[0], factor * weights[1]
    w2, w3 = factor * weights[2], factor * weights[3]
    for i in range(target.size):
        target[i] += w0 * a[i] + w1 * b[i] + w2 * c[i] + w3 * d[i]


@njit(cache=True, nogil=True)
def lift(box, axis, size, before, odd, weights, sign, upward):
    """The odd or the even nodes of the block += sign * weights of the others along an axis."""
    sx, sy, sz = box.shape
    x0, x1 = extent(0, axis, sx, size, before, odd, upward)
    y0, y1 = extent(1, axis, sy, size, before, odd, upward)
    z0, z1 = extent(2, axis, sz, size, before, odd, upward)
    jump_x, jump_y, jump_z = 2 if axis == 0 else 1, 2 if axis == 1 else 1, 2 if axis == 2 else 1
    dx, dy, dz = 1 if axis == 0 else 0, 1 if axis == 1 else 0, 1 if axis == 2 else 0
    for start in range(0, weights.size, 4):
        s = 2 * start - weights.size + 1
        some = weights[start:]
        for x in range(x0, x1, jump_x):
            for y in range(y0, y1, jump_y):
                target = box[x, y, z0:z1:jump_z]
                i, j, k, m = x + s * dx, y + s * dy, z0 + s * dz, z1 + s * dz
                a = box[i, j, k:m:jump_z]
                b = box[i + 2 * dx, j + 2 * dy, k + 2 * dz : m + 2 * dz : jump_z]
                if some.size < 4:
                    add_two(target, some, sign, a, b)
                    continue
                c = box[i + 4 * dx, j + 4 * dy, k + 4 * dz : m + 4 * dz : jump_z]
                d = box[i + 6 * dx, j + 6 * dy, k + 6 * dz : m + 6 * dz : jump_z]
                add_four(target, some, sign, a, b, c, d)


@njit(cache=True, nogil=True)
def blank(box, around, size, before, after):
    """Zeros again where there are no blocks of the level."""
    deep = 1 if box.shape[0] > 1 else 0
    k = 0
    for ox in range(-deep, deep + 1):
        x0, x1, _ = span(ox, size if deep else 1, deep * before, deep * after)
        for oy in range(-1, 2):
            y0, y1, _ = span(oy, size, before, after)
            for oz in range(-1, 2):
                z0, z1, _ = span(oz, size, before, after)
                if around[k] < 0:
                    box[x0:x1, y0:y1, z0:z1] = 0
                k += 1


@njit(cache=True, nogil=True)
def new_box(values, before, after):
    """Scratch for a block with so many ghosts."""
    _, _, bx, b, _ = values.shape
    size = before + b + after
    return np.empty((size if bx > 1 else 1, size, size), values.dtype)


@njit(cache=True, nogil=True)
def inside(box, values, before):
    """The block in its box."""
    _, bx, b, _ = values.shape
    x = before if bx > 1 else 0
    return box[x : x + bx, before : before + b, before : before + b]


@njit(cache=True, nogil=True)
def quadrant(values, side):
    """The part of a block under a finer block on that side of it."""
    bx, b, _ = values.shape
    half = b // 2
    wide = half if bx > 1 else 1
    x, y, z = side[0] * wide, side[1] * half, side[2] * half
    return values[x : x + wide, y : y + half, z : z + half]


@njit(cache=True, nogil=True)
def assign(target, source):
    """Copy values, row by row."""
    for x in range(target.shape[0]):
        for y in range(target.shape[1]):
            for z in range(target.shape[2]):
                target[x, y, z] = source[x, y, z]


@njit(cache=True, nogil=True)
def settle(box, beyond, around, size, before, after, axis):
    """What a prediction along an axis finds where no blocks are: no details of earlier axes."""
    deep = 1 if box.shape[0] > 1 else 0
    k = 0
    for ox in range(-deep, deep + 1):
        x0, x1, _ = span(ox, size if deep else 1, deep * before, deep * after)
        for oy in range(-1, 2):
            y0, y1, _ = span(oy, size, before, after)
            for oz in range(-1, 2):
                z0, z1, _ = span(oz, size, before, after)
                if around[k] == ABSENT:
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            if (axis > 0 and x & 1) or (axis > 1 and y & 1):
                                box[x, y, z0:z1] = 0
                            else:
                                for z in range(z0, z1):
                                    box[x, y, z] = beyond[x, y, z]
                k += 1


@njit(cache=True, nogil=True)
def predict_blocks(first, pieces, step, start, values, work, tables, weights, forward):
    """From ``values`` to even nodes and details of the interpolation in ``work``, or back.

    Predictions along each axis see subdivisions where no blocks are: of even nodes alone, so that
    each step can be undone whatever the details.
    """
    around, under, sides = tables
    b = values.shape[4]
    axes = 0 if values.shape[2] > 1 else 1
    before, after = weights.size - 2, weights.size - 1
    sign = weights.dtype.type(-1 if forward else 1)
    box, beyond = new_box(values, before, after), new_box(values, before, after)
    edge, nodes, slab, plane = scratch(values[0], before, after, weights.size // 2)
    for piece in range(first, pieces, step):
        n = start + piece
        jump = has_jump(around[n])
        for c in range(values.shape[0]):
            source, target = (values[c], work[c]) if forward else (work[c], values[c])
            copy(source, around[n], before, after, box, False)
            if jump:
                lattice(source, values[c], around[n], under[n], sides[n], edge, nodes)
                subdivide(nodes, edge, (before, before, before), weights, slab, plane, beyond)
            for k in range(axes, 3):
                axis = k if forward else axes + 2 - k
                if jump:
                    settle(box, beyond, around[n], b, before, after, axis)
                lift(box, axis, b, before, 1, weights, sign, forward)
            assign(target[n], inside(box, target, before))


@njit(cache=True, nogil=True)
def update(first, pieces, step, start, work, tables, weights, spill, smooth, details):
    """The coarser values under each block, and its details; see `lift_work`."""
    around, under, sides = tables
    before, after = max(weights.size - 1, 0), max(weights.size - 2, 0)
    box = new_box(work, before, after)
    middle = around.shape[1] // 2
    for piece in range(first, pieces, step):
        n = start + piece
        for c in range(work.shape[0]):
            copy(work[c], around[n], before, after, box, True)
            lift_work(box, around[n], work.shape[4], before, after, weights, True, not spill)
            own = inside(box, work[c], before)
            even = own[::2, ::2, ::2]
            assign(quadrant(smooth[c, under[n, middle]], sides[n]), even)
            even[:] = 0
            assign(details[c, n], own)


@njit(cache=True, nogil=True)
def lift_work(box, around, size, before, after, weights, forward, cut):
    """Add details to even nodes along all axes, or undo it; to those of blocks only if ``cut``."""
    axes = 0 if box.shape[0] > 1 else 1
    one = weights.dtype.type(1)
    jump = cut and has_jump(around)
    for k in range(axes, 3):
        axis = k if forward else axes + 2 - k
        lift(box, axis, size, before, 0, weights, one if forward else -one, forward)
        if jump:
            blank(box, around, size, before, after)


@njit(cache=True, nogil=True)
def place_around(n, x, y, z, neighbours, children, result):
    """Blocks of the next finer level around a quadrant of a block; tells whether there are any."""
    deep = 1 if result.size > 9 else 0
    found = False
    k = 0
    for ox in range(-deep, deep + 1):
        for oy in range(-1, 2):
            for oz in range(-1, 2):
                i, j, m = x + ox, y + oy, z + oz
                number = neighbours[n, (((i >> 1) + deep) * 3 + (j >> 1) + 1) * 3 + (m >> 1) + 1]
                if number >= 0:
                    number = children[number, ((i & 1) * 2 + (j & 1)) * 2 + (m & 1)]
                result[k] = number
                found |= number >= 0
                k += 1
    return found


@njit(cache=True, nogil=True)
def spill(first, pieces, step, start, work, neighbours, children, weights, smooth):
    """Add to coarse nodes where there are no finer blocks what the details beside them give."""
    b = work.shape[4]
    before, after = weights.size - 1, weights.size - 2
    box = new_box(work, before, after)
    around = np.empty(neighbours.shape[1], np.int32)
    side = np.empty(3, np.int8)
    for piece in range(first, pieces, step):
        n = start + piece
        for k in range(children.shape[1]):
            side[0], side[1], side[2] = k >> 2, (k >> 1) & 1, k & 1
            if children[n, k] >= 0:
                continue
            if not place_around(n, side[0], side[1], side[2], neighbours, children, around):
                continue
            for c in range(work.shape[0]):
                copy(work[c], around, before, after, box, True)
                lift_work(box, around, b, before, after, weights, True, False)
                even = inside(box, work[c], before)[::2, ::2, ::2]
                target = quadrant(smooth[c, n], side)
                for x in range(target.shape[0]):
                    for y in range(target.shape[1]):
                        for z in range(target.shape[2]):
                            target[x, y, z] += even[x, y, z]


@njit(cache=True, nogil=True)
def undo_update(first, pieces, step, start, values, details, tables, weights, work):
    """Even nodes as before the update, from the coarser values, and details likewise."""
    around, under, sides = tables
    before, after = max(weights.size - 1, 0), max(weights.size - 2, 0)
    box = new_box(work, before, after)
    middle = around.shape[1] // 2
    for piece in range(first, pieces, step):
        n = start + piece
        for c in range(work.shape[0]):
            copy(details[c], around[n], before, after, box, True)
            own = inside(box, work[c], before)
            assign(own[::2, ::2, ::2], quadrant(values[c, under[n, middle]], sides[n]))
            lift_work(box, around[n], work.shape[4], before, after, weights, False, True)
            assign(work[c, n], own)
