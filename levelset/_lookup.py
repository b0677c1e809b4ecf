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

TRIES = 8  # Newton steps
CLOSE = 1e-5  # spacings: the last step then leaves its square times the bend of the map
SLACK = 1e-9  # spacings by which a place may lie outside its cell
FLAT = 0.9999  # of the level value: what is above is flat
MARGIN = 0.3  # spacings around a cell from which Newton starts


@njit(cache=True, nogil=True)
def lay(first, pieces, step, size, nodes, positions, values, shape, known, fields):
    """Displacements and values of particles to their home nodes; ``known`` marks these."""
    ndim = positions.shape[1]
    row = shape[1] * shape[2]
    marks = known.reshape(known.size)
    flat = fields.reshape(fields.shape[0], known.size)
    for piece in range(first, pieces, step):
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            node = nodes[p]
            i = node // row
            m = (node // shape[2]) % shape[1]
            c = node % shape[2]
            marks[node] = 1
            flat[0, node] = positions[p, 0] - i
            if ndim == 3:
                flat[1, node] = positions[p, 1] - m
            flat[ndim - 1, node] = positions[p, ndim - 1] - c
            flat[ndim, node] = values[p]


@njit(cache=True, nogil=True, inline="always")
def wrapped(index, size, periodic):
    """The index on a periodic axis; -1 outside an unbounded one."""
    if 0 <= index < size:
        return index
    return index % size if periodic else -1


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
def find_cell(i, m, c, shape, periodic, left, taps, mid, rows, columns):
    """Rows and columns that a stencil of the cell reads; False where it leaves the mesh."""
    for a in range(len(taps)):
        x = wrapped(i + a - left, shape[0], periodic[0])
        z = wrapped(c + a - left, shape[2], periodic[2])
        if x < 0 or z < 0:
            return False
        columns[a] = z
        for b in range(len(mid)):
            y = wrapped(m + b - left, shape[1], periodic[1]) if len(mid) > 1 else 0
            if y < 0:
                return False
            rows[a * len(mid) + b] = (x * shape[1] + y) * shape[2]
    return True


@njit(cache=True, nogil=True)
def all_known(known, rows, columns, taps, mid):
    """Whether every node of a stencil holds a particle."""
    found = np.uint8(1)
    for line in range(len(taps) * len(mid)):
        for t in range(len(taps)):
            found &= known[rows[line] + columns[t]]
    return found == 1


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def blend(field, rows, columns, whole, wa, wb, wc, taps, mid):
    """A field at a place of a cell; ``whole``: its columns follow each other."""
    total = 0.0
    for a in range(len(taps)):
        plane = 0.0
        for b in range(len(mid)):
            start = rows[a * len(mid) + b]
            along = 0.0
            if whole:
                line = field[start + columns[0] : start + columns[0] + len(taps)]
                for t in range(len(taps)):
                    along += wc[t] * line[t]
            else:
                for t in range(len(taps)):
                    along += wc[t] * field[start + columns[t]]
            if len(mid) > 1:
                plane += wb[b] * along
            else:
                plane += along
        total += wa[a] * plane
    return total


@njit(cache=True, nogil=True)
def invert(matrix, inverse):
    """Inverse of a 3 x 3 matrix; returns its determinant."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for n in range(3):
            p, q = (n + 1) % 3, (n + 2) % 3
            inverse[n, i] = matrix[j, p] * matrix[k, q] - matrix[j, q] * matrix[k, p]
    volume = 0.0
    for n in range(3):
        volume += matrix[0, n] * inverse[n, 0]
    if volume != 0.0:
        for i in range(3):
            for n in range(3):
                inverse[i, n] /= volume
    return volume


@njit(cache=True, nogil=True)
def corners(i, m, c, shape, periodic, known, mid, nodes):
    """Flat indices of a cell's corners, lowest first; False unless all hold particles."""
    for a in range(2):
        for b in range(len(mid)):
            for d in range(2):
                x = wrapped(i + a, shape[0], periodic[0])
                y = wrapped(m + b, shape[1], periodic[1]) if len(mid) > 1 else 0
                z = wrapped(c + d, shape[2], periodic[2])
                if x < 0 or y < 0 or z < 0:
                    return False
                node = (x * shape[1] + y) * shape[2] + z
                if known[node] == 0:
                    return False
                nodes[(a * len(mid) + b) * 2 + d] = node
    return True


@njit(cache=True, nogil=True)
def stretch(flat, nodes, cell, mid, matrix, low, high, center):
    """Gradient of the map in a cell, the box and the middle of its image."""
    count = 4 * len(mid)
    last = 1 + (len(mid) > 1)  # of the displacement's components
    matrix[:] = 0.0
    matrix[1, 1] = 1.0 if len(mid) == 1 else 0.0
    for axis in range(3):
        low[axis] = 1e300
        high[axis] = -1e300
        center[axis] = 0.0
    if len(mid) == 1:
        low[1] = high[1] = 0.0
    for k in range(count):
        along = (k // (2 * len(mid)), (k // 2) % len(mid), k % 2)
        for axis in range(3):
            if axis == 1 and len(mid) == 1:
                continue
            part = 0 if axis == 0 else (1 if axis == 1 else last)
            x = cell[axis] + along[axis] + flat[part, nodes[k]]
            low[axis] = min(low[axis], x)
            high[axis] = max(high[axis], x)
            center[axis] += x / count
            for other in range(3):
                if other == 1 and len(mid) == 1:
                    continue
                matrix[axis, other] += (2 * along[other] - 1) * x * 2.0 / count


@njit(cache=True, nogil=True)
def all_flat(level, nodes, flat):
    """Whether the level set is flat in a cell, and so says nothing."""
    lowest = highest = level[nodes[0]]
    for node in nodes:
        lowest = min(lowest, level[node])
        highest = max(highest, level[node])
    return lowest > flat or highest < -flat


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
    ndim = fields.shape[0] - 1
    marks = known.reshape(known.size)
    flat = fields.reshape(fields.shape[0], known.size)
    level = flat[ndim]
    rows = np.empty(width * len(mid), np.int64)
    columns = np.empty(width, np.int64)
    edge = np.empty(4 * len(pair), np.int64)
    wa, wb, wc = np.empty(width), np.empty(width), np.empty(width)
    matrix, inverse = np.empty((3, 3)), np.empty((3, 3))
    low, high, center = np.empty(3), np.empty(3), np.empty(3)
    place, gap, target = np.empty(3), np.empty(3), np.empty(3, np.int64)
    cell = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        count = 0
        folded = 0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            cell[0] = nodes[p] // (shape[1] * shape[2])
            cell[1] = (nodes[p] // shape[2]) % shape[1]
            cell[2] = nodes[p] % shape[2]
            if not corners(cell[0], cell[1], cell[2], shape, periodic, marks, pair, edge):
                continue
            if all_flat(level, edge, FLAT * plateau):
                continue
            stretch(flat, edge, cell, pair, matrix, low, high, center)
            if not invert(matrix, inverse) > 0.0:
                folded += 1
                continue
            inside = find_cell(
                cell[0], cell[1], cell[2], shape, periodic, left, taps, mid, rows, columns
            )
            full = inside and all_known(marks, rows, columns, taps, mid)
            whole = full and columns[width - 1] - columns[0] == width - 1
            for x in range(np.ceil(low[0] - MARGIN), np.floor(high[0] + MARGIN) + 1):
                for y in range(np.ceil(low[1] - MARGIN), np.floor(high[1] + MARGIN) + 1):
                    for z in range(np.ceil(low[2] - MARGIN), np.floor(high[2] + MARGIN) + 1):
                        target[0] = wrapped(np.int64(x), shape[0], periodic[0])
                        target[1] = (
                            wrapped(np.int64(y), shape[1], periodic[1]) if len(mid) > 1 else 0
                        )
                        target[2] = wrapped(np.int64(z), shape[2], periodic[2])
                        if len(mid) == 1 and y != 0:
                            continue
                        if target[0] < 0 or target[1] < 0 or target[2] < 0:
                            continue
                        gap[0], gap[1], gap[2] = x - center[0], y - center[1], z - center[2]
                        near = True
                        for n in range(3):
                            place[n] = 0.0
                            for k in range(3):
                                place[n] += inverse[n, k] * gap[k]
                            near &= abs(place[n]) < 0.5 + MARGIN
                        if not near:
                            continue
                        value = 0.0
                        if full:
                            for _ in range(TRIES):
                                weigh(place[0], coeffs, taps, terms, wa)
                                weigh(place[2], coeffs, taps, terms, wc)
                                if len(mid) > 1:
                                    weigh(place[1], coeffs, taps, terms, wb)
                                    gap[1] = (
                                        y
                                        - cell[1]
                                        - 0.5
                                        - place[1]
                                        - blend(
                                            flat[1], rows, columns, whole, wa, wb, wc, taps, mid
                                        )
                                    )
                                gap[0] = (
                                    x
                                    - cell[0]
                                    - 0.5
                                    - place[0]
                                    - blend(flat[0], rows, columns, whole, wa, wb, wc, taps, mid)
                                )
                                gap[2] = (
                                    z
                                    - cell[2]
                                    - 0.5
                                    - place[2]
                                    - blend(
                                        flat[ndim - 1], rows, columns, whole, wa, wb, wc, taps, mid
                                    )
                                )
                                far = 0.0
                                for n in range(3):
                                    for k in range(3):
                                        place[n] += inverse[n, k] * gap[k]
                                    far = max(far, abs(gap[n]))
                                if not (far > CLOSE and far < 1.0):
                                    break
                            weigh(place[0], coeffs, taps, terms, wa)
                            weigh(place[2], coeffs, taps, terms, wc)
                            if len(mid) > 1:
                                weigh(place[1], coeffs, taps, terms, wb)
                            value = blend(level, rows, columns, whole, wa, wb, wc, taps, mid)
                        else:  # the band's edge: straight between the corners
                            for k in range(4 * len(pair)):
                                part = level[edge[k]]
                                part *= 0.5 + (2 * (k // (2 * len(pair))) - 1) * place[0]
                                part *= 0.5 + (2 * (k % 2) - 1) * place[2]
                                if len(mid) > 1:
                                    part *= 0.5 + (2 * ((k // 2) % len(pair)) - 1) * place[1]
                                value += part
                        if max(abs(place[0]), abs(place[1]), abs(place[2])) > 0.5 + SLACK:
                            continue
                        if count < found.shape[1]:
                            node = (target[0] * shape[1] + target[1]) * shape[2] + target[2]
                            found[piece, count] = node
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


@njit(cache=True, nogil=True)
def neighbours(node, shape, periodic, diagonal, out):
    """Nodes around one, those along the axes or with ``diagonal`` all; returns how many."""
    row = shape[1] * shape[2]
    i, m, c = node // row, (node // shape[2]) % shape[1], node % shape[2]
    count = 0
    for a in range(-1, 2):
        x = wrapped(i + a, shape[0], periodic[0])
        for b in range(-1, 2) if shape[1] > 1 else range(1):
            y = wrapped(m + b, shape[1], periodic[1])
            for d in range(-1, 2):
                z = wrapped(c + d, shape[2], periodic[2])
                moves = abs(a) + abs(b) + abs(d)
                if moves and (diagonal or moves == 1) and x >= 0 and y >= 0 and z >= 0:
                    out[count] = (x * shape[1] + y) * shape[2] + z
                    count += 1
    return count


@njit(cache=True, nogil=True)
def select(nodes, level, bound, core):
    """Nodes where the level set is within a bound, into ``core``; returns how many."""
    count = 0
    for k in range(nodes.size):
        if abs(level[nodes[k]]) < bound:
            core[count] = nodes[k]
            count += 1
    return count


@njit(cache=True, nogil=True)
def widen(core, count, layers, shape, periodic, marks, level, flat, least, nodes):
    """The core and so many layers of nodes around it, into ``nodes``; returns how many.

    ``marks``: 1 where ``level`` is known, 2 where a node was taken. A node that is not known takes
    the value of the one from which it was reached, and at least the part ``least`` of ``flat``.
    Layers reach along the axes and to all sides in turn, which makes them nearly round. -1: no
    room.
    """
    near = np.empty(27, np.int64)
    for k in range(count):
        marks[core[k]] = 2
        nodes[k] = core[k]
    total = count
    start = 0
    for layer in range(layers):
        stop = total
        for k in range(start, stop):
            for n in range(neighbours(nodes[k], shape, periodic, layer % 2 == 1, near)):
                node = near[n]
                if marks[node] == 2:
                    continue
                if total == nodes.size:
                    return -1
                if marks[node] == 0:
                    value = max(abs(level[nodes[k]]), least * flat)
                    value = flat if value > FLAT * flat else value
                    level[node] = value if level[nodes[k]] > 0 else -value
                marks[node] = 2
                nodes[total] = node
                total += 1
        start = stop
    return total


@njit(cache=True, nogil=True)
def order(nodes, count, columns, starts, result):
    """Nodes in ascending order: counted by rows, then sorted within each; ``starts`` all zero."""
    for k in range(count):
        starts[nodes[k] // columns + 1] += 1
    for row in range(starts.size - 1):
        starts[row + 1] += starts[row]
    for k in range(count):
        row = nodes[k] // columns
        result[starts[row]] = nodes[k]
        starts[row] += 1
    begin = 0
    for row in range(starts.size - 1):
        end = starts[row]
        if end - begin > 1:
            result[begin:end] = np.sort(result[begin:end])
        begin = end


@njit(cache=True, nogil=True)
def principal(first, pieces, step, size, nodes, shape, periodic, known, fields, mid, grams, folds):
    """Cauchy-Green tensors of the map in the cells between particles, and how many are folded."""
    marks = known.reshape(known.size)
    flat = fields.reshape(fields.shape[0], known.size)
    edge = np.empty(4 * len(mid), np.int64)
    matrix, inverse = np.empty((3, 3)), np.empty((3, 3))
    low, high, center = np.empty(3), np.empty(3), np.empty(3)
    cell = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        folded = 0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            for i in range(3):
                for j in range(3):
                    grams[p, i, j] = 1.0 if i == j else 0.0
            cell[0] = nodes[p] // (shape[1] * shape[2])
            cell[1] = (nodes[p] // shape[2]) % shape[1]
            cell[2] = nodes[p] % shape[2]
            if not corners(cell[0], cell[1], cell[2], shape, periodic, marks, mid, edge):
                continue
            stretch(flat, edge, cell, mid, matrix, low, high, center)
            folded += not invert(matrix, inverse) > 0.0
            for i in range(3):
                for j in range(3):
                    total = 0.0
                    for k in range(3):
                        total += matrix[k, i] * matrix[k, j]
                    grams[p, i, j] = total
        folds[piece] = folded


@njit(cache=True, nogil=True)
def strain(
    first, pieces, step, size, nodes, shape, periodic, known, fields, rates, mid, largest
):  # fmt: skip
    """Largest row sum of |du_i/dx_j| in each piece; ``rates`` hold velocities as displacements."""
    marks = known.reshape(known.size)
    flat = fields.reshape(fields.shape[0], known.size)
    speeds = rates.reshape(rates.shape[0], known.size)
    edge = np.empty(4 * len(mid), np.int64)
    matrix, inverse, growth = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    low, high, center = np.empty(3), np.empty(3), np.empty(3)
    cell = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        top = 0.0
        for p in range(piece * size, min((piece + 1) * size, nodes.size)):
            cell[0] = nodes[p] // (shape[1] * shape[2])
            cell[1] = (nodes[p] // shape[2]) % shape[1]
            cell[2] = nodes[p] % shape[2]
            if not corners(cell[0], cell[1], cell[2], shape, periodic, marks, mid, edge):
                continue
            stretch(flat, edge, cell, mid, matrix, low, high, center)
            if not invert(matrix, inverse) > 0.0:
                continue
            stretch(speeds, edge, cell, mid, growth, low, high, center)
            for i in range(3):
                growth[i, i] -= 1.0
                total = 0.0
                for j in range(3):
                    part = 0.0
                    for k in range(3):
                        part += growth[i, k] * inverse[k, j]
                    total += abs(part)
                top = max(top, total)
        largest[piece] = top
