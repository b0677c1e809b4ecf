"""Compiled pieces of the node laws: weights of a row, runs of equal whole cells, sums on a run.

Numba keeps one cache per file: after a change here, touch the files that import it.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.layout import FAR

CHUNK = 128  # nodes per piece of a row: the weights of all axes stay in the first-level cache
ONE, TWO, THREE = np.uintp(1), np.uintp(2), np.uintp(3)  # unsigned: no test for negative indices


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


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread(source, weights, start, count, taps, target):
    """target[k + t] += source[start + k] * weights[t, start + k] for a run of >= taps nodes."""
    width = len(taps)
    for k in range(width - 1):
        for t in range(k + 1):
            target[k] += source[start + k - t] * weights[t * CHUNK + start + k - t]
    middle = target[width - 1 : count]
    lead = source[start : start + count]
    for k in range(middle.size):
        total = middle[k]
        for t in range(width):
            j = np.uintp(k + width - 1 - t)
            total += lead[j] * weights[np.uintp(t * CHUNK + start + k + width - 1 - t)]
        middle[k] = total
    for k in range(count, count + width - 1):
        for t in range(k - count + 1, width):
            target[k] += source[start + k - t] * weights[t * CHUNK + start + k - t]


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_short(flat, bases, lifted, weights, start, stop, taps):
    """As `spread` for a run too short for it, node by node so that stores do not queue up."""
    for n in range(start, stop):
        for row in range(len(bases)):
            value = lifted[row, np.uintp(n)]
            place = np.uintp(bases[row] + n - start)
            for t in range(len(taps)):
                flat[place + np.uintp(t)] += value * weights[np.uintp(t * CHUNK + n)]


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


@njit(cache=True, nogil=True, fastmath={"contract"})
def spread_edge(lifted, weights, start, stop, taps, mid, field, x, y, z, periodic):
    """As `spread` where a run crosses an edge: wraps, or returns the strength that is lost."""
    nx, nm, nc = field.shape
    lost = field.dtype.type(0)
    for a in range(len(taps)):
        i = row_of(x + a, nx, periodic[0], False)
        for b in range(len(mid)):
            m = row_of(y + b, nm, periodic[1], False) if len(mid) > 1 else 0
            source = lifted[a * len(mid) + b]
            for n in range(start, stop):
                for t in range(len(taps)):
                    j = row_of(z + n - start + t, nc, periodic[2], False)
                    value = source[n] * weights[t * CHUNK + n]
                    if i >= 0 and m >= 0 and j >= 0:
                        field[i, m, j] += value
                    else:
                        lost += value
    return lost


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather(flat, bases, first, middle, last, start, stop, taps, mid, target):
    """target[n] = sum of weights times field over the stencil, four nodes at a time, for a run.

    ``bases`` are the places in ``flat`` of the stencil's rows for the node ``start``.
    """
    n = start
    while n < stop:
        if n + 4 > stop:
            n = stop - 4  # the same values again: the run is at least four nodes long
        k = np.uintp(n)
        zero = flat.dtype.type(0)
        s0 = s1 = s2 = s3 = zero
        for a in range(len(taps)):
            u0 = u1 = u2 = u3 = zero
            for b in range(len(mid)):
                place = np.uintp(bases[a * len(mid) + b] + n - start)
                v0 = v1 = v2 = v3 = zero
                for c in range(len(taps)):
                    w = np.uintp(c * CHUNK + n)
                    f = place + np.uintp(c)
                    v0 += last[w] * flat[f]
                    v1 += last[w + ONE] * flat[f + ONE]
                    v2 += last[w + TWO] * flat[f + TWO]
                    v3 += last[w + THREE] * flat[f + THREE]
                if len(mid) > 1:
                    w = np.uintp(b * CHUNK + n)
                    v0 *= middle[w]
                    v1 *= middle[w + ONE]
                    v2 *= middle[w + TWO]
                    v3 *= middle[w + THREE]
                u0 += v0
                u1 += v1
                u2 += v2
                u3 += v3
            w = np.uintp(a * CHUNK + n)
            s0 += first[w] * u0
            s1 += first[w + ONE] * u1
            s2 += first[w + TWO] * u2
            s3 += first[w + THREE] * u3
        target[k] = s0
        target[k + ONE] = s1
        target[k + TWO] = s2
        target[k + THREE] = s3
        n += 4


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def gather_short(flat, bases, first, middle, last, start, stop, taps, mid, target):
    """As `gather` for runs of fewer than four nodes."""
    for n in range(start, stop):
        total = flat.dtype.type(0)
        for a in range(len(taps)):
            across = flat.dtype.type(0)
            for b in range(len(mid)):
                place = np.uintp(bases[a * len(mid) + b] + n - start)
                along = flat.dtype.type(0)
                for c in range(len(taps)):
                    along += last[np.uintp(c * CHUNK + n)] * flat[place + np.uintp(c)]
                if len(mid) > 1:
                    along *= middle[np.uintp(b * CHUNK + n)]
                across += along
            total += first[np.uintp(a * CHUNK + n)] * across
        target[n] = total


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather_edge(
    field, first, middle, last, start, stop, taps, mid, x, y, z, periodic, clamps, target
):
    """As `gather` for short runs and where a run crosses an edge; it starts at node x, y, z."""
    nx, nm, nc = field.shape
    for n in range(start, stop):
        total = field.dtype.type(0)
        for a in range(len(taps)):
            i = row_of(x + a, nx, periodic[0], clamps)
            for b in range(len(mid)):
                m = row_of(y + b, nm, periodic[1], clamps) if len(mid) > 1 else 0
                if i < 0 or m < 0:
                    continue
                line = first[a * CHUNK + n]
                if len(mid) > 1:
                    line *= middle[b * CHUNK + n]
                for c in range(len(taps)):
                    j = row_of(z + n - start + c, nc, periodic[2], clamps)
                    if j >= 0:
                        total += line * (last[c * CHUNK + n] * field[i, m, j])
        target[n] = total


@njit(cache=True, nogil=True)
def any_value(source):
    """Whether a piece of a row holds anything but zeros."""
    used = 0
    for n in range(source.size):
        used |= source[n] != 0
    return used != 0


@njit(cache=True, nogil=True)
def runs(count, columns, left, cells_a, cells_b, cells_c, column, changes, starts):
    """Starts of the runs of equal whole cells on one side of the edges; returns how many."""
    for n in range(1, count):
        here = column + n + np.int64(cells_c[n]) - left
        there = column + n - 1 + np.int64(cells_c[n - 1]) - left
        edge = (here < 0) ^ (there < 0) | (here < columns) ^ (there < columns)
        same = (cells_a[n] == cells_a[n - 1]) & (cells_b[n] == cells_b[n - 1])
        changes[n] = edge | (cells_c[n] != cells_c[n - 1]) | ~same
    found = 1
    starts[0] = 0
    for n in range(1, count):
        starts[found] = n
        found += changes[n]
    starts[found] = count
    return found


@njit(cache=True, nogil=True)
def find_rows(x, y, z, shape, periodic, clamps, taps, mid, bases):
    """Places in the flat field of a stencil's rows from x, y, z on; false if one is missing."""
    nx, nm, nc = shape
    whole = True
    for a in range(len(taps)):
        i = row_of(x + a, nx, periodic[0], clamps)
        for b in range(len(mid)):
            m = row_of(y + b, nm, periodic[1], clamps) if len(mid) > 1 else 0
            whole &= i >= 0 and m >= 0
            bases[a * len(mid) + b] = (i * nm + m) * nc + z
    return whole


@njit(cache=True, nogil=True, fastmath={"contract"})
def lift(source, first, middle, taps, mid, lifted):
    """source * weights of tap a on the first axis * those of tap b on the middle axis, all a, b."""
    for a in range(len(taps)):
        for b in range(len(mid)):
            row = lifted[a * len(mid) + b]
            left = first[a * CHUNK : (a + 1) * CHUNK]
            right = middle[b * CHUNK : (b + 1) * CHUNK]
            if len(mid) > 1:
                for n in range(source.size):
                    row[n] = source[n] * left[n] * right[n]
            else:
                for n in range(source.size):
                    row[n] = source[n] * left[n]
