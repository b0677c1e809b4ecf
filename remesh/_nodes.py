"""Compiled loops over nodes: rows are cut into runs of equal whole-cell displacement, for SIMD.

Fields are ``(components, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one
node and one tap, so that one text serves 2-D and 3-D. ``taps``, ``mid`` and ``terms`` are tuples
whose lengths (nodes reached per axis, Horner terms) are constants to the compiler.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

CHUNK = 128  # nodes per piece of a row: the weights of all axes stay in the first-level cache
FAR = 1 << 30  # displacements beyond this many cells, or not numbers, are told by this value


@njit(cache=True, nogil=True)
def reach(first, pieces, step, rows, displacement, scale, lowest, highest):
    """Smallest and largest whole-cell displacement in each piece of the rows."""
    far = scale[2]
    size = displacement.size
    for piece in range(first, pieces, step):
        part = displacement[piece * rows : min((piece + 1) * rows, size)]
        low = np.int32(FAR)
        high = np.int32(-FAR)
        for n in range(part.size):
            x = part[n] * scale[0]
            x = x if abs(x) < far else far
            k = np.int32(np.floor(x))
            low = min(low, k)
            high = max(high, k)
        lowest[piece] = low
        highest[piece] = high


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
    """target[k + t] += source[start + k] * weights[t, start + k] for a run that fits in target."""
    width = len(taps)
    if count < width:
        for k in range(count):
            for t in range(width):
                target[k + t] += source[start + k] * weights[t * CHUNK + start + k]
        return
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
def spread_edge(source, weights, start, count, taps, target, column, wraps):
    """As `spread` where the run crosses an edge: wraps, or returns the strength that is lost."""
    size = target.size
    lost = source[0] * 0
    for k in range(count):
        for t in range(len(taps)):
            j = column + k + t
            value = source[start + k] * weights[t * CHUNK + start + k]
            if wraps:
                target[j % size] += value
            elif 0 <= j < size:
                target[j] += value
            else:
                lost += value
    return lost


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather(source, weights, factor, start, count, taps, target):
    """target[start + k] += factor[start + k] * sum over t of weights[t, start + k] source[k+t]."""
    into = target[start : start + count]
    scale = factor[start : start + count]
    for k in range(count):
        total = weights[np.uintp(start + k)] * source[k]
        for t in range(1, len(taps)):
            total += weights[np.uintp(t * CHUNK + start + k)] * source[np.uintp(k + t)]
        into[k] += scale[k] * total


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather_edge(source, weights, factor, start, count, taps, target, column, wraps, clamps):
    """As `gather` where the run crosses an edge: wraps, takes the edge value, or sees zero."""
    size = source.size
    for k in range(count):
        for t in range(len(taps)):
            j = column + k + t
            if wraps:
                j = j % size
            elif clamps:
                j = min(max(j, 0), size - 1)
            elif not 0 <= j < size:
                continue
            target[start + k] += factor[start + k] * (weights[t * CHUNK + start + k] * source[j])


@njit(cache=True, nogil=True)
def run_end(start, count, columns, left, cells_a, cells_b, cells_c, column):
    """End of the run that begins at ``start``: same whole cells, same side of the edges."""
    a = cells_a[start]
    b = cells_b[start]
    c = cells_c[start]
    low = left - c - column  # first node whose stencil begins inside
    if start < low:
        limit = low
    elif start < columns + low:
        limit = columns + low
    else:
        limit = count
    stop = start + 1
    while stop < count and stop < limit:
        if cells_a[stop] != a or cells_b[stop] != b or cells_c[stop] != c:
            break
        stop += 1
    return stop


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
def lift(source, first, middle, a, b, mid, start, stop, target):
    """target = source * weights of tap a on the first axis * those of tap b on the middle axis."""
    for n in range(start, stop):
        target[n] = source[n] * first[np.uintp(a * CHUNK + n)]
    if len(mid) > 1:
        for n in range(start, stop):
            target[n] *= middle[np.uintp(b * CHUNK + n)]


@njit(cache=True, nogil=True, fastmath={"contract"})
def advect(
    first, pieces, step, colour, edges, field, displacement,
    scale, coeffs, taps, mid, terms, periodic, out, dropped, bad,
):  # fmt: skip
    """Every second band of rows, moved and remeshed into ``out``."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, field.dtype)
    part_row = np.empty(CHUNK, field.dtype)
    for piece in range(first, pieces, step):
        band = 2 * piece + colour
        for row in range(edges[band] * nm, edges[band + 1] * nm):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                count = min(CHUNK, nc - column)
                stop = column + count
                used = False
                for p in range(parts):
                    for n in range(column, stop):
                        used |= field[p, i, m, n] != 0
                if not used:
                    continue
                bad[band] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[band] += weigh(
                        displacement[1, i, m, column:stop],
                        scale,
                        coeffs,
                        taps,
                        terms,
                        kb,
                        local,
                        wb,
                    )
                bad[band] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                n0 = 0
                while n0 < count:
                    n1 = run_end(n0, count, nc - width + 1, left, ka, kb, kc, column)
                    start = column + n0 + np.int64(kc[n0]) - left
                    inside = start >= 0 and start + n1 - n0 + width - 1 <= nc
                    for p in range(parts):
                        source = field[p, i, m, column:stop]
                        for a in range(width):
                            x = row_of(i + np.int64(ka[n0]) + a - left, nx, periodic[0], False)
                            for b in range(len(mid)):
                                y = m
                                if len(mid) > 1:
                                    y = row_of(
                                        m + np.int64(kb[n0]) + b - left, nm, periodic[1], False
                                    )
                                lift(source, wa, wb, a, b, mid, n0, n1, part_row)
                                if x < 0 or y < 0:
                                    for n in range(n0, n1):
                                        dropped[band, p] += part_row[n]
                                elif inside:
                                    spread(
                                        part_row,
                                        wc,
                                        n0,
                                        n1 - n0,
                                        taps,
                                        out[p, x, y, start : start + n1 - n0 + width - 1],
                                    )
                                else:
                                    dropped[band, p] += spread_edge(
                                        part_row,
                                        wc,
                                        n0,
                                        n1 - n0,
                                        taps,
                                        out[p, x, y],
                                        start,
                                        periodic[2],
                                    )
                    n0 = n1


@njit(cache=True, nogil=True, fastmath={"contract"})
def sample(
    first, pieces, step, rows, field, displacement,
    scale, coeffs, taps, mid, terms, periodic, clamps, out, bad,
):  # fmt: skip
    """Pieces of ``rows`` rows of ``out``: the field at node + displacement."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, field.dtype)
    ones = np.ones(CHUNK, field.dtype)
    factor = np.empty(CHUNK, field.dtype)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                count = min(CHUNK, nc - column)
                stop = column + count
                bad[piece] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[piece] += weigh(
                        displacement[1, i, m, column:stop],
                        scale,
                        coeffs,
                        taps,
                        terms,
                        kb,
                        local,
                        wb,
                    )
                bad[piece] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                for p in range(parts):
                    for n in range(column, stop):
                        out[p, i, m, n] = 0
                n0 = 0
                while n0 < count:
                    n1 = run_end(n0, count, nc - width + 1, left, ka, kb, kc, column)
                    start = column + n0 + np.int64(kc[n0]) - left
                    inside = start >= 0 and start + n1 - n0 + width - 1 <= nc
                    for a in range(width):
                        x = row_of(i + np.int64(ka[n0]) + a - left, nx, periodic[0], clamps)
                        for b in range(len(mid)):
                            y = m
                            if len(mid) > 1:
                                y = row_of(m + np.int64(kb[n0]) + b - left, nm, periodic[1], clamps)
                            if x < 0 or y < 0:
                                continue
                            lift(ones, wa, wb, a, b, mid, n0, n1, factor)
                            for p in range(parts):
                                target = out[p, i, m, column:stop]
                                if inside:
                                    gather(
                                        field[p, x, y, start : start + n1 - n0 + width - 1],
                                        wc,
                                        factor,
                                        n0,
                                        n1 - n0,
                                        taps,
                                        target,
                                    )
                                else:
                                    gather_edge(
                                        field[p, x, y],
                                        wc,
                                        factor,
                                        n0,
                                        n1 - n0,
                                        taps,
                                        target,
                                        start,
                                        periodic[2],
                                        clamps,
                                    )
                    n0 = n1
