"""Compiled loops over triangles: a tree of boxes, and the nearest triangle through it."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

LEAF = 4  # triangles in a leaf of the tree, at most
DEPTH = 64  # of the tree, at most


@njit(cache=True, nogil=True, error_model="numpy")
def build(corners, order, boxes):
    """Sort triangles ``corners`` (n, 3, 3) into a tree: halves along the longest side, by middle.

    Writes their ``order`` (n,) and the ``boxes`` (nodes, 6) of the nodes, low then high; node k
    has children 2 k + 1 and 2 k + 2, each with half of its run of triangles.
    """
    n = len(corners)
    middles = np.empty((n, 3))
    for i in range(n):
        order[i] = i
        for c in range(3):
            middles[i, c] = (corners[i, 0, c] + corners[i, 1, c] + corners[i, 2, c]) / 3.0
    runs = np.zeros((len(boxes), 2), np.int64)
    runs[0, 1] = n
    for node in range(len(boxes)):
        first, last = runs[node]
        if last <= first:
            continue
        for c in range(3):
            low, high = np.inf, -np.inf
            for i in range(first, last):
                for k in range(3):
                    low = min(low, corners[order[i], k, c])
                    high = max(high, corners[order[i], k, c])
            boxes[node, c], boxes[node, 3 + c] = low, high
        if 2 * node + 2 >= len(boxes):
            continue
        axis = 0
        for c in range(3):
            if boxes[node, 3 + c] - boxes[node, c] > boxes[node, 3 + axis] - boxes[node, axis]:
                axis = c
        half = (first + last) // 2
        _part(order, middles, axis, first, last, half)
        runs[2 * node + 1, 0], runs[2 * node + 1, 1] = first, half
        runs[2 * node + 2, 0], runs[2 * node + 2, 1] = half, last


@njit(cache=True, nogil=True, error_model="numpy")
def _part(order, middles, axis, first, last, half):
    """Bring the smaller ones along an axis before place ``half`` (Hoare's selection)."""
    low, high = first, last - 1
    while low < high:
        pivot = middles[order[(low + high) // 2], axis]
        i, j = low, high
        while i <= j:
            while middles[order[i], axis] < pivot:
                i += 1
            while middles[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if half <= j:
            high = j
        elif half >= i:
            low = i
        else:
            return


@njit(cache=True, nogil=True, error_model="numpy")
def distances(first, pieces, step, piece, points, corners, planes, normals, boxes, out):
    """Signed distance of ``points`` (n, 3), piece by piece; triangles in the order of the tree.

    ``planes`` (n, 4): unit normal and height over 0; ``normals`` (n, 7, 3): of the face, of the
    edges 01, 12, 20 and of the corners 0, 1, 2.
    """
    waiting, gaps = np.empty(2 * DEPTH, np.int64), np.empty(2 * DEPTH)
    runs = np.empty((2 * DEPTH, 2), np.int64)
    near, best = np.empty(3), np.empty(3)
    for k in range(first, pieces, step):
        hit = 0
        for i in range(k * piece, min((k + 1) * piece, len(points))):
            # the last point's triangle first: neighbours have it in common
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            part = _nearest(x, y, z, corners[hit], best)
            least = (x - best[0]) ** 2 + (y - best[1]) ** 2 + (z - best[2]) ** 2
            waiting[0], gaps[0], count = 0, _gap(x, y, z, boxes[0]), 1
            runs[0, 0], runs[0, 1] = 0, len(corners)
            while count > 0:
                count -= 1
                node, low, high = waiting[count], runs[count, 0], runs[count, 1]
                if gaps[count] >= least:
                    continue
                if 2 * node + 2 >= len(boxes):
                    for t in range(low, high):
                        over = x * planes[t, 0] + y * planes[t, 1] + z * planes[t, 2] - planes[t, 3]
                        if over * over >= least:
                            continue
                        here = _nearest(x, y, z, corners[t], near)
                        gap = (x - near[0]) ** 2 + (y - near[1]) ** 2 + (z - near[2]) ** 2
                        if gap < least:
                            least, hit, part = gap, t, here
                            best[0], best[1], best[2] = near[0], near[1], near[2]
                    continue
                half = (low + high) // 2
                left = _gap(x, y, z, boxes[2 * node + 1])
                right = _gap(x, y, z, boxes[2 * node + 2])
                for turn in range(2):  # the nearer one is put down last and taken first
                    second = (turn == 0) == (left <= right)
                    gap = right if second else left
                    if gap < least:
                        waiting[count] = 2 * node + 2 if second else 2 * node + 1
                        gaps[count] = gap
                        runs[count, 0] = half if second else low
                        runs[count, 1] = high if second else half
                        count += 1
            side = 0.0
            side += (x - best[0]) * normals[hit, part, 0]
            side += (y - best[1]) * normals[hit, part, 1]
            side += (z - best[2]) * normals[hit, part, 2]
            out[i] = math.copysign(math.sqrt(least), side)


@njit(cache=True, nogil=True, error_model="numpy")
def curve(points, box, codes):
    """Places of ``points`` (n, 3) along Morton's curve through 64^3 cells of a box (6,)."""
    for i in range(len(points)):
        code = 0
        for c in range(3):
            share = 64.0 * (points[i, c] - box[c]) / (box[3 + c] - box[c])
            cell = int(min(max(share, 0.0), 63.0)) if share == share else 0
            for bit in range(6):
                code |= ((cell >> bit) & 1) << (3 * bit + c)
        codes[i] = code


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _gap(x, y, z, box):
    """Squared distance to a box."""
    dx = max(box[0] - x, 0.0, x - box[3])
    dy = max(box[1] - y, 0.0, y - box[4])
    dz = max(box[2] - z, 0.0, z - box[5])
    return dx * dx + dy * dy + dz * dz


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(x, y, z, t, out):
    """Write a triangle's nearest point; which part it is on: face 0, edges 1 to 3, corners 4 to 6.

    The regions of the plane of the triangle are told apart by signs of areas (C. Ericson,
    Real-Time Collision Detection, 2005, section 5.1.5).
    """
    ax, ay, az = t[0, 0], t[0, 1], t[0, 2]
    ux, uy, uz = t[1, 0] - ax, t[1, 1] - ay, t[1, 2] - az
    vx, vy, vz = t[2, 0] - ax, t[2, 1] - ay, t[2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    uu, uv, vv = (
        ux * ux + uy * uy + uz * uz,
        ux * vx + uy * vy + uz * vz,
        vx * vx + vy * vy + vz * vz,
    )
    pu, pv = px * ux + py * uy + pz * uz, px * vx + py * vy + pz * vz
    d3, d4, d5, d6 = pu - uu, pv - uv, pu - uv, pv - vv  # seen from the corners 1 and 2
    s, r, part = 0.0, 0.0, 4
    if pu <= 0.0 and pv <= 0.0:
        part = 4
    elif d3 >= 0.0 and d4 <= d3:
        s, part = 1.0, 5
    elif d6 >= 0.0 and d5 <= d6:
        r, part = 1.0, 6
    else:
        vc, vb, va = pu * d4 - d3 * pv, d5 * pv - pu * d6, d3 * d6 - d5 * d4
        if vc <= 0.0 and pu >= 0.0 and d3 <= 0.0:
            s, part = pu / uu, 1
        elif vb <= 0.0 and pv >= 0.0 and d6 <= 0.0:
            r, part = pv / vv, 3
        elif va <= 0.0 and d4 >= d3 and d5 >= d6:
            r = (d4 - d3) / (uu - 2.0 * uv + vv)
            s, part = 1.0 - r, 2
        else:
            scale = 1.0 / (va + vb + vc)
            s, r, part = vb * scale, vc * scale, 0
    out[0] = ax + s * ux + r * vx
    out[1] = ay + s * uy + r * vy
    out[2] = az + s * uz + r * vz
    return part
