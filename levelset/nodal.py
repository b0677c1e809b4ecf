"""A level set on the nodes of a mesh, checked and laid out for the compiled loops."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Values = NDArray[np.float64]
Three = tuple[int, int, int]
Wraps = tuple[bool, bool, bool]


class Laid(NamedTuple):
    """What the loops take: flat values, three axes, nodes; and pieces of work."""

    grid: Grid
    flat: Values  # with gaps, zero where nothing is known
    shape: Three  # (nx, nm, nc); in the plane the middle axis has one node
    wraps: Wraps
    nodes: Nodes  # where results are wanted; one entry, not read, if these are all nodes
    gaps: bool  # whether phi is known at the nodes only
    size: int  # of a piece of work
    pieces: int
    dtype: np.dtype[Any]  # of the values given, float32 or float64

    @property
    def known(self) -> Values:
        """The values where they are known."""
        return self.flat[self.nodes] if self.gaps else self.flat


def laid_out(
    phi: Array | Band,
    grid: Grid | None = None,
    nodes: Nodes | None = None,
    *,
    name: str = "phi",
) -> Laid:
    """The level set for the loops, in float64; with ``nodes`` its cost is that of the nodes.

    A `Band` stands for all three. Refuses another shape than the grid's, nodes that do not ascend
    or lie beyond it, and values that are not real, or not finite where they are known; errors call
    the values by ``name``.
    """
    given, mesh, wanted = on_mesh(phi, grid, nodes)
    shape, periodic = axes(mesh)
    if wanted is None:
        check_level_set(given, mesh, name)
        flat = np.ascontiguousarray(given, np.float64).reshape(-1)
        places = np.zeros(1, np.int64)
    else:
        places = np.ascontiguousarray(check_nodes(wanted, mesh))
        flat = scattered(check_band_values(given, mesh, places, name), places, mesh)
    size, pieces = split(flat.size if wanted is None else len(places))
    return Laid(
        mesh, flat, shape, periodic, places, wanted is not None, size, pieces, precision(given)
    )


def on_mesh(
    phi: Array | Band, grid: Grid | None, nodes: Nodes | None = None
) -> tuple[Array, Grid, Nodes | None]:
    """A level set as a field, its grid and its nodes, from a field or a band."""
    if isinstance(phi, Band):
        if nodes is not None or grid not in (None, phi.grid):
            raise InputError(
                "a band has a grid and nodes of its own, got others beside it",
                hint="the band alone, or band.values, band.grid, nodes=band.nodes",
            )
        return np.asarray(phi.values), phi.grid, phi.nodes
    if grid is None:
        raise InputError(
            "a level set on all nodes needs its grid", hint="a grid beside phi, or a Band"
        )
    return np.asarray(phi), grid, nodes


def axes(grid: Grid) -> tuple[Three, Wraps]:
    """Shape and periodic axes as the loops take them."""
    _, first, middle, last = layout(grid)
    x, y, z = wraps(grid).tolist()
    return (first, middle, last), (x, y, z)


def three(grid: Grid, points: Values) -> Values:
    """Points (n, ndim) [L] in node units with three coordinates, as the loops' axes are."""
    places = np.zeros((len(points), 3))
    places[:, :: 1 if grid.ndim == 3 else 2] = (points - np.array(grid.origin)) / grid.spacing
    return places


def refuse_empty(laid: Laid) -> None:
    """Refuse a level set of one sign: it has no contour."""
    below = laid.known < 0
    if below.all() or not below.any():
        told = (
            "on no nodes" if not below.size else "negative" if below.all() else "nowhere negative"
        )
        raise InputError(
            f"the level set has no contour: it is {told}",
            hint="a shape that the mesh resolves and that lies in the box",
        )


def check_level_set(phi: Array, grid: Grid, name: str = "phi") -> Array:
    """Refuse what is not a finite value per node."""
    _refuse_not_real(phi, name)
    if phi.shape != grid.shape:
        raise InputError(
            f"{name} must have shape {grid.shape}, got {phi.shape}", hint="one value per node"
        )
    _refuse_not_finite(phi, name)
    return phi


def check_nodes(nodes: Nodes, grid: Grid) -> Nodes:
    """Refuse what are not ascending flat indices of the grid."""
    known = np.asarray(nodes)
    if known.ndim != 1 or not np.issubdtype(known.dtype, np.integer):
        raise InputError(
            f"nodes must be flat indices of shape (n,), got {known.dtype} {known.shape}",
            hint="np.flatnonzero(abs(phi) < width)",
        )
    if len(known) and (known[0] < 0 or known[-1] >= grid.size or np.any(np.diff(known) <= 0)):
        raise InputError(
            f"nodes must ascend and lie between 0 and {grid.size - 1}", hint="np.unique(nodes)"
        )
    return known.astype(np.int64, copy=False)


def check_band_values(phi: Array, grid: Grid, nodes: Nodes, name: str = "phi") -> Array:
    """The values at the nodes; refuses other shapes and what is not finite there."""
    _refuse_not_real(phi, name)
    if phi.shape not in (grid.shape, nodes.shape):
        raise InputError(
            f"{name} must have shape {grid.shape} or {nodes.shape}, got {phi.shape}",
            hint="one value per node of the grid, or per node of the band",
        )
    values = phi if phi.shape == nodes.shape else phi.reshape(-1)[nodes]
    _refuse_not_finite(values, name)
    return values


def check_width(width: float) -> float:
    """Refuse a width that is no positive length."""
    given = as_number("width", width, hint="width=4 * grid.spacing")
    if not (math.isfinite(given) and given > 0):
        raise InputError(
            f"width must be a positive length, got {width}", hint="width=4 * grid.spacing"
        )
    return given


def scattered(values: Array, nodes: Nodes, grid: Grid) -> Values:
    """The values on the grid, unset nodes zero, known zeros tiny; as the interpolants ask."""
    from levelset._interpolant import TINY

    known = np.where(values == 0, TINY, np.asarray(values, np.float64))
    return np.asarray(Band(grid, nodes, known).on_grid().reshape(-1))


def _refuse_not_real(values: NDArray[Any], name: str) -> None:
    if values.dtype.kind not in "fiub":
        raise InputError(
            f"{name} must be real numbers, got {values.dtype}", hint=f"{name}.real, or floats"
        )


def _refuse_not_finite(values: Array, name: str) -> None:
    bad = int(np.size(values) - np.count_nonzero(np.isfinite(values)))
    if bad:
        raise InputError(
            f"{name} must be finite, it is not at {bad} of {values.size} nodes",
            hint="check the velocity that moved it",
        )
