"""The summary of a run: its numbers beside published ones, and what it cost."""

from __future__ import annotations

import json
import math
import resource
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal

from pmesh.run.files import write_atomic
from remesh.errors import InputError

Kind = Literal["relative", "absolute", "report"]


@dataclass(frozen=True)
class Metric:
    """A number of the run beside its reference; ``grade`` and ``source`` say how far to trust that.

    The error is ``(value - reference) / |reference|`` if ``kind`` is "relative", the difference if
    "absolute"; it passes if its size is at most ``tolerance``. A "report" is shown and not judged.
    """

    name: str
    value: float
    reference: float | None = None
    tolerance: float | None = None
    grade: str = ""
    source: str = ""
    kind: Kind = "relative"

    def __post_init__(self) -> None:
        """Refuse a metric that cannot be judged."""
        if self.kind not in ("relative", "absolute", "report"):
            raise InputError(
                f"kind must be 'relative', 'absolute' or 'report', got {self.kind!r}",
                hint="kind='relative'",
            )
        if self.kind != "report" and (self.reference is None or self.tolerance is None):
            raise InputError(
                f"the metric {self.name!r} needs a reference and a tolerance to be judged",
                hint="kind='report', if there is none",
            )
        if self.kind == "relative" and self.reference == 0:
            raise InputError(
                f"the metric {self.name!r} has no relative error, its reference is 0",
                hint="kind='absolute'",
            )

    @property
    def error(self) -> float | None:
        """How far the value is from the reference, if there is one."""
        if self.reference is None:
            return None
        difference = float(self.value) - float(self.reference)
        relative = self.kind == "relative" or (self.kind == "report" and self.reference != 0)
        return difference / abs(float(self.reference)) if relative else difference

    @property
    def passed(self) -> bool | None:
        """Whether the error is within the tolerance; None for a report. NaN never passes."""
        if self.kind == "report" or self.error is None or self.tolerance is None:
            return None
        return bool(abs(self.error) <= self.tolerance)


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a run cost, all its parts together."""

    steps: int
    seconds: float
    node_steps: int  # sum over the steps of the nodes moved

    def as_dict(self) -> dict[str, float]:
        """The entries of summary.json."""
        speed = self.node_steps / self.seconds if self.seconds > 0 else 0.0
        return {
            "steps": self.steps,
            "seconds": round(self.seconds, 3),
            "particle_steps_per_second": round(speed, 1),
            "peak_memory_mb": round(peak_memory(), 1),
        }


def peak_memory() -> float:
    """The most memory this process has held so far [MB]."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def summary(case: str, metrics: Sequence[Metric], cost: Cost) -> dict[str, Any]:
    """The content of summary.json; a number that is not finite becomes null."""
    return {
        "case": case,
        "metrics": [
            {
                "name": metric.name,
                "value": _finite(metric.value),
                "reference": _finite(metric.reference),
                "error": _finite(metric.error),
                "tolerance": _finite(metric.tolerance),
                "pass": metric.passed,
                "grade": metric.grade,
                "source": metric.source,
            }
            for metric in metrics
        ],
        "cost": cost.as_dict(),
    }


def write_summary(path: Path, case: str, metrics: Sequence[Metric], cost: Cost) -> None:
    """Write summary.json."""
    text = json.dumps(summary(case, metrics, cost), indent=2, allow_nan=False)
    write_atomic(path, (text + "\n").encode())


def show(case: str, metrics: Sequence[Metric], cost: Cost, stream: IO[str] | None = None) -> None:
    """Write the closing table: value, reference, error, tolerance, pass or fail; then the cost."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console, JustifyMethod
    from rich.table import Table
    from rich.text import Text

    out = stream or sys.stdout
    console = Console(file=out, width=None if out.isatty() else 140)
    table = Table(title=case, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    names = ["metric", *NUMBERS, "result", "grade", "source"]
    if console.width < 100:
        names = names[:-2]  # summary.json has grades and sources; here the numbers come first
    for name in names:
        side: JustifyMethod = "right" if name in NUMBERS else "left"
        table.add_column(name, justify=side, no_wrap=name not in ("metric", "source"))
    for metric in metrics:
        result, colour = RESULTS[metric.passed]
        if metric.passed is None and metric.reference is not None:
            result = "not judged"
        relative = metric.kind == "relative" or (metric.kind == "report" and metric.reference)
        cells = (
            Text(metric.name),
            _number(metric.value),
            _number(metric.reference),
            _percent(metric.error) if relative else _number(metric.error),
            _percent(metric.tolerance) if metric.kind == "relative" else _number(metric.tolerance),
            Text(result, style=colour),
            Text(metric.grade),
            Text(metric.source),
        )
        table.add_row(*cells[: len(names)])
    console.print(table)
    numbers = cost.as_dict()
    console.print(
        f"{numbers['steps']} steps in {numbers['seconds']:.1f} s, "
        f"{numbers['particle_steps_per_second'] / 1e6:.2f} million particle steps per second, "
        f"{numbers['peak_memory_mb']:.0f} MB",
        highlight=False,
    )


NUMBERS = ("value", "reference", "error", "tolerance")
RESULTS = {True: ("pass", "green"), False: ("FAIL", "bold red"), None: ("", "")}


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _percent(value: float | None) -> str:
    if value is None:
        return ""
    return f"{100 * value:.3g} %" if abs(value) >= 1e-5 else f"{value:.2g}"
