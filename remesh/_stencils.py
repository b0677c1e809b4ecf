"""Compiled loop over nodes for the largest velocity gradient."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, inline="always")
def neighbours(index, size, wraps):
    """The two nodes of a difference at ``index``: central, wrapped, or one-sided at an edge."""
    ahead = index + 1
    behind = index - 1
    if wraps:
        return behind % size, ahead % size
    return max(behind, 0), min(ahead, size - 1)


@njit(cache=True, nogil=True, fastmath={"contract", "nsz"})
def row_sums(ux, uy, uz, factors, total):
    """total[k] += sum over the rows' differences; one row of nodes for one velocity component."""
    a, b = ux
    c, d = uy
    e, f = uz
    for k in range(total.size):
        total[k] = abs(a[k] - b[k]) * factors[0] + abs(c[k] - d[k]) * factors[1]
    if factors[2] != 0:
        for k in range(total.size):
            total[k] += abs(e[k] - f[k]) * factors[2]


@njit(cache=True, nogil=True, fastmath={"contract"})
def largest_gradient(first, pieces, step, rows, velocity, inverse, periodic, result):
    """Per piece of rows: the largest over nodes and components of sum_j |du_i/dx_j|."""
    parts, nx, nm, nc = velocity.shape
    total = np.empty(nc, velocity.dtype)
    factors = np.zeros(3, velocity.dtype)
    half = inverse * velocity.dtype.type(0.5)
    for piece in range(first, pieces, step):
        worst = velocity.dtype.type(0)
        broken = False
        for line in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            i = line // nm
            m = line % nm
            x0, x1 = neighbours(i, nx, periodic[0])
            y0, y1 = neighbours(m, nm, periodic[1])
            factors[0] = half if periodic[0] or x1 - x0 == 2 else inverse
            factors[1] = half
            factors[2] = 0
            if nm > 1:
                factors[2] = half if periodic[1] or y1 - y0 == 2 else inverse
            for p in range(parts):
                row = velocity[p, i, m]
                over = (velocity[p, x1, m, 1:-1], velocity[p, x0, m, 1:-1])
                along = (row[2:], row[:-2])
                across = (velocity[p, i, y1, 1:-1], velocity[p, i, y0, 1:-1])
                inner = total[1:-1]
                row_sums(over, along, across, factors, inner)
                for k in (0, nc - 1):
                    z0, z1 = neighbours(k, nc, periodic[2])
                    wide = half if periodic[2] or z1 - z0 == 2 else inverse
                    total[k] = (
                        abs(velocity[p, x1, m, k] - velocity[p, x0, m, k]) * factors[0]
                        + abs(row[z1] - row[z0]) * wide
                        + abs(velocity[p, i, y1, k] - velocity[p, i, y0, k]) * factors[2]
                    )
                for k in range(nc):
                    broken |= total[k] != total[k]
                    worst = max(worst, total[k])
        result[piece] = np.nan if broken else worst


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_difference(ahead, behind, weight, out):
    """out += weight (ahead - behind)."""
    for k in range(out.size):
        out[k] += weight * (ahead[k] - behind[k])


@njit(cache=True, nogil=True)
def split_gradient(first, pieces, step, field, weights, periodic, result):
    """Per plane of the first axis: sums of the squared divergence and of the squared gradient.

    At nodes whose stencils lie inside; ``weights`` of an antisymmetric difference, from the middle.
    """
    _, nx, ny, nz = field.shape
    reach = weights.size
    low = 0 if periodic[2] else reach
    high = nz - low
    total = np.empty(nz, field.dtype)
    one = np.empty(nz, field.dtype)
    line = np.empty(nz + 2 * reach, field.dtype)
    for i in range(first, pieces, step):
        squared = 0.0
        whole = 0.0
        for j in range(ny):
            inside = (periodic[0] or reach <= i < nx - reach) and (
                periodic[1] or reach <= j < ny - reach
            )
            if not inside:
                continue
            total[:] = 0
            for c in range(3):
                for axis in range(3):
                    one[:] = 0
                    if axis == 2:
                        line[reach : reach + nz] = field[c, i, j]
                        line[:reach] = field[c, i, j, nz - reach :]
                        line[reach + nz :] = field[c, i, j, :reach]
                    for m in range(reach):
                        if axis == 0:
                            ahead = field[c, (i + m + 1) % nx, j]
                            behind = field[c, (i - m - 1) % nx, j]
                        elif axis == 1:
                            ahead = field[c, i, (j + m + 1) % ny]
                            behind = field[c, i, (j - m - 1) % ny]
                        else:
                            ahead = line[reach + m + 1 : reach + m + 1 + nz]
                            behind = line[reach - m - 1 : reach - m - 1 + nz]
                        add_difference(ahead, behind, weights[m], one)
                    if axis == c:
                        for k in range(nz):
                            total[k] += one[k]
                    for k in range(low, high):
                        whole += np.float64(one[k]) * np.float64(one[k])
            for k in range(low, high):
                squared += np.float64(total[k]) * np.float64(total[k])
        result[i, 0] = squared
        result[i, 1] = whole
