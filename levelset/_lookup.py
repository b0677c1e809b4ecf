"""Compiled loops of level sets on particles: nodes look up the map of the particles.

Meshes are ``(nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node and one
tap, so that one text serves 2-D and 3-D. ``taps``, ``mid`` (of the middle axis) and ``pair`` (a
cell's corners along it) are tuples whose lengths, constants to the compiler, are what counts.
Positions are ``(n, ndim)``, in spacings from the first node.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from levelset import _lattice
from levelset._lattice import corners, invert, stretch, wrapped
from remesh.compiled import drop_stale

TRIES = 8  # Newton steps
CLOSE = 1e-5  # spacings: what is left is taken off along the cell's gradient, to a tenth and better
SLACK = 1e-9  # spacings by which a place may lie outside its cell
FLAT = 0.9999  # of the level value: what is above is flat
MARGIN = 0.3  # spacings around a cell from which Newton starts, at most
LEAST = 0.02  # and at least
LONGEST = 255  # run of neighbours that is told

drop_stale(__file__, _lattice.__file__)


@njit(cache=True, nogil=True)
def lay(first, pieces, step, size, nodes, positions, values, shape, known, fields):
    """Displacements and values of particles to their home nodes, side by side in the last axis.

    ``known``: how many nodes from here on along the last axis hold particles, 0 without one here.
    """
    ndim = positions.shape[1]
    columns = shape[2]
    marks = known.reshape(known.size)
    flat = fields.reshape(known.size, ndim + 1)
    for piece in range(first, pieces, step):
        stop = min((piece + 1) * size, nodes.size)
        p = stop
        while p < nodes.size and p < stop + LONGEST:
            if nodes[p] != nodes[p - 1] + 1 or nodes[p] % columns == 0:
                break
            p += 1
        run = p - stop
        for back in range(stop - piece * size):
            p = stop - 1 - back
            node = nodes[p]
            i = node // (shape[1] * columns)
            m = (node // columns) % shape[1]
            c = node % columns
            if back and (nodes[p + 1] != node + 1 or c == columns - 1):
                run = 0
            run = min(run + 1, LONGEST)
            marks[node] = run
            flat[node, 0] = positions[p, 0] - i
            if ndim == 3:
                flat[node, 1] = positions[p, 1] - m
            flat[node, ndim - 1] = positions[p, ndim - 1] - c
            flat[node, ndim] = values[p]


@njit(cache=True, nogil=True)
def weigh(s, coeffs, taps, terms, weights):
    """Weights of the taps at s, from the middle of a cell in spacings."""
    half = len(taps) // 2
    square = s * s
    for i in range(half):
        base = 2 * i * len(terms)
        even = coeffs[base + len(terms) - 1]
        odd = coeffs[base + 2 * len(terms) - 1]
        for k in range(1, len(terms)):
            even = even * square + coeffs[base + len(terms) - 1 - k]
            odd = odd * square + coeffs[base + 2 * len(terms) - 1 - k]
        odd = odd * s
        weights[half - 1 - i] = even + odd
        weights[half + i] = even - odd


@njit(cache=True, nogil=True)
def find_stencil(i, m, c, shape, periodic, left, marks, flat, taps, mid, copied):
    """Where the stencil of a cell begins, strides of its planes and lines; -1 if not all is known.

    Across a periodic edge it is copied, and -2 is where it begins.
    """
    width = len(taps)
    columns, row = shape[2], shape[1] * shape[2]
    deep = len(mid) > 1
    inside = i >= left and i - left + width <= shape[0]
    inside &= c >= left and c - left + width <= columns
    if deep:
        inside &= m >= left and m - left + width <= shape[1]
    if inside:
        start = (i - left) * row + (m - left if deep else 0) * columns + c - left
        for a in range(width):
            for b in range(len(mid)):
                if marks[start + a * row + b * columns] < width:
                    return -1, row, columns
        return start, row, columns
    k = 0
    for a in range(width):
        x = wrapped(i + a - left, shape[0], periodic[0])
        for b in range(len(mid)):
            y = wrapped(m + b - left, shape[1], periodic[1]) if deep else 0
            for d in range(width):
                z = wrapped(c + d - left, columns, periodic[2])
                if x < 0 or y < 0 or z < 0 or marks[x * row + y * columns + z] == 0:
                    return -1, row, columns
                copied[k] = flat[x * row + y * columns + z]
                k += 1
    return -2, width * len(mid), width


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def blend(flat, start, plane, line, wa, wb, wc, taps, mid):
    """Displacement along the first, the middle and the last axis and value at a place of a cell."""
    width = len(taps)
    x = y = z = v = 0.0
    for a in range(width):
        ax = ay = az = av = 0.0
        for b in range(len(mid)):
            begin = start + a * plane + b * line
            near = flat[begin : begin + width]
            bx = by = bz = bv = 0.0
            for t in range(width):
                if len(mid) > 1:
                    bx += wc[t] * near[t, 0]
                    by += wc[t] * near[t, 1]
                    bz += wc[t] * near[t, 2]
                    bv += wc[t] * near[t, 3]
                else:
                    ax += wc[t] * near[t, 0]
                    az += wc[t] * near[t, 1]
                    av += wc[t] * near[t, 2]
            if len(mid) > 1:
                ax += wb[b] * bx
                ay += wb[b] * by
                az += wb[b] * bz
                av += wb[b] * bv
        x += wa[a] * ax
        y += wa[a] * ay
        z += wa[a] * az
        v += wa[a] * av
    return x, y, z, v


@njit(cache=True, nogil=True)
def bend(flat, start, plane, line, taps, mid):
    """How far the middle of a cell is from that of its corners: of pure second differences."""
    left = len(taps) // 2 - 1
    deep = len(mid) > 1
    here = start + left * plane + (left * line if deep else 0) + left
    most = 0.0
    for part in range(3 if deep else 2):
        total = 0.0
        for axis in range(3):
            if axis == 1 and not deep:
                continue
            jump = plane if axis == 0 else (line if axis == 1 else 1)
            total += abs(
                flat[here - jump, part]
                - flat[here, part]
                - flat[here + jump, part]
                + flat[here + 2 * jump, part]
            )
        most = max(most, 0.0625 * total)
    return most


@njit(cache=True, nogil=True)
def all_flat(flat, nodes, last, bound):
    """Whether the level set is flat in a cell, and so says nothing."""
    lowest = highest = flat[nodes[0], last]
    for node in nodes:
        lowest = min(lowest, flat[node, last])
        highest = max(highest, flat[node, last])
    return lowest > bound or highest < -bound


@njit(cache=True, nogil=True)
def look_up(
    first, pieces, step, size, nodes, shape, periodic, known, fields, plateau,
    coeffs, taps, mid, pair, terms, found, values, counts, folds,
):  # fmt: skip
    """Nodes that the images of cells reach, and the values that the map brings them.

    A cell is one between particles, its lowest corner one of ``nodes``; a place X in it goes to
    x(X), interpolated. Newton solves x(X) = node; the value there is interpolated at X. Each piece
    writes its own row of ``found`` and ``values``; a count beyond its length is what it needs.
    """
    width = len(taps)
    left = width // 2 - 1
    ndim = fields.shape[-1] - 1
    deep = len(mid) > 1
    row, columns = shape[1] * shape[2], shape[2]
    marks = known.reshape(known.size)
    flat = fields.reshape(known.size, ndim + 1)
    copied = np.empty((width * width * len(mid), ndim + 1))
    edge = np.empty(4 * len(pair), np.int64)
    wa, wb, wc = np.empty(width), np.empty(width), np.empty(width)
    matrix, inverse = np.empty((4, 3)), np.empty((3, 3))
    center, half = np.empty(3), np.empty(3)
    for piece in range(first, pieces, step):
        count = 0
        folded = 0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            i, m, c = nodes[p] // row, (nodes[p] // columns) % shape[1], nodes[p] % columns
            if not corners(nodes[p], i, m, c, shape, periodic, marks, pair, edge):
                continue
            if all_flat(flat, edge, ndim, FLAT * plateau):
                continue
            off = stretch(flat, edge, i, m, c, pair, matrix, center, half)
            if not invert(matrix, inverse) > 0.0:
                folded += 1
                continue
            start, plane, line = find_stencil(
                i, m, c, shape, periodic, left, marks, flat, taps, mid, copied
            )
            source, full = flat, start != -1
            if start == -2:
                source, start = copied, 0
            margin = MARGIN
            if full:
                off += bend(source, start, plane, line, taps, mid)
                size_of = 0.0
                for n in range(3):
                    size_of = max(
                        size_of, abs(inverse[n, 0]) + abs(inverse[n, 1]) + abs(inverse[n, 2])
                    )
                margin = min(MARGIN, LEAST + 2.0 * off * size_of)
            bound = 0.5 + margin
            more = 1.0 + 2.0 * margin
            for x in range(
                np.int64(np.ceil(center[0] - more * half[0])),
                np.int64(np.floor(center[0] + more * half[0])) + 1,
            ):
                tx = wrapped(x, shape[0], periodic[0])
                for y in range(
                    np.int64(np.ceil(center[1] - more * half[1])),
                    np.int64(np.floor(center[1] + more * half[1])) + 1,
                ):
                    ty = wrapped(y, shape[1], periodic[1])
                    for z in range(
                        np.int64(np.ceil(center[2] - more * half[2])),
                        np.int64(np.floor(center[2] + more * half[2])) + 1,
                    ):
                        tz = wrapped(z, columns, periodic[2])
                        if tx < 0 or ty < 0 or tz < 0:
                            continue
                        gx, gy, gz = x - center[0], y - center[1], z - center[2]
                        r = inverse[0, 0] * gx + inverse[0, 1] * gy + inverse[0, 2] * gz
                        s = inverse[1, 0] * gx + inverse[1, 1] * gy + inverse[1, 2] * gz
                        t = inverse[2, 0] * gx + inverse[2, 1] * gy + inverse[2, 2] * gz
                        if max(abs(r), abs(s), abs(t)) > bound:
                            continue
                        value = 0.0
                        if full:
                            for _ in range(TRIES):
                                weigh(r, coeffs, taps, terms, wa)
                                weigh(t, coeffs, taps, terms, wc)
                                if deep:
                                    weigh(s, coeffs, taps, terms, wb)
                                dx, dy, dz, value = blend(
                                    source, start, plane, line, wa, wb, wc, taps, mid
                                )
                                gx = x - i - 0.5 - r - dx
                                gy = y - m - 0.5 - s - dy if deep else 0.0
                                gz = z - c - 0.5 - t - dz
                                dr = inverse[0, 0] * gx + inverse[0, 1] * gy + inverse[0, 2] * gz
                                ds = inverse[1, 0] * gx + inverse[1, 1] * gy + inverse[1, 2] * gz
                                dt = inverse[2, 0] * gx + inverse[2, 1] * gy + inverse[2, 2] * gz
                                r, s, t = r + dr, s + ds, t + dt
                                far = max(abs(gx), abs(gy), abs(gz))
                                if far <= CLOSE:
                                    value += matrix[3, 0] * dr + matrix[3, 1] * ds
                                    value += matrix[3, 2] * dt
                                    break
                                if not far < 1.0 or max(abs(r), abs(s), abs(t)) > 0.5 + far:
                                    break
                        else:  # the band's edge: straight between the corners
                            for k in range(4 * len(pair)):
                                part = flat[edge[k], ndim]
                                part *= 0.5 + (2 * (k // (2 * len(pair))) - 1) * r
                                part *= 0.5 + (2 * (k % 2) - 1) * t
                                if deep:
                                    part *= 0.5 + (2 * ((k // 2) % len(pair)) - 1) * s
                                value += part
                        if max(abs(r), abs(s), abs(t)) > 0.5 + SLACK:
                            continue
                        if count < found.shape[1]:
                            found[piece, count] = tx * row + ty * columns + tz
                            values[piece, count] = min(max(value, -plateau), plateau)
                        count += 1
        counts[piece] = count
        folds[piece] = folded


@njit(cache=True, nogil=True)
def merge(found, values, counts, marks, level, nodes):
    """Values to their nodes, the first piece's where two agree; returns how many nodes."""
    total = 0
    for piece in range(counts.size):
        for k in range(counts[piece]):
            node = found[piece, k]
            if marks[node] == 0:
                marks[node] = 1
                level[node] = values[piece, k]
                nodes[total] = node
                total += 1
    return total
