"""Compiled fronts: the feet of the nodes at the contour, and of those farther out, ring by ring.

Fields are (nx, nm, nc) in C order, their nodes told by flat indices. ``slot`` says of every node
where it stands in the list of nodes reached, counted from 1; 0 is not reached. ``feet`` (n, 3) are
offsets from the nodes in node units, ``away`` (n,) their lengths.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from levelset import _foot, _interpolant, _kinks
from levelset._foot import crossing, foot, kind_around
from levelset._interpolant import beside
from levelset._kinks import HELD
from remesh.compiled import drop_stale

drop_stale(__file__, _foot.__file__, _interpolant.__file__, _kinks.__file__)

NEARER = 1e-6  # node spacings; feet that are nearer by less are the same
DOUBT = 0.4  # node spacings; so badly is a contour known beside a kink
BESIDE = 2.5  # node spacings from the contour: what its interpolant is made of


@njit(cache=True, nogil=True)
def crossed(first, pieces, step, rows, flat, shape, wraps, nodes, gaps, found, counts):
    """Per piece of nodes: those with a neighbour of the other sign, and how many.

    ``nodes`` are all if there are none; ``found`` holds a piece's nodes from its start on.
    """
    nx, nm, nc = shape
    for piece in range(first, pieces, step):
        start = piece * rows
        count = 0
        for n in range(start, min(start + rows, len(found))):
            node = nodes[n] if len(nodes) else n
            inside = flat[node] < 0.0
            k = node % nc
            m = (node // nc) % nm
            i = node // (nc * nm)
            hit = False
            for side in (-1, 1):
                if not hit:
                    o = beside(k, side, nc, wraps[2])
                    hit = o >= 0 and differs(flat, node + o - k, inside, gaps)
                if not hit:
                    o = beside(i, side, nx, wraps[0])
                    hit = o >= 0 and differs(flat, node + (o - i) * nc * nm, inside, gaps)
                if not hit and nm > 1:
                    o = beside(m, side, nm, wraps[1])
                    hit = o >= 0 and differs(flat, node + (o - m) * nc, inside, gaps)
            if hit:
                found[start + count] = node
                count += 1
        counts[piece] = count


@njit(cache=True, nogil=True)
def differs(flat, node, inside, gaps):
    """Whether a node is known and on the other side."""
    value = flat[node]
    return (value < 0.0) != inside and not (gaps and value == 0.0)


@njit(cache=True, nogil=True)
def land_first(first, pieces, step, rows, flat, kinds, shape, wraps, gaps, nodes, feet, away):
    """The feet of nodes that have neighbours of the other sign, from the nearest crossing."""
    _, nm, nc = shape
    strides = (nc * nm, nc, 1)
    for piece in range(first, pieces, step):
        for n in range(piece * rows, min((piece + 1) * rows, len(nodes))):
            node = nodes[n]
            place = (node // (nc * nm), (node // nc) % nm, node % nc)
            inside = flat[node] < 0.0
            a, b, c, nearest = 0.0, 0.0, 0.0, math.inf
            for axis in range(3):
                i, size, stride = place[axis], shape[axis], strides[axis]
                base = node - i * stride
                for side in (-1, 1):
                    o = beside(i, side, size, wraps[axis])
                    if o < 0 or not differs(flat, base + o * stride, inside, gaps):
                        continue
                    root = crossing(flat, stride, base, i, size, wraps[axis], gaps, side > 0)
                    if root < nearest:
                        nearest = root
                        a = side * root if axis == 0 else 0.0
                        b = side * root if axis == 1 else 0.0
                        c = side * root if axis == 2 else 0.0
            x, y, z = float(place[0]), float(place[1]), float(place[2])
            feet[n, 0], feet[n, 1], feet[n, 2], away[n] = foot(
                flat, kinds, shape, wraps, gaps, x, y, z, a, b, c
            )


@njit(cache=True, nogil=True)
def advance(
    flat, shape, wraps, gaps, confined, reach, slot, nodes, inside, away, start, stop
):  # fmt: skip
    """Append the unreached neighbours of the list's last ring, ``start:stop``; the new length.

    Those beyond ``reach`` do not spread; ``confined`` keeps to nodes whose value is set. A node
    that is not set takes the sign of the one that reached it.
    """
    _, nm, nc = shape
    strides = (nc * nm, nc, 1)
    count = stop
    for n in range(start, stop):
        if away[n] > reach:
            continue
        node = nodes[n]
        place = (node // (nc * nm), (node // nc) % nm, node % nc)
        for axis in range(3):
            for side in (-1, 1):
                o = beside(place[axis], side, shape[axis], wraps[axis])
                other = node + (o - place[axis]) * strides[axis]
                if o < 0 or slot[other] != 0 or (confined and flat[other] == 0.0):
                    continue
                nodes[count] = other
                value = flat[other]
                inside[count] = inside[n] if gaps and value == 0.0 else value < 0.0
                count += 1
                slot[other] = count
    return count


@njit(cache=True, nogil=True)
def nearest_known(shape, wraps, slot, feet, last, node, nearest):
    """The nearest of the feet of a node's neighbours within the list up to ``last``.

    Returns its offset from the node, and whether one is nearer than ``nearest``.
    """
    nx, nm, nc = shape
    i, m, k = node // (nc * nm), (node // nc) % nm, node % nc
    a, b, c, found = 0.0, 0.0, 0.0, False
    nearest *= nearest
    across = 1 if nm > 1 else 0
    for di in (-1, 0, 1):
        oi = beside(i, di, nx, wraps[0])
        if oi < 0:
            continue
        for dm in range(-across, across + 1):
            om = beside(m, dm, nm, wraps[1])
            if om < 0:
                continue
            for dk in (-1, 0, 1):
                ok = beside(k, dk, nc, wraps[2])
                if ok < 0:
                    continue
                s = np.int64(slot[(oi * nm + om) * nc + ok]) - 1
                if s < 0 or s >= last:
                    continue
                u, v, w = feet[s, 0] + di, feet[s, 1] + dm, feet[s, 2] + dk
                gap = u * u + v * v + w * w
                if gap < nearest:
                    a, b, c, nearest, found = u, v, w, gap, True
    return a, b, c, found


@njit(cache=True, nogil=True)
def land_ring(
    first, pieces, step, rows, flat, kinds, shape, wraps, gaps, slot, nodes, feet, away, start, stop
):  # fmt: skip
    """The feet of the ring ``start:stop``, from those of neighbours in the rings before."""
    _, nm, nc = shape
    for piece in range(first, pieces, step):
        low = start + piece * rows
        for n in range(low, min(low + rows, stop)):
            node = nodes[n]
            a, b, c, _ = nearest_known(shape, wraps, slot, feet, start, node, math.inf)
            x, y, z = float(node // (nc * nm)), float((node // nc) % nm), float(node % nc)
            feet[n, 0], feet[n, 1], feet[n, 2], away[n] = foot(
                flat, kinds, shape, wraps, gaps, x, y, z, a, b, c
            )


@njit(cache=True, nogil=True)
def improve(
    first, pieces, step, rows, flat, kinds, shape, wraps, gaps, slot, nodes, feet, away, asked,
    fresh,
):  # fmt: skip
    """Where a neighbour knows a nearer foot, a new one: ``fresh`` (n, 4), its length or infinity.

    ``asked`` are the places in the list to look at. What is read is not written.
    """
    _, nm, nc = shape
    for piece in range(first, pieces, step):
        for q in range(piece * rows, min((piece + 1) * rows, len(asked))):
            n = asked[q]
            node = nodes[n]
            limit = away[n] - NEARER
            fresh[q, 3] = math.inf
            if limit <= 0.0:
                continue
            a, b, c, nearer = nearest_known(shape, wraps, slot, feet, len(nodes), node, limit)
            if nearer:
                x, y, z = float(node // (nc * nm)), float((node // nc) % nm), float(node % nc)
                a, b, c, near = foot(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c)
                if near < limit:
                    fresh[q, 0], fresh[q, 1], fresh[q, 2], fresh[q, 3] = a, b, c, near


@njit(cache=True, nogil=True)
def accept(shape, wraps, slot, nodes, feet, away, asked, fresh, marks):
    """Take over what was found; the places of their neighbours, which are to be looked at next."""
    nx, nm, nc = shape
    across = 1 if nm > 1 else 0
    count = 0
    following = np.empty(len(nodes), np.int64)
    for q in range(len(asked)):
        if fresh[q, 3] == math.inf:
            continue
        n = asked[q]
        feet[n, 0], feet[n, 1], feet[n, 2], away[n] = (
            fresh[q, 0], fresh[q, 1], fresh[q, 2], fresh[q, 3],
        )  # fmt: skip
        node = nodes[n]
        i, m, k = node // (nc * nm), (node // nc) % nm, node % nc
        for di in (-1, 0, 1):
            oi = beside(i, di, nx, wraps[0])
            for dm in range(-across, across + 1):
                om = beside(m, dm, nm, wraps[1])
                for dk in (-1, 0, 1):
                    ok = beside(k, dk, nc, wraps[2])
                    if oi < 0 or om < 0 or ok < 0:
                        continue
                    s = np.int64(slot[(oi * nm + om) * nc + ok]) - 1
                    if s >= 0 and marks[s] == 0:
                        marks[s] = 1
                        following[count] = s
                        count += 1
    for q in range(count):
        marks[following[q]] = 0
    return following[:count].copy()


@njit(cache=True, nogil=True)
def keep(first, pieces, step, rows, flat, kinds, shape, wraps, gaps, spacing, nodes, feet, away):
    """Leave the values of nodes whose feet are beside a kink, where new ones are no better."""
    _, nm, nc = shape
    for piece in range(first, pieces, step):
        for n in range(piece * rows, min((piece + 1) * rows, len(nodes))):
            node = nodes[n]
            if away[n] > BESIDE:
                continue
            x, y, z = node // (nc * nm) + feet[n, 0], feet[n, 1], node % nc + feet[n, 2]
            y += (node // nc) % nm
            if (kind_around(kinds, shape, wraps, x, y, z) & HELD) == 0:
                continue
            given = abs(flat[node]) / spacing
            if abs(given - away[n]) < DOUBT and not (gaps and given == 0.0):
                away[n] = given
