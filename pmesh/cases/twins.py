"""Two flows that take the same steps, so that they can be compared at every one of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.grid import Grid
from remesh.limit import Limit, tightest

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class Pair:
    """The states of two flows at one instant."""

    time: float  # [T]
    step: int
    first: State
    second: State

    @property
    def grid(self) -> Grid:
        """The mesh of the first."""
        return self.first.grid

    @property
    def size(self) -> int:
        """Nodes that a step moves, of both."""
        return self.first.size + self.second.size


@dataclass(frozen=True, kw_only=True)
class Twins:
    """Two flows side by side, each in its own space; the smaller of their steps is both's.

    Columns and fields are those of the first; the columns of the second have a ``prefix``.
    """

    first: VortexFlow
    second: VortexFlow
    prefix: str

    def start(self) -> Pair:
        """Both at time 0."""
        return Pair(time=0.0, step=0, first=self.first.start(), second=self.second.start())

    def step(self, state: Pair, dt: float) -> Pair:
        """Both one step of dt [T] later."""
        return Pair(
            time=state.time + dt,
            step=state.step + 1,
            first=self.first.step(state.first, dt),
            second=self.second.step(state.second, dt),
        )

    def limit(self, state: Pair) -> Limit:
        """The largest step [T] that both allow, and the rule that sets it."""
        return tightest(self.first.limit(state.first), self.second.limit(state.second))

    def ledger(self, state: Pair) -> Mapping[str, float]:
        """What both keep."""
        return self._both(self.first.ledger(state.first), self.second.ledger(state.second))

    def forces(self, state: Pair) -> Mapping[str, float]:
        """Forces of both."""
        return self._both(self.first.forces(state.first), self.second.forces(state.second))

    def fields(self, state: Pair) -> Mapping[str, Array]:
        """Fields of the first."""
        return self.first.fields(state.first)

    def _both(self, first: Mapping[str, float], second: Mapping[str, float]) -> dict[str, float]:
        return {**first, **{f"{self.prefix}{name}": value for name, value in second.items()}}
