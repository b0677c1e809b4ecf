"""Compiled loops over points: nodal values there, and points brought onto the contour."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from numba import njit

from levelset import _interpolant
from levelset._interpolant import gradient2, gradient3
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__)

LANDINGS = 8  # Newton steps, at most


@njit(cache=True, nogil=True)
def at(flat, shape, wraps, gaps, x, y, z):
    """Value and gradient at a point in node units; in the plane the middle axis has one node."""
    if shape[1] == 1:
        p, px, pz = gradient2(flat, (shape[0], shape[2]), (wraps[0], wraps[2]), gaps, x, z)
        return p, px, 0.0, pz
    return gradient3(flat, shape, wraps, gaps, x, y, z)


@njit(cache=True, nogil=True)
def sample(first, pieces, step, size, flat, shape, wraps, points, out):
    """Values at points (n, 3) in node units, from nodes of which unset ones are zero."""
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(points))):
            out[n] = at(flat, shape, wraps, True, points[n, 0], points[n, 1], points[n, 2])[0]


@njit(cache=True, nogil=True)
def land(first, pieces, step, size, flat, shape, wraps, gaps, reach, points, normals):
    """Bring points along the gradient onto the contour, in place, and give the normals there.

    A point that would go farther than ``reach`` node units stays where it was.
    """
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(points))):
            x, y, z = points[n, 0], points[n, 1], points[n, 2]
            p, px, py, pz = at(flat, shape, wraps, gaps, x, y, z)
            for _ in range(LANDINGS):
                steep = px * px + py * py + pz * pz
                if not steep > 0:
                    break
                share = p / steep
                x, y, z = x - share * px, y - share * py, z - share * pz
                p, px, py, pz = at(flat, shape, wraps, gaps, x, y, z)
                if abs(share) * math.sqrt(steep) < 1e-14:
                    break
            far = (x - points[n, 0]) ** 2 + (y - points[n, 1]) ** 2 + (z - points[n, 2]) ** 2
            if far <= reach * reach and p * p <= 1e-16 * (px * px + py * py + pz * pz):
                points[n, 0], points[n, 1], points[n, 2] = x, y, z
            else:
                x, y, z = points[n, 0], points[n, 1], points[n, 2]
                p, px, py, pz = at(flat, shape, wraps, gaps, x, y, z)
            length = math.sqrt(px * px + py * py + pz * pz)
            share = 1.0 / length if length > 0 else 0.0
            normals[n, 0], normals[n, 1], normals[n, 2] = share * px, share * py, share * pz
