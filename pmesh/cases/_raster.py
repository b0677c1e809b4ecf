"""Compiled loop over pixels: which triangle is the nearest in each."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

from numba import njit

EDGE = -1e-6  # a pixel on the edge of two triangles belongs to both


@njit(cache=True, nogil=True)
def nearest(places, faces, near, which, weights):
    """Per pixel the nearest triangle, its nearness, and the weights of its corners in space.

    ``places`` (n, 3): column, row and nearness of each vertex; triangles behind the eye are left
    out. ``near`` is zero and ``which`` negative where nothing is.
    """
    height, width = near.shape
    for m in range(len(faces)):
        a, b, c = places[faces[m, 0]], places[faces[m, 1]], places[faces[m, 2]]
        if min(a[2], b[2], c[2]) <= 0.0:
            continue
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        left = int(max(math.ceil(min(a[0], b[0], c[0])), 0.0))
        right = int(min(math.floor(max(a[0], b[0], c[0])), width - 1.0))
        top = int(max(math.ceil(min(a[1], b[1], c[1])), 0.0))
        bottom = int(min(math.floor(max(a[1], b[1], c[1])), height - 1.0))
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                v = ((column - a[0]) * (c[1] - a[1]) - (row - a[1]) * (c[0] - a[0])) / area
                w = ((b[0] - a[0]) * (row - a[1]) - (b[1] - a[1]) * (column - a[0])) / area
                u = 1.0 - v - w
                if u < EDGE or v < EDGE or w < EDGE:
                    continue
                here = u * a[2] + v * b[2] + w * c[2]
                if here > near[row, column]:
                    near[row, column] = here
                    which[row, column] = m
                    weights[row, column, 0] = u * a[2] / here
                    weights[row, column, 1] = v * b[2] / here
                    weights[row, column, 2] = w * c[2] / here
