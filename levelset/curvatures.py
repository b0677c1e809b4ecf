"""Normals and curvatures of the level surfaces of phi."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from levelset.closest import check_band_values, check_level_set, check_nodes
from levelset.extension import extend
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Kind = Literal["mean", "gaussian"]
At = Literal["node", "contour"]


def normal(
    phi: Array, grid: Grid, *, nodes: Nodes | None = None, threads: int | None = None
) -> Array:
    """Unit normal grad phi / |grad phi|, outward: ``(ndim, *grid.shape)``, ``(ndim, len(nodes))``.

    ``phi`` of ``grid.shape``, negative inside, with any slope. Differences of order 4 where two
    nodes to all sides are known, else of order 2, leaning inward at edges; zero where phi is flat.
    ``nodes``: flat indices where alone phi is known (then ``(len(nodes),)`` will do) and the normal
    wanted; NaN where even a neighbour is missing. Cost: O(nodes). Same bits for any number of
    threads. Refuses another shape, and values that are not finite.
    """
    from levelset import _curvature

    work = _Work(phi, grid, nodes)
    out = np.empty((3, len(work.nodes)), work.dtype)
    share(_curvature.normals, work.pieces, thread_count(threads), *work.arguments, out)
    found = out[::2] if grid.ndim == 2 else out
    return found if nodes is not None else found.reshape(grid.ndim, *grid.shape)


def curvature(
    phi: Array,
    grid: Grid,
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
    if kind == "gaussian" and grid.ndim == 2:
        raise InputError("a line has no Gaussian curvature", hint="kind='mean'")
    work = _Work(phi, grid, nodes)
    out = np.empty(len(work.nodes), work.dtype)
    share(
        _curvature.curvatures, work.pieces, thread_count(threads), *work.arguments, grid.spacing,
        kind == "gaussian", out,
    )  # fmt: skip
    found: Array = out if nodes is not None else out.reshape(grid.shape)
    if at == "node":
        return found
    return extend(found, phi, grid, nodes=nodes, threads=threads)


class _Work:
    """The level set as the loops take it."""

    def __init__(self, phi: Array, grid: Grid, nodes: Nodes | None) -> None:
        values = np.asarray(phi)
        self.dtype = precision(values)
        if nodes is None:
            flat = np.ascontiguousarray(check_level_set(values, grid), self.dtype).reshape(-1)
            self.nodes, known = np.arange(grid.size), np.ones(grid.size, np.bool_)
        else:
            self.nodes = check_nodes(nodes, grid)
            flat, known = np.zeros(grid.size, self.dtype), np.zeros(grid.size, np.bool_)
            flat[self.nodes] = check_band_values(values, grid, self.nodes)
            known[self.nodes] = True
        rows, self.pieces = split(len(self.nodes))
        self.arguments = (
            rows, flat, known, self.nodes, layout(grid)[1:], tuple(wraps(grid).tolist())
        )  # fmt: skip
