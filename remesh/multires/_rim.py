"""Compiled loops where a refined region ends: which nodes moved particles leave incomplete.

Layout as in `_travel`. Regions of a level end where a neighbour is absent; bit 1 of a node in a
tile tells that a particle reaches it, bit 2 that one does which came from an end of its region.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

INNER, OUTER = np.uint8(1), np.uint8(3)


@njit(cache=True, nogil=True)
def near_ends(neighbours, absent, depth, near):
    """Mark the nodes (nx, nm, nc) of a block up to ``depth`` nodes from a neighbour not there."""
    nx, nm, nc = near.shape
    near[:] = False
    sides = 3 if neighbours.size == 27 else 1
    found = False
    for a in range(3):
        for b in range(sides):
            for c in range(3):
                if neighbours[(a * sides + b) * 3 + c] != absent:
                    continue
                found = True
                i0, i1 = strip(a, nx, depth)
                m0, m1 = strip(b if sides == 3 else 1, nm, depth)
                k0, k1 = strip(c, nc, depth)
                near[i0:i1, m0:m1, k0:k1] = True
    return found


@njit(cache=True, nogil=True)
def strip(side, nodes, depth):
    """The nodes along an axis next to the lower side 0, the upper side 2; all for 1."""
    return nodes - depth if side == 2 else 0, depth if side == 0 else nodes


@njit(cache=True, nogil=True)
def concerned(heads, pairs, ends, sources):
    """Mark in ``sources`` the blocks that reach a target which a block at an end reaches too."""
    for t in range(heads.size - 1):
        found = False
        for p in range(heads[t], heads[t + 1]):
            found |= ends[pairs[p, 0]]
        if found:
            for p in range(heads[t], heads[t + 1]):
                sources[pairs[p, 0]] = True


@njit(cache=True, nogil=True)
def mark(
    first, pieces, step, size, sources, neighbours, absent, depth, moves, inverse, width,
    shifts, sizes, offsets, tiles,
):  # fmt: skip
    """In the tile of each block concerned: which nodes are reached, and which from an end."""
    parts, blocks, nx, nm, nc = moves.shape
    near = np.empty((nx, nm, nc), np.bool_)
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            if not sources[b]:
                continue
            tile = tiles[offsets[b] : offsets[b + 1]]
            tile[:] = 0
            near_ends(neighbours[b], absent, depth, near)
            ty, tz = sizes[b, 1], sizes[b, 2]
            for i in range(nx):
                for m in range(nm):
                    for k in range(nc):
                        x = i + np.int64(np.floor(moves[0, b, i, m, k] * inverse[b]))
                        z = k + np.int64(np.floor(moves[parts - 1, b, i, m, k] * inverse[b]))
                        place = (x - shifts[b, 0]) * ty * tz + z - shifts[b, 2]
                        if parts == 3:
                            y = m + np.int64(np.floor(moves[1, b, i, m, k] * inverse[b]))
                            place += (y - shifts[b, 1]) * tz
                        tile[place] |= OUTER if near[i, m, k] else INNER
            dilate(tile, 1, sizes[b, 0], ty * tz, width)
            if parts == 3:
                dilate(tile, sizes[b, 0], ty, tz, width)
            dilate(tile, sizes[b, 0] * ty, tz, 1, width)


@njit(cache=True, nogil=True)
def dilate(tile, outer, nodes, inner, width):
    """Along the middle axis of a flat tile: each node also tells for the ``width`` - 1 after it."""
    done = 1
    while done < width:
        shift = min(done, width - done)
        for o in range(outer):
            line = tile[o * nodes * inner : (o + 1) * nodes * inner]
            for n in range(line.size - 1, shift * inner - 1, -1):
                line[n] |= line[n - shift * inner]
        done += shift


@njit(cache=True, nogil=True)
def incomplete(
    first, pieces, step, size, whole, levels, heads, pairs, ends, neighbours, absent, depth, sizes,
    offsets, tiles, mask,
):  # fmt: skip
    """Mark the nodes of the targets whose values must come from coarser ones.

    ``whole`` tells the levels that covered the whole domain: what does not arrive there is zero.
    """
    blocks = mask.shape[0]
    for piece in range(first, pieces, step):
        for t in range(piece * size, min((piece + 1) * size, blocks)):
            if heads[t] == heads[t + 1] and not whole[levels[t]]:
                mask[t] = True
                continue
            near_ends(neighbours[t], absent, depth, mask[t])
            found = False
            for p in range(heads[t], heads[t + 1]):
                found |= ends[pairs[p, 0]]
            if found:
                fold(t, heads, pairs, sizes, offsets, tiles, mask[t])


@njit(cache=True, nogil=True)
def fold(t, heads, pairs, sizes, offsets, tiles, mask):
    """Mark what no particle reaches on a target, or one that comes from an end."""
    nx, nm, nc = mask.shape
    seen = np.zeros((nx, nm, nc), np.uint8)
    for p in range(heads[t], heads[t + 1]):
        b, x, y, z = pairs[p]
        tx, ty, tz = sizes[b]
        begin, end = max(0, -z), min(nc, tz - z)
        for i in range(max(0, -x), min(nx, tx - x)):
            for m in range(max(0, -y), min(nm, ty - y)):
                place = offsets[b] + ((i + x) * ty + m + y) * tz + z
                for k in range(begin, end):
                    seen[i, m, k] |= tiles[place + k]
    for i in range(nx):
        for m in range(nm):
            for k in range(nc):
                mask[i, m, k] |= seen[i, m, k] != INNER


@njit(cache=True, nogil=True)
def gather_coarse(values, coarser, place, half, margin, outside, patch):
    """Copy the coarser nodes under a block and ``margin`` around; zero where there are none."""
    nx, nm, nc = values.shape[1:]
    px, pm, pc = patch.shape
    sides = 3 if coarser.size == 27 else 1
    for i in range(px):
        a = side_of(i, half, margin)
        x = (place[0] * half - margin + i) % nx
        for m in range(pm):
            b = side_of(m, half, margin) if sides == 3 else 0
            y = (place[1] * half - margin + m) % nm if sides == 3 else 0
            for c in range(3):
                k0 = 0 if c == 0 else (margin if c == 1 else margin + half)
                k1 = margin if c == 0 else (margin + half if c == 1 else pc)
                block = coarser[(a * sides + b) * 3 + c]
                z = (place[place.size - 1] * half - margin + k0) % nc
                if block == outside:
                    patch[i, m, k0:k1] = 0
                else:
                    patch[i, m, k0:k1] = values[block, x, y, z : z + k1 - k0]


@njit(cache=True, nogil=True, inline="always")
def side_of(index, half, margin):
    """0, 1 or 2: on which neighbour's footprint a coarser node lies."""
    return 0 if index < margin else (1 if index < margin + half else 2)


@njit(cache=True, nogil=True, fastmath={"contract"})
def refine(source, outer, coarse, inner, weights, target):
    """Subdivide the middle axis of ``source`` (outer, coarse + margins, inner), flat arrays."""
    half = weights.size // 2
    wide = coarse + 2 * half
    for o in range(outer):
        for n in range(coarse):
            even = target[(o * 2 * coarse + 2 * n) * inner : (o * 2 * coarse + 2 * n + 1) * inner]
            odd = target[
                (o * 2 * coarse + 2 * n + 1) * inner : (o * 2 * coarse + 2 * n + 2) * inner
            ]
            start = (o * wide + n + half) * inner
            for k in range(inner):
                even[k] = source[start + k]
                odd[k] = 0
            for t in range(weights.size):
                start = (o * wide + n + 1 + t) * inner
                for k in range(inner):
                    odd[k] += weights[t] * source[start + k]


@njit(cache=True, nogil=True)
def fill(
    first, pieces, step, size, start, stop, mask, places, coarser, outside, weights, values
):  # fmt: skip
    """Give marked nodes of the blocks ``start`` to ``stop`` - 1 what the coarser level predicts."""
    _, nx, nm, nc = values.shape
    margin, half = weights.size // 2, nc // 2
    wide = half + 2 * margin
    middle = wide if nm > 1 else 1
    patch = np.empty((wide, middle, wide), values.dtype)
    one = np.empty(nx * middle * wide, values.dtype)
    two = np.empty(nx * nm * wide, values.dtype)
    three = np.empty((nx, nm, nc), values.dtype)
    flat = patch.reshape(patch.size)
    for piece in range(first, pieces, step):
        for b in range(start + piece * size, min(start + (piece + 1) * size, stop)):
            if not mask[b].any():
                continue
            gather_coarse(values, coarser[b], places[b], half, margin, outside, patch)
            refine(flat, 1, half, middle * wide, weights, one)
            if nm > 1:
                refine(one, nx, half, wide, weights, two)
                refine(two, nx * nm, half, 1, weights, three.reshape(three.size))
            else:
                refine(one, nx, half, 1, weights, three.reshape(three.size))
            for i in range(nx):
                for m in range(nm):
                    for k in range(nc):
                        if mask[b, i, m, k]:
                            values[b, i, m, k] = three[i, m, k]
