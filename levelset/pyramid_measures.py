"""Volume, area and centroid of a level set in bands of several spacings: each place counts once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from levelset import _pyramid
from levelset.nodal import axes, laid_out
from levelset.pyramid import Pyramid
from levelset.quadrature import Measures, cell_terms, with_beyond
from remesh.layout import split

Values = NDArray[np.float64]
Nodes = NDArray[np.int64]


def pyramid_measures(pyramid: Pyramid, *, threads: int | None = None) -> Measures:
    """Volume where the level set is negative, area of its surface, its centre; as `measures`.

    Each cell is counted on the finest level that knows two nodes to each side of it. Of order 4 in
    the spacing at each place; exact where the interpolants are, across jumps of the spacing too.
    """
    mesh = pyramid.mesh
    volume = surface = 0.0
    first = np.zeros(mesh.ndim)
    for level, own in enumerate(_counted(pyramid)):
        band = pyramid.bands[level]
        if not len(own):
            continue
        laid = laid_out(band)
        size, pieces = split(len(own))
        found = cell_terms(
            laid._replace(nodes=own, size=size, pieces=pieces), None, "inside", threads
        )
        if level == 0:
            found = with_beyond(laid, found)
        h = band.grid.spacing
        volume += found[0] * h**mesh.ndim
        surface += found[5] * h ** (mesh.ndim - 1)
        first += h ** (mesh.ndim + 1) * found[1 : 1 + mesh.ndim]
    centre = np.full(mesh.ndim, np.nan)
    if volume > 0:
        centre = mesh.grid.origin + first / volume
    return Measures(float(volume), float(surface), centre)


def _counted(pyramid: Pyramid) -> list[Nodes]:
    """The nodes at which the cells begin that each level counts."""
    bands, result = pyramid.bands, []
    above, higher = np.empty(0, np.uint8), np.ones(3, np.int64)
    for level, band in enumerate(bands):
        shape, wraps = (np.array(part) for part in axes(band.grid))
        marks = np.zeros(band.grid.size, np.uint8)
        if level < pyramid.mesh.levels:
            finer = bands[level + 1]
            under = np.empty(len(finer.nodes), np.int64)
            finer_shape = np.array(axes(finer.grid)[0])
            _pyramid.parents(finer.nodes, finer_shape, shape, marks, _pyramid.COVERED, under)
        own = np.empty(len(band.nodes), np.int64)
        count = _pyramid.cells(band.nodes, level > 0, shape, wraps, marks, above, higher, own)
        result.append(own[:count])
        above, higher = marks, shape
    return result
