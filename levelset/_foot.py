"""Compiled search for the foot of a node: the nearest point of the interpolant's zero contour.

Fields are (nx, nm, nc) in C order; in 2-D the middle axis has one node and all goes on in a plane.
Lengths are in node units; a foot is told by its offset from its node: periodic axes need no care.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from numba import njit

from levelset import _interpolant
from levelset._interpolant import (
    four,
    gradient2,
    gradient3,
    hessian2,
    hessian3,
    kind_of,
    slopes,
    two,
    weights,
)
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__)

CLOSE = 3e-4  # a Newton step so short is the last: what is left is of its square
LANDED = 1e-8  # so near is on the contour
STILL = 1e-3  # a slide so short is the last
NEWTON, SLIDES, LANDINGS = 8, 20, 6  # most steps of each search
SAME, JUMP = 1e-6, 0.1  # a foot may be farther than the start by so much; so at kinks' cells
BEYOND = 8.0  # a contour goes on straight beyond an unbounded edge, so far


@njit(cache=True, nogil=True)
def probe(flat, kinds, shape, wraps, gaps, x, y, z):
    """Value and gradient of the interpolant; NaN where nothing is known."""
    if (
        not (abs(x - 0.5 * shape[0]) < 0.5 * shape[0] + BEYOND)
        or not (abs(z - 0.5 * shape[2]) < 0.5 * shape[2] + BEYOND)
        or not (abs(y - 0.5 * shape[1]) < 0.5 * shape[1] + BEYOND)
    ):
        return math.nan, math.nan, math.nan, math.nan
    if shape[1] > 1:
        return gradient3(flat, shape, wraps, gaps, x, y, z, kinds)
    p, px, pz = gradient2(flat, (shape[0], shape[2]), (wraps[0], wraps[2]), gaps, x, z, kinds)
    return p, px, 0.0, pz


@njit(cache=True, nogil=True)
def bend(flat, kinds, shape, wraps, gaps, x, y, z):
    """Second derivatives xx, yy, zz, xy, xz, yz."""
    if shape[1] > 1:
        return hessian3(flat, shape, wraps, gaps, x, y, z, kinds)
    xx, xz, zz = hessian2(flat, (shape[0], shape[2]), (wraps[0], wraps[2]), gaps, x, z, kinds)
    return xx, 0.0, zz, 0.0, xz, 0.0


@njit(cache=True, nogil=True)
def foot(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c):
    """Offset of the nearest contour point to a node, searched from the contour point at (a, b, c).

    Newton on p = 0 and (node - foot) along grad p, both at once; never farther than the start.
    """
    most = math.sqrt(a * a + b * b + c * c)
    u, v, w = a, b, c
    xx = yy = zz = xy = xz = yz = 0.0
    for turn in range(NEWTON):
        p, px, py, pz = probe(flat, kinds, shape, wraps, gaps, x + u, y + v, z + w)
        square = px * px + py * py + pz * pz
        if not square > 0.0:
            break
        length = math.sqrt(square)
        nx, ny, nz = px / length, py / length, pz / length
        off = p / length
        height = -(u * nx + v * ny + w * nz)
        tx, ty, tz = -u - height * nx, -v - height * ny, -w - height * nz
        aside = tx * tx + ty * ty + tz * tz
        if aside > CLOSE * CLOSE:
            if turn % 3 == 0:
                xx, yy, zz, xy, xz, yz = bend(flat, kinds, shape, wraps, gaps, x + u, y + v, z + w)
            k = (height + off) / length
            tx, ty, tz = along(tx, ty, tz, nx, ny, nz, k, xx, yy, zz, xy, xz, yz)
        tx, ty, tz = tx - off * nx, ty - off * ny, tz - off * nz
        size = math.sqrt(tx * tx + ty * ty + tz * tz)
        if size > 1.0:
            tx, ty, tz = tx / size, ty / size, tz / size
        u, v, w = u + tx, v + ty, w + tz
        if size < CLOSE:
            away = math.sqrt(u * u + v * v + w * w)
            if away <= most + SAME:
                return u, v, w, away
            if away <= most + JUMP and (
                kinked(kinds, shape, wraps, x + a, y + b, z + c)
                or kinked(kinds, shape, wraps, x + u, y + v, z + w)
            ):
                return u, v, w, away
            break
    return slide(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c)


@njit(cache=True, nogil=True)
def along(tx, ty, tz, nx, ny, nz, k, xx, yy, zz, xy, xz, yz):
    """The step along a contour that brings its foot below a node which is (tx, ty, tz) aside.

    Solves (1 + k H) step = t in the tangent plane, H the second derivatives there: a node higher
    by k over a curved contour is nearer to its foot than it is aside.
    """
    hx = xx * nx + xy * ny + xz * nz
    hy = xy * nx + yy * ny + yz * nz
    hz = xz * nx + yz * ny + zz * nz
    trace = k * (xx + yy + zz - (nx * hx + ny * hy + nz * hz))
    minor = nx * (nx * (yy * zz - yz * yz) + 2.0 * ny * (xz * yz - xy * zz))
    minor += ny * (ny * (xx * zz - xz * xz) + 2.0 * nz * (xy * xz - yz * xx))
    minor += nz * (nz * (xx * yy - xy * xy) + 2.0 * nx * (xy * yz - xz * yy))
    det = 1.0 + trace + k * k * minor
    if not det > 0.1:  # near a centre of curvature
        return tx, ty, tz
    sx = k * (xx * tx + xy * ty + xz * tz)
    sy = k * (xy * tx + yy * ty + yz * tz)
    sz = k * (xz * tx + yz * ty + zz * tz)
    out = sx * nx + sy * ny + sz * nz
    return (
        ((1.0 + trace) * tx - sx + out * nx) / det,
        ((1.0 + trace) * ty - sy + out * ny) / det,
        ((1.0 + trace) * tz - sz + out * nz) / det,
    )


@njit(cache=True, nogil=True)
def kind_around(kinds, shape, wraps, x, y, z):
    """What is said of the cell around a point."""
    a, _, _ = two(x, shape[0], wraps[0])
    b = two(y, shape[1], wraps[1])[0] if shape[1] > 1 else 0
    c, _, _ = two(z, shape[2], wraps[2])
    return kinds[(a * shape[1] + b) * shape[2] + c]


@njit(cache=True, nogil=True)
def kinked(kinds, shape, wraps, x, y, z):
    """Whether the cell around a point is beside a kink, where contours of cells do not join."""
    return (kind_around(kinds, shape, wraps, x, y, z) & 63) != 0


@njit(cache=True, nogil=True)
def slide(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c):
    """The same by steps along the contour that shorten the distance: slow, but it cannot fail."""
    u, v, w, found = land(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c)
    if found:
        a, b, c = u, v, w
    nearest = math.sqrt(a * a + b * b + c * c)
    share = 1.0
    for _ in range(SLIDES):
        _, px, py, pz = probe(flat, kinds, shape, wraps, gaps, x + a, y + b, z + c)
        square = px * px + py * py + pz * pz
        if not square > 0.0:
            break
        height = -(a * px + b * py + c * pz) / square
        tx, ty, tz = -a - height * px, -b - height * py, -c - height * pz
        size = math.sqrt(tx * tx + ty * ty + tz * tz)
        part = min(share, 0.5 / max(size, 1e-12))
        if part * size < STILL:
            break
        u, v, w, found = land(
            flat, kinds, shape, wraps, gaps, x, y, z, a + part * tx, b + part * ty, c + part * tz
        )
        away = math.sqrt(u * u + v * v + w * w)
        if found and away < nearest:
            a, b, c, nearest = u, v, w, away
            share = min(2.0 * part, 1.0)
        else:
            share = 0.25 * part
    return a, b, c, nearest


@njit(cache=True, nogil=True)
def land(flat, kinds, shape, wraps, gaps, x, y, z, a, b, c):
    """From an offset along the gradient to the contour, at most half a spacing; and whether."""
    u, v, w = a, b, c
    for _ in range(LANDINGS):
        p, px, py, pz = probe(flat, kinds, shape, wraps, gaps, x + u, y + v, z + w)
        square = px * px + py * py + pz * pz
        if not square > 0.0:
            return a, b, c, False
        p /= square
        u, v, w = u - p * px, v - p * py, w - p * pz
        if (u - a) ** 2 + (v - b) ** 2 + (w - c) ** 2 > 0.25:
            return a, b, c, False
        if p * p * square < LANDED * LANDED:
            return u, v, w, True
    return a, b, c, False


@njit(cache=True, nogil=True)
def crossing(flat, stride, base, i, n, wraps, gaps, forward):
    """Distance from node i of a mesh line to the contour before the next node, of other sign.

    The line's nodes are ``flat[base + stride * i]``; the root is of the cubic that the interpolant
    is there, by Newton between the two nodes' bounds.
    """
    a, b, c, d, u, _ = four(float(i) if forward else i - 1.0, n, wraps)
    fa, fb = flat[base + stride * a], flat[base + stride * b]
    fc, fd = flat[base + stride * c], flat[base + stride * d]
    first = a if u < -0.5 else (b if u < 0.5 else c)
    second = b if u < -0.5 else (c if u < 0.5 else d)
    low, high = float(flat[base + stride * first]), float(flat[base + stride * second])
    root = low / (low - high)
    kind = 0
    if first == b:
        turn_low, turn_high = fa - 2.0 * fb + fc, fb - 2.0 * fc + fd
        largest = max(abs(fb - fa), abs(fc - fb), abs(fd - fc))
        kind = kind_of(largest, abs(turn_high - turn_low), abs(turn_low), abs(turn_high))
    if not (gaps and (fa == 0.0 or fb == 0.0 or fc == 0.0 or fd == 0.0)):
        left, right = 0.0, 1.0
        for _ in range(40):
            w, s = weights(u + root, kind), slopes(u + root, kind)
            value = w[0] * fa + w[1] * fb + w[2] * fc + w[3] * fd
            slope = s[0] * fa + s[1] * fb + s[2] * fc + s[3] * fd
            if (value < 0.0) == (low < 0.0):
                left = root
            else:
                right = root
            new = root - value / slope if slope != 0.0 else -1.0
            if not left <= new <= right:
                new = 0.5 * (left + right)
            moved = abs(new - root)
            root = new
            if moved < 1e-12:
                break
    return root if forward else 1.0 - root
