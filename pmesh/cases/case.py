"""A named benchmark: parameters, the flow they mean, the metrics and the figure it is judged by."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pmesh.cases.options import checked, option, spelt
from remesh.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pmesh.cases.reference import Curve
    from pmesh.run.protocols import Watcher
    from pmesh.run.series import Series
    from pmesh.run.snapshots import Snapshot
    from pmesh.run.summary import Metric


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a finished run leaves to its case."""

    series: Series  # columns of series.csv by name, all steps since the start
    flow: Any
    state: Any
    folder: Path

    def snapshots(self) -> list[Snapshot]:
        """The snapshots of the run, in the order of their times."""
        from pmesh.run.snapshots import read_snapshots

        return read_snapshots(self.folder)

    def stages(self, times: Sequence[float]) -> list[Snapshot]:
        """The snapshots closest to some times, each once; the start if alone."""
        shots = self.snapshots()
        shots = shots[1:] or shots
        chosen = {shot.step: shot for t in times
                  for shot in [min(shots, key=lambda one: abs(one.time - t))]}  # fmt: skip
        return list(chosen.values())


@dataclass(frozen=True, kw_only=True)
class Case(ABC):
    """Base of the named cases: a frozen dataclass, each field an option of the command line."""

    until: float = option(1.0, "end of the run", unit="T")

    title: ClassVar[str]  # of the figure and the table
    source: ClassVar[str] = ""  # the paper and figure it repeats
    short: ClassVar[Mapping[str, Any]] = {}  # the options that make it a quick run
    size: ClassVar[str] = ""  # the option that sets the nodes: whole numbers, or a spacing

    def __post_init__(self) -> None:
        """Refuse parameters of the wrong kind; a case adds its own checks after this one."""
        values = {part.name: getattr(self, part.name) for part in dataclasses.fields(self)}
        for name, value in checked(type(self), values).items():
            object.__setattr__(self, name, value)
        self.require(self.until > 0, "until", "a positive time")

    def recipe(self) -> Any:
        """The flow alone, before any field on its mesh is made; None if the case cannot tell.

        A run too large for the memory is then refused before it takes any.
        """
        return None

    @abstractmethod
    def build(self) -> tuple[Any, Any]:
        """The flow and the state it starts from."""

    @abstractmethod
    def metrics(self, outcome: Outcome) -> list[Metric]:
        """The numbers of the run beside their references."""

    @abstractmethod
    def draw(self, outcome: Outcome) -> Figure:
        """The picture the paper shows, ours over the reference."""

    def watchers(self) -> Sequence[Watcher]:
        """Who watches the run: forces and the ledger; a case may add snapshots."""
        from pmesh.run.watchers import Forces, Ledger

        return [Forces(), Ledger()]

    def published(self) -> Mapping[str, Curve]:
        """Published histories, by the column of ``series.csv`` that they stand beside."""
        return {}

    @classmethod
    def make(cls, values: Mapping[str, Any], *, quick: bool = False) -> Self:
        """The case with these options, the others at their defaults; refuses unknown ones."""
        return cls(**checked(cls, {**(cls.short if quick else {}), **values}))

    def parameters(self) -> dict[str, Any]:
        """Every option with its value."""
        return {part.name: getattr(self, part.name) for part in dataclasses.fields(self)}

    def require(self, holds: bool, name: str, what: str, hint: str = "") -> None:
        """Refuse the option ``name`` unless ``holds``: it must be ``what``."""
        if not holds:
            default = type(self).__dataclass_fields__[name].default
            raise InputError(
                f"{name} must be {what}, got {getattr(self, name)}",
                hint=hint or f"--{name.replace('_', '-')} {spelt(default)}",
            )

    def positive(self, *names: str) -> None:
        """Refuse options that are not positive."""
        for name in names:
            value = getattr(self, name)
            self.require(value is None or (value > 0 and math.isfinite(value)), name, "positive")
