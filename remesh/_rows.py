"""Compiled pieces of the node laws: weights of a row, groups of its nodes, sums over a stencil.

A group is a few nodes in a row whose stencils lie in the same rows and, along the last axis, within
the same few nodes, the lanes: what a group gives is added to a row of nodes in one go.

Numba keeps one cache per file: after a change here, touch the files that import it.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call, call-arg, var-annotated"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _lanes
from remesh._lanes import dot, load, none, plus, store, times
from remesh.compiled import drop_stale
from remesh.layout import FAR

CHUNK = 128  # nodes per piece of a row: the weights of all axes stay in the first-level cache

drop_stale(__file__, _lanes.__file__)


@njit(cache=True, nogil=True, fastmath={"contract"})
def weigh(displacement, scale, coeffs, taps, terms, cells, local, weights):
    """Whole cells and tap weights of a piece of a row; returns how many displacements are bad."""
    half_width = len(taps) // 2
    count = displacement.size
    inverse = scale[0]
    half = scale[1]
    far = scale[2]
    bad = 0
    for n in range(count):
        x = displacement[n] * inverse
        x = x if abs(x) < far else far
        whole = np.floor(x)
        cells[n] = np.int32(whole)
        local[n] = x - whole - half
    for n in range(count):
        bad += cells[n] == FAR
    for i in range(half_width):
        left = weights[(half_width - 1 - i) * CHUNK : (half_width - i) * CHUNK]
        right = weights[(half_width + i) * CHUNK : (half_width + i + 1) * CHUNK]
        c = coeffs[2 * i * len(terms) : 2 * (i + 1) * len(terms)]
        for n in range(count):
            s = local[n]
            square = s * s
            even = c[len(terms) - 1]
            odd = c[2 * len(terms) - 1]
            for k in range(1, len(terms)):
                even = even * square + c[len(terms) - 1 - k]
                odd = odd * square + c[2 * len(terms) - 1 - k]
            odd = odd * s
            left[n] = even + odd
            right[n] = even - odd
    return bad


@njit(cache=True, nogil=True)
def row_of(index, size, wraps, clamps):
    """The row that an index means: wrapped, the edge row, or -1 for none."""
    if 0 <= index < size:
        return index
    if wraps:
        return index % size
    if clamps:
        return 0 if index < 0 else size - 1
    return -1


@njit(cache=True, nogil=True)
def any_value(source):
    """Whether a piece of a row holds anything but zeros."""
    used = 0
    for n in range(source.size):
        used |= source[n] != 0
    return used != 0


@njit(cache=True, nogil=True)
def group(count, columns, first, cells, taps, lanes, wraps, same, starts, bases, places, offsets):
    """Starts of the groups of nodes, and where their lanes begin; returns how many.

    ``first``: the column of the first node. ``places``: the column where each stencil begins,
    ``offsets``: its place in the lanes. Lanes that would reach beyond the row begin earlier; a node
    whose stencil crosses an end of the row stands alone, with -1 for a base.
    """
    width = len(taps)
    cells_a, cells_b, cells_c = cells
    for n in range(count):
        places[n] = first + n + np.int64(cells_c[n]) - (width // 2 - 1)
    if wraps:
        for n in range(count):
            if places[n] < 0 or places[n] >= columns:
                places[n] %= columns
    for n in range(1, count):
        same[n] = (cells_a[n] == cells_a[n - 1]) & (cells_b[n] == cells_b[n - 1])
    same[0] = False
    room = columns - width if len(lanes) <= columns else -1
    found = 0
    base = np.int64(FAR)
    for n in range(count):
        z = places[n]
        offset = z - base
        if not (same[n] and 0 <= offset <= len(lanes) - width):
            inside = 0 <= z <= room
            base = min(z, columns - len(lanes)) if inside else np.int64(FAR)
            offset = z - base if inside else 0
            starts[found] = n
            bases[found] = base if inside else -1
            found += 1
        offsets[n] = offset
    starts[found] = count
    return found


@njit(cache=True, nogil=True)
def lay(weights, count, offsets, taps, lanes, table):
    """Weights node by node, each at its place in the lanes, zeros beside."""
    for n in range(count):
        place = n * len(lanes)
        store(none(table, lanes), table, place)
        place += offsets[n]
        for t in range(len(taps)):
            table[np.uintp(place + t)] = weights[np.uintp(t * CHUNK + n)]


@njit(cache=True, nogil=True)
def find_rows(x, y, shape, periodic, clamps, taps, mid, rows):
    """Places in the flat field of a stencil's rows from x, y on, -1 for none; false if one is."""
    nx, nm, nc = shape
    if x >= 0 and x + len(taps) <= nx and y >= 0 and y + len(mid) <= nm:
        for a in range(len(taps)):
            for b in range(len(mid)):
                rows[np.uintp(a * len(mid) + b)] = ((x + a) * nm + y + b) * nc
        return True
    whole = True
    for a in range(len(taps)):
        i = row_of(x + a, nx, periodic[0], clamps)
        for b in range(len(mid)):
            m = row_of(y + b, nm, periodic[1], clamps) if len(mid) > 1 else 0
            inside = i >= 0 and m >= 0
            whole &= inside
            rows[a * len(mid) + b] = (i * nm + m) * nc if inside else -1
    return whole


@njit(cache=True, nogil=True, fastmath={"contract"})
def multiply(first, middle, count, taps, mid, lanes, both):
    """Node by node the weights of tap a on the first axis times those of tap b on the middle one.

    ``middle`` node by node as `lay` makes it; ``both`` has one place per a in the plane, and in
    space as many as lanes.
    """
    width = len(taps)
    for n in range(count):
        if len(mid) > 1:
            along = load(middle, n * len(lanes), lanes)
            for a in range(width):
                place = (n * width + a) * len(lanes)
                store(times(along, first[np.uintp(a * CHUNK + n)]), both, place)
        else:
            for a in range(width):
                both[np.uintp(n * width + a)] = first[np.uintp(a * CHUNK + n)]


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread(source, rows, base, both, table, start, stop, taps, mid, lanes, flat):
    """Add to the stencil's rows what the nodes of a group give, three of them at once."""
    width = len(taps)
    pitch = len(lanes) if len(mid) > 1 else 1
    step = width * pitch
    for n in range(start, stop, 3):
        one = times(load(table, n * len(lanes), lanes), source[np.uintp(n)])
        two = none(flat, lanes)
        three = none(flat, lanes)
        if n + 1 < stop:
            two = times(load(table, (n + 1) * len(lanes), lanes), source[np.uintp(n + 1)])
        if n + 2 < stop:
            three = times(load(table, (n + 2) * len(lanes), lanes), source[np.uintp(n + 2)])
        for a in range(width):
            for b in range(len(mid)):
                place = rows[np.uintp(a * len(mid) + b)] + base
                weight = np.uintp(n * step + a * pitch + b)
                total = load(flat, place, lanes)
                total = plus(total, one, both[weight])
                total = plus(total, two, both[weight + np.uintp(step)])
                total = plus(total, three, both[weight + np.uintp(2 * step)])
                store(total, flat, place)


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_edge(value, rows, z, columns, wraps, both, table, offset, n, taps, mid, lanes, flat):
    """As `spread` for one node whose stencil crosses an edge; returns the strength that is lost."""
    width = len(taps)
    pitch = len(lanes) if len(mid) > 1 else 1
    lost = flat.dtype.type(0)
    for t in range(width):
        along = value * table[n * len(lanes) + offset + t]
        k = row_of(z + t, columns, wraps, False)
        for a in range(width):
            for b in range(len(mid)):
                given = along * both[np.uintp((n * width + a) * pitch + b)]
                row = rows[a * len(mid) + b]
                if row >= 0 and k >= 0:
                    flat[row + k] += given
                else:
                    lost += given
    return lost


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather(flat, rows, base, first, middle, table, n, taps, mid, lanes):
    """The sum of weights times values over the stencil of one node."""
    total = none(flat, lanes)
    for a in range(len(taps)):
        weight = first[np.uintp(a * CHUNK + n)]
        if len(mid) > 1:
            across = none(flat, lanes)
            for b in range(len(mid)):
                values = load(flat, rows[a * len(mid) + b] + base, lanes)
                across = plus(across, values, middle[np.uintp(b * CHUNK + n)])
            total = plus(total, across, weight)
        else:
            total = plus(total, load(flat, rows[a] + base, lanes), weight)
    return dot(total, load(table, n * len(lanes), lanes))


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather_edge(
    flat, rows, z, columns, wraps, clamps, first, middle, table, offset, n, taps, mid, lanes
):
    """As `gather` where the stencil crosses an edge."""
    total = flat.dtype.type(0)
    for t in range(len(taps)):
        k = row_of(z + t, columns, wraps, clamps)
        along = flat.dtype.type(0)
        for a in range(len(taps)):
            across = flat.dtype.type(0)
            for b in range(len(mid)):
                row = rows[a * len(mid) + b]
                if row >= 0 and k >= 0:
                    weight = flat.dtype.type(1)
                    if len(mid) > 1:
                        weight = middle[np.uintp(b * CHUNK + n)]
                    across += weight * flat[row + k]
            along += first[np.uintp(a * CHUNK + n)] * across
        total += table[n * len(lanes) + offset + t] * along
    return total
