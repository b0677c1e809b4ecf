"""An interface on particles at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

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
