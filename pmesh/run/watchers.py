"""The watchers that every run can have: forces and the ledger of invariants as columns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pmesh.run.protocols import Moment
from pmesh.run.series import TEXT, Series
from remesh.errors import InputError


class Recorder:
    """What a watcher has seen in this process, step by step; ``series.csv`` holds the whole run."""

    def __init__(self) -> None:
        self._rows: list[dict[str, float | str]] = []

    @property
    def series(self) -> Series:
        """Columns by name: step, time, dt, rule and the watcher's own."""
        names = list(self._rows[0]) if self._rows else []
        return {
            name: np.array([row[name] for row in self._rows], dtype=str if name in TEXT else float)
            for name in names
        }

    def record(self, moment: Moment, columns: Mapping[str, float]) -> Mapping[str, float]:
        """Keep the columns of one step."""
        head: dict[str, float | str] = {
            "step": moment.step,
            "time": moment.time,
            "dt": moment.dt,
            "rule": moment.rule,
        }
        self._rows.append(head | dict(columns))
        return columns


class Forces(Recorder):
    """Columns with the forces on every body, by each route the flow offers.

    ``routes``: steps between those at which routes that cost more are asked too; the columns are
    NaN at others. None asks for none.
    """

    def __init__(self, *, routes: int | None = None) -> None:
        super().__init__()
        if routes is not None and not (isinstance(routes, int) and routes > 0):
            raise InputError(f"routes must be a number of steps, got {routes!r}", hint="routes=10")
        self.routes = routes
        self._before: Any = None

    def open(self, moment: Moment) -> None:
        """Keep the state that the next step begins from, if it will be asked for."""
        self._before = moment.state if self.routes is not None else None

    def close(self) -> None:
        """Let it go."""
        self._before = None

    def __call__(self, moment: Moment) -> Mapping[str, float]:
        """The forces at this moment."""
        forces = dict(moment.flow.forces(moment.state))
        if self.routes is not None and forces:
            forces |= self._more(moment, self.routes)
            self._before = moment.state
        return self.record(moment, forces)

    def _more(self, moment: Moment, every: int) -> Mapping[str, float]:
        """The routes that cost more, or their columns without values."""
        if moment.step % every == 0 and moment.dt > 0:
            return dict(moment.flow.routes(self._before, moment.state))
        return dict.fromkeys(moment.flow.route_names, math.nan)


class Ledger(Recorder):
    """Columns with the flow's invariants, and what left the domain."""

    def __call__(self, moment: Moment) -> Mapping[str, float]:
        """The invariants at this moment."""
        return self.record(moment, moment.flow.ledger(moment.state))
