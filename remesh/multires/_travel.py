"""Compiled loops of remeshing on an adaptive mesh: blocks scatter to tiles, targets collect them.

Blocks are ``(n, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node and
one tap, so that one text serves 2-D and 3-D. The tile of a source block is the box of nodes of its
level that its moved particles reach: ``low`` is its first node, counted from the origin of the
mesh and never wrapped, ``sizes`` its edges, ``offsets`` where it begins in the flat tiles.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows
from remesh._rows import CHUNK, any_value, weigh
from remesh.compiled import drop_stale
from remesh.layout import FAR
from remesh.multires import _hashing
from remesh.multires._hashing import find

drop_stale(__file__, _rows.__file__, _hashing.__file__)


@njit(cache=True, nogil=True)
def reach(first, pieces, step, size, moves, inverse, numbers, low, high, bad):
    """Lowest and highest whole-cell displacement in each row of a block, summed up to a box."""
    parts, blocks, nx, nm, nc = moves.shape
    far = numbers[1]
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            for axis in range(3):
                low[b, axis] = 0
                high[b, axis] = 0
            for part in range(parts):
                axis = 2 if part == parts - 1 else part
                least = np.int64(FAR)
                most = np.int64(-FAR)
                for i in range(nx):
                    for m in range(nm):
                        row = moves[part, b, i, m]
                        lowest = np.int32(FAR)
                        highest = np.int32(-FAR)
                        for k in range(nc):
                            x = row[k] * inverse[b]
                            x = x if abs(x) < far else far
                            n = np.int32(np.floor(x))
                            bad[b] |= n == FAR
                            n += np.int32(k if axis == 2 else 0)
                            lowest = min(lowest, n)
                            highest = max(highest, n)
                        home = np.int64(i if axis == 0 else (m if axis == 1 else 0))
                        least = min(least, home + lowest)
                        most = max(most, home + highest)
                low[b, axis] = least
                high[b, axis] = most


@njit(cache=True, nogil=True)
def meetings(low, sizes, levels, edges, counts, offsets, wraps, keys, values, bits, heads, pairs):
    """Which tiles reach which target blocks.

    Without ``pairs`` counts them, ``heads[t + 1]`` for target t; with ``pairs`` notes them from
    ``heads[t]`` on, by ascending source: source and where in the tile the target begins.
    """
    begin = np.empty(3, np.int64)
    end = np.empty(3, np.int64)
    for b in range(low.shape[0]):
        level = levels[b]
        for axis in range(3):
            begin[axis] = low[b, axis] // edges[axis]
            end[axis] = (low[b, axis] + sizes[b, axis] - 1) // edges[axis]
            if not wraps[axis]:
                begin[axis] = max(begin[axis], 0)
                end[axis] = min(end[axis], counts[level, axis] - 1)
        nx, nm, nc = counts[level]
        for i in range(begin[0], end[0] + 1):
            for m in range(begin[1], end[1] + 1):
                for k in range(begin[2], end[2] + 1):
                    key = ((i % nx) * nm + m % nm) * nc + k % nc
                    target = find(key + offsets[level], keys, values, bits)
                    if target < 0:
                        continue
                    if pairs.size:
                        n = heads[target]
                        pairs[n, 0] = b
                        pairs[n, 1] = i * edges[0] - low[b, 0]
                        pairs[n, 2] = m * edges[1] - low[b, 1]
                        pairs[n, 3] = k * edges[2] - low[b, 2]
                        heads[target] = n + 1
                    else:
                        heads[target + 1] += 1


@njit(cache=True, nogil=True, fastmath={"contract"})
def scatter(
    first, pieces, step, size, values, moves, inverse, numbers, coeffs, taps, mid, terms,
    shifts, sizes, offsets, tiles,
):  # fmt: skip
    """Each block's particles, remeshed into its own tile."""
    blocks, nx, nm, nc = values.shape
    last = moves.shape[0] - 1
    lines = CHUNK // nc
    width = len(taps)
    wa = np.empty(width * CHUNK, values.dtype)
    wb = np.empty(width * CHUNK, values.dtype)
    wc = np.empty(width * CHUNK, values.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, values.dtype)
    scale = np.empty(3, values.dtype)
    scale[1:] = numbers
    own = values.reshape(blocks, nx * nm * nc)
    far = moves.reshape(last + 1, blocks, nx * nm * nc)
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            tile = tiles[offsets[b] : offsets[b + 1]]
            tile[:] = 0
            scale[0] = inverse[b]
            ty, tz = sizes[b, 1], sizes[b, 2]
            for line in range(0, nx * nm, lines):
                rows = min(lines, nx * nm - line)
                part = own[b, line * nc : (line + rows) * nc]
                if not any_value(part):
                    continue
                here = slice(line * nc, (line + rows) * nc)
                weigh(far[0, b, here], scale, coeffs, taps, terms, ka, local, wa)
                if len(mid) > 1:
                    weigh(far[1, b, here], scale, coeffs, taps, terms, kb, local, wb)
                weigh(far[last, b, here], scale, coeffs, taps, terms, kc, local, wc)
                for row in range(rows):
                    i = (line + row) // nm - shifts[b, 0]
                    m = (line + row) % nm - shifts[b, 1]
                    for k in range(nc):
                        n = row * nc + k
                        place = ((i + ka[n]) * ty + m + kb[n]) * tz + k + kc[n] - shifts[b, 2]
                        put(tile, place, ty * tz, tz, part[n], n, wa, wb, wc, taps, mid)


@njit(cache=True, nogil=True, fastmath={"contract"}, inline="always")
def put(tile, place, over, across, value, n, wa, wb, wc, taps, mid):
    """One particle's strength times the weights of its taps, from a place in a tile on."""
    for a in range(len(taps)):
        line = value * wa[np.uintp(a * CHUNK + n)]
        for b in range(len(mid)):
            factor = line
            if len(mid) > 1:
                factor = line * wb[np.uintp(b * CHUNK + n)]
            start = np.uintp(place + a * over + b * across)
            for c in range(len(taps)):
                tile[start + np.uintp(c)] += factor * wc[np.uintp(c * CHUNK + n)]


@njit(cache=True, nogil=True)
def collect(first, pieces, step, size, heads, pairs, sizes, offsets, tiles, out):
    """Sum on each target block what the tiles hold there, by ascending source."""
    blocks, nx, nm, nc = out.shape
    for piece in range(first, pieces, step):
        for t in range(piece * size, min((piece + 1) * size, blocks)):
            out[t] = 0
            for p in range(heads[t], heads[t + 1]):
                b, x, y, z = pairs[p]
                tx, ty, tz = sizes[b]
                begin, end = max(0, -z), min(nc, tz - z)
                for i in range(max(0, -x), min(nx, tx - x)):
                    for m in range(max(0, -y), min(nm, ty - y)):
                        place = offsets[b] + ((i + x) * ty + m + y) * tz + z
                        target = out[t, i, m, begin:end]
                        source = tiles[place + begin : place + end]
                        for k in range(target.size):
                            target[k] += source[k]


@njit(cache=True, nogil=True)
def beyond(low, sizes, offsets, tiles, nodes, wraps):
    """Sum over the tiles of what lies beyond unbounded ends; ``nodes`` of the level per axis."""
    lost = 0.0
    for b in range(low.shape[0]):
        whole = True
        for axis in range(3):
            inside = low[b, axis] >= 0 and low[b, axis] + sizes[b, axis] <= nodes[axis]
            whole &= wraps[axis] or inside
        if whole:
            continue
        tx, ty, tz = sizes[b]
        for i in range(tx):
            x = low[b, 0] + i
            over = not wraps[0] and (x < 0 or x >= nodes[0])
            for m in range(ty):
                y = low[b, 1] + m
                across = over or (not wraps[1] and (y < 0 or y >= nodes[1]))
                place = offsets[b] + (i * ty + m) * tz
                for k in range(tz):
                    z = low[b, 2] + k
                    if across or (not wraps[2] and (z < 0 or z >= nodes[2])):
                        lost += tiles[place + k]
    return lost
