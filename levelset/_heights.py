"""Compiled integration over a piece of a cell: the contour as a height, Gauss points and roots.

In a cell the contour is a height above the axis of the largest slope where the derivative along it
keeps its sign; Gauss points lie between the places where the contour leaves the cell, and one root
is sought above each. A cell without such an axis is halved along all its own, down to ``FINEST``.
Where the gradient hardly changes in a piece two Gauss points do, which are of order 4; else three.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from levelset import _bernstein
from levelset._bernstein import ascending, basis, cubic, halve, roots, sign, slope, tangent, value
from remesh.compiled import drop_stale

drop_stale(__file__, _bernstein.__file__)

FINEST = 1 / 32  # of a cell that is no height above any axis: it is halved no more
STEEPEST = 4.0  # contour above a unit of its base, at most, in pieces that are halved no more
PIECES = 8 * 5 + 1  # of a cell that wait to be integrated, at most
EVEN = 0.25  # of the largest slope: a gradient that changes by less in a piece hardly changes
TWO = (0.5 - math.sqrt(1 / 12), 0.5 + math.sqrt(1 / 12))
PLACES = np.array(((*TWO, 0.0), (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))))
WEIGHTS = np.array(((0.5, 0.5, 0.0), (5 / 18, 8 / 18, 5 / 18)))  # of two and of three Gauss points
NOTHING, INSIDE, SURFACE = 0, 1, 2  # over what values are integrated
TERMS = 10  # inside: volume, first moments, values; contour: area, first moments, values
AREA = 5  # the first of the terms of the contour


@njit(cache=True, nogil=True)
def put(terms, at, weight, place, values, wanted):
    """Add one quadrature point to five terms: weight, first moments, values."""
    terms[at] += weight
    terms[at + 1] += weight * place[0]
    terms[at + 2] += weight * place[1]
    terms[at + 3] += weight * place[2]
    if wanted:
        terms[at + 4] += weight * value(values, place[0], place[1], place[2])


@njit(cache=True, nogil=True)
def dot(weights, a, b, c, d):
    """The sum of four products."""
    return weights[0] * a + weights[1] * b + weights[2] * c + weights[3] * d


@njit(cache=True, nogil=True)
def above(line, over, across, foot, axis, weight, box, values, wanted, found, terms):
    """The part of a line below zero, and its roots; ``line`` its coefficients along ``axis``.

    ``over`` and ``across``: those of the derivatives along the two other axes; ``box``: where the
    piece is in its cell and how wide; ``foot``: where the line is in the piece.
    """
    a, b, c, d = line
    count = roots(a, b, c, d, found, 0)
    wide = box[3]
    base = weight * wide * wide if values.shape[2] == 4 else weight * wide
    low = 0.0
    for i in range(count + 1):
        high = found[i] if i < count else 1.0
        if cubic(a, b, c, d, 0.5 * (low + high)) < 0:
            length = (high - low) * wide
            if wanted == INSIDE:
                for g in range(2):
                    foot[axis] = low + (high - low) * TWO[g]
                    put(terms, 0, 0.5 * base * length, seat(box, foot), values, True)
            else:
                foot[axis] = 0.5 * (low + high)
                put(terms, 0, base * length, seat(box, foot), values, False)
        if i < count:
            up = abs(dot(tangent(high), a, b, c, d))
            side = cubic(over[0], over[1], over[2], over[3], high)
            other = cubic(across[0], across[1], across[2], across[3], high)
            ratio = math.sqrt(up * up + side * side + other * other) / max(up, 1e-300)
            if wide <= FINEST:
                ratio = min(ratio, STEEPEST)
            foot[axis] = high
            put(terms, AREA, base * ratio, seat(box, foot), values, wanted == SURFACE)
        low = high


@njit(cache=True, nogil=True)
def seat(box, foot):
    """Where a place of a piece is in its cell."""
    return box[0] + box[3] * foot[0], box[1] + box[3] * foot[1], box[2] + box[3] * foot[2]


@njit(cache=True, nogil=True)
def plane(cell, axis, points, box, values, wanted, scratch, terms):
    """Add the terms of a piece of the plane whose contour is a height above the other axis."""
    breaks, found, foot = scratch[0], scratch[1], scratch[2]
    base = 1 - axis
    p = cell[:, :, 0].T if axis == 1 else cell[:, :, 0]  # [height, base]
    breaks[0] = 0.0
    count = 1
    for end in (0, 3):
        count = roots(p[end, 0], p[end, 1], p[end, 2], p[end, 3], breaks, count)
    ascending(breaks, count)
    breaks[count] = 1.0
    none = (0.0, 0.0, 0.0, 0.0)
    for piece in range(count):
        width = breaks[piece + 1] - breaks[piece]
        if width < 1e-14:
            continue
        for g in range(points):
            t = breaks[piece] + width * PLACES[points - 2, g]
            weight = width * WEIGHTS[points - 2, g]
            w, v = basis(t), tangent(t)
            line, over = weighed(w, p), weighed(v, p)
            foot[base] = t
            foot[2] = 0.0
            above(line, over, none, foot, axis, weight, box, values, wanted, found, terms)


@njit(cache=True, nogil=True)
def turned(cell, axis, side, base, out):
    """The coefficients with axes in the order height, side, base."""
    flat, strides = cell.reshape(64), (16, 4, 1)
    up, beside, along = strides[axis], strides[side], strides[base]
    for i in range(4):
        for j in range(4):
            for k in range(4):
                out[i, j, k] = flat[i * up + j * beside + k * along]


@njit(cache=True, nogil=True)
def space(p, axes, points, box, values, wanted, scratch, terms):
    """Add the terms of a piece of space; ``p``: its coefficients, [height, side, base]."""
    axis, side, base = axes
    breaks, found, foot, inner = scratch[0], scratch[1], scratch[2], scratch[3]
    flat, over = scratch[4:8], scratch[8:12]  # [height, side] at one place of the base
    breaks[0] = 0.0
    count = 1
    for end in (0, 3):
        if sign(p[end : end + 1]) == 0:
            for rim in (0, 3):
                q = p[end, rim]
                count = roots(q[0], q[1], q[2], q[3], breaks, count)
    ascending(breaks, count)
    breaks[count] = 1.0
    for piece in range(count):
        width = breaks[piece + 1] - breaks[piece]
        if width < 1e-14:
            continue
        for g in range(points):
            t = breaks[piece] + width * PLACES[points - 2, g]
            weight = width * WEIGHTS[points - 2, g]
            w, v = basis(t), tangent(t)
            for i in range(4):
                for j in range(4):
                    flat[i, j] = dot(w, p[i, j, 0], p[i, j, 1], p[i, j, 2], p[i, j, 3])
                    over[i, j] = dot(v, p[i, j, 0], p[i, j, 1], p[i, j, 2], p[i, j, 3])
            foot[base] = t
            inner[0] = 0.0
            parts = 1
            for end in (0, 3):
                q = flat[end]
                parts = roots(q[0], q[1], q[2], q[3], inner, parts)
            ascending(inner, parts)
            inner[parts] = 1.0
            for part in range(parts):
                height = inner[part + 1] - inner[part]
                if height < 1e-14:
                    continue
                for m in range(points):
                    foot[side] = inner[part] + height * PLACES[points - 2, m]
                    x, y = basis(foot[side]), tangent(foot[side])
                    above(
                        weighed(x, flat), weighed(y, flat), weighed(x, over), foot, axis,
                        weight * height * WEIGHTS[points - 2, m], box, values, wanted, found, terms,
                    )  # fmt: skip


@njit(cache=True, nogil=True)
def weighed(w, q):
    """The coefficients along the height, at one place of the side."""
    return (
        dot(w, q[0, 0], q[0, 1], q[0, 2], q[0, 3]),
        dot(w, q[1, 0], q[1, 1], q[1, 2], q[1, 3]),
        dot(w, q[2, 0], q[2, 1], q[2, 2], q[2, 3]),
        dot(w, q[3, 0], q[3, 1], q[3, 2], q[3, 3]),
    )


@njit(cache=True, nogil=True)
def heights(cell):
    """The axis of the largest slope, whether the contour is a height above it, Gauss points."""
    axis, best, sure, change = 0, -1.0, False, 0.0
    for k in range(2 if cell.shape[2] == 1 else 3):
        steep, least, most = slope(cell, k)
        change = max(change, most - least)
        if abs(steep) > best:
            axis, best, sure = k, abs(steep), least >= 0 or most <= 0
    return axis, sure, 2 if sure and change <= EVEN * best else 3


@njit(cache=True, nogil=True)
def sides(cell, axis):
    """The two other axes, side first, and whether the rims of the ends are heights above a side."""
    best, chosen, sure = -1.0, (axis + 1) % 3, False
    for step in (1, 2):
        side = (axis + step) % 3
        least, fits = np.inf, True
        for end in (0, 3):
            rim = cell[end : end + 1]
            if axis == 1:
                rim = cell[:, end : end + 1]
            elif axis == 2:
                rim = cell[:, :, end : end + 1]
            if sign(rim) == 0:
                steep, below, above = slope(rim, side)
                least = min(least, abs(steep))
                fits &= below >= 0 or above <= 0
        if (fits and not sure) or (fits == sure and least > best):
            best, chosen, sure = least, side, fits
    return chosen, 3 - axis - chosen, sure


@njit(cache=True, nogil=True)
def whole(box, values, wanted, terms):
    """Add the terms of a piece that is inside as a whole; its values are of cubics."""
    deep = values.shape[2] == 4
    half = 0.5 * box[3]
    size = half * half * half if deep else half * half
    for a in range(2):
        for b in range(2):
            for c in range(2 if deep else 1):
                place = (
                    box[0] + box[3] * TWO[a],
                    box[1] + box[3] * TWO[b],
                    box[2] + box[3] * TWO[c] if deep else 0.0,
                )
                put(terms, 0, size, place, values, wanted == INSIDE)


@njit(cache=True, nogil=True)
def cut(plain, pieces, boxes, values, wanted, scratch, order, terms):
    """Add the terms of the cell whose coefficients are ``pieces[0]``, in units of the cell.

    ``plain``: any array of as many dimensions as the mesh; what they do not need is not compiled.
    """
    boxes[0, :3] = 0.0
    boxes[0, 3] = 1.0
    deep = plain.ndim == 3
    top = 1
    while top > 0:
        top -= 1
        cell, box = pieces[top], boxes[top]
        side = sign(cell)
        if side != 0:
            if side < 0:
                whole(box, values, wanted, terms)
            continue
        axis, sure, points = heights(cell)
        second, third = 0, 0
        if plain.ndim == 3:
            second, third, fits = sides(cell, axis)
            sure &= fits
        if not sure and box[3] > FINEST:
            own = boxes[top].copy()
            parent = pieces[top].copy()
            for corner in range(8 if deep else 4):
                pieces[top] = parent
                boxes[top, 3] = 0.5 * own[3]
                for k in range(3 if deep else 2):
                    upper = (corner >> k) & 1
                    halve(pieces[top], k, upper == 1)
                    boxes[top, k] = own[k] + upper * 0.5 * own[3]
                top += 1
        elif plain.ndim == 3:
            turned(cell, axis, second, third, order)
            space(order, (axis, second, third), points, box, values, wanted, scratch, terms)
        else:
            plane(cell, axis, points, box, values, wanted, scratch, terms)
