"""What the velocity gradient says of vortices: the Q criterion and lambda-2."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
CENTRAL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
NARROW = ((-1, -1 / 2), (1, 1 / 2))  # next to an unbounded edge
LEANING = ((0, -3 / 2), (1, 2.0), (2, -1 / 2))  # at an unbounded edge


def q_criterion(velocity: Array, grid: Grid, *, threads: int | None = None) -> Array:
    """Q = (|Omega|^2 - |S|^2) / 2 at every node, ``grid.shape`` [1/T^2]; positive in vortices.

    ``velocity`` ``(ndim, *shape)`` [L/T]; S and Omega are the symmetric and the antisymmetric part
    of its gradient, |.| their Frobenius norms: the laplacian of the pressure over twice the
    density. In a plane flow without divergence it is -1/4 of the Okubo-Weiss parameter.
    Differences of order 4, of order 2 at the two outermost nodes of an unbounded axis; no
    free stream and no rotation of the axes changes it. float32 in, float32 out, worked out in
    float64; same bits for any number of threads. Refuses a velocity of another shape.
    Source: Hunt, Wray & Moin, Center for Turbulence Research Rep. CTR-S88 (1988) 193.
    """
    return _swirl(velocity, grid, threads, middle=False)


def lambda2(velocity: Array, grid: Grid, *, threads: int | None = None) -> Array:
    """Middle eigenvalue of S^2 + Omega^2 at every node, ``grid.shape`` [1/T^2]; < 0 in vortices.

    ``velocity`` ``(3, *shape)`` [L/T], S and Omega as for `q_criterion`, and so are differences,
    precision and threads. Eigenvalues in closed form: right to round-off of the largest of them
    also where two are the same, as in every round column. Refuses a flow in the plane, where
    this says no more than the sign of Q.
    Source: Jeong & Hussain, J. Fluid Mech. 285 (1995) 69.
    """
    if grid.ndim != 3:
        raise InputError(
            f"lambda2 is of flows in space, this grid has {grid.ndim} axes",
            hint="pmesh.q_criterion(velocity, grid)",
        )
    return _swirl(velocity, grid, threads, middle=True)


def _swirl(velocity: Array, grid: Grid, threads: int | None, *, middle: bool) -> Array:
    from pmesh.vortex import _criteria

    values = np.asarray(velocity)
    if values.shape != (grid.ndim, *grid.shape):
        raise InputError(
            f"velocity must have shape {(grid.ndim, *grid.shape)}, got {values.shape}",
            hint="velocity=pmesh.velocity(vorticity, grid)",
        )
    values = np.ascontiguousarray(values, precision(values)).reshape(layout(grid))
    result = np.empty(values.shape[1:], values.dtype)
    tables = tuple(
        _table(nodes, bool(periodic), grid.spacing)
        for nodes, periodic in zip(values.shape[1:], wraps(grid), strict=True)
    )
    rows, pieces = split(values.shape[1] * values.shape[2])
    share(
        _criteria.swirl, pieces, thread_count(threads), rows, values, tables, middle, result,
    )  # fmt: skip
    return result.reshape(grid.shape)


def _table(
    nodes: int, periodic: bool, spacing: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Which nodes the difference at each node of an axis reads, and their weights, (nodes, 4)."""
    places = np.zeros((nodes, len(CENTRAL)), np.int64)
    weights = np.zeros((nodes, len(CENTRAL)))
    if nodes == 1:
        return places, weights
    for node in range(nodes):
        away = 2 if periodic else min(node, nodes - 1 - node)
        taps = (LEANING, NARROW, CENTRAL)[min(away, 2)]
        sign = -1 if away == 0 and node > 0 else 1  # a leaning one is mirrored at the far end
        for k, (offset, weight) in enumerate(taps):
            places[node, k] = (node + sign * offset) % nodes
            weights[node, k] = sign * weight / spacing
    return places, weights
