"""Compiled loops over nodes of one level and of the next finer one: which are kept, their values.

Meshes are ``(nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node, so that
one text serves 2-D and 3-D. Node 2i of a level is node i of the next coarser one; the children of
node i are 2i and 2i + 1 along each axis. ``marks`` hold flags of the nodes of a level.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from levelset import _lattice, _layers, _lookup
from levelset._lattice import wrapped
from levelset._layers import neighbours
from levelset._lookup import find_stencil
from remesh.compiled import drop_stale

FOUND, HELD, NEAR, ROUGH, COVERED = 1, 2, 4, 8, 16
# a value is known; of the band; beside the contour; to be refined around; the band is finer here

drop_stale(__file__, _lattice.__file__, _layers.__file__, _lookup.__file__)


@njit(cache=True, nogil=True)
def whole(nodes, shape, periodic, known, fields, taps, mid, cells):
    """The nodes at which cells begin whose stencils are known, into ``cells``; returns how many."""
    left = len(taps) // 2 - 1
    row, columns = shape[1] * shape[2], shape[2]
    marks = known.reshape(known.size)
    flat = fields.reshape(known.size, fields.shape[-1])
    copied = np.empty((len(taps) * len(taps) * len(mid), fields.shape[-1]))
    count = 0
    for node in nodes:
        i, m, c = node // row, (node // columns) % shape[1], node % columns
        start, _, _ = find_stencil(i, m, c, shape, periodic, left, marks, flat, taps, mid, copied)
        if start != -1:
            cells[count] = node
            count += 1
    return count


@njit(cache=True, nogil=True)
def restrict(nodes, field, shape, below, coarse, marks, more):
    """Values at nodes with even indices to the coarser level; returns how many are new there.

    ``below``: shape of the coarser level; the new ones go into ``more``.
    """
    row, columns = shape[1] * shape[2], shape[2]
    count = 0
    for node in nodes:
        i, m, c = node // row, (node // columns) % shape[1], node % columns
        if i % 2 or m % 2 or c % 2:
            continue
        parent = ((i // 2) * below[1] + m // 2) * below[2] + c // 2
        coarse[parent] = field[node]
        if marks[parent] & FOUND == 0:
            marks[parent] |= FOUND
            more[count] = parent
            count += 1
    return count


@njit(cache=True, nogil=True)
def beside_contour(nodes, field, marks, known, shape, periodic, above, higher, near):
    """Nodes of a band from which zero is a spacing away or less, into ``near``; returns how many.

    Told by the differences to the nodes beside them, so that a filament too thin to change a sign
    counts. ``known``: the flag of the nodes that it may read; ``higher``: shape of the next
    coarser level, where ``above`` must tell that the place is to be refined; of no size for the
    coarsest.
    """
    around = np.empty(27, np.int64)
    row, columns = shape[1] * shape[2], shape[2]
    count = 0
    for node in nodes:
        if above.size > 0:
            i, m, c = node // row, (node // columns) % shape[1], node % columns
            parent = ((i // 2) * higher[1] + m // 2) * higher[2] + c // 2
            if above[parent] & ROUGH == 0:
                continue
        value, most = field[node], 0.0
        for n in range(neighbours(node, shape, periodic, False, around)):
            if marks[around[n]] & known:
                most = max(most, abs(field[around[n]] - value))
        if abs(value) <= most:
            marks[node] |= NEAR
            near[count] = node
            count += 1
    return count


@njit(cache=True, nogil=True)
def step_to(node, axis, move, shape, periodic):
    """The flat index of a node some steps away along an axis; -1 beyond an unbounded end."""
    stride = shape[1] * shape[2] if axis == 0 else (shape[2] if axis == 1 else 1)
    place = (node // stride) % shape[axis]
    other = wrapped(place + move, shape[axis], periodic[axis])
    return node + (other - place) * stride if other >= 0 else -1


@njit(cache=True, nogil=True)
def details(nodes, field, marks, known, shape, periodic, predict, result):
    """How far interpolation from every second node would shift the contour, in spacings.

    Along each axis a node is interpolated from those at odd distances by ``predict``, the sum of
    what it is off divided by the slope. An axis along which one of them is not known counts zero.
    """
    half = len(predict) // 2
    for k in range(len(nodes)):
        node = nodes[k]
        value, total, slope = field[nodes[k]], 0.0, 0.0
        for axis in range(3):
            if shape[axis] == 1:
                continue
            guess, steep = 0.0, 0.0
            for t in range(2 * half):
                other = step_to(node, axis, 2 * (t - half) + 1, shape, periodic)
                if other < 0 or marks[other] & known == 0:
                    guess = np.nan
                    continue
                guess += predict[t] * field[other]
                if t == half - 1 or t == half:
                    steep = max(steep, abs(field[other] - value))
            if guess == guess:
                total += abs(value - guess)
            slope += steep * steep
        result[k] = total / np.sqrt(slope) if slope > 0.0 else 0.0


@njit(cache=True, nogil=True)
def parents_of_rough(near, sizes, coarsen, shape, below, marks, parents):
    """The nodes of the coarser level, of shape ``below``, under those with details; how many."""
    row, columns = shape[1] * shape[2], shape[2]
    count = 0
    for k in range(len(near)):
        if sizes[k] <= coarsen:
            continue
        i, m, c = near[k] // row, (near[k] // columns) % shape[1], near[k] % columns
        parent = ((i // 2) * below[1] + m // 2) * below[2] + c // 2
        if marks[parent] == FOUND:
            marks[parent] |= ROUGH
            parents[count] = parent
            count += 1
    return count


@njit(cache=True, nogil=True)
def to_refine(near, sizes, coarsen, refine, shape, finer, below, marks, rough, count):
    """Nodes beside the contour that are to be refined, after those in ``rough``; how many it has.

    Those with details beyond ``refine``, or beyond ``coarsen`` where the next level, of shape
    ``below``, is known already.
    """
    row, columns = shape[1] * shape[2], shape[2]
    for k in range(len(near)):
        if sizes[k] <= coarsen:
            continue
        node = near[k]
        if sizes[k] <= refine:
            i, m, c = node // row, (node // columns) % shape[1], node % columns
            m = 2 * m if shape[1] > 1 else 0
            if finer[(2 * i * below[1] + m) * below[2] + 2 * c] & FOUND == 0:
                continue
        if marks[node] & ROUGH == 0:
            marks[node] |= ROUGH
            rough[count] = node
            count += 1
    return count


@njit(cache=True, nogil=True)
def spread(nodes, count, layers, within, flag, shape, periodic, marks):
    """Flag layers of nodes around some that have the flag, where ``within`` is told already.

    ``nodes`` takes them too, those given first; returns how many there are then. Layers reach to
    all sides and along the axes in turn.
    """
    around = np.empty(27, np.int64)
    start, total = 0, count
    for layer in range(layers):
        stop = total
        for k in range(start, stop):
            for n in range(neighbours(nodes[k], shape, periodic, layer % 2 == 1, around)):
                node = around[n]
                if marks[node] & within and marks[node] & flag == 0:
                    marks[node] |= flag
                    nodes[total] = node
                    total += 1
        start = stop
    return total


@njit(cache=True, nogil=True)
def known_around(node, half, shape, periodic, marks):
    """Whether the nodes that the children of a node are interpolated from are of the band."""
    row, columns = shape[1] * shape[2], shape[2]
    i, m, c = node // row, (node // columns) % shape[1], node % columns
    deep = shape[1] > 1
    for a in range(1 - half, half + 1):
        x = wrapped(i + a, shape[0], periodic[0])
        for b in range(1 - half if deep else 0, half + 1 if deep else 1):
            y = wrapped(m + b, shape[1], periodic[1])
            for d in range(1 - half, half + 1):
                z = wrapped(c + d, columns, periodic[2])
                if x < 0 or y < 0 or z < 0:
                    return False
                if marks[x * row + y * columns + z] & HELD == 0:
                    return False
    return True


@njit(cache=True, nogil=True)
def interpolated(node, a, b, d, field, shape, periodic, predict):
    """The value at the child (a, b, d) of a node, from the nodes around it."""
    row, columns = shape[1] * shape[2], shape[2]
    i, m, c = node // row, (node // columns) % shape[1], node % columns
    half = len(predict) // 2
    total, least, most = 0.0, np.inf, -np.inf
    for p in range(1 - half if a else 0, half + 1 if a else 1):
        x = wrapped(i + p, shape[0], periodic[0]) * row
        wx = predict[p + half - 1] if a else 1.0
        for q in range(1 - half if b else 0, half + 1 if b else 1):
            y = x + wrapped(m + q, shape[1], periodic[1]) * columns
            wy = wx * predict[q + half - 1] if b else wx
            for r in range(1 - half if d else 0, half + 1 if d else 1):
                wz = wy * predict[r + half - 1] if d else wy
                value = field[y + wrapped(c + r, columns, periodic[2])]
                total += wz * value
                if 0 <= p <= a and 0 <= q <= b and 0 <= r <= d:
                    least, most = min(least, value), max(most, value)
    return min(max(total, least), most)


@njit(cache=True, nogil=True)
def bear(covered, shape, below, marks, born, fresh):
    """Children of nodes into ``born``, those without a value into ``fresh``; how many of these."""
    row, columns = shape[1] * shape[2], shape[2]
    deep = shape[1] > 1
    count, new = 0, 0
    for parent in covered:
        i, m, c = parent // row, (parent // columns) % shape[1], parent % columns
        for a in range(2):
            for b in range(2 if deep else 1):
                for d in range(2):
                    child = ((2 * i + a) * below[1] + (2 * m + b if deep else 0)) * below[2]
                    child += 2 * c + d
                    if marks[child] & FOUND == 0:
                        fresh[new] = child
                        new += 1
                    marks[child] |= HELD
                    born[count] = child
                    count += 1
    return new


@njit(cache=True, nogil=True)
def interpolate(nodes, field, shape, periodic, predict, below, finer):
    """Values at nodes of the finer level, of shape ``below``, from the nodes around them."""
    row, columns = below[1] * below[2], below[2]
    for node in nodes:
        i, m, c = node // row, (node // columns) % below[1], node % columns
        parent = ((i // 2) * shape[1] + m // 2) * shape[2] + c // 2
        finer[node] = interpolated(parent, i % 2, m % 2, c % 2, field, shape, periodic, predict)


@njit(cache=True, nogil=True)
def keep_known(nodes, count, half, shape, periodic, marks, kept):
    """Those of the nodes whose children can be interpolated, into ``kept``; returns how many."""
    total = 0
    for k in range(count):
        if known_around(nodes[k], half, shape, periodic, marks):
            kept[total] = nodes[k]
            total += 1
        else:
            marks[nodes[k]] &= ~COVERED
    return total


@njit(cache=True, nogil=True)
def parents(nodes, shape, below, marks, flag, covered):
    """Flag the nodes of the coarser level, of shape ``below``, that lie under even ones."""
    row, columns = shape[1] * shape[2], shape[2]
    count = 0
    for node in nodes:
        i, m, c = node // row, (node // columns) % shape[1], node % columns
        if i % 2 or m % 2 or c % 2:
            continue
        parent = ((i // 2) * below[1] + m // 2) * below[2] + c // 2
        marks[parent] |= flag
        covered[count] = parent
        count += 1
    return count


@njit(cache=True, nogil=True)
def cells(nodes, live, shape, periodic, marks, above, higher, own):
    """The cells that a level is to count: those it shows and no finer level does.

    A cell is counted on the next level, and is marked ``ROUGH``, where the nodes around it, two to
    each side of it, are ``COVERED``. ``above`` tells so of the coarser level, of shape ``higher``;
    it has no size on the coarsest. Returns how many there are in ``own``.
    """
    around = np.empty(27, np.int64)
    row, columns = shape[1] * shape[2], shape[2]
    deep = shape[1] > 1
    count = 0
    for node in nodes:
        i, m, c = node // row, (node // columns) % shape[1], node % columns
        if live:
            parent = ((i // 2) * higher[1] + m // 2) * higher[2] + c // 2
            if above[parent] & ROUGH == 0:
                continue
        under = marks[node] & COVERED != 0
        wanted = 26 if deep else 8
        if under and neighbours(node, shape, periodic, True, around) == wanted:
            for n in range(wanted):
                under &= marks[around[n]] & COVERED != 0
        else:
            under = False
        if under:
            marks[node] |= ROUGH
        else:
            own[count] = node
            count += 1
    return count


@njit(cache=True, nogil=True)
def fill(first, pieces, step, size, field, shape, periodic, predict, level, below, finer):
    """All nodes of the finer level, interpolated; as the nearest where that is level, or an end."""
    row, columns = shape[1] * shape[2], shape[2]
    deep = shape[1] > 1
    half = len(predict) // 2
    for piece in range(first, pieces, step):
        for i in range(piece * size, min((piece + 1) * size, shape[0])):
            for m in range(shape[1]):
                for c in range(columns):
                    node = i * row + m * columns + c
                    plain = i < half - 1 or i + half >= shape[0]
                    plain |= c < half - 1 or c + half >= columns
                    plain |= deep and (m < half - 1 or m + half >= shape[1])
                    same = abs(field[node]) >= level
                    if not plain:
                        for a in range(2):
                            for b in range(2 if deep else 1):
                                for d in range(2):
                                    other = node + a * row + b * columns + d
                                    same &= field[other] == field[node]
                    for a in range(2):
                        for b in range(2 if deep else 1):
                            for d in range(2):
                                child = (2 * i + a) * below[1] + (2 * m + b if deep else 0)
                                child = child * below[2] + 2 * c + d
                                finer[child] = field[node]
                                if same or (
                                    plain and not inner(i, m, c, a, b, d, half, shape, periodic)
                                ):
                                    continue
                                finer[child] = interpolated(
                                    node, a, b, d, field, shape, periodic, predict
                                )


@njit(cache=True, nogil=True)
def inner(i, m, c, a, b, d, half, shape, periodic):
    """Whether a child has all the nodes that it is interpolated from."""
    if a and not periodic[0] and (i < half - 1 or i + half >= shape[0]):
        return False
    if b and not periodic[1] and (m < half - 1 or m + half >= shape[1]):
        return False
    return not (d and not periodic[2] and (c < half - 1 or c + half >= shape[2]))
