"""A level set in bands of several spacings: fine where the interface needs it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset import _pyramid
from levelset.band import Band
from levelset.floors import Floor, bands, predicts
from levelset.lookup import Lattice, places
from levelset.nodal import axes
from levelset.profile import LEVEL
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.layout import split, tables
from remesh.multires.mesh import AdaptiveMesh
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


class Pyramid(NamedTuple):
    """The same level set in a band of each level of a mesh; fine ones lie within coarse ones.

    The band of level 0 is around all of the interface, those of finer levels around the parts that
    need them. Where a finer one has a node the coarser one holds its value.
    """

    mesh: AdaptiveMesh
    bands: tuple[Band, ...]  # of levels 0 to mesh.levels; empty where nothing is so fine

    @property
    def stored(self) -> int:
        """Number of nodes in all bands."""
        return sum(len(band.nodes) for band in self.bands)

    @property
    def active(self) -> int:
        """Number of places that nodes are at: each counts once, on its finest level."""
        part: int = 2**self.mesh.ndim
        return self.stored - sum(len(band.nodes) for band in self.bands[1:]) // part

    @property
    def finest(self) -> int:
        """The finest level that has nodes."""
        return max((n for n, band in enumerate(self.bands) if len(band.nodes)), default=0)


def remeshed(
    mesh: AdaptiveMesh,
    particles: Sequence[tuple[Nodes, Array, Array]],
    kernel: str | Kernel,
    width: float,
    *,
    threads: int | None = None,
) -> Pyramid:
    """Particles of all levels that left their home nodes, remeshed onto the bands they need now.

    ``particles``: home nodes, positions (n, ndim) [L] and values of each level. Every level looks
    up its own map (`levelset.lookup.remeshed`), finer ones only where their stencils are whole.
    """
    floors, folds = [], 0
    for level, (nodes, positions, values) in enumerate(particles):
        grid = mesh.level_grid(level)
        lattice = Lattice(grid, nodes, positions, values, threads)
        cells = None if level == 0 else _whole(lattice, kernel)
        looked = lattice.look_up(kernel, LEVEL * width, cells)
        found = looked.nodes.copy()
        floors.append((grid, found, looked.field[found]))
        folds += looked.folds
        looked.close(Band(grid, found, values))
    if folds:
        raise InputError(
            f"particles have crossed each other in {folds} cells of their lattice",
            hint="a smaller dt or `deformation`, or remeshing more often",
        )
    more = get_kernel(kernel).half_width
    return Pyramid(mesh, bands(mesh, [Floor(*floor) for floor in floors], width, more))


def _whole(lattice: Lattice, kernel: str | Kernel) -> Nodes:
    """The nodes at which cells begin whose stencils are all known."""
    _, _, taps, mid, _ = tables(kernel, lattice.grid, np.dtype(np.float64))
    found = np.empty(len(lattice.nodes), np.int64)
    count = _pyramid.whole(
        lattice.nodes, lattice.shape, lattice.wraps, lattice.known, lattice.fields, taps, mid, found
    )
    return found[:count]


def started(
    mesh: AdaptiveMesh, exact: Callable[[Array], Array], width: float, more: int
) -> Pyramid:
    """The bands around a level set that is known at all places (n, ndim) [L]."""
    grid = mesh.level_grid(0)
    nodes = np.arange(grid.size)
    floors = [Floor(grid, nodes, exact(places(grid, nodes)))]
    floors += [Floor(mesh.level_grid(level)) for level in range(1, mesh.levels + 1)]
    return Pyramid(mesh, bands(mesh, floors, width, more, exact))


def at_nodes(known: Array, grid: Grid) -> Callable[[Array], Array]:
    """The law that gives what is known on the nodes of a grid, at places (n, ndim) of these."""
    start = np.array(grid.origin)

    def law(at: Array) -> Array:
        indices = np.rint((at - start) / grid.spacing).astype(np.int64)
        return np.asarray(known[tuple(indices.T)])

    return law


def to_uniform(
    pyramid: Pyramid, level: int | None, beyond: float, *, threads: int | None = None
) -> Array:
    """The level set on all nodes of a level, None: the finest: its values, else coarser ones'.

    ``beyond``: its size away from the interface. Nodes without a value are interpolated. Refuses
    levels that the mesh has not.
    """
    mesh = pyramid.mesh
    predict = predicts(mesh)
    field = pyramid.bands[0].filled(beyond)
    for finer in range(1, mesh.checked_level(level) + 1):
        band = pyramid.bands[finer]
        shape, wraps = axes(mesh.level_grid(finer - 1))
        below, _ = axes(band.grid)
        result = np.empty(band.grid.size)
        size, pieces = split(shape[0])
        share(
            _pyramid.fill, pieces, thread_count(threads), size, field.reshape(-1), shape, wraps,
            predict, 0.9999 * beyond, below, result,
        )  # fmt: skip
        result[band.nodes] = band.values
        field = result.reshape(band.grid.shape)
    return field


def levels_at(pyramid: Pyramid, level: int | None = None) -> NDArray[np.int8]:
    """The finest level that has a node at each node of a level, within its cell, or under it.

    By default on the finest; -1 where no level has one. Refuses levels that the mesh has not.
    """
    asked, first = pyramid.mesh.checked_level(level), pyramid.bands[0]
    result = np.full(first.grid.shape, -1, np.int8)
    result.reshape(-1)[first.nodes] = 0
    for finer, band in enumerate(pyramid.bands[1:], 1):
        if finer <= asked:
            for axis in range(result.ndim):
                result = np.repeat(result, 2, axis=axis)
            result.reshape(-1)[band.nodes] = finer
        else:
            at = np.array(np.unravel_index(band.nodes, band.grid.shape))
            result[tuple(at >> (finer - asked))] = finer
    return result
