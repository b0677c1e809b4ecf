"""Compiled interpolants of nodal values: cubic in every cell, continuous over the whole mesh.

In a cell the interpolant is the tensor product of the cubics through the four nodes around it: of
order 4, its gradient of order 3; on a face it is made of that face's own lines, so it is continuous
across, and along a mesh line it is the cubic of that line's nodes. At an unbounded edge the four
nodes lean inward, and beyond the edge the interpolant goes on straight. ``flat`` holds the nodes in
C order; points are in node units, node i at i. With ``gaps`` a value of exactly zero is a node that
is unset (`TINY` stands for a known zero): where the four nodes are not all set the cell is
multilinear, and where its own corners are not, every value is NaN.

A cubic through a kink overshoots. ``kinds``, one number per cell or None, says where `kind_of`
found a kink beside a cell: along that axis it takes the parabola on the other side instead. Two
bits per axis (`KIND_X`, ...): 0 the cubic, 1 the parabola of nodes -1, 0, 1, 2 that of 0, 1, 2.
There the interpolant of a cell does not quite join those of its neighbours.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from numba import njit

TINY = 1e-30  # a known zero among values where zero says unset
KIND_X, KIND_Y, KIND_Z = 0, 2, 4  # where the bits of each axis begin; in the plane x and z
KINK = 0.25  # a third difference so large beside the first ones is no longer smooth


@njit(cache=True, nogil=True)
def beside(index, step, size, wraps):
    """The node some steps on along an axis; -1 beyond an unbounded edge."""
    other = index + step
    if 0 <= other < size:
        return other
    return other % size if wraps and size > 1 else -1


@njit(cache=True, nogil=True)
def four(x, n, wraps):
    """The four nodes around x, where x is from the second of them, and how far beyond the edge."""
    if wraps:
        cell = math.floor(x)
        k = int(cell)
        a = (k - 1) % n
        b = a + 1 if a + 1 < n else 0
        c = b + 1 if b + 1 < n else 0
        d = c + 1 if c + 1 < n else 0
        return a, b, c, d, x - cell, 0.0
    inner = min(max(x, 0.0), n - 1.0)
    k = min(max(int(inner), 1), n - 3)
    return k - 1, k, k + 1, k + 2, inner - k, x - inner


@njit(cache=True, nogil=True)
def two(x, n, wraps):
    """The two nodes around x, and where x is from the first of them."""
    if wraps:
        cell = math.floor(x)
        a = int(cell) % n
        return a, (a + 1 if a + 1 < n else 0), x - cell
    k = min(int(max(x, 0.0)), n - 2)
    return k, k + 1, x - k


@njit(cache=True, nogil=True)
def weights(u, kind=0):
    """Of the cubic through the nodes -1, 0, 1, 2, at u; of a parabola through three of them."""
    a, b, c = u + 1.0, u - 1.0, u - 2.0
    if kind == 1:
        return 0.5 * u * b, -a * b, 0.5 * a * u, 0.0
    if kind == 2:
        return 0.0, 0.5 * b * c, -u * c, 0.5 * u * b
    return -u * b * c / 6.0, a * b * c / 2.0, -a * u * c / 2.0, a * u * b / 6.0


@njit(cache=True, nogil=True)
def slopes(u, kind=0):
    """Derivatives of the weights."""
    if kind == 1:
        return u - 0.5, -2.0 * u, u + 0.5, 0.0
    if kind == 2:
        return 0.0, u - 1.5, 2.0 - 2.0 * u, u - 0.5
    square = u * u
    return (
        (-3.0 * square + 6.0 * u - 2.0) / 6.0,
        (3.0 * square - 4.0 * u - 1.0) / 2.0,
        (-3.0 * square + 2.0 * u + 2.0) / 2.0,
        (3.0 * square - 1.0) / 6.0,
    )


@njit(cache=True, nogil=True)
def bends(u, kind=0):
    """Second derivatives of the weights."""
    if kind == 1:
        return 1.0, -2.0, 1.0, 0.0
    if kind == 2:
        return 0.0, 1.0, -2.0, 1.0
    return 1.0 - u, 3.0 * u - 2.0, 1.0 - 3.0 * u, u


@njit(cache=True, nogil=True)
def kind_of(first, ahead, turn_low, turn_high):
    """Kind of a cell: from the largest first difference and the second ones at its two ends."""
    if ahead <= KINK * first:
        return 0
    return 1 if turn_low <= turn_high else 2


@njit(cache=True, nogil=True)
def kind_at(kinds, cell, shift, u):
    """What ``kinds`` says of a cell and axis; the cubic where four nodes lean inward."""
    if 0.0 <= u <= 1.0:
        return (kinds[cell] >> shift) & 3
    return 0


@njit(cache=True, nogil=True)
def kinds_at(kinds, cell, u, v, w):
    """The same of a cell's three axes; of a plane's, the middle one says nothing."""
    if kinds is None:
        return 0, 0, 0
    return (
        kind_at(kinds, cell, KIND_X, u),
        kind_at(kinds, cell, KIND_Y, v),
        kind_at(kinds, cell, KIND_Z, w),
    )


@njit(cache=True, nogil=True)
def gradient2(flat, shape, wraps, gaps, x, y, kinds=None):
    """Value and gradient per node spacing at a point of the plane."""
    a0, a1, a2, a3, u, over_x = four(x, shape[0], wraps[0])
    b0, b1, b2, b3, v, over_y = four(y, shape[1], wraps[1])
    ku, _, kv = kinds_at(kinds, a1 * shape[1] + b1, u, 0.0, v)
    wu, du = weights(u, ku), slopes(u, ku)
    wv, dv = weights(v, kv), slopes(v, kv)
    p, px, py = 0.0, 0.0, 0.0
    rows = (a0, a1, a2, a3)
    for i in range(4):
        base = rows[i] * shape[1]
        f0, f1, f2, f3 = flat[base + b0], flat[base + b1], flat[base + b2], flat[base + b3]
        if gaps and (f0 == 0.0 or f1 == 0.0 or f2 == 0.0 or f3 == 0.0):
            return linear2(flat, shape, wraps, x, y)
        s = wv[0] * f0 + wv[1] * f1 + wv[2] * f2 + wv[3] * f3
        p += wu[i] * s
        px += du[i] * s
        py += wu[i] * (dv[0] * f0 + dv[1] * f1 + dv[2] * f2 + dv[3] * f3)
    return p + px * over_x + py * over_y, px, py


@njit(cache=True, nogil=True)
def linear2(flat, shape, wraps, x, y):
    """Value and gradient of the bilinear interpolant; NaN where a corner is unset."""
    a0, a1, u = two(x, shape[0], wraps[0])
    b0, b1, v = two(y, shape[1], wraps[1])
    n = shape[1]
    f00, f01 = flat[a0 * n + b0], flat[a0 * n + b1]
    f10, f11 = flat[a1 * n + b0], flat[a1 * n + b1]
    if f00 == 0.0 or f01 == 0.0 or f10 == 0.0 or f11 == 0.0:
        return math.nan, math.nan, math.nan
    low, high = f00 + v * (f01 - f00), f10 + v * (f11 - f10)
    across = (1.0 - u) * (f01 - f00) + u * (f11 - f10)
    return low + u * (high - low), high - low, across


@njit(cache=True, nogil=True)
def hessian2(flat, shape, wraps, gaps, x, y, kinds=None):
    """Second derivatives xx, xy, yy per squared node spacing; zero where the cell is bilinear."""
    a0, a1, a2, a3, u, _ = four(x, shape[0], wraps[0])
    b0, b1, b2, b3, v, _ = four(y, shape[1], wraps[1])
    ku, _, kv = kinds_at(kinds, a1 * shape[1] + b1, u, 0.0, v)
    wu, du, cu = weights(u, ku), slopes(u, ku), bends(u, ku)
    wv, dv, cv = weights(v, kv), slopes(v, kv), bends(v, kv)
    xx, xy, yy = 0.0, 0.0, 0.0
    rows = (a0, a1, a2, a3)
    for i in range(4):
        base = rows[i] * shape[1]
        f0, f1, f2, f3 = flat[base + b0], flat[base + b1], flat[base + b2], flat[base + b3]
        if gaps and (f0 == 0.0 or f1 == 0.0 or f2 == 0.0 or f3 == 0.0):
            return 0.0, 0.0, 0.0
        xx += cu[i] * (wv[0] * f0 + wv[1] * f1 + wv[2] * f2 + wv[3] * f3)
        xy += du[i] * (dv[0] * f0 + dv[1] * f1 + dv[2] * f2 + dv[3] * f3)
        yy += wu[i] * (cv[0] * f0 + cv[1] * f1 + cv[2] * f2 + cv[3] * f3)
    return xx, xy, yy


@njit(cache=True, nogil=True)
def gradient3(flat, shape, wraps, gaps, x, y, z, kinds=None):
    """Value and gradient per node spacing at a point of space."""
    a0, a1, a2, a3, u, over_x = four(x, shape[0], wraps[0])
    b0, b1, b2, b3, v, over_y = four(y, shape[1], wraps[1])
    c0, c1, c2, c3, w, over_z = four(z, shape[2], wraps[2])
    ku, kv, kw = kinds_at(kinds, (a1 * shape[1] + b1) * shape[2] + c1, u, v, w)
    wu, du = weights(u, ku), slopes(u, ku)
    wv, dv = weights(v, kv), slopes(v, kv)
    ww, dw = weights(w, kw), slopes(w, kw)
    p, px, py, pz = 0.0, 0.0, 0.0, 0.0
    planes, rows = (a0, a1, a2, a3), (b0, b1, b2, b3)
    for i in range(4):
        q, qy, qz = 0.0, 0.0, 0.0
        for j in range(4):
            base = (planes[i] * shape[1] + rows[j]) * shape[2]
            f0, f1, f2, f3 = flat[base + c0], flat[base + c1], flat[base + c2], flat[base + c3]
            if gaps and (f0 == 0.0 or f1 == 0.0 or f2 == 0.0 or f3 == 0.0):
                return linear3(flat, shape, wraps, x, y, z)
            s = ww[0] * f0 + ww[1] * f1 + ww[2] * f2 + ww[3] * f3
            q += wv[j] * s
            qy += dv[j] * s
            qz += wv[j] * (dw[0] * f0 + dw[1] * f1 + dw[2] * f2 + dw[3] * f3)
        p += wu[i] * q
        px += du[i] * q
        py += wu[i] * qy
        pz += wu[i] * qz
    return p + px * over_x + py * over_y + pz * over_z, px, py, pz


@njit(cache=True, nogil=True)
def linear3(flat, shape, wraps, x, y, z):
    """Value and gradient of the trilinear interpolant; NaN where a corner is unset."""
    a0, a1, u = two(x, shape[0], wraps[0])
    b0, b1, v = two(y, shape[1], wraps[1])
    c0, c1, w = two(z, shape[2], wraps[2])
    p, px, py, pz = 0.0, 0.0, 0.0, 0.0
    for i in range(2):
        wu, du = (u, 1.0) if i else (1.0 - u, -1.0)
        for j in range(2):
            wv, dv = (v, 1.0) if j else (1.0 - v, -1.0)
            base = ((a1 if i else a0) * shape[1] + (b1 if j else b0)) * shape[2]
            f0, f1 = flat[base + c0], flat[base + c1]
            if f0 == 0.0 or f1 == 0.0:
                return math.nan, math.nan, math.nan, math.nan
            s = f0 + w * (f1 - f0)
            p += wu * wv * s
            px += du * wv * s
            py += wu * dv * s
            pz += wu * wv * (f1 - f0)
    return p, px, py, pz


@njit(cache=True, nogil=True)
def hessian3(flat, shape, wraps, gaps, x, y, z, kinds=None):
    """Second derivatives xx, yy, zz, xy, xz, yz; zero where the cell is trilinear."""
    a0, a1, a2, a3, u, _ = four(x, shape[0], wraps[0])
    b0, b1, b2, b3, v, _ = four(y, shape[1], wraps[1])
    c0, c1, c2, c3, w, _ = four(z, shape[2], wraps[2])
    ku, kv, kw = kinds_at(kinds, (a1 * shape[1] + b1) * shape[2] + c1, u, v, w)
    wu, du, cu = weights(u, ku), slopes(u, ku), bends(u, ku)
    wv, dv, cv = weights(v, kv), slopes(v, kv), bends(v, kv)
    ww, dw, cw = weights(w, kw), slopes(w, kw), bends(w, kw)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    planes, rows = (a0, a1, a2, a3), (b0, b1, b2, b3)
    for i in range(4):
        q, qy, qz, qyy, qyz, qzz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            base = (planes[i] * shape[1] + rows[j]) * shape[2]
            f0, f1, f2, f3 = flat[base + c0], flat[base + c1], flat[base + c2], flat[base + c3]
            if gaps and (f0 == 0.0 or f1 == 0.0 or f2 == 0.0 or f3 == 0.0):
                return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            s = ww[0] * f0 + ww[1] * f1 + ww[2] * f2 + ww[3] * f3
            d = dw[0] * f0 + dw[1] * f1 + dw[2] * f2 + dw[3] * f3
            q += wv[j] * s
            qy += dv[j] * s
            qz += wv[j] * d
            qyy += cv[j] * s
            qyz += dv[j] * d
            qzz += wv[j] * (cw[0] * f0 + cw[1] * f1 + cw[2] * f2 + cw[3] * f3)
        xx += cu[i] * q
        xy += du[i] * qy
        xz += du[i] * qz
        yy += wu[i] * qyy
        yz += wu[i] * qyz
        zz += wu[i] * qzz
    return xx, yy, zz, xy, xz, yz
