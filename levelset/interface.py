"""An interface on particles at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Interface:
    """An interface at one instant: the particles near it. A value: a step makes a new one."""

    time: float  # [T]
    step: int  # steps taken since the start
    grid: Grid
    nodes: Nodes  # (n,), where each particle started after the last remeshing; ascending
    positions: Array  # (n, ndim), where it is [L]
    values: Array  # (n,), what it carries: the profile of its distance [L]
    gradient: float  # largest |grad u| where particles are [1/T]
    age: int = 0  # steps since the last remeshing
    remeshings: int = 0  # since the start

    @property
    def size(self) -> int:
        """Number of particles."""
        return len(self.nodes)


class ByLevel:
    """Base of states whose nodes are those of several levels, one after the other."""

    mesh: AdaptiveMesh
    nodes: Nodes  # of each level's own grid, the coarsest level first
    starts: tuple[int, ...]  # nodes starts[l] to starts[l + 1] - 1 are of level l

    @property
    def size(self) -> int:
        """Number of active nodes: each place counts once, on its finest level."""
        return int(len(self.nodes) - (len(self.nodes) - self.starts[1]) // 2**self.mesh.ndim)

    def of(self, level: int) -> slice:
        """The nodes of a level."""
        return slice(self.starts[level], self.starts[level + 1])

    @property
    def finest(self) -> int:
        """The finest level that has nodes."""
        return int(np.flatnonzero(np.diff(self.starts)).max(initial=0))


@dataclass(frozen=True, kw_only=True)
class AdaptiveInterface(ByLevel, Interface):
    """An interface on particles of several spacings: those of each level, the coarsest first.

    ``nodes`` are those of the level's own grid, ascending within each level. Where a finer level
    has particles the coarser one keeps its own beside them. ``grid`` is the finest.
    """

    mesh: AdaptiveMesh
    starts: tuple[int, ...]  # particles starts[l] to starts[l + 1] - 1 are of level l
