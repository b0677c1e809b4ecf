"""What is known of a level set on the levels of a mesh, while its new bands are sought."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset import _layers, _pyramid
from levelset.band import Band
from levelset.lookup import around, places
from levelset.nodal import axes
from levelset.scratch import borrow, give_back
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.wavelets import get_wavelet

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
GUARD = 2  # nodes of a level beside those whose details ask for the next one
NONE = np.empty(0, np.int64)


class Floor:
    """What is known on one level, in scratch of the level's size."""

    def __init__(self, grid: Grid, nodes: Nodes = NONE, values: Array | None = None) -> None:
        self.grid = grid
        self.shape, self.wraps = map(np.array, axes(grid))
        self.marks = borrow("marks", (grid.size,), np.uint8)  # all zero but at the nodes
        self.field = borrow("field", (grid.size,), np.float64)
        self.nodes = [nodes]  # where a value is known
        self.asked = NONE  # where finer levels ask for the next one
        if values is not None:
            self.marks[nodes] = _pyramid.FOUND
            self.field[nodes] = values

    def take(self, finer: Floor, most: float, predict: Array) -> None:
        """Take the values of the next finer level, and what it asks for to stay.

        It stays where its own details, in its spacings, are above ``most``, so that what is too
        thin for this level is not lost with it.
        """
        for nodes in tuple(finer.nodes):
            more = np.empty(len(nodes), np.int64)
            count = _pyramid.restrict(
                nodes, finer.field, finer.shape, self.shape, self.field, self.marks, more
            )
            self.nodes.append(more[:count])
        near, sizes = finer.details(np.concatenate(finer.nodes), _pyramid.FOUND, predict)
        finer.marks[near] &= ~np.uint8(_pyramid.NEAR)
        near = np.concatenate([near, finer.asked])
        sizes = np.concatenate([sizes, np.full(len(finer.asked), np.inf)])
        asked = np.empty(len(near), np.int64)
        count = _pyramid.parents_of_rough(
            near, sizes, most, finer.shape, self.shape, self.marks, asked
        )
        self.asked = asked[:count]

    def ground(self, width: float, more: int) -> Nodes:
        """The band of the coarsest level: around all of the interface."""
        nodes = np.concatenate(self.nodes)
        band = around(nodes, self.field, self.marks, self.grid, width, more, self.asked)
        self.marks[band.nodes] = _pyramid.HELD
        self.marks[nodes] |= _pyramid.FOUND
        self.nodes.append(band.nodes)
        return band.nodes

    def details(
        self, nodes: Nodes, known: int, predict: Array, under: Floor | None = None
    ) -> tuple[Nodes, Array]:
        """Nodes beside the contour, and how far off it is without every second node there."""
        near = np.empty(len(nodes), np.int64)
        count = _pyramid.beside_contour(
            nodes, self.field, self.marks, known, self.shape, self.wraps,
            np.empty(0, np.uint8) if under is None else under.marks,
            self.shape if under is None else under.shape, near,
        )  # fmt: skip
        sizes = np.empty(count)
        _pyramid.details(
            near[:count], self.field, self.marks, known, self.shape, self.wraps, predict, sizes
        )
        return near[:count], sizes

    def ask(self, nodes: Nodes, sizes: Array, bounds: Sequence[float], above: Floor) -> None:
        """Ask for the next level where details are above the second bound.

        Where it is known already: above the first. And where finer levels asked for it.
        """
        asked = np.empty(len(nodes) + len(self.asked), np.int64)
        count = len(self.asked)
        asked[:count] = self.asked
        self.marks[self.asked] |= _pyramid.ROUGH
        total = _pyramid.to_refine(
            nodes, sizes, bounds[0], bounds[1], self.shape, above.marks, above.shape, self.marks,
            asked, count,
        )  # fmt: skip
        self.asked = asked[:total]

    def covered(self, room: int, layers: int, half: int) -> Nodes:
        """The nodes over which the next level has its own: around those where it is asked for."""
        total = len(self.asked)
        wide = np.empty(room + total, np.int64)
        wide[:total] = self.asked
        total = _pyramid.spread(
            wide, total, GUARD, _pyramid.NEAR, _pyramid.ROUGH, self.shape, self.wraps, self.marks
        )
        self.marks[wide[:total]] |= _pyramid.COVERED
        total = _pyramid.spread(
            wide, total, layers, _pyramid.HELD, _pyramid.COVERED, self.shape, self.wraps, self.marks
        )
        kept = np.empty(total, np.int64)
        count = _pyramid.keep_known(wide, total, half, self.shape, self.wraps, self.marks, kept)
        return kept[:count]

    def bear(self, covered: Nodes, above: Floor, fill: Callable[[Nodes], None]) -> Nodes:
        """The band of the next level: the children of these nodes; new ones are to be filled."""
        count = len(covered) * 2**self.grid.ndim
        born, fresh = np.empty(count, np.int64), np.empty(count, np.int64)
        new = _pyramid.bear(covered, self.shape, above.shape, above.marks, born, fresh)
        fill(fresh[:new])
        above.nodes.append(born)
        columns = above.grid.shape[-1]
        nodes = np.empty(count, np.int64)
        starts = np.zeros(above.grid.size // columns + 1, np.int64)
        _layers.order(born, count, columns, starts, nodes)
        return nodes

    def interpolate(self, above: Floor, predict: Array, nodes: Nodes) -> None:
        """Values at nodes of the next level, none beyond those nearest around it."""
        _pyramid.interpolate(
            nodes, self.field, self.shape, self.wraps, predict, above.shape, above.field
        )

    def evaluate(self, exact: Callable[[Array], Array], nodes: Nodes) -> None:
        """Values at nodes of this level as a law gives them at places (n, ndim)."""
        self.field[nodes] = exact(places(self.grid, nodes))

    def close(self) -> None:
        """Let others use the scratch."""
        for nodes in self.nodes:
            self.marks[nodes] = 0
        give_back("marks", self.marks)
        give_back("field", self.field)


def grown(
    mesh: AdaptiveMesh,
    floors: Sequence[Floor],
    bounds: Sequence[Sequence[float]],
    layers: int,
    ground: Callable[[], Nodes],
    fill: Callable[[int, Nodes], None],
) -> list[Nodes]:
    """The nodes of all levels, from the coarsest up, as details ask.

    ``bounds`` of each level: details below the first are let go, beyond the second refined.
    ``layers`` of nodes around those to be refined have finer ones too. ``ground`` gives the
    nodes of the coarsest level, ``fill`` a value to nodes that are new on a level.
    """
    predict = predicts(mesh)
    for level in range(mesh.levels, 0, -1):
        floors[level - 1].take(floors[level], bounds[level][0], predict)
    found = [ground()]
    for level in range(mesh.levels):
        here, above = floors[level], floors[level + 1]
        under = floors[level - 1] if level else None
        near, rough = here.details(found[-1], _pyramid.HELD, predict, under)
        here.ask(near, rough, bounds[level], above)
        covered = here.covered(len(found[-1]), layers, len(predict) // 2)
        found.append(here.bear(covered, above, partial(fill, level + 1)))
    return found


def bands(
    mesh: AdaptiveMesh,
    floors: Sequence[Floor],
    width: float,
    more: int,
    exact: Callable[[Array], Array] | None = None,
) -> tuple[Band, ...]:
    """The bands of all levels, from the coarsest up, as details ask; uses the floors up.

    ``width``: half width of the profile [L]; ``more``: nodes that a kernel reads. Nodes that are
    new on a level take the values that ``exact`` gives at places (n, ndim), else are interpolated
    from the coarser level.
    """
    predict = predicts(mesh)
    bounds = [[part * width / floor.grid.spacing for part in mesh.thresholds] for floor in floors]
    layers = (more + 3) // 2  # what the kernel reads, drawn together by half, over two

    def fill(level: int, nodes: Nodes) -> None:
        if exact is None:
            floors[level - 1].interpolate(floors[level], predict, nodes)
        else:
            floors[level].evaluate(exact, nodes)

    found = grown(mesh, floors, bounds, layers, lambda: floors[0].ground(width, more), fill)
    result = tuple(
        Band(floor.grid, nodes, floor.field[nodes])
        for floor, nodes in zip(floors, found, strict=True)
    )
    for floor in floors:
        floor.close()
    return result


def predicts(mesh: AdaptiveMesh) -> Array:
    """The weights by which the mesh's wavelet interpolates midway between nodes."""
    return np.array([float(w) for w in get_wavelet(mesh.wavelet).predict])
