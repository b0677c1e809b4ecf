"""Compiled loops between particles and a mesh, two and three dimensions in one text.

Meshes are ``(components, nx, nm, nc)`` as in `_nodes`; in 2-D the middle axis has one node.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows
from remesh._rows import CHUNK, row_of, weigh
from remesh.compiled import drop_stale

OUTSIDE = -1
NOT_A_NUMBER = -2

drop_stale(__file__, _rows.__file__)


@njit(cache=True, nogil=True)
def locate(
    first, pieces, step, size, positions, origin, slack, scale, shape, periodic, bands, home
):
    """Band of each particle's home row, or a negative mark; a cell's width is ``1 / scale[0]``.

    Within ``slack`` cells of an unbounded edge a particle counts as inside.
    """
    ndim = positions.shape[1]
    far = scale[2]
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, positions.shape[0])):
            mark = 0
            for axis in range(ndim):
                x = scale.dtype.type(positions[n, axis] - origin[axis]) * scale[0]
                if not abs(x) < far:
                    mark = NOT_A_NUMBER
                elif not periodic[axis] and not (x >= -slack and x <= shape[axis] - 1 + slack):
                    mark = min(mark, OUTSIDE)
                if axis == 0 and mark == 0:
                    row = np.int64(np.floor(x))
                    mark = bands[row % shape[0] if periodic[0] else max(row, 0)]
            home[n] = mark


@njit(cache=True, nogil=True)
def sort(home, bands, starts, order):
    """Stable counting sort of particles by band; marked particles are left out."""
    counts = np.zeros(bands + 1, np.int64)
    for n in range(home.size):
        if home[n] >= 0:
            counts[home[n] + 1] += 1
    for band in range(bands):
        counts[band + 1] += counts[band]
    starts[:] = counts
    for n in range(home.size):
        band = home[n]
        if band >= 0:
            order[counts[band]] = n
            counts[band] += 1


@njit(cache=True, nogil=True, fastmath={"contract"})
def load(order, begin, end, positions, axis, origin, buffer):
    """Distances of some particles from the first node along one axis, rounded only then."""
    for n in range(begin, end):
        buffer[n - begin] = positions[order[n], axis] - origin[axis]


@njit(cache=True, nogil=True, fastmath={"contract"})
def scatter(
    first, pieces, step, colour, starts, order, positions, strengths, origin,
    scale, coeffs, taps, mid, terms, periodic, out, dropped,
):  # fmt: skip
    """The particles of every second band onto the mesh ``out``; what misses it into ``dropped``."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = out.shape
    last = positions.shape[1] - 1
    wa = np.empty(width * CHUNK, out.dtype)
    wb = np.empty(width * CHUNK, out.dtype)
    wc = np.empty(width * CHUNK, out.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, out.dtype)
    buffer = np.empty(CHUNK, out.dtype)
    for piece in range(first, pieces, step):
        band = 2 * piece + colour
        for begin in range(starts[band], starts[band + 1], CHUNK):
            end = min(begin + CHUNK, starts[band + 1])
            count = end - begin
            load(order, begin, end, positions, 0, origin, buffer)
            weigh(buffer[:count], scale, coeffs, taps, terms, ka, local, wa)
            if len(mid) > 1:
                load(order, begin, end, positions, 1, origin, buffer)
                weigh(buffer[:count], scale, coeffs, taps, terms, kb, local, wb)
            load(order, begin, end, positions, last, origin, buffer)
            weigh(buffer[:count], scale, coeffs, taps, terms, kc, local, wc)
            for k in range(count):
                z = np.int64(kc[k]) - left
                inside = z >= 0 and z + width <= nc
                for p in range(parts):
                    strength = strengths[order[begin + k], p]
                    for a in range(width):
                        i = row_of(np.int64(ka[k]) + a - left, nx, periodic[0], False)
                        for b in range(len(mid)):
                            y = np.int64(kb[k]) + b - left if len(mid) > 1 else 0
                            m = row_of(y, nm, periodic[1], False)
                            line = strength * wa[np.uintp(a * CHUNK + k)]
                            if len(mid) > 1:
                                line *= wb[np.uintp(b * CHUNK + k)]
                            if i < 0 or m < 0:
                                dropped[band, p] += line
                            elif inside:
                                target = out[p, i, m]
                                for c in range(width):
                                    w = wc[np.uintp(c * CHUNK + k)]
                                    target[np.uintp(z + c)] += line * w
                            else:
                                for c in range(width):
                                    j = row_of(z + c, nc, periodic[2], False)
                                    value = line * wc[c * CHUNK + k]
                                    if j >= 0:
                                        out[p, i, m, j] += value
                                    else:
                                        dropped[band, p] += value


@njit(cache=True, nogil=True, fastmath={"contract"})
def gather(
    first, pieces, step, size, home, positions, origin,
    scale, coeffs, taps, mid, terms, periodic, field, values,
):  # fmt: skip
    """The field at the particles of each piece; zero beyond an edge and for marked particles."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = positions.shape[1] - 1
    total_count = positions.shape[0]
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, field.dtype)
    buffer = np.empty(CHUNK, field.dtype)
    for piece in range(first, pieces, step):
        for begin in range(piece * size, min((piece + 1) * size, total_count), CHUNK):
            end = min(begin + CHUNK, (piece + 1) * size, total_count)
            count = end - begin
            for axis in range(positions.shape[1]):
                for k in range(count):
                    buffer[k] = positions[begin + k, axis] - origin[axis]
                if axis == 0:
                    weigh(buffer[:count], scale, coeffs, taps, terms, ka, local, wa)
                elif axis == last:
                    weigh(buffer[:count], scale, coeffs, taps, terms, kc, local, wc)
                else:
                    weigh(buffer[:count], scale, coeffs, taps, terms, kb, local, wb)
            for k in range(count):
                z = np.int64(kc[k]) - left
                inside = z >= 0 and z + width <= nc
                for p in range(parts):
                    total = field.dtype.type(0)
                    for a in range(width):
                        i = row_of(np.int64(ka[k]) + a - left, nx, periodic[0], False)
                        for b in range(len(mid)):
                            y = np.int64(kb[k]) + b - left if len(mid) > 1 else 0
                            m = row_of(y, nm, periodic[1], False)
                            if i < 0 or m < 0 or home[begin + k] < 0:
                                continue
                            along = field.dtype.type(0)
                            if inside:
                                row = field[p, i, m]
                                for c in range(width):
                                    along += wc[np.uintp(c * CHUNK + k)] * row[np.uintp(z + c)]
                            else:
                                for c in range(width):
                                    j = row_of(z + c, nc, periodic[2], False)
                                    if j >= 0:
                                        along += wc[c * CHUNK + k] * field[p, i, m, j]
                            line = wa[np.uintp(a * CHUNK + k)]
                            if len(mid) > 1:
                                line *= wb[np.uintp(b * CHUNK + k)]
                            total += line * along
                    values[begin + k, p] = total
