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
ONE, TWO, THREE = np.uintp(1), np.uintp(2), np.uintp(3)  # unsigned: no test for negative indices
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
    lost = source.dtype.type(0)
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


@njit(cache=True, nogil=True, fastmath={"contract"})
def advect(
    first, pieces, step, colour, edges, field, displacement,
    scale, coeffs, taps, mid, terms, periodic, out, dropped, bad,
):  # fmt: skip
    """Every second band of rows, moved and remeshed into ``out``."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    wa, wb, wc = np.empty((3, width * CHUNK), field.dtype)
    lifted = np.empty((width * len(mid), CHUNK), field.dtype)
    ka, kb, kc = np.zeros((3, CHUNK), np.int32)
    local = np.empty(CHUNK, field.dtype)
    changes = np.empty(CHUNK, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
    for piece in range(first, pieces, step):
        band = 2 * piece + colour
        for row in range(edges[band] * nm, edges[band + 1] * nm):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                stop = min(column + CHUNK, nc)
                used = False
                for p in range(parts):
                    for n in range(column, stop):
                        used |= field[p, i, m, n] != 0
                if not used:
                    continue
                move = displacement[:, i, m, column:stop]
                bad[band] += weigh(move[0], scale, coeffs, taps, terms, ka, local, wa)
                if len(mid) > 1:
                    bad[band] += weigh(move[1], scale, coeffs, taps, terms, kb, local, wb)
                bad[band] += weigh(move[-1], scale, coeffs, taps, terms, kc, local, wc)
                found = runs(
                    stop - column, nc - width + 1, left, ka, kb, kc, column, changes, starts
                )
                for p in range(parts):
                    lift(field[p, i, m, column:stop], wa, wb, taps, mid, lifted)
                    for r in range(found):
                        n0, n1 = starts[r], starts[r + 1]
                        length = n1 - n0 + width - 1
                        z = column + n0 + np.int64(kc[n0]) - left
                        for a in range(width):
                            x = row_of(i + np.int64(ka[n0]) + a - left, nx, periodic[0], False)
                            for b in range(len(mid)):
                                y = m + np.int64(kb[n0]) + b - left if len(mid) > 1 else 0
                                y = row_of(y, nm, periodic[1], False)
                                source = lifted[a * len(mid) + b]
                                if x < 0 or y < 0:
                                    for n in range(n0, n1):
                                        dropped[band, p] += source[n]
                                elif z >= 0 and z + length <= nc:
                                    target = out[p, x, y, z : z + length]
                                    spread(source, wc, n0, n1 - n0, taps, target)
                                else:
                                    dropped[band, p] += spread_edge(
                                        source, wc, n0, n1 - n0, taps, out[p, x, y], z, periodic[2]
                                    )


@njit(cache=True, nogil=True, fastmath={"contract"})
def sample(
    first, pieces, step, rows, field, displacement,
    scale, coeffs, taps, mid, terms, periodic, clamps, out, bad,
):  # fmt: skip
    """Pieces of ``rows`` rows of ``out``: the field at node + displacement."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    flat = field.reshape(field.size)
    wa, wb, wc = np.empty((3, width * CHUNK), field.dtype)
    ka, kb, kc = np.zeros((3, CHUNK), np.int32)
    local = np.empty(CHUNK, field.dtype)
    changes = np.empty(CHUNK, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
    bases = np.empty(width * len(mid), np.int64)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                stop = min(column + CHUNK, nc)
                move = displacement[:, i, m, column:stop]
                bad[piece] += weigh(move[0], scale, coeffs, taps, terms, ka, local, wa)
                if len(mid) > 1:
                    bad[piece] += weigh(move[1], scale, coeffs, taps, terms, kb, local, wb)
                bad[piece] += weigh(move[-1], scale, coeffs, taps, terms, kc, local, wc)
                found = runs(
                    stop - column, nc - width + 1, left, ka, kb, kc, column, changes, starts
                )
                for r in range(found):
                    n0, n1 = starts[r], starts[r + 1]
                    x = i + np.int64(ka[n0]) - left
                    y = m + np.int64(kb[n0]) - left if len(mid) > 1 else 0
                    z = column + n0 + np.int64(kc[n0]) - left
                    inside = n1 - n0 >= 4 and z >= 0 and z + n1 - n0 + width - 1 <= nc
                    for a in range(width):
                        for b in range(len(mid)):
                            u = row_of(x + a, nx, periodic[0], clamps)
                            v = row_of(y + b, nm, periodic[1], clamps)
                            inside &= u >= 0 and v >= 0
                            bases[a * len(mid) + b] = (u * nm + v) * nc + z
                    for p in range(parts):
                        target = out[p, i, m, column:stop]
                        if inside:
                            part = flat[p * nx * nm * nc : (p + 1) * nx * nm * nc]
                            gather(part, bases, wa, wb, wc, n0, n1, taps, mid, target)
                        else:
                            gather_edge(
                                field[p], wa, wb, wc, n0, n1, taps, mid, x, y, z, periodic,
                                clamps, target,
                            )  # fmt: skip
