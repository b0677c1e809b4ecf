"""Compiled pieces of the node laws: weights of a row, groups of its nodes, sums over a stencil.

A group is a few nodes in a row whose stencils lie in the same rows and, along the last axis, within
the same few nodes, the lanes: what a group gives is added to a row of nodes in one go. In the
plane, where weights are most of the work, many nodes that move alike are not laid into lanes.

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
FEW = 4  # nodes that move alike, on average: with fewer no even groups are looked for

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
def group(
    count, columns, first, cells, taps, mid, lanes, wraps, same, cuts, starts, bases, even, places,
    offsets,
):  # fmt: skip
    """Starts of the groups of nodes, and where their lanes begin; returns how many.

    ``first``: the column of the first node. ``places``: the column where each stencil begins,
    ``offsets``: its place in the lanes. Lanes that would reach beyond the row begin earlier; a node
    whose stencil crosses an end of the row stands alone, with -1 for a base. In the plane as many
    nodes as lanes, or more, that move by the same whole cells are an ``even`` group.
    """
    width = len(taps)
    cells_a, cells_b, cells_c = cells
    for n in range(count):
        places[n] = first + n + np.int64(cells_c[n]) - (width // 2 - 1)
    beyond = 0
    for n in range(count):
        beyond += (places[n] < 0) | (places[n] >= columns)
    if wraps and beyond > 0:
        for n in range(count):
            places[n] %= columns
    same[0] = False
    for n in range(1, count):
        same[n] = (cells_a[n] == cells_a[n - 1]) & (cells_b[n] == cells_b[n - 1])
    runs = 1
    cuts[0] = 0
    if len(mid) == 1:
        for n in range(1, count):
            offsets[n] = (not same[n]) | (places[n] != places[n - 1] + 1)
        for n in range(1, count):
            cuts[runs] = n
            runs += offsets[n]
    alike = len(mid) == 1 and runs * FEW <= count
    runs = runs if alike else 1
    cuts[runs] = count
    room = columns - width if len(lanes) <= columns else -1
    found = 0
    base = np.int64(FAR)
    for run in range(runs):
        n = cuts[run]
        size = cuts[run + 1] - n
        inside = 0 <= places[n] <= columns - width - size + 1
        even[found] = alike and size >= len(lanes) and inside
        if even[found]:
            starts[found] = n
            bases[found] = places[n]
            found += 1
            base = np.int64(FAR)
            continue
        for k in range(n, n + size):
            z = places[k]
            offset = z - base
            if not (same[k] and 0 <= offset <= len(lanes) - width):
                inside = 0 <= z <= room
                base = min(z, columns - len(lanes)) if inside else np.int64(FAR)
                offset = z - base if inside else 0
                starts[found] = k
                bases[found] = base if inside else -1
                even[found] = False
                found += 1
            offsets[k] = offset
    starts[found] = count
    return found


@njit(cache=True, nogil=True)
def lay(weights, starts, even, groups, offsets, taps, lanes, table):
    """Weights node by node, each at its place in the lanes, zeros beside."""
    g = 0
    while g < groups:
        start = starts[g]
        while g < groups and not even[g]:
            g += 1
        for n in range(start, starts[g]):
            place = n * len(lanes)
            store(none(table, lanes), table, place)
            place += offsets[n]
            for t in range(len(taps)):
                table[np.uintp(place + t)] = weights[np.uintp(t * CHUNK + n)]
        g += 1


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
def multiply(first, middle, count, taps, lanes, both):
    """Node by node the weights of tap a on the first axis times those of all on the middle one.

    ``middle`` node by node as `lay` makes it; ``both`` has as many places per a as lanes.
    """
    width = len(taps)
    for n in range(count):
        along = load(middle, n * len(lanes), lanes)
        for a in range(width):
            place = (n * width + a) * len(lanes)
            store(times(along, first[np.uintp(a * CHUNK + n)]), both, place)


@njit(cache=True, nogil=True)
def strides(taps, mid, lanes):
    """From node to node, and from tap to tap on the first axis, in the weights across the rows.

    In space these are what `multiply` makes, in the plane the weights on the first axis.
    """
    if len(mid) > 1:
        return len(taps) * len(lanes), len(lanes)
    return 1, CHUNK


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread(source, rows, base, across, table, start, stop, taps, mid, lanes, flat):
    """Add to the stencil's rows what the nodes of a group give, three of them at once."""
    step, pitch = strides(taps, mid, lanes)
    for n in range(start, stop, 3):
        one = times(load(table, n * len(lanes), lanes), source[np.uintp(n)])
        two = none(flat, lanes)
        three = none(flat, lanes)
        if n + 1 < stop:
            two = times(load(table, (n + 1) * len(lanes), lanes), source[np.uintp(n + 1)])
        if n + 2 < stop:
            three = times(load(table, (n + 2) * len(lanes), lanes), source[np.uintp(n + 2)])
        for a in range(len(taps)):
            for b in range(len(mid)):
                place = rows[np.uintp(a * len(mid) + b)] + base
                weight = np.uintp(n * step + a * pitch + b)
                total = load(flat, place, lanes)
                total = plus(total, one, across[weight])
                total = plus(total, two, across[weight + np.uintp(step)])
                total = plus(total, three, across[weight + np.uintp(2 * step)])
                store(total, flat, place)


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_even(source, rows, base, first, last, start, count, taps, lifted, flat):
    """As `spread` for an even group in the plane: node k gives tap t what goes to place k + t."""
    width = len(taps)
    for a in range(width):
        for k in range(count):
            n = np.uintp(start + k)
            lifted[np.uintp(k)] = source[n] * first[np.uintp(a * CHUNK) + n]
        place = rows[a] + base
        for k in range(width - 1):
            for t in range(k + 1):
                given = lifted[np.uintp(k - t)] * last[np.uintp(t * CHUNK + start + k - t)]
                flat[np.uintp(place + k)] += given
        for k in range(width - 1, count):
            total = flat[np.uintp(place + k)]
            for t in range(width):
                given = last[np.uintp(t * CHUNK + start + k - t)]
                total += lifted[np.uintp(k - t)] * given
            flat[np.uintp(place + k)] = total
        for k in range(count, count + width - 1):
            for t in range(k - count + 1, width):
                given = lifted[np.uintp(k - t)] * last[np.uintp(t * CHUNK + start + k - t)]
                flat[np.uintp(place + k)] += given


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_edge(value, rows, z, columns, wraps, across, last, n, taps, mid, lanes, flat):
    """As `spread` for one node whose stencil crosses an edge; returns the strength that is lost."""
    step, pitch = strides(taps, mid, lanes)
    lost = flat.dtype.type(0)
    for t in range(len(taps)):
        along = value * last[t * CHUNK + n]
        k = row_of(z + t, columns, wraps, False)
        for a in range(len(taps)):
            for b in range(len(mid)):
                given = along * across[np.uintp(n * step + a * pitch + b)]
                row = rows[a * len(mid) + b]
                if row >= 0 and k >= 0:
                    flat[row + k] += given
                else:
                    lost += given
    return lost


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather_even(flat, rows, base, first, last, start, stop, taps, lanes, target):
    """As `gather` for the nodes of an even group in the plane, as many at once as lanes."""
    for n in range(start, stop, len(lanes)):
        k = min(n, stop - len(lanes))  # at the end some once more, with the same values
        total = none(flat, lanes)
        for a in range(len(taps)):
            place = rows[a] + base + k - start
            along = none(flat, lanes)
            for t in range(len(taps)):
                values = load(flat, place + t, lanes)
                along = plus(along, values, load(last, t * CHUNK + k, lanes))
            total = plus(total, along, load(first, a * CHUNK + k, lanes))
        store(total, target, k)


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
def gather_edge(flat, rows, z, columns, wraps, clamps, first, middle, last, n, taps, mid):
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
        total += last[t * CHUNK + n] * along
    return total
