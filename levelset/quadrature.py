"""Volume, area, centroid and integrals of a level set on a mesh, of order 4."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.nodal import Laid, Nodes, laid_out
from levelset.rows import runs
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
Over = Literal["surface", "inside"]


class Measures(NamedTuple):
    """What one pass over the cells measures."""

    volume: float  # where phi < 0 [L^3], in 2-D its area [L^2]
    area: float  # of the surface phi = 0 [L^2], in 2-D the length of the contour [L]
    centroid: Values  # (ndim,) of that volume [L]; NaN where there is none


def measures(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Measures:
    """Volume where ``phi < 0``, area of its surface, its centre: all of order 4, in one pass.

    ``phi`` of ``grid.shape``, any function of the right sign, not only a distance. Quadrature over
    the cubic interpolant of each cell: of order 4 for a smooth contour, of order 2 in the size of
    its pieces with corners; no weight is negative. An unbounded axis is integrated from its first
    node to its last; the edge of the box is no part of the surface. On periodic axes a volume
    across the seam counts where its parts are.
    ``nodes``: flat indices of a band where alone phi is known, or a `Band` for all three. With two
    nodes to each side of the contour the order is 4; with fewer it falls to 2. What lies beyond
    counts by its side along rows. Cost: that of the nodes that the contour comes close to, and a
    look at the others. Same bits for any number of threads.
    Refuses values that are not finite, and a band that misses a corner of a cell that is crossed.
    Source: Saye, SIAM J. Sci. Comput. 37 (2015) A993; J. Comput. Phys. 448 (2022) 110720.
    """
    laid = laid_out(phi, grid, nodes)
    mesh = laid.grid
    found = with_beyond(laid, cell_terms(laid, None, "inside", threads))
    centre = np.full(mesh.ndim, np.nan)
    if found[0] > 0:
        centre = mesh.origin + mesh.spacing * found[1 : 1 + mesh.ndim] / found[0]
    surface = float(found[5] * mesh.spacing ** (mesh.ndim - 1))
    return Measures(float(found[0] * mesh.cell_volume), surface, centre)


def volume(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> float:
    """Volume where ``phi < 0`` [L^3], in 2-D its area [L^2]; zero if it is nowhere.

    Order, arguments, cost and refusals are those of `measures`, which gives the area with it.
    """
    return measures(phi, grid, nodes=nodes, threads=threads).volume


def area(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> float:
    """Area of the surface ``phi = 0`` [L^2], in 2-D the length of the contour [L]; else zero.

    Order, arguments, cost and refusals are those of `measures`, which gives the volume with it.
    """
    return measures(phi, grid, nodes=nodes, threads=threads).area


def centroid(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> Values:
    """Centre of the volume where ``phi < 0``, ``(ndim,)`` [L]; all else as `measures`.

    Refuses an empty inside.
    """
    found = measures(phi, grid, nodes=nodes, threads=threads)
    if not found.volume > 0:
        raise InputError(
            "an empty inside has no centre: phi is negative nowhere",
            hint="a shape that the mesh resolves and that lies in the box",
        )
    return found.centroid


def integrate(
    values: Array,
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    over: Over = "surface",
    nodes: Nodes | None = None,
    threads: int | None = None,
) -> float:
    """Integral of nodal ``values`` over the surface ``phi = 0`` or over the inside.

    ``values`` of ``grid.shape``, with nodes or a `Band` ``(len(nodes),)`` will do too, known where
    phi is; both are interpolated by cubics, order 4. Arguments and cost as of `measures`; a band is
    enough for the surface only. Refuses values of another shape, and values that are not finite,
    over the surface only beside it.
    """
    if over not in ("surface", "inside"):
        raise InputError(f"over must be 'surface' or 'inside', got {over!r}", hint="over='surface'")
    laid = laid_out(phi, grid, nodes)
    if over == "inside" and laid.gaps:
        raise InputError(
            "values are known in a band only, the inside reaches beyond it",
            hint="over='surface', or values and phi on all nodes",
        )
    wanted = laid.nodes if laid.gaps else None
    if over == "inside":
        given = laid_out(values, laid.grid, wanted, name="values").flat
        return float(cell_terms(laid, given, over, threads)[4] * laid.grid.cell_volume)
    holes = ~np.isfinite(values) if np.asarray(values).dtype.kind == "f" else np.zeros(1, bool)
    given = laid_out(np.where(holes, 0.0, values), laid.grid, wanted, name="values").flat
    if holes.any():  # far from the surface nobody asks
        given[laid_out(holes.astype(float), laid.grid, wanted).flat > 0] = np.nan
    found = float(cell_terms(laid, given, over, threads)[9])
    if not math.isfinite(found):
        raise InputError(
            "values must be finite beside the surface", hint="look at them where phi is near zero"
        )
    return found * float(laid.grid.spacing) ** (laid.grid.ndim - 1)


def cell_terms(laid: Laid, values: Values | None, over: Over, threads: int | None) -> Values:
    """The sums over cells, in node units: see ``_quadrature.TERMS``.

    Between two nodes a cubic through four is off their line by a quarter of the largest step at
    most, and no larger than 1.25 of its values: in cells so far from zero there is no contour.
    """
    from levelset import _quadrature
    from levelset._heights import INSIDE, NOTHING, SURFACE, TERMS

    ndim, workers = laid.grid.ndim, thread_count(threads)
    shape, wraps = (*laid.grid.shape, 1)[:3], (*laid.grid.periodic, False)[:3]  # a plane's last
    steps = np.zeros(laid.pieces)
    share(
        _quadrature.steepest, laid.pieces, workers, laid.size, laid.nodes, laid.flat, shape, wraps,
        laid.gaps, steps,
    )  # fmt: skip
    near = 0.25 * sum(1.25**k for k in range(ndim)) * float(steps.max(initial=0.0))
    wanted = NOTHING if values is None else INSIDE if over == "inside" else SURFACE
    result = np.zeros((laid.pieces, TERMS + 1))
    share(
        _quadrature.integrals, laid.pieces, workers, laid.size, np.empty((0,) * ndim), laid.nodes,
        laid.flat, shape, wraps, laid.gaps, near, laid.flat if values is None else values, wanted,
        result,
    )  # fmt: skip
    total: Values = result.sum(axis=0)
    if total[TERMS]:
        raise InputError(
            "the band is too thin: the contour crosses cells of which corners are unknown",
            hint="a wider band, two nodes to each side of the contour: abs(phi) < 3 * grid.spacing",
        )
    return total


def with_beyond(laid: Laid, found: Values) -> Values:
    """Volume and first moments with the cells beyond the band, in node units."""
    if not laid.gaps:
        return found
    grid = laid.grid
    beyond = runs(laid.nodes, laid.known, grid)
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
