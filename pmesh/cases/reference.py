"""Published curves that the cases compare with, read from the data files beside this module."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

KOUMOUTSAKOS_LEONARD = "Koumoutsakos & Leonard 1995"
DATA = Path(__file__).parent / "data"


@dataclass(frozen=True, eq=False)
class Curve:
    """A published curve: values over increasing times, with its grade and source."""

    time: NDArray[np.float64]
    value: NDArray[np.float64]
    grade: str
    source: str

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the curve."""
        return float(self.time[0]), float(self.time[-1])

    def at(self, time: float | NDArray[np.floating[Any]]) -> NDArray[np.float64]:
        """Values at the given times, straight between points in log-log; NaN outside the span."""
        asked = np.asarray(time, np.float64)
        low, high = self.span
        known = (asked >= low) & (asked <= high)
        inside = np.log(np.where(known, asked, low))
        value = np.exp(np.interp(inside, np.log(self.time), np.log(self.value)))
        return np.where(known, value, np.nan)


def cylinder_drag(reynolds: float, source: str = KOUMOUTSAKOS_LEONARD) -> Curve:
    """Drag coefficient of the impulsively started cylinder over T = U t/R, as published.

    Refuses a Reynolds number (U D/nu) that the source does not give, listing those it gives.
    """
    curves = _cylinder_curves()
    if (float(reynolds), source) not in curves:
        given = sorted(re for re, name in curves if name == source)
        if not given:
            known = ", ".join(repr(name) for name in sorted({name for _, name in curves}))
            raise InputError(f"no drag curves from {source!r}", hint=f"one of {known}")
        raise InputError(
            f"{source} give no drag at Re = {reynolds:g}",
            hint="Re = " + ", ".join(f"{re:g}" for re in given),
        )
    return curves[float(reynolds), source]


def cylinder_reynolds(source: str = KOUMOUTSAKOS_LEONARD) -> tuple[float, ...]:
    """Reynolds numbers, increasing, at which a source gives the drag of the started cylinder."""
    return tuple(sorted(re for re, name in _cylinder_curves() if name == source))


@cache
def _cylinder_curves() -> dict[tuple[float, str], Curve]:
    """All curves of the drag file, by Reynolds number and source."""
    groups: dict[tuple[float, str], list[dict[str, str]]] = {}
    for row in read_table("cylinder_drag.csv"):
        groups.setdefault((float(row["reynolds"]), row["source"]), []).append(row)
    return {
        (reynolds, source): Curve(
            np.array([float(row["time"]) for row in rows]),
            np.array([float(row["drag"]) for row in rows]),
            rows[0]["grade"],
            source,
        )
        for (reynolds, source), rows in groups.items()
    }


def read_table(name: str) -> list[dict[str, str]]:
    """Rows of a data file by column name; lines that begin with # are its citation."""
    with (DATA / name).open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))
