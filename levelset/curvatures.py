"""Normals and curvatures of the level surfaces of phi."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.extension import extend
from levelset.nodal import laid_out
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Kind = Literal["mean", "gaussian"]
At = Literal["node", "contour"]


def normal(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Array:
    """Unit normal grad phi / |grad phi|, outward: ``(ndim, *grid.shape)``, ``(ndim, len(nodes))``.

    ``phi`` of ``grid.shape``, negative inside, with any slope. Differences of order 4 where two
    nodes to all sides are known, else of order 2, leaning inward at edges; zero where phi is flat.
    ``nodes``: flat indices where alone phi is known (then ``(len(nodes),)`` will do) and the normal
    wanted, or a `Band` for all three; NaN where even a neighbour is missing. Cost: O(nodes). Same
    bits for any number of threads. Refuses another shape, and values that are not finite.
    """
    from levelset import _curvature

    laid = laid_out(phi, grid, nodes)
    out = np.empty((3, len(laid.known)), laid.dtype)
    share(
        _curvature.normals, laid.pieces, thread_count(threads), laid.size, laid.flat, laid.nodes,
        laid.gaps, laid.shape, laid.wraps, out,
    )  # fmt: skip
    found = out[::2] if laid.grid.ndim == 2 else out
    return found if laid.gaps else found.reshape(-1, *laid.grid.shape)


def curvature(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    kind: Kind = "mean",
    at: At = "node",
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Array:
    """Curvature of the level surfaces: ``grid.shape``, with nodes ``(len(nodes),)``.

    ``"mean"`` is kappa = div n [1/L], the sum of the principal curvatures: 1/R for a circle, 2/R
    for a sphere, positive where the inside is convex. ``"gaussian"`` is their product [1/L^2],
    1/R^2 for a sphere, and is refused in 2-D. ``phi`` may have any slope: of the second derivatives
    nothing is dropped. Differences as in `normal`: of order 4 for the smooth, and of order 2 at
    least one node inside an edge of box or band. ``at="node"`` is that of the level surface through
    each node; ``at="contour"`` that of phi = 0 at the node's closest point (`extend`), at the cost
    of finding it. NaN where phi is flat, where nodes are missing, and with ``at="contour"`` where
    no contour is reached. Same bits for any number of threads. Refuses another shape, values that
    are not finite, and with ``at="contour"`` a phi of one sign.
    Source: Goldman, Comput. Aided Geom. Des. 22 (2005) 632.
    """
    from levelset import _curvature

    if kind not in ("mean", "gaussian") or at not in ("node", "contour"):
        raise InputError(
            f"kind must be 'mean' or 'gaussian', at 'node' or 'contour', got {kind!r}, {at!r}",
            hint="kind='mean'",
        )
    laid = laid_out(phi, grid, nodes)
    if kind == "gaussian" and laid.grid.ndim == 2:
        raise InputError("a line has no Gaussian curvature", hint="kind='mean'")
    out = np.empty(len(laid.known), laid.dtype)
    share(
        _curvature.curvatures, laid.pieces, thread_count(threads), laid.size, laid.flat, laid.nodes,
        laid.gaps, laid.shape, laid.wraps, laid.grid.spacing, kind == "gaussian", out,
    )  # fmt: skip
    found: Array = out if laid.gaps else out.reshape(laid.grid.shape)
    if at == "node":
        return found
    return extend(found, phi, grid, nodes=nodes, threads=threads)
