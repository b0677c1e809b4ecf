"""A level set on the nodes of a mesh, checked and laid out for the compiled loops."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.closest import check_band_values, check_level_set, check_nodes, scattered
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import split

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Values = NDArray[np.float64]


class Laid(NamedTuple):
    """What the loops take: flat values, three axes (the last of one node in the plane), nodes."""

    flat: Values  # with gaps, zero where nothing is known
    shape: NDArray[np.int64]
    wraps: NDArray[np.bool_]
    nodes: Nodes  # where results are wanted; one entry, not read, if these are all nodes
    gaps: bool  # whether phi is known at the nodes only
    size: int  # of a piece of work
    pieces: int

    @property
    def known(self) -> Values:
        """The values where they are known."""
        return self.flat[self.nodes] if self.gaps else self.flat


def laid_out(phi: Array, grid: Grid, nodes: Nodes | None = None, *, name: str = "phi") -> Laid:
    """The level set for the loops, in float64; with ``nodes`` its cost is that of the nodes.

    Refuses another shape than the grid's, nodes that do not ascend or lie beyond it, and values
    that are not finite where they are known; errors call the values by ``name``.
    """
    values = np.asarray(phi)
    shape = np.array((*grid.shape, 1)[:3], np.int64)
    wraps = np.array((*grid.periodic, False)[:3])
    if nodes is None:
        flat = np.ascontiguousarray(check_level_set(values, grid, name), np.float64).reshape(-1)
        size, pieces = split(flat.size)
        return Laid(flat, shape, wraps, np.zeros(1, np.int64), False, size, pieces)
    places = np.ascontiguousarray(check_nodes(nodes, grid))
    known = check_band_values(values, grid, places, name).astype(np.float64)
    size, pieces = split(len(places))
    flat = np.asarray(scattered(known, places, grid), np.float64)
    return Laid(flat, shape, wraps, places, True, size, pieces)


def on_mesh(phi: Array | Band, grid: Grid | None) -> tuple[Array, Grid, Nodes | None]:
    """A level set as a field, its grid and its nodes, from a field or a band."""
    if isinstance(phi, Band):
        return phi.values, phi.grid, phi.nodes
    if grid is None:
        raise InputError("a level set on all nodes needs its grid", hint="contours(phi, grid)")
    return np.asarray(phi), grid, None


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
