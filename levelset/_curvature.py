"""Compiled loops over nodes: unit normals and curvatures from the derivatives of phi."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from levelset import _surface_operators
from levelset._surface_operators import FLAT, across, jet
from remesh.compiled import drop_stale

drop_stale(__file__, _surface_operators.__file__)


@njit(cache=True, nogil=True)
def curvatures(first, pieces, step, rows, phi, known, nodes, shape, wraps, h, gaussian, out):
    """Mean curvature div n, or the Gaussian one, at the nodes; NaN where phi is flat."""
    f, g = np.empty(5), np.empty((5, 5))
    ok, gk = np.empty(5, np.bool_), np.empty((5, 5), np.bool_)
    p = np.empty(9)
    place = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(nodes))):
            place[0] = nodes[m] // (shape[1] * shape[2])
            place[1] = nodes[m] // shape[2] % shape[1]
            place[2] = nodes[m] % shape[2]
            jet(phi, known, place, shape, wraps, True, f, ok, g, gk, p)
            steep = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
            if steep < FLAT:
                out[m] = math.nan
            elif gaussian:
                out[m] = product(p) / (steep * steep * h * h)
            else:
                out[m] = across(p, p, steep) / (math.sqrt(steep) * h)


@njit(cache=True, nogil=True)
def normals(first, pieces, step, rows, phi, known, nodes, shape, wraps, out):
    """grad phi / |grad phi| at the nodes, zero where phi is flat; out (3, n)."""
    f, g = np.empty(5), np.empty((5, 5))
    ok, gk = np.empty(5, np.bool_), np.empty((5, 5), np.bool_)
    p = np.empty(9)
    place = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(nodes))):
            place[0] = nodes[m] // (shape[1] * shape[2])
            place[1] = nodes[m] // shape[2] % shape[1]
            place[2] = nodes[m] % shape[2]
            jet(phi, known, place, shape, wraps, False, f, ok, g, gk, p)
            steep = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
            share = 0.0 if steep < FLAT else 1.0 / math.sqrt(steep)
            for axis in range(3):
                out[axis, m] = share * p[axis]


@njit(cache=True, nogil=True, inline="always")
def product(p):
    """g . adj(H) g with the slopes and second derivatives in p."""
    xx, yy, zz, xy, xz, yz = p[3], p[4], p[5], p[6], p[7], p[8]
    pure = p[0] * p[0] * (yy * zz - yz * yz)
    pure += p[1] * p[1] * (xx * zz - xz * xz)
    pure += p[2] * p[2] * (xx * yy - xy * xy)
    mixed = p[0] * p[1] * (xz * yz - xy * zz)
    mixed += p[0] * p[2] * (xy * yz - xz * yy)
    mixed += p[1] * p[2] * (xy * xz - yz * xx)
    return pure + 2.0 * mixed
