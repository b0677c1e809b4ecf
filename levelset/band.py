"""Nodes near an interface and what is known there, at a cost that follows the interface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.rows import filled
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


class Band(NamedTuple):
    """A level set known at some nodes of a grid only."""

    grid: Grid
    nodes: Nodes  # flat indices in C order, ascending
    values: Array  # of the level set there, negative inside [L]

    def on_grid(self) -> Array:
        """The values in an array of ``grid.shape``, zero where nothing is known.

        Pages without nodes are never touched: the cost is that of the nodes.
        """
        field = np.zeros(self.grid.shape, self.values.dtype)
        field.reshape(-1)[self.nodes] = self.values
        return field

    def filled(self, beyond: float) -> Array:
        """The values on all nodes: +-``beyond`` outside the band, by the side that they are on."""
        return filled(self.nodes, self.values, self.grid, beyond)
