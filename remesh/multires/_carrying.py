"""Compiled loops that fill new blocks from coarser ones; blocks as in `_ghosts`."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

from remesh.compiled import drop_stale
from remesh.multires import _ghosts, _pyramid
from remesh.multires._ghosts import lattice, scratch, subdivide
from remesh.multires._pyramid import assign, quadrant

drop_stale(__file__, _ghosts.__file__, _pyramid.__file__)


@njit(cache=True, nogil=True)
def seed(first, pieces, step, start, values, tables, new):
    """The even nodes of the new blocks of a level."""
    _, under, sides = tables
    middle = under.shape[1] // 2
    for piece in range(first, pieces, step):
        n = start + piece
        if new[n]:
            for c in range(values.shape[0]):
                even = values[c, n, ::2, ::2, ::2]
                assign(even, quadrant(values[c, under[n, middle]], sides[n]))


@njit(cache=True, nogil=True)
def grow(first, pieces, step, start, values, tables, new, weights):
    """The other nodes of the new blocks of a level, predicted."""
    around, under, sides = tables
    edge, nodes, slab, plane = scratch(values[0], 0, 0, weights.size // 2)
    for piece in range(first, pieces, step):
        n = start + piece
        if new[n]:
            for c in range(values.shape[0]):
                lattice(values[c], values[c], around[n], under[n], sides[n], edge, nodes)
                subdivide(nodes, edge, (0, 0, 0), weights, slab, plane, values[c, n])
