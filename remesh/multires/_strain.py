"""Compiled loop over active nodes of blocks for the largest velocity gradient."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.layout import FAR

GHOSTS = 2


@njit(cache=True, nogil=True, inline="always", fastmath={"contract"})
def slope(behind, own, ahead, behind2, ahead2, lower, upper):
    """Twelve times the difference of order 4, of 2 or 1 where fewer nodes lie before an end."""
    if lower >= 2 and upper >= 2:
        return 8 * (ahead - behind) - (ahead2 - behind2)
    if lower >= 1 and upper >= 1:
        return 6 * (ahead - behind)
    if lower >= 1:
        return 12 * (own - behind)
    return 12 * (ahead - own)


@njit(cache=True, nogil=True, fastmath={"contract"})
def largest(
    first, pieces, step, size, velocity, factors, leaves, places, counts, levels, wraps, result
):
    """Per block: the largest over active nodes and components of sum_j |du_i/dx_j|.

    ``velocity`` (components, n, nx, nm, nc) comes with two ghosts on each side.
    """
    parts, blocks, px, pm, pc = velocity.shape
    flat = velocity.reshape(parts, blocks, px * pm * pc)
    deep = pm > 1
    skip = GHOSTS if deep else 0
    lower = np.empty(3, np.int64)
    upper = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            worst = velocity.dtype.type(0)
            broken = False
            nx, nm, nc = px - 2 * GHOSTS, pm - 2 * skip, pc - 2 * GHOSTS
            for p in range(parts):
                u = flat[p, b]
                for i in range(nx):
                    lower[0], upper[0] = room(places[b, 0], i, nx, counts[levels[b], 0], wraps[0])
                    for m in range(nm):
                        lower[1], upper[1] = room(
                            places[b, 1], m, nm, counts[levels[b], 1], wraps[1]
                        )
                        for k in range(nc):
                            if not leaves[b, i, m, k]:
                                continue
                            lower[2], upper[2] = room(
                                places[b, 2], k, nc, counts[levels[b], 2], wraps[2]
                            )
                            n = ((i + GHOSTS) * pm + m + skip) * pc + k + GHOSTS
                            total = abs(along(u, n, pm * pc, lower[0], upper[0]))
                            total += abs(along(u, n, 1, lower[2], upper[2]))
                            if deep:
                                total += abs(along(u, n, pc, lower[1], upper[1]))
                            broken |= total != total
                            worst = max(worst, total)
            result[b] = np.nan if broken else worst * factors[b]


@njit(cache=True, nogil=True, inline="always")
def along(u, n, stride, lower, upper):
    """Twelve times the difference at n along the axis of this stride."""
    return slope(
        u[n - stride], u[n], u[n + stride], u[n - 2 * stride], u[n + 2 * stride], lower, upper
    )


@njit(cache=True, nogil=True, inline="always")
def room(place, index, edge, count, wraps):
    """How many nodes lie before and behind a node on the mesh."""
    node = place * edge + index
    return (FAR, FAR) if wraps else (node, count * edge - 1 - node)
