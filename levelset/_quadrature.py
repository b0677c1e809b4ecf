"""Compiled quadrature of a level set: cell by cell, over its inside and its contour."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from levelset import _bernstein, _heights, _interpolant
from levelset._bernstein import LINE, MATRICES, WITHOUT_FIRST, WITHOUT_LAST, along
from levelset._heights import AREA, INSIDE, NOTHING, PIECES, TERMS, cut
from levelset._interpolant import KINK, four
from remesh.compiled import drop_stale

drop_stale(__file__, _bernstein.__file__, _heights.__file__, _interpolant.__file__)

INNER = 0.1  # where the second differences at both ends of a cell compare so, the kink is in it


@njit(cache=True, nogil=True)
def stencil(i, n, wraps):
    """The four nodes around cell i of an axis, and how far the cell is from the first."""
    if n == 1:
        return (0, 0, 0, 0), 0
    a, b, c, d, u, _ = four(float(i), n, wraps)
    return (a, b, c, d), 1 + int(u)


@njit(cache=True, nogil=True)
def load(source, flat, shape, wraps, gaps, cell, nodal, ready):
    """Values of ``source`` on the four nodes around a cell along each axis.

    ``ready`` tells those set in ``flat``. Returns where the cell is along each axis from the first
    of the four, its row of ``MATRICES``; and how many are not set.
    """
    rows, lead_i = stencil(cell[0], shape[0], wraps[0])
    lines, lead_j = stencil(cell[1], shape[1], wraps[1])
    places, lead_k = stencil(cell[2], shape[2], wraps[2])
    deep = nodal.shape[2]
    missing = 0
    for a in range(4):
        for b in range(4):
            row = (rows[a] * shape[1] + lines[b]) * shape[2]
            for c in range(deep):
                node = row + places[c]
                nodal[a, b, c] = source[node]
                if gaps:
                    ready[a, b, c] = flat[node] != 0.0
                    missing += not ready[a, b, c]
    return (lead_i, lead_j, lead_k), missing


@njit(cache=True, nogil=True)
def completed(nodal, ready, found, leads, missing):
    """Give unset nodes a value: along parabolas from the others, else none but the corners count.

    Returns the row of ``MATRICES`` for each axis.
    """
    if missing == 0 or mended(nodal, ready, found, missing):
        return leads
    for a in range(2):
        for b in range(2):
            for c in range(min(nodal.shape[2], 2)):
                nodal[a, b, c] = nodal[leads[0] + a, leads[1] + b, leads[2] + c]
    return LINE, LINE, LINE


@njit(cache=True, nogil=True)
def mended(nodal, ready, found, missing):
    """Whether nodes at the ends of lines of four could be filled in, in place, from the others."""
    deep = nodal.shape[2]
    for _ in range(3):
        count = 0
        for a in range(4):
            for b in range(4):
                for c in range(deep):
                    if ready[a, b, c]:
                        continue
                    total, ways = 0.0, 0
                    if a == 0 or a == 3:
                        line, ok = nodal[:, b, c], ready[:, b, c]
                        total, more = ends(line, ok, a, total)
                        ways += more
                    if b == 0 or b == 3:
                        line, ok = nodal[a, :, c], ready[a, :, c]
                        total, more = ends(line, ok, b, total)
                        ways += more
                    if deep == 4 and (c == 0 or c == 3):
                        line, ok = nodal[a, b, :], ready[a, b, :]
                        total, more = ends(line, ok, c, total)
                        ways += more
                    if ways > 0:
                        nodal[a, b, c] = total / ways
                        found[count, 0], found[count, 1], found[count, 2] = a, b, c
                        count += 1
        for k in range(count):
            ready[found[k, 0], found[k, 1], found[k, 2]] = True
        missing -= count
        if missing == 0 or count == 0:
            break
    return missing == 0


@njit(cache=True, nogil=True)
def ends(line, ready, place, total):
    """Add the value at an end of a line by the parabola through its others, if these are known."""
    one, two, three = (1, 2, 3) if place == 0 else (2, 1, 0)
    if ready[one] and ready[two] and ready[three]:
        return total + 3 * (line[one] - line[two]) + line[three], 1
    return total, 0


@njit(cache=True, nogil=True)
def crossable(nodal, leads):
    """Whether the contour may cross a cell: not if its corners are large and of one sign."""
    below, above, most, least = False, False, 0.0, np.inf
    deep = nodal.shape[2]
    for a in range(4):
        for b in range(4):
            core = 0 <= a - leads[0] <= 1 and 0 <= b - leads[1] <= 1
            for c in range(deep):
                this = nodal[a, b, c]
                below |= this < 0
                above |= this > 0
                size = abs(this)
                most = size if size > most else most
                if size < least and core and (deep == 1 or 0 <= c - leads[2] <= 1):
                    least = size
    return (below and above) or least < 0.4 * most or least == 0


@njit(cache=True, nogil=True)
def kind(nodal, axis, leads):
    """The row of ``MATRICES`` of an axis: a parabola on the smooth side where a kink is near."""
    if leads[axis] != 1:
        return leads[axis]
    ahead, behind = (axis + 1) % 3, (axis + 2) % 3
    most, third, low, high = 0.0, 0.0, 0.0, 0.0
    for m in range(2 if nodal.shape[ahead] == 4 else 1):
        for n in range(2 if nodal.shape[behind] == 4 else 1):
            i = min(leads[ahead] + m, nodal.shape[ahead] - 1)
            j = min(leads[behind] + n, nodal.shape[behind] - 1)
            if axis == 0:
                line = nodal[:, i, j]
            elif axis == 1:
                line = nodal[j, :, i]
            else:
                line = nodal[i, j, :]
            one, two, three = line[1] - line[0], line[2] - line[1], line[3] - line[2]
            most = max(most, abs(one), abs(two), abs(three))
            third = max(third, abs(three - 2 * two + one))
            low = max(low, abs(two - one))
            high = max(high, abs(three - two))
    if third <= KINK * most or min(low, high) > INNER * max(low, high):
        return 1
    return WITHOUT_LAST if low <= high else WITHOUT_FIRST


@njit(cache=True, nogil=True)
def coefficients(nodal, leads):
    """From nodal values to Bernstein coefficients on the cell, in place."""
    along(nodal, 0, MATRICES[leads[0]])
    along(nodal, 1, MATRICES[leads[1]])
    if nodal.shape[2] == 4:
        along(nodal, 2, MATRICES[leads[2]])


@njit(cache=True, nogil=True)
def begins(cell, shape, wraps):
    """Whether a cell begins at this node: none does at an unbounded edge."""
    x = wraps[0] or cell[0] + 1 < shape[0]
    y = wraps[1] or cell[1] + 1 < shape[1]
    return x and y and (wraps[2] or cell[2] + 1 < shape[2] or shape[2] == 1)


@njit(cache=True, nogil=True)
def corners(flat, shape, gaps, cell):
    """Of the corners of a cell: how many are below zero, how many are set, the least size."""
    below, known, least = 0, 0, np.inf
    ahead = cell[1] + 1 if cell[1] + 1 < shape[1] else 0
    beyond = cell[2] + 1 if cell[2] + 1 < shape[2] else 0
    for a in range(2):
        i = cell[0] + a if cell[0] + a < shape[0] else 0
        for b in range(2):
            row = (i * shape[1] + (ahead if b else cell[1])) * shape[2]
            for c in range(2 if shape[2] > 1 else 1):
                this = flat[row + (beyond if c else cell[2])]
                below += this < 0
                known += this != 0.0 or not gaps
                least = abs(this) if abs(this) < least else least
    return below, known, least


@njit(cache=True, nogil=True)
def torn(flat, shape, wraps, cell, first):
    """Whether the contour crosses a cell around this node that begins at one that is not set."""
    for corner in range(1, 8 if shape[2] > 1 else 4):
        for k in range(3):
            first[k] = cell[k] - ((corner >> k) & 1)
            if first[k] < 0 and wraps[k]:
                first[k] += shape[k]
        if first[0] < 0 or first[1] < 0 or first[2] < 0:
            continue
        node = (first[0] * shape[1] + first[1]) * shape[2] + first[2]
        if flat[node] == 0.0 and begins(first, shape, wraps):
            below, known, _ = corners(flat, shape, True, first)
            if 0 < below < known:
                return True
    return False


@njit(cache=True, nogil=True)
def steepest(first, pieces, step, size, nodes, flat, shape, wraps, gaps, result):
    """Per piece of nodes: the largest step of the values from a node to the next on an axis."""
    strides = (shape[1] * shape[2], shape[2], 1)
    total = len(nodes) if gaps else flat.size
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, total)):
            node = nodes[n] if gaps else n
            rest, here = node, flat[node]
            for axis in range(3):
                place = rest // strides[axis]
                rest -= place * strides[axis]
                if place + 1 < shape[axis]:
                    other = node + strides[axis]
                elif wraps[axis]:
                    other = node - place * strides[axis]
                else:
                    continue
                if not (gaps and flat[other] == 0.0):
                    result[piece] = max(result[piece], abs(flat[other] - here))


@njit(cache=True, nogil=True)
def measure(plain, flat, shape, wraps, gaps, cell, below, values, wanted, work, terms):
    """Add the terms of a cell whose corners are all set, in units of the cell."""
    stack, boxes, extra, order, scratch, ready, found = work
    if wanted != NOTHING:
        leads, missing = load(values, flat, shape, wraps, gaps, cell, extra, ready)
        coefficients(extra, completed(extra, ready, found, leads, missing))
    leads, missing = load(flat, flat, shape, wraps, gaps, cell, stack[0], ready)
    if crossable(stack[0], leads):
        leads = completed(stack[0], ready, found, leads, missing)
        kinds = (kind(stack[0], 0, leads), kind(stack[0], 1, leads), leads[2])
        if shape[2] > 1:
            kinds = (kinds[0], kinds[1], kind(stack[0], 2, leads))
        coefficients(stack[0], kinds)
        cut(plain, stack, boxes, extra, wanted, scratch, order, terms)
    elif below > 0:
        full(extra.mean() if wanted == INSIDE else 0.0, terms)


@njit(cache=True, nogil=True)
def full(mean, terms):
    """The terms of a cell that is inside as a whole."""
    terms[0] = 1.0
    terms[1:4] = 0.5
    terms[4] = mean


@njit(cache=True, nogil=True)
def integrals(
    first, pieces, step, size, plain, nodes, flat, shape, wraps, gaps, near, values, wanted, result
):  # fmt: skip
    """Per piece of nodes: the terms over the cells that begin at these nodes, in node units.

    A cell with corners of one sign, all beyond ``near``, is not crossed; one that is and of which
    corners are not set is counted in the last of the results. ``plain``: see `cut`; ``wanted``:
    over what the values are integrated.
    """
    deep = 4 if shape[2] > 1 else 1
    count = 8 if shape[2] > 1 else 4
    work = (
        np.zeros((PIECES, 4, 4, deep)),
        np.zeros((PIECES, 4)),
        np.zeros((4, 4, deep)),
        np.zeros((4, 4, 4)),
        np.zeros((12, 16)),
        np.ones((4, 4, deep), np.bool_),
        np.zeros((64, 3), np.int64),
    )
    terms = np.zeros(TERMS)
    cell, other = np.zeros(3, np.int64), np.zeros(3, np.int64)
    total = len(nodes) if gaps else flat.size
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, total)):
            node = nodes[n] if gaps else n
            row = node // shape[2]
            cell[0] = row // shape[1]
            cell[1] = row - cell[0] * shape[1]
            cell[2] = node - row * shape[2]
            if gaps and torn(flat, shape, wraps, cell, other):
                result[piece, TERMS] += 1.0
            if not begins(cell, shape, wraps):
                continue
            below, known, least = corners(flat, shape, gaps, cell)
            if below == 0 and least > near:
                continue
            terms[:] = 0.0
            if known < count:
                if 0 < below < known:
                    result[piece, TERMS] += 1.0
                full(0.0, terms)
                terms *= below / known
            elif below == count and least > near and wanted != INSIDE:
                full(0.0, terms)
            else:
                measure(
                    plain, flat, shape, wraps, gaps, cell, below, values, wanted, work, terms
                )  # fmt: skip
            for at in (0, AREA):
                result[piece, at] += terms[at]
                result[piece, at + 4] += terms[at + 4]
                for axis in range(3):
                    result[piece, at + 1 + axis] += cell[axis] * terms[at] + terms[at + 1 + axis]
