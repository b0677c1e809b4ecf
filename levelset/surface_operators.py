"""Gradient and Laplacian along the level surfaces of phi, by volume operators on the mesh.

With n = grad phi/|grad phi|, P = I - n n and kappa = div n, for any smooth phi and any smooth c,

    grad_s c    = P grad c
    laplace_s c = (1/|grad phi|) div(|grad phi| P grad c) = tr(P Hess c) - kappa n . grad c,

on the level surface through each point: the anisotropic operator div(P grad c) where phi is a
distance, and lap c on the surface where besides n . grad c = 0 near it. The second form is what is
computed: it needs neither a distance nor c constant along normals, and no second pass.
Source: Bertalmio, Cheng, Osher & Sapiro, J. Comput. Phys. 174 (2001) 759.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.nodal import laid_out
from remesh.grid import Grid
from remesh.layout import precision
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


def surface_gradient(
    values: Array,
    phi: Array,
    grid: Grid,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Array:
    """(I - n n) grad c, shape ``(ndim, *grid.shape)`` or ``(ndim, len(nodes))``.

    ``values`` and ``phi`` ``grid.shape``; with ``nodes`` (flat, ascending) they are read there
    only, and ``(len(nodes),)`` will do. Order 4 where two nodes to all sides are known, else 2,
    one-sided at edges. Tangential to the level surface to round-off; where phi is flat, the whole
    gradient. Costs O(nodes). Refuses other shapes, and what is not finite where it is read.
    """
    from levelset import _surface_operators

    return _over_nodes(
        _surface_operators.surface_gradient, values, phi, grid, nodes, threads, vector=True
    )


def laplace_beltrami(
    values: Array,
    phi: Array,
    grid: Grid,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Array:
    """Laplacian of c along the level surfaces of phi, ``grid.shape`` or ``(len(nodes),)``.

    ``values`` and ``phi`` ``grid.shape``; with ``nodes`` (flat, ascending) they are read there
    only, and ``(len(nodes),)`` will do. Order 4 where two nodes to all sides are known, 2 where one
    is, order 1 at edges; NaN where too few are, and where phi is flat. Costs O(nodes). Refuses
    other shapes, and what is not finite where it is read.
    """
    from levelset import _surface_operators

    return _over_nodes(
        _surface_operators.laplace_beltrami, values, phi, grid, nodes, threads, vector=False
    )


def _over_nodes(
    loop: Callable[..., None],
    values: Array,
    phi: Array,
    grid: Grid,
    nodes: Nodes | None,
    threads: int | None,
    *,
    vector: bool,
) -> Array:
    """What a loop gives at the nodes, in the precision of the values."""
    laid = laid_out(phi, grid, nodes)
    given = laid_out(values, grid, nodes, name="values")
    count = grid.size if nodes is None else len(laid.nodes)
    out = np.empty((3, count) if vector else count, precision(np.asarray(values)))
    share(
        loop, laid.pieces, thread_count(threads), laid.size, laid.flat, given.flat, laid.nodes,
        laid.gaps, laid.shape, laid.wraps, grid.spacing, out,
    )  # fmt: skip
    if vector:
        out = out[[axis for axis in range(3) if laid.shape[axis] > 1]]
    return out if nodes is not None else out.reshape(*out.shape[:-1], *grid.shape)
