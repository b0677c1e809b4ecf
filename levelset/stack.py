"""A level set on the levels of a mesh while it moves: all of the box coarse, parts of it finer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset import _pyramid, _stack
from levelset.band import Band
from levelset.floors import Floor, grown, predicts
from levelset.stages import stage_count, stages
from remesh.layout import split
from remesh.multires.mesh import AdaptiveMesh
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
Nodes = NDArray[np.int64]
LAYERS = 2  # nodes of a level around those to be refined over which the next one has its own
TAKEN = 32  # flag of a node: the next finer level tells its value
EXPLICIT = 0.375  # of h^2/ndim: the step in which the highest wave of fourth order turns its sign


class Part(NamedTuple):
    """The nodes of a level: those that move, those told by the coarser one, those that tell it."""

    moved: Nodes
    told: Nodes
    pairs: Nodes  # nodes whose value goes to the coarser level,
    under: Nodes  # to these


class Stack:
    """All levels at work: dense scratch of each, in which the nodes of its band are known."""

    def __init__(
        self,
        mesh: AdaptiveMesh,
        floors: Sequence[Floor],
        exact: Callable[[Array], Array] | None = None,
        threads: int | None = None,
    ) -> None:
        self.mesh, self.floors, self.threads = mesh, floors, thread_count(threads)
        self.predict = predicts(mesh)
        self.tables = [_tables(floor) for floor in floors]
        self.nodes = self._adapt(exact)

    def _adapt(self, exact: Callable[[Array], Array] | None) -> list[Nodes]:
        """The nodes of all levels that the contour needs now; new ones interpolated, or exact."""

        def fill(level: int, nodes: Nodes) -> None:
            if exact is None:
                self._prolong(level, nodes)
            else:
                self.floors[level].evaluate(exact, nodes)

        bounds = [self.mesh.thresholds] * len(self.floors)
        return grown(self.mesh, self.floors, bounds, LAYERS, self._ground, fill)

    def _ground(self) -> Nodes:
        """The nodes of the coarsest level: all."""
        ground = self.floors[0]
        ground.marks |= np.uint8(_pyramid.FOUND | _pyramid.HELD)
        return np.arange(ground.grid.size)

    def _prolong(self, level: int, nodes: Nodes) -> None:
        """Values at nodes of a level, interpolated from the next coarser one."""
        here, below = self.floors[level], self.floors[level - 1]
        size, pieces = split(len(nodes))
        if pieces:
            share(
                _stack.prolong, pieces, self.threads, size, nodes, here.shape, below.shape,
                *self.tables[level - 1], below.field, self.predict, here.field,
            )  # fmt: skip

    def parts(self) -> list[Part]:
        """The nodes of each level parted by who tells them."""
        result = []
        for level in range(self.mesh.levels, -1, -1):
            here, nodes = self.floors[level], self.nodes[level]
            below = self.floors[level - 1] if level else here
            moved, told, under, pairs = (np.empty(len(nodes), np.int64) for _ in range(4))
            going, held, shared = _stack.part(
                nodes, level == 0, here.shape, below.shape, *self.tables[level], here.marks,
                below.marks, (_pyramid.HELD, TAKEN), moved, told, under, pairs,
            )  # fmt: skip
            result.append(Part(moved[:going], told[:held], pairs[:shared], under[:shared]))
        return result[::-1]

    def settle(self, parts: Sequence[Part]) -> None:
        """Levels tell each other: finer ones down, then coarser ones up."""
        for level in range(self.mesh.levels, 0, -1):
            part = parts[level]
            here, below = self.floors[level], self.floors[level - 1]
            _stack.hand_down(part.pairs, part.under, here.field, below.field)
        for level in range(1, self.mesh.levels + 1):
            self._prolong(level, parts[level].told)

    def rates(self, level: int, nodes: Nodes, result: Values) -> None:
        """kappa |grad phi| [1/L] at nodes of a level."""
        here = self.floors[level]
        loop = _stack.motion2 if self.mesh.ndim == 2 else _stack.motion3
        size, pieces = split(len(nodes))
        if pieces:
            share(
                loop, pieces, self.threads, size, nodes, here.shape, *self.tables[level],
                here.field, here.grid.spacing**-2, result,
            )  # fmt: skip

    def move(self, dt: float) -> None:
        """All levels by the time dt [L^2] of motion by mean curvature, in as many stages as needed.

        Of order 2 in dt, stable for any; the levels agree after every stage.
        """
        parts = self.parts()
        self.settle(parts)
        starts = [f.field[p.moved] for f, p in zip(self.floors, parts, strict=True)]
        befores = [start.copy() for start in starts]
        rates = [np.empty(len(start)) for start in starts]
        initial: list[Values] = []
        for weights in stages(stage_count(dt / self.explicit(parts))):
            for level, part in enumerate(parts):
                self.rates(level, part.moved, rates[level])
            initial = initial or [rate.copy() for rate in rates]
            told = (*weights[:3], dt * weights.rate, dt * weights.start)
            for level, part in enumerate(parts):
                size, pieces = split(len(part.moved))
                if pieces:
                    share(
                        _stack.advance, pieces, self.threads, size, part.moved, told,
                        starts[level], befores[level], rates[level], initial[level],
                        self.floors[level].field,
                    )  # fmt: skip
            self.settle(parts)

    def explicit(self, parts: Sequence[Part]) -> float:
        """The longest step [L^2] of the explicit Euler method."""
        finest = max(level for level, part in enumerate(parts) if len(part.moved))
        return EXPLICIT * self.mesh.spacing(finest) ** 2 / self.mesh.ndim

    def close(self, dtype: np.dtype[Any]) -> tuple[Band, ...]:
        """The bands of all levels; lets others use the scratch."""
        bands = tuple(
            Band(floor.grid, nodes, floor.field[nodes].astype(dtype))
            for floor, nodes in zip(self.floors, self.nodes, strict=True)
        )
        for floor in self.floors:
            floor.close()
        return bands


def _tables(floor: Floor) -> tuple[Nodes, Nodes, Nodes]:
    """Flat indices along each axis of a level, with two places beyond both ends."""
    _, middle, last = (int(n) for n in floor.shape)
    found = []
    for axis, stride in enumerate((middle * last, last, 1)):
        count = int(floor.shape[axis])
        result = np.empty(count + 4, np.int64)
        _stack.table(count, bool(floor.wraps[axis]), stride, result)
        found.append(result)
    return found[0], found[1], found[2]
