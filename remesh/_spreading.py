"""Compiled sums of symmetric stencils on a uniform mesh: first axis, then plane by plane.

Fields are ``(components, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one
node. Every piece of work reads a copy of what it then writes, so that a field is changed in place.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows
from remesh._rows import CHUNK, any_value, row_of
from remesh.compiled import drop_stale

drop_stale(__file__, _rows.__file__)


@njit(cache=True, nogil=True, fastmath={"contract"})
def blend(source, start, stride, weights, target):
    """target[k] = sum of the weights times source[start + k + j * stride], both sides."""
    own = source[start : start + target.size]
    for k in range(target.size):
        target[k] = weights[0] * own[k]
    for j in range(1, weights.size):
        behind = source[start - j * stride : start - j * stride + target.size]
        ahead = source[start + j * stride : start + j * stride + target.size]
        for k in range(target.size):
            target[k] += weights[j] * (behind[k] + ahead[k])


@njit(cache=True, nogil=True)
def over_first(first, pieces, step, field, weights, wraps, out):
    """Strips of all rows of the first axis: the stencil along it."""
    _, nx, nm, nc = field.shape
    width = weights.size - 1
    strips = -(-nc // CHUNK)
    strip = np.zeros(((nx + 2 * width), CHUNK), field.dtype)
    flat = strip.reshape(strip.size)
    for piece in range(first, pieces, step):
        p = piece // (nm * strips)
        m = piece // strips % nm
        column = piece % strips * CHUNK
        stop = min(column + CHUNK, nc)
        used = False
        for i in range(nx):
            row = field[p, i, m, column:stop]
            used |= any_value(row)
            strip[i + width, : stop - column] = row
        if not used:
            for i in range(nx):
                out[p, i, m, column:stop] = 0
            continue
        for k in range(width):
            for edge, index in ((k, k - width), (nx + width + k, nx + k)):
                i = row_of(index, nx, wraps, False)
                if i >= 0:
                    strip[edge] = strip[i + width]
                else:
                    strip[edge] = 0
        for i in range(nx):
            blend(flat, (i + width) * CHUNK, CHUNK, weights, out[p, i, m, column:stop])


@njit(cache=True, nogil=True)
def over_others(first, pieces, step, field, weights, periodic):
    """Planes across the first axis: the stencil along the others."""
    _, nx, nm, nc = field.shape
    width = weights.size - 1
    deep = width if nm > 1 else 0
    plane = np.empty((nm + 2 * deep, nc), field.dtype)
    flat = plane.reshape(plane.size)
    line = np.empty(nc + 2 * width, field.dtype)
    for piece in range(first, pieces, step):
        p = piece // nx
        i = piece % nx
        used = False
        for m in range(nm):
            used |= any_value(field[p, i, m])
            plane[m + deep] = field[p, i, m]
        if not used:
            continue
        for k in range(deep):
            for edge, index in ((k, k - deep), (nm + deep + k, nm + k)):
                m = row_of(index, nm, periodic[1], False)
                if m >= 0:
                    plane[edge] = plane[m + deep]
                else:
                    plane[edge] = 0
        for m in range(nm):
            middle = line[width : width + nc]
            if deep > 0:
                blend(flat, (m + deep) * nc, nc, weights, middle)
            else:
                middle[:] = plane[m]
            for k in range(width):
                before = row_of(k - width, nc, periodic[2], False)
                after = row_of(nc + k, nc, periodic[2], False)
                line[k] = middle[before] if before >= 0 else 0
                line[width + nc + k] = middle[after] if after >= 0 else 0
            blend(line, width, 1, weights, field[p, i, m])
