"""Compiled loops over nodes: derivatives of what is known there, and the surface operators.

Fields are flat, of three axes; an axis of one node, as in the plane, has no derivative. With
``gaps`` a value of exactly zero is a node that is unset, and not read. Differences are central, of
order 4 where all their nodes are known, else of order 2, else they lean to the side that is; NaN
where even that fails.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from levelset import _interpolant
from levelset._interpolant import beside
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__)

FLAT = 1e-150  # squared slopes below it have no direction


@njit(cache=True, nogil=True, inline="always")
def slope(f, ok):
    """First derivative per node spacing from five nodes."""
    if ok[1] and ok[3]:
        if ok[0] and ok[4]:
            return (8.0 * (f[3] - f[1]) - (f[4] - f[0])) / 12.0
        return 0.5 * (f[3] - f[1])
    if ok[3]:
        return 0.5 * (4.0 * f[3] - 3.0 * f[2] - f[4]) if ok[4] else f[3] - f[2]
    if ok[1]:
        return 0.5 * (3.0 * f[2] - 4.0 * f[1] + f[0]) if ok[0] else f[2] - f[1]
    return math.nan


@njit(cache=True, nogil=True, inline="always")
def bend(f, ok):
    """Second derivative per squared node spacing from five nodes."""
    if ok[1] and ok[3]:
        if ok[0] and ok[4]:
            return (16.0 * (f[3] + f[1]) - (f[4] + f[0]) - 30.0 * f[2]) / 12.0
        return (f[3] + f[1]) - 2.0 * f[2]
    if ok[3] and ok[4]:
        return (f[2] + f[4]) - 2.0 * f[3]
    if ok[1] and ok[0]:
        return (f[2] + f[0]) - 2.0 * f[1]
    return math.nan


@njit(cache=True, nogil=True)
def twist(flat, gaps, place, first, second, shape, wraps, f, ok):
    """Mixed derivative per squared node spacing: order 4, or the mean of the quadrants known."""
    strides = (shape[1] * shape[2], shape[2], 1)
    here = place[0] * strides[0] + place[1] * strides[1] + place[2]
    base = here - place[first] * strides[first] - place[second] * strides[second]
    all_known = True
    for a in range(5):
        i = beside(place[first], a - 2, shape[first], wraps[first])
        for b in range(5):
            j = beside(place[second], b - 2, shape[second], wraps[second])
            node = base + i * strides[first] + j * strides[second]
            ok[a, b] = i >= 0 and j >= 0 and not (gaps and flat[node] == 0.0)
            f[a, b] = flat[node] if ok[a, b] else 0.0
            all_known &= ok[a, b] or a == 2 or b == 2
    if all_known:
        near = (f[3, 3] + f[1, 1]) - (f[3, 1] + f[1, 3])
        far = (f[4, 4] + f[0, 0]) - (f[4, 0] + f[0, 4])
        long = ((f[4, 3] + f[0, 1]) - (f[4, 1] + f[0, 3])) + (
            (f[3, 4] + f[1, 0]) - (f[3, 0] + f[1, 4])
        )
        return (64.0 * near - 8.0 * long + far) / 144.0
    total, count = 0.0, 0
    for a in (1, 3):
        for b in (1, 3):
            if ok[a, b] and ok[a, 2] and ok[2, b]:
                total += (a - 2) * (b - 2) * ((f[a, b] + f[2, 2]) - (f[a, 2] + f[2, b]))
                count += 1
    return total / count if count else math.nan


@njit(cache=True, nogil=True)
def jet(flat, gaps, place, shape, wraps, second, f, ok, g, gk, out):
    """Slopes out[:3], bends out[3:6], twists xy, xz, yz out[6:] of a field at one node."""
    out[:] = 0.0
    strides = (shape[1] * shape[2], shape[2], 1)
    here = place[0] * strides[0] + place[1] * strides[1] + place[2]
    for axis in range(3):
        if shape[axis] == 1:
            continue
        for a in range(5):
            i = beside(place[axis], a - 2, shape[axis], wraps[axis])
            node = here + (i - place[axis]) * strides[axis]
            ok[a] = i >= 0 and not (gaps and flat[node] == 0.0)
            f[a] = flat[node] if ok[a] else 0.0
        out[axis] = slope(f, ok)
        if second:
            out[3 + axis] = bend(f, ok)
    if second:
        for pair in range(3):
            a, b = (0, 0, 1)[pair], (1, 2, 2)[pair]
            if shape[a] > 1 and shape[b] > 1:
                out[6 + pair] = twist(flat, gaps, place, a, b, shape, wraps, g, gk)


@njit(cache=True, nogil=True)
def scratch():
    """Stencils of a line and of a plane, and which of their nodes are known."""
    return np.empty(5), np.empty(5, np.bool_), np.empty((5, 5)), np.empty((5, 5), np.bool_)


@njit(cache=True, nogil=True)
def jets(phi, values, node, gaps, shape, wraps, second, work, p, c):
    """Squared slope of phi, and its product with the slope of the values; p and c as in `jet`."""
    f, ok, g, gk = work
    plane = shape[1] * shape[2]
    place = (node // plane, node // shape[2] % shape[1], node % shape[2])
    jet(phi, gaps, place, shape, wraps, second, f, ok, g, gk, p)
    jet(values, gaps, place, shape, wraps, second, f, ok, g, gk, c)
    steep = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
    return steep, p[0] * c[0] + p[1] * c[1] + p[2] * c[2]


@njit(cache=True, nogil=True)
def surface_gradient(first, pieces, step, rows, phi, values, nodes, gaps, shape, wraps, h, out):
    """(I - n n) grad values at the nodes; the whole gradient where phi is flat. out (3, n)."""
    work, p, c = scratch(), np.empty(9), np.empty(9)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, out.shape[1])):
            node = nodes[m] if gaps else m
            steep, along = jets(phi, values, node, gaps, shape, wraps, False, work, p, c)
            share = along / steep if not steep < FLAT else 0.0
            for axis in range(3):
                out[axis, m] = (c[axis] - share * p[axis]) / h


@njit(cache=True, nogil=True)
def laplace_beltrami(first, pieces, step, rows, phi, values, nodes, gaps, shape, wraps, h, out):
    """tr(P H_c) - kappa n.grad c, P = I - n n, kappa = tr(P H_phi)/|grad phi|; NaN if flat."""
    work, p, c = scratch(), np.empty(9), np.empty(9)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(out))):
            node = nodes[m] if gaps else m
            steep, along = jets(phi, values, node, gaps, shape, wraps, True, work, p, c)
            if steep < FLAT:
                out[m] = math.nan
                continue
            out[m] = (across(c, p, steep) - across(p, p, steep) * along / steep) / (h * h)


@njit(cache=True, nogil=True, inline="always")
def across(c, p, steep):
    """tr((I - n n) H) of the second derivatives in c, n along the slopes in p."""
    trace = c[3] + c[4] + c[5]
    pure = p[0] * p[0] * c[3] + p[1] * p[1] * c[4] + p[2] * p[2] * c[5]
    mixed = p[0] * p[1] * c[6] + p[0] * p[2] * c[7] + p[1] * p[2] * c[8]
    return trace - (pure + 2.0 * mixed) / steep
