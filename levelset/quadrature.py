"""Volume, area, centroid and integrals of a level set on a mesh, of order 4."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from levelset.nodal import Laid, Nodes, laid_out
from levelset.rows import runs
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Over = Literal["surface", "inside"]


def volume(
    phi: Array, grid: Grid, *, nodes: Nodes | None = None, threads: int | None = None
) -> float:
    """Volume where ``phi < 0`` [L^3], in 2-D its area [L^2]; zero if it is nowhere.

    ``phi`` of ``grid.shape``, any function of the right sign, not only a distance. Quadrature over
    the cubic interpolant of each cell: of order 4 for a smooth contour, of order 2 in the size of
    its pieces with corners; no weight is negative. An unbounded axis is integrated from its first
    node to its last.
    ``nodes``: flat indices of a band where alone phi is known, which holds all corners of the cells
    that the contour crosses; what lies beyond counts by its side along rows, and the cost is that
    of the nodes. Same bits for any number of threads. Refuses values that are not finite.
    Source: Saye, SIAM J. Sci. Comput. 37 (2015) A993; J. Comput. Phys. 448 (2022) 110720.
    """
    laid = laid_out(phi, grid, nodes)
    found = _inside(laid, grid, _terms(laid, None, threads, surface=False)[:4])
    return float(found[0] * grid.cell_volume)


def area(
    phi: Array, grid: Grid, *, nodes: Nodes | None = None, threads: int | None = None
) -> float:
    """Area of the surface ``phi = 0`` [L^2], in 2-D the length of the contour [L].

    Of order 4 for a smooth contour. Arguments, cost and refusals as of `volume`; zero where there
    is no contour. The edge of the box is no part of it.
    """
    found = _terms(laid_out(phi, grid, nodes), None, threads, surface=True)
    return float(found[5] * grid.spacing ** (grid.ndim - 1))


def centroid(
    phi: Array, grid: Grid, *, nodes: Nodes | None = None, threads: int | None = None
) -> NDArray[np.float64]:
    """Centre of the volume where ``phi < 0``, ``(ndim,)`` [L], of order 4; arguments as `volume`.

    On periodic axes a volume across the seam counts where its parts are. Refuses an empty inside.
    """
    laid = laid_out(phi, grid, nodes)
    found = _inside(laid, grid, _terms(laid, None, threads, surface=False)[:4])
    if not found[0] > 0:
        raise InputError(
            "an empty inside has no centre: phi is negative nowhere",
            hint="a shape that the mesh resolves and that lies in the box",
        )
    middle: NDArray[np.float64] = found[1 : 1 + grid.ndim] / found[0]
    return np.asarray(grid.origin + grid.spacing * middle)


def integrate(
    values: Array,
    phi: Array,
    grid: Grid,
    *,
    over: Over = "surface",
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> float:
    """Integral of nodal ``values`` over the surface ``phi = 0`` or over the inside.

    ``values`` of ``grid.shape``, known where phi is; both are interpolated by cubics, order 4.
    Arguments and cost as of `volume`; a band is enough for the surface only. Refuses values of
    another shape, and values that are not finite.
    """
    if over not in ("surface", "inside"):
        raise InputError(f"over must be 'surface' or 'inside', got {over!r}", hint="over='surface'")
    if over == "inside" and nodes is not None:
        raise InputError(
            "values are known in a band only, the inside reaches beyond it",
            hint="over='surface', or values and phi on all nodes",
        )
    laid = laid_out(phi, grid, nodes)
    given = np.asarray(values)
    if given.shape != grid.shape:
        raise InputError(
            f"values must have the grid's shape {grid.shape}, got {given.shape}",
            hint="one value per node",
        )
    flat = np.ascontiguousarray(given, np.float64).reshape(-1)
    if not np.isfinite(flat if nodes is None else flat[laid.nodes]).all():
        raise InputError("values must be finite", hint="check the field they come from")
    surface = over == "surface"
    found = _terms(laid, flat, threads, surface=surface)
    return float(
        found[9] * grid.spacing ** (grid.ndim - 1) if surface else found[4] * grid.cell_volume
    )


def _terms(
    laid: Laid, values: NDArray[np.float64] | None, threads: int | None, *, surface: bool
) -> NDArray[np.float64]:
    """The sums over cells, in node units: see ``_quadrature.TERMS``."""
    from levelset import _quadrature

    given = laid.flat if values is None else values
    ndim = 3 if laid.shape[2] > 1 else 2
    result = np.zeros((laid.pieces, 10))
    share(
        _quadrature.integrals, laid.pieces, thread_count(threads), laid.size,
        np.empty((0,) * ndim), laid.nodes, laid.flat, laid.shape, laid.wraps, laid.gaps,
        _far(laid), surface, given, values is not None, result,
    )  # fmt: skip
    total: NDArray[np.float64] = result.sum(axis=0)
    return total


def _far(laid: Laid) -> float:
    """A size of phi beyond which the contour is not near, from the largest step between nodes.

    The four nodes around a cell along each axis are two steps away from its first corner, so
    there they are of one sign, and of a size with which the cubics do not reach zero.
    """
    if laid.gaps:
        return math.inf
    field = laid.flat.reshape(laid.shape)
    steepest = 0.0
    for axis in range(3):
        line = np.moveaxis(field, axis, 0)
        for step in (np.diff(line, axis=0), line[:1] - line[-1:] if laid.wraps[axis] else line[:0]):
            steepest = max(steepest, float(step.max(initial=0.0)), -float(step.min(initial=0.0)))
    return 3.0 * int((laid.shape > 1).sum()) * steepest


def _inside(laid: Laid, grid: Grid, found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Volume and first moments with the cells beyond the band, in node units."""
    if not laid.gaps:
        return found
    beyond = runs(laid.nodes, laid.flat[laid.nodes], grid)
    cells = np.array([n if w else n - 1 for n, w in zip(grid.shape, grid.periodic, strict=True)])
    stop = np.minimum(beyond.stop, cells[-1])
    counts = np.where(beyond.inside, np.maximum(stop - beyond.first, 0), 0).astype(np.float64)
    places = np.unravel_index(beyond.row, grid.shape[:-1])
    for place, most in zip(places, cells, strict=False):
        counts[place >= most] = 0.0
    total = found.copy()
    total[0] += counts.sum()
    for axis, place in enumerate(places):
        total[1 + axis] += (counts * (place + 0.5)).sum()
    total[grid.ndim] += (counts * 0.5 * (beyond.first + stop)).sum()
    return total
