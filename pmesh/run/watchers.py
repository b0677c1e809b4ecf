"""The watchers that every run can have: forces and the ledger of invariants as columns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pmesh.run.protocols import Moment
from pmesh.run.series import TEXT, Series


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
    """Columns with the forces on every body, by each route the flow offers."""

    def __call__(self, moment: Moment) -> Mapping[str, float]:
        """The forces at this moment."""
        return self.record(moment, moment.flow.forces(moment.state))


class Ledger(Recorder):
    """Columns with the flow's invariants, and what left the domain."""

    def __call__(self, moment: Moment) -> Mapping[str, float]:
        """The invariants at this moment."""
        return self.record(moment, moment.flow.ledger(moment.state))
