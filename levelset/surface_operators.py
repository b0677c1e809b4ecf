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

from levelset.closest import check_nodes
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps
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
    only. Order 4 where two nodes to all sides are known, else 2, one-sided at edges. Tangential to
    the level surface to round-off; where phi is flat, the whole gradient. Costs O(nodes).
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
    only. Order 4 where two nodes to all sides are known, 2 where one is, order 1 at edges; NaN
    where too few are, and where phi is flat. Costs O(nodes).
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
    c, surface = (_field(name, field, grid) for name, field in (("values", values), ("phi", phi)))
    wanted = np.arange(grid.size) if nodes is None else check_nodes(nodes, grid)
    known = np.ones(grid.size, np.bool_) if nodes is None else np.zeros(grid.size, np.bool_)
    if nodes is not None:
        known[wanted] = True
    out = np.empty((3, len(wanted)) if vector else len(wanted), precision(c))
    rows, pieces = split(len(wanted))
    share(
        loop, pieces, thread_count(threads), rows, surface.reshape(-1), c.reshape(-1), known,
        wanted, layout(grid)[1:], tuple(wraps(grid).tolist()), grid.spacing, out,
    )  # fmt: skip
    if vector and grid.ndim == 2:
        out = out[::2]
    return out if nodes is not None else out.reshape(*out.shape[:-1], *grid.shape)


def _field(name: str, field: Array, grid: Grid) -> Array:
    """The field, contiguous and floating."""
    given = np.asarray(field)
    if given.shape != grid.shape:
        raise InputError(
            f"{name} must have the grid's shape {grid.shape}, got {given.shape}",
            hint="values on the nodes of this grid; unset ones may be anything if nodes are given",
        )
    return np.ascontiguousarray(given, precision(given))
