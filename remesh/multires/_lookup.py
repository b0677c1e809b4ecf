"""Compiled interpolation on an adaptive mesh at displaced nodes.

Blocks are ``(n, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node and
one tap, so that one text serves 2-D and 3-D. Fields come with ghosts of a kernel's half width.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows
from remesh._rows import CHUNK, weigh
from remesh.compiled import drop_stale
from remesh.multires import _hashing
from remesh.multires._hashing import find

drop_stale(__file__, _rows.__file__, _hashing.__file__)


@njit(cache=True, nogil=True)
def locate(moves, home, inverse, far, whole, fraction):
    """Whole nodes and fractions of a row's places along an axis; ``home`` is their own node.

    The last axis counts up along the row: then ``home`` is that of its first node. Returns how
    many places are no usable numbers.
    """
    bad = 0
    for n in range(moves.size):
        x = moves[n] * inverse
        x = x if abs(x) < far else far
        cell = np.floor(x)
        rest = x - cell
        up = rest >= 1  # rounded up from a place just below a node
        fraction[n] = 0 if up else rest
        whole[n] = home + np.int64(cell) + up
        bad += x == far
    return bad


@njit(cache=True, nogil=True, inline="always")
def inside(node, nodes, wraps):
    """The node of the mesh that is meant or nearest."""
    if wraps:
        return node if 0 <= node < nodes else node % nodes
    return min(max(node, 0), nodes - 1)


@njit(cache=True, nogil=True)
def interpolate(
    first, pieces, step, size, field, ends, table_keys, table_values, bits, counts, offsets,
    levels, places, moves, inverse, numbers, edges, wraps, coeffs, taps, mid, terms, out, bad,
):  # fmt: skip
    """Fields at the displaced nodes of each source block, from the finest level up to their own."""
    blocks = moves.shape[1]
    last = moves.shape[0] - 1
    nx, nm, nc = edges
    lines = max(1, CHUNK // nc)
    width = len(taps)
    dtype = out.dtype
    w = (
        np.empty(width * CHUNK, dtype), np.empty(width * CHUNK, dtype),
        np.empty(width * CHUNK, dtype),
    )  # fmt: skip
    parts, px, pm, pc = field.shape[0], field.shape[2], field.shape[3], field.shape[4]
    flat = field.reshape(parts, field.shape[1] * px * pm * pc)
    flat_out = out.reshape(parts, blocks, nx * nm * nc)
    whole = np.zeros((3, CHUNK), np.int64)
    fraction = np.zeros((3, CHUNK), dtype)
    waiting = np.empty(CHUNK, np.int64)
    ready = np.empty(CHUNK, np.int64)
    homes = np.empty((CHUNK, 5), np.int64)  # block, first tap on it with ghosts, that in the field
    packed = np.empty(CHUNK, dtype)
    cells = np.empty(CHUNK, np.int32)
    local = np.empty(CHUNK, dtype)
    one = np.ones(3, dtype)
    one[1:] = numbers
    far = numbers[1]
    nodes = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            for line in range(0, nx * nm, lines):
                rows = min(lines, nx * nm - line)
                for row in range(rows):
                    i, m = (line + row) // nm, (line + row) % nm
                    part = slice(row * nc, (row + 1) * nc)
                    x, z = whole[0, part], whole[2, part]
                    bad[b] += locate(
                        moves[0, b, i, m], places[b, 0] * nx + i, inverse[b], far, x,
                        fraction[0, part],
                    )  # fmt: skip
                    if len(mid) > 1:
                        bad[b] += locate(
                            moves[1, b, i, m], places[b, 1] * nm + m, inverse[b], far,
                            whole[1, part], fraction[1, part],
                        )  # fmt: skip
                    bad[b] += locate(
                        moves[last, b, i, m], places[b, 2] * nc, inverse[b], far, z,
                        fraction[2, part],
                    )  # fmt: skip
                    for k in range(nc):
                        z[k] += k
                left = rows * nc
                for n in range(left):
                    waiting[n] = n
                for level in range(levels[b], -1, -1):
                    for axis in range(3):
                        nodes[axis] = counts[level, axis] * edges[axis]
                    found = seek(
                        waiting, left, whole, level, counts, offsets, table_keys, table_values,
                        bits, nodes, edges, wraps, (px, pm, pc), ready, homes,
                    )  # fmt: skip
                    left -= found
                    for axis in range(3):
                        if axis == 1 and len(mid) == 1:
                            continue
                        for n in range(found):
                            packed[n] = fraction[axis, ready[n]]
                        weights = w[0] if axis == 0 else (w[1] if axis == 1 else w[2])
                        weigh(packed[:found], one, coeffs, taps, terms, cells, local, weights)
                    for p in range(out.shape[0]):
                        target = flat_out[p, b, line * nc : (line + rows) * nc]
                        gather(flat[p], found, ready, homes, pm, pc, w, taps, mid, target)
                    for n in range(found):
                        if ends[homes[n, 0]] and cut(whole[:, ready[n]], nodes, wraps, width):
                            for p in range(out.shape[0]):
                                flat_out[p, b, line * nc + ready[n]] = gather_end(
                                    field[p, homes[n, 0]], n, ready[n], whole, homes, nodes, edges,
                                    wraps, w, taps, mid,
                                )  # fmt: skip
                    if left == 0:
                        break
                    for n in range(left):
                        j = waiting[n]
                        for axis in range(3):
                            odd = dtype.type(whole[axis, j] & 1)
                            rest = (fraction[axis, j] + odd) * dtype.type(0.5)
                            up = rest >= 1
                            whole[axis, j] = (whole[axis, j] >> 1) + up
                            fraction[axis, j] = 0 if up else rest


@njit(cache=True, nogil=True)
def seek(
    waiting, left, whole, level, counts, offsets, keys, values, bits, nodes, edges, wraps, shape,
    ready, homes,
):  # fmt: skip
    """Move the places that lie on a block of this level from ``waiting`` to ``ready``."""
    found = 0
    kept = 0
    place_x = place_y = place_z = np.int64(-1)
    number = np.int32(-1)
    for n in range(left):
        j = waiting[n]
        x = inside(whole[0, j], nodes[0], wraps[0])
        y = inside(whole[1, j], nodes[1], wraps[1])
        z = inside(whole[2, j], nodes[2], wraps[2])
        a, b, c = x // edges[0], y // edges[1], z // edges[2]
        if a != place_x or b != place_y or c != place_z:
            place_x, place_y, place_z = a, b, c
            key = (a * counts[level, 1] + b) * counts[level, 2] + c + offsets[level]
            number = find(key, keys, values, bits)
        if number < 0:
            waiting[kept] = j
            kept += 1
            continue
        ready[found] = j
        homes[found, 0] = number
        homes[found, 1] = x - a * edges[0] + 1
        homes[found, 2] = y - b * edges[1] + (edges[1] > 1)
        homes[found, 3] = z - c * edges[2] + 1
        homes[found, 4] = (
            (number * shape[0] + homes[found, 1]) * shape[1] + homes[found, 2]
        ) * shape[2] + homes[found, 3]
        found += 1
    return found


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def gather(flat, found, ready, homes, pm, pc, w, taps, mid, target):
    """Sums of weights times the field over the taps of the places found."""
    first, middle, last = w
    for n in range(found):
        total = flat.dtype.type(0)
        place = homes[n, 4]
        for s in range(len(taps)):
            across = flat.dtype.type(0)
            for t in range(len(mid)):
                start = np.uintp(place + (s * pm + t) * pc)
                along = flat.dtype.type(0)
                for u in range(len(taps)):
                    along += last[np.uintp(u * CHUNK + n)] * flat[start + np.uintp(u)]
                if len(mid) > 1:
                    along *= middle[np.uintp(t * CHUNK + n)]
                across += along
            total += first[np.uintp(s * CHUNK + n)] * across
        target[ready[n]] = total


@njit(cache=True, nogil=True)
def cut(node, nodes, wraps, width):
    """Whether taps around a node lie beyond an unbounded end."""
    half = width // 2
    found = False
    for axis in range(3):
        if not wraps[axis] and nodes[axis] > 1:
            found |= node[axis] < half - 1 or node[axis] + half >= nodes[axis]
    return found


@njit(cache=True, nogil=True)
def gather_end(field, n, j, whole, homes, nodes, edges, wraps, w, taps, mid):
    """As `gather` where unbounded ends are near: beyond them the last node's value goes on."""
    total = field.dtype.type(0)
    for s in range(len(taps)):
        x = tap(s, n, j, 0, whole, homes, nodes, edges, wraps, len(taps))
        for t in range(len(mid)):
            y = 0
            factor = w[0][s * CHUNK + n]
            if len(mid) > 1:
                y = tap(t, n, j, 1, whole, homes, nodes, edges, wraps, len(taps))
                factor *= w[1][t * CHUNK + n]
            for u in range(len(taps)):
                z = tap(u, n, j, 2, whole, homes, nodes, edges, wraps, len(taps))
                total += factor * w[2][u * CHUNK + n] * field[x, y, z]
    return total


@njit(cache=True, nogil=True, inline="always")
def tap(t, n, j, axis, whole, homes, nodes, edges, wraps, width):
    """Where tap t lies on its block, ghosts counted, kept within unbounded ends."""
    if wraps[axis]:
        return homes[n, 1 + axis] + t
    half = width // 2
    node = whole[axis, j]
    home = min(max(node, 0), nodes[axis] - 1)
    start = home - (homes[n, 1 + axis] - 1)
    return min(max(node - half + 1 + t, 0), nodes[axis] - 1) - start + half
