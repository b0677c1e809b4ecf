"""Compiled loops of local corrections on blocks, several blocks at once, one per lane of a vector.

Blocks are ``(c, n, bx, b, b)`` with ``bx`` = 1 in 2-D, see `remesh.multires._ghosts`, which lays
the ghosts. The last axis is split into even and odd nodes ("phases"), lanes run fastest. Opposite
rows are added or subtracted first: taps are even or odd along all axes but the last.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.compiled import drop_stale
from remesh.multires import _ghosts
from remesh.multires._ghosts import copy, extend, has_jump, lattice, scratch, subdivide
from remesh.multires.blocks import ABSENT

CHUNK = 4  # taps applied in one pass

drop_stale(__file__, _ghosts.__file__)


@njit(cache=True, nogil=True, fastmath={"contract"})
def convolve(line, taps, slot, count, lanes, even, odd):
    """Add a phase of a line to both phases of the targets; ``slot``: its first node read."""
    size = even.size
    for k in range(0, count, CHUNK):
        a0, a1, a2, a3 = taps[0, k], taps[0, k + 1], taps[0, k + 2], taps[0, k + 3]
        b0, b1, b2, b3 = taps[1, k], taps[1, k + 1], taps[1, k + 2], taps[1, k + 3]
        first = (slot + k) * lanes
        p0 = line[first : first + size]
        p1 = line[first + lanes : first + lanes + size]
        p2 = line[first + 2 * lanes : first + 2 * lanes + size]
        p3 = line[first + 3 * lanes : first + 3 * lanes + size]
        for i in range(size):
            x0, x1, x2, x3 = p0[i], p1[i], p2[i], p3[i]
            even[i] += a0 * x0 + a1 * x1 + a2 * x2 + a3 * x3
            odd[i] += b0 * x0 + b1 * x1 + b2 * x2 + b3 * x3


@njit(cache=True, nogil=True)
def fold(ahead, behind, total, difference):
    """Sum and difference of two rows."""
    for i in range(total.size):
        total[i] = ahead[i] + behind[i]
        difference[i] = ahead[i] - behind[i]


@njit(cache=True, nogil=True)
def lay(values, own, around, under, sides, weights, ghosts, space, boxes, least, rows):
    """Blocks and their ghosts into the lanes of rows (.., 2, nodes * lanes), phase by phase.

    Values below ``least`` are none: sums of numbers that small are many times slower.
    """
    start, nodes, slab, plane = space
    lanes = own.size
    for lane in range(lanes):
        n = own[lane]
        if n < 0:
            continue
        if has_jump(around[n]):
            lattice(values, values, around[n], under[n], sides[n], start, nodes)
            before = (ghosts, ghosts, ghosts)
            subdivide(nodes, start, before, weights, slab, plane, boxes[lane])
        copy(values, around[n], ghosts, ghosts, boxes[lane], False)
    flat = boxes.reshape(lanes, -1, boxes.shape[3])
    for r in range(flat.shape[1]):
        for lane in range(lanes):
            source = flat[lane, r]
            for phase in range(2):
                target = rows[r, phase]
                for i in range(source.size // 2):
                    value = source[2 * i + phase]
                    target[i * lanes + lane] = value if abs(value) >= least else 0


@njit(cache=True, nogil=True)
def store(sums, factor, lane, lanes, line):
    """Both phases of a lane's targets into a line of its block."""
    for i in range(line.size // 2):
        line[2 * i] = factor * sums[0, i * lanes + lane]
        line[2 * i + 1] = factor * sums[1, i * lanes + lane]


@njit(cache=True, nogil=True)
def correct_plane(
    first, groups, step, numbers, values, around, under, sides, weights, tables, extents,
    which, factors, least, out,
):  # fmt: skip
    """Corrections of 2-D blocks ``numbers``: ``out[:, n] = factors[n] * (d_y G, -d_x G) * values``.

    ``tables``: [which][parity of the row][component][m][phase][parity of the target][slot].
    """
    reach = extents.size - 1
    lanes = numbers.shape[1]
    size = values.shape[-1]
    wide = size + 2 * reach
    nodes = (wide // 2 + CHUNK) * lanes
    space = scratch(values[0], reach, reach, weights.size // 2)
    boxes = np.zeros((lanes, 1, wide, wide), values.dtype)
    rows = np.zeros((wide, 2, nodes), values.dtype)
    folded = np.empty((2, 2, nodes), values.dtype)
    sums = np.empty((2, 2, size // 2 * lanes), values.dtype)
    for group in range(first, groups, step):
        own = numbers[group]
        taps = tables[which[group]]
        lay(values[0], own, around, under, sides, weights, reach, space, boxes, least, rows)
        for y in range(size):
            sums[:] = 0
            for m in range(reach + 1):
                middle = reach + y
                fold(
                    rows[middle + m].reshape(-1), rows[middle - m].reshape(-1),
                    folded[0].reshape(-1), folded[1].reshape(-1),
                )  # fmt: skip
                for c in range(2):
                    for phase in range(2):
                        convolve(
                            folded[c, phase], taps[y % 2, c, m, phase],
                            reach // 2 - extents[m], 2 * extents[m] + 1, lanes,
                            sums[c, 0], sums[c, 1],
                        )  # fmt: skip
            for c in range(2):
                for lane in range(lanes):
                    if own[lane] >= 0:
                        store(sums[c], factors[own[lane]], lane, lanes, out[c, own[lane], 0, y])


@njit(cache=True, nogil=True)
def combine(ahead, behind, one, other, total):
    """Two rows, each with its sign."""
    for i in range(total.size):
        total[i] = one * ahead[i] + other * behind[i]


@njit(cache=True, nogil=True, fastmath={"contract"})
def correct_space(
    first, groups, step, numbers, values, around, under, sides, weights, tables, extents,
    which, factors, least, out,
):  # fmt: skip
    """Corrections of 3-D blocks, curl(G * values).

    ``tables``: [which][parity of x][parity of y][component of grad G][m_x][m_y][phase][parity of
    the target][slot]; ``extents[m_x, m_y]`` is negative where there are no taps.
    """
    reach = extents.shape[0] - 1
    lanes = numbers.shape[1]
    size = values.shape[-1]
    wide = size + 2 * reach
    nodes = (wide // 2 + CHUNK) * lanes
    space = scratch(values[0], reach, reach, weights.size // 2)
    boxes = np.zeros((lanes, wide, wide, wide), values.dtype)
    rows = np.zeros((3, wide, wide, 2, nodes), values.dtype)
    planes = np.empty((2, 3, wide, 2 * nodes), values.dtype)
    line = np.empty((2, nodes), values.dtype)
    sums = np.empty((size, 3, 2, size // 2 * lanes), values.dtype)
    for group in range(first, groups, step):
        own = numbers[group]
        for c in range(3):
            flat = rows[c].reshape(wide * wide, 2, nodes)
            lay(values[c], own, around, under, sides, weights, reach, space, boxes, least, flat)
        for x in range(size):
            sums[:] = 0
            for m in range(reach + 1):
                for c in range(3):
                    ahead = rows[c, reach + x + m].reshape(-1)
                    behind = rows[c, reach + x - m].reshape(-1)
                    combine(ahead, behind, 1, 1, planes[0, c].reshape(-1))
                    combine(ahead, behind, 1, -1, planes[1, c].reshape(-1))
                for y in range(size):
                    taps = tables[which[group], x % 2, y % 2]
                    plane_pair(planes, reach + y, m, reach, taps, extents[m], lanes, line, sums[y])
            for y in range(size):
                for c in range(3):
                    for lane in range(lanes):
                        if own[lane] >= 0:
                            store(
                                sums[y, c], factors[own[lane]], lane, lanes, out[c, own[lane], x, y]
                            )


@njit(cache=True, nogil=True)
def plane_pair(planes, row, m, reach, taps, extents, lanes, line, sums):
    """What two opposite planes, added [0] and subtracted [1], give to one row of targets.

    u = d_y G * w_z - d_z G * w_y and so on: six products, d_x G odd in x, d_y G odd in y.
    """
    flat = line.reshape(-1)
    for n in range(reach + 1):
        extent = extents[n]
        if extent < 0:
            break
        slot, count = reach // 2 - extent, 2 * extent + 1
        up, down = row + n, row - n
        for product in range(6):
            if product == 0:
                kernel, target = 0, 2
                combine(planes[1, 1, up], planes[1, 1, down], 1, 1, flat)
            elif product == 1:
                kernel, target = 0, 1
                combine(planes[1, 2, up], planes[1, 2, down], -1, -1, flat)
            elif product == 2:
                kernel, target = 1, 0
                combine(planes[0, 2, up], planes[0, 2, down], 1, -1, flat)
            elif product == 3:
                kernel, target = 1, 2
                combine(planes[0, 0, up], planes[0, 0, down], -1, 1, flat)
            elif product == 4:
                kernel, target = 2, 0
                combine(planes[0, 1, up], planes[0, 1, down], -1, -1, flat)
            else:
                kernel, target = 2, 1
                combine(planes[0, 0, up], planes[0, 0, down], 1, 1, flat)
            for phase in range(2):
                convolve(
                    line[phase], taps[kernel, m, n, phase], slot, count, lanes,
                    sums[target, 0], sums[target, 1],
                )  # fmt: skip


@njit(cache=True, nogil=True)
def descend(first, pieces, step, start, velocity, around, under, sides, weights):
    """Add the interpolated velocity of the coarser level to blocks ``start`` to start + pieces."""
    before, nodes, slab, plane = scratch(velocity[0], 0, 0, weights.size // 2)
    box = np.empty(velocity.shape[2:], velocity.dtype)
    only = np.empty(around.shape[1], around.dtype)
    for piece in range(first, pieces, step):
        n = start + piece
        for k in range(only.size):
            only[k] = min(around[n, k], ABSENT)
        for c in range(velocity.shape[0]):
            lattice(velocity[c], velocity[c], only, under[n], sides[n], before, nodes)
            extend(nodes, around[n], before, velocity.shape[-1] // 2)
            subdivide(nodes, before, (0, 0, 0), weights, slab, plane, box)
            add(box.reshape(-1), velocity[c, n].reshape(-1))


@njit(cache=True, nogil=True)
def descend_first(first, pieces, step, start, velocity, whole, margin, places, weights):
    """The same for level 1, from the coarsest level as one mesh with a margin around it."""
    before, nodes, slab, plane = scratch(velocity[0], 0, 0, weights.size // 2)
    box = np.empty(velocity.shape[2:], velocity.dtype)
    half = velocity.shape[-1] // 2
    sx, sy, sz = nodes.shape
    for piece in range(first, pieces, step):
        n = start + piece
        place = places[n]
        x = place[0] * half + margin - before if place.size == 3 else 0
        y, z = place[-2] * half + margin - before, place[-1] * half + margin - before
        for c in range(velocity.shape[0]):
            nodes[:] = whole[c, x : x + sx, y : y + sy, z : z + sz]
            subdivide(nodes, before, (0, 0, 0), weights, slab, plane, box)
            add(box.reshape(-1), velocity[c, n].reshape(-1))


@njit(cache=True, nogil=True)
def add(values, target):
    """Values onto others."""
    for i in range(target.size):
        target[i] += values[i]


@njit(cache=True, nogil=True)
def inject(first, pieces, step, start, velocity, under, sides):
    """The even nodes of blocks ``start`` to start + pieces to the coarser blocks below them."""
    _, _, bx, b, _ = velocity.shape
    half = b // 2
    middle = under.shape[1] // 2
    for piece in range(first, pieces, step):
        n = start + piece
        x0, y0, z0 = sides[n, 0] * (bx // 2), sides[n, 1] * half, sides[n, 2] * half
        for c in range(velocity.shape[0]):
            target = velocity[c, under[n, middle]]
            for x in range((bx + 1) // 2):
                for y in range(half):
                    source = velocity[c, n, 2 * x, 2 * y]
                    line = target[x0 + x, y0 + y]
                    for z in range(half):
                        line[z0 + z] = source[2 * z]
