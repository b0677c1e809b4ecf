"""Values off an interface: constant along its normals, from the closest points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.closest import closest_points
from levelset.nodal import axes, check_nodes, on_mesh, scattered, three
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import precision, split
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


def extend(
    values: Array,
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    width: float | None = None,
    threads: int | None = None,
) -> Array:
    """Nodal values made constant along the normals of phi = 0: each node takes its foot's value.

    ``values`` ``(..., *grid.shape)``, with ``nodes`` also ``(..., len(nodes))``, of which those
    within two nodes of the contour count; those not finite are unset. ``nodes``: flat indices where
    alone phi and values are known and results are wanted; a `Band` in place of phi brings its own.
    With ``width`` [L] nodes farther from
    the contour keep the values given. Returns ``(..., *grid.shape)`` or ``(..., len(nodes))``; NaN
    at a node from which no contour is reached, or where the values around its foot are unset.
    Cubic interpolation at `closest_points`: of order 3 at least for smooth values. Cost: O(nodes
    answered). Same bits for any number of threads. Refuses wrong shapes, a phi of one sign.
    """
    phi, grid, nodes = on_mesh(phi, grid, nodes)
    given = np.asarray(values)
    dtype = precision(given)
    dense = given.shape[-grid.ndim :] == grid.shape
    short = nodes is not None and given.shape[-1:] == np.shape(nodes)
    if not dense and not short:
        ends = f"{grid.shape}" if nodes is None else f"{grid.shape} or {np.shape(nodes)}"
        raise InputError(f"values must end in {ends}, got {given.shape}", hint="one value per node")
    lead = given.shape[: -grid.ndim] if dense else given.shape[:-1]
    parts = given.reshape(-1, grid.size if dense else len(np.asarray(nodes)))
    feet = closest_points(phi, grid, nodes=nodes, width=width, threads=threads)
    known = np.arange(grid.size) if nodes is None else np.asarray(nodes, np.int64)
    found = parts[:, known] if dense else parts
    result = found.astype(dtype) if width is not None else np.full(found.shape, np.nan, dtype)
    where, mine = _answered(feet.nodes, known)
    for part, out in zip(found, result, strict=True):
        finite = np.isfinite(part)
        laid = scattered(part[finite].astype(np.float64), known[finite], grid)
        out[where] = sample(laid, grid, feet.points[mine], threads)
    return result.reshape(*lead, *(grid.shape if nodes is None else (len(known),)))


def values_at(
    values: Array,
    points: Array,
    grid: Grid,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Array:
    """Nodal values at ``points`` ``(n, ndim)`` [L], as at a surface's vertices: ``(n,)``.

    Cubic interpolation of order 4; bilinear beside nodes that are unset (not finite, or not in
    ``nodes``), NaN where a corner of the point's cell is. Beyond an unbounded edge the values go
    on straight. ``values`` of ``grid.shape``, with ``nodes`` ``(len(nodes),)`` will do too. Refuses
    wrong shapes, and points that are not finite.
    """
    given = np.asarray(values)
    known = np.arange(grid.size) if nodes is None else check_nodes(nodes, grid)
    if given.shape == grid.shape:
        given = given.reshape(-1)[known]
    elif nodes is None or given.shape != known.shape:
        raise InputError(
            f"values must have the grid's shape {grid.shape}, got {given.shape}",
            hint="one value per node",
        )
    places = np.asarray(points, np.float64)
    if places.ndim != 2 or places.shape[1] != grid.ndim or not np.isfinite(places).all():
        raise InputError(
            f"points must be finite and of shape (n, {grid.ndim}), got {places.shape}",
            hint="surface.vertices",
        )
    finite = np.isfinite(given)
    laid = scattered(given[finite].astype(np.float64), known[finite], grid)
    found = sample(laid, grid, places, threads)
    return found.astype(precision(given))


def sample(
    flat: Array, grid: Grid, points: NDArray[np.float64], threads: int | None
) -> NDArray[np.float64]:
    """Flat nodal values, zero where unset, at ``points`` ``(n, ndim)`` [L]."""
    from levelset import _extension

    out = np.empty(len(points))
    size, pieces = split(len(points))
    share(
        _extension.sample, pieces, thread_count(threads), size, flat, *axes(grid),
        three(grid, points), out,
    )  # fmt: skip
    return out


def _answered(found: Nodes, known: Nodes) -> tuple[Nodes, Nodes]:
    """Where in ``known`` the nodes found are, and which of those found are there."""
    where = np.searchsorted(known, found)
    where[where == len(known)] = 0
    mine = np.flatnonzero(known[where] == found)
    return where[mine], mine
