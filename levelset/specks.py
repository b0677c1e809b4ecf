"""Drops of a single node, which a mesh keeps though it does not resolve them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.nodal import laid_out
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


def specks(
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    depth: float = 0.5,
) -> Nodes:
    """Flat indices of the nodes inside that have no neighbour inside, ascending.

    Only those less than ``depth`` spacings deep: phi is a distance. `redistance` never changes a
    sign, so a drop that shrank to one node would stay for ever; who follows an interface through
    time may raise these nodes to outside before it. -phi finds bubbles. ``phi`` of ``grid.shape``,
    known at ``nodes`` only, or a `Band`. Cost: that of the nodes. Refuses what is not finite.
    """
    laid = laid_out(phi, grid, nodes)
    every = laid.nodes if laid.gaps else np.arange(laid.grid.size)
    known = laid.known
    found = every[(known < 0) & (known > -depth * laid.grid.spacing)]
    places = np.unravel_index(found, laid.grid.shape)
    alone = np.ones(len(found), bool)
    for axis, (size, wraps) in enumerate(zip(laid.grid.shape, laid.grid.periodic, strict=True)):
        for step in (-1, 1):
            beside = places[axis] + step
            there = wraps | ((beside >= 0) & (beside < size))
            around = [beside % size if k == axis else place for k, place in enumerate(places)]
            other = np.ravel_multi_index(around, laid.grid.shape)
            alone &= ~(there & (laid.flat[other] < 0))
    return np.asarray(found[alone])
