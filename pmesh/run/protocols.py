"""What the loop asks of a flow, of a state and of a watcher."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar, runtime_checkable

from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.limit import Limit

LANDING = 1e-9  # times closer than this part of `every` are the same time


class State(Protocol):
    """A frozen dataclass that holds exactly what a restart needs."""

    @property
    def time(self) -> float:
        """Time [T]."""

    @property
    def step(self) -> int:
        """Steps taken since the start."""

    @property
    def grid(self) -> Grid:
        """The mesh the fields live on, of an adaptive one the finest; it may change on the way."""

    @property
    def size(self) -> int:
        """Nodes or particles that a step moves."""


S = TypeVar("S", bound=State)
T_contra = TypeVar("T_contra", bound=State, contravariant=True)


class Observable(Protocol[T_contra]):
    """What can be asked of a state without changing it."""

    def limit(self, state: T_contra) -> Limit:
        """The largest step this state allows, and the rule that sets it."""

    def ledger(self, state: T_contra) -> Mapping[str, float]:
        """Invariants by name; the same names for every state of a run."""

    def forces(self, state: T_contra) -> Mapping[str, float]:
        """Forces by name, empty without bodies; the same names for every state of a run."""

    def fields(self, state: T_contra) -> Mapping[str, NDArray[Any]]:
        """Fields by name: scalars ``shape``, vectors ``(ndim, *shape)``.

        On the nodes of ``state.grid``; of a state that has ``blocks`` on those, with their shape.
        The mapping may compute a field only when it is asked for.
        """


class Flow(Observable[S], Protocol[S]):
    """A recipe that advances a state: ``step`` depends on its arguments only."""

    def step(self, state: S, dt: float) -> S:
        """The state one step of dt [T] later."""


@dataclass(frozen=True, kw_only=True)
class Moment:
    """What a watcher sees: a state of the run, and the step that led to it."""

    flow: Any
    state: Any
    dt: float  # of the step that led here [T]; 0 at the start
    rule: str  # that set dt; "start" at the start
    until: float  # end of the run [T]
    seconds: float = 0.0  # of work so far, earlier parts of a resumed run included
    node_steps: int = 0  # sum over the steps of the nodes or particles they moved
    out: Path | None = None  # the run directory

    @property
    def time(self) -> float:
        """Time of the state [T]."""
        return float(self.state.time)

    @property
    def step(self) -> int:
        """Steps taken since the start."""
        return int(self.state.step)

    def on(self, every: float) -> bool:
        """Whether the time is a multiple of ``every`` [T]."""
        return math.isclose(
            self.time, round(self.time / every) * every, rel_tol=1e-12, abs_tol=LANDING * every
        )


# A watcher is any callable of a Moment; the numbers it returns become columns of the series.
Watcher = Callable[[Moment], Mapping[str, float] | None]


@runtime_checkable
class Paced(Protocol):
    """A watcher on whose times, the multiples of ``every`` [T], the loop lands exactly."""

    @property
    def every(self) -> float:
        """Spacing of the times [T]."""


@runtime_checkable
class Staged(Protocol):
    """A watcher that wants to know when a run (or its resumption) begins and ends."""

    def open(self, moment: Moment) -> None:
        """Called once before the first step; after a resumption what is later is forgotten."""

    def close(self) -> None:
        """Called once when the run ends, however it ends."""
