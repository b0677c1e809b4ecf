"""Compiled loops over nodes: unit normals and curvatures from the derivatives of phi."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from levelset import _interpolant, _surface_operators
from levelset._surface_operators import FLAT, across, jet, scratch
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__, _surface_operators.__file__)


@njit(cache=True, nogil=True)
def at(phi, node, gaps, shape, wraps, second, work, p):
    """Squared slope of phi at a node; derivatives in p as `jet` gives them."""
    f, ok, g, gk = work
    plane = shape[1] * shape[2]
    place = (node // plane, node // shape[2] % shape[1], node % shape[2])
    jet(phi, gaps, place, shape, wraps, second, f, ok, g, gk, p)
    return p[0] * p[0] + p[1] * p[1] + p[2] * p[2]


@njit(cache=True, nogil=True)
def curvatures(first, pieces, step, rows, phi, nodes, gaps, shape, wraps, h, gaussian, out):
    """Mean curvature div n, or the Gaussian one, at the nodes; NaN where phi is flat."""
    work, p = scratch(), np.empty(9)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, len(out))):
            steep = at(phi, nodes[m] if gaps else m, gaps, shape, wraps, True, work, p)
            if steep < FLAT:
                out[m] = math.nan
            elif gaussian:
                out[m] = product(p) / (steep * steep * h * h)
            else:
                out[m] = across(p, p, steep) / (math.sqrt(steep) * h)


@njit(cache=True, nogil=True)
def normals(first, pieces, step, rows, phi, nodes, gaps, shape, wraps, out):
    """grad phi / |grad phi| at the nodes, zero where phi is flat; out (3, n)."""
    work, p = scratch(), np.empty(9)
    for piece in range(first, pieces, step):
        for m in range(piece * rows, min((piece + 1) * rows, out.shape[1])):
            steep = at(phi, nodes[m] if gaps else m, gaps, shape, wraps, False, work, p)
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
