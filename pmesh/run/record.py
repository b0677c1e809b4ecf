"""A quantity over time as a curve: from uneven steps to its mean over any stretch of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from remesh.errors import InputError

Values = NDArray[np.float64]
FEWEST = 8  # rows


@dataclass(frozen=True)
class Record:
    """A curve over ``edges[0] <= t <= edges[-1]`` [T] through its running integral, a cubic spline.

    Fourth order in the steps; the integral between two edges is that of the rows, to round-off.
    """

    edges: Values  # of the steps, increasing [T]
    integral: Any  # CubicSpline [Q T]

    @property
    def start(self) -> float:
        """Where it begins [T]."""
        return float(self.edges[0])

    @property
    def end(self) -> float:
        """Where it ends [T]."""
        return float(self.edges[-1])

    @property
    def span(self) -> float:
        """How long it is [T]."""
        return self.end - self.start

    @property
    def step(self) -> float:
        """The median step [T]."""
        return float(np.median(np.diff(self.edges)))

    def at(self, time: ArrayLike) -> Values:
        """Values at the given times."""
        return np.asarray(self.integral(np.asarray(time), 1), np.float64)

    def means(self, edges: Values) -> Values:
        """Means between successive times."""
        return np.asarray(np.diff(self.integral(edges)) / np.diff(edges), np.float64)

    def even(self, count: int) -> tuple[Values, Values]:
        """Middles of ``count`` stretches of equal length, and the mean over each."""
        edges = np.linspace(self.start, self.end, count + 1)
        return 0.5 * (edges[1:] + edges[:-1]), self.means(edges)

    def after(self, time: float) -> Record:
        """The part from a time on."""
        kept = self.edges[self.edges > time]
        if kept.size < FEWEST:
            raise InputError(
                f"the record ends at t = {self.end:g}, asked for what comes after {time:g}",
                hint="an earlier time, or a longer run",
            )
        return Record(np.concatenate([[max(time, self.start)], kept]), self.integral)


def record(time: ArrayLike, value: ArrayLike, dt: ArrayLike | None = None) -> Record:
    """The curve of columns ``time`` [T] and ``value`` [Q] with uneven steps.

    With ``dt`` [T] each value is the mean over the step that ends at its time, as forces in
    ``series.csv`` are; without, values are at their times. Rows at the start that hold NaN, or
    whose dt is 0, are left out. Refuses fewer than 8 rows, times that do not increase, NaN in
    between, and steps with gaps.
    """
    t, x = np.asarray(time, np.float64), np.asarray(value, np.float64)
    steps = None if dt is None else np.asarray(dt, np.float64)
    if t.ndim != 1 or t.shape != x.shape or (steps is not None and steps.shape != t.shape):
        shapes = [t.shape, x.shape] + ([] if steps is None else [steps.shape])
        raise InputError(f"time, value and dt must be columns of one length, got {shapes}")
    usable = np.isfinite(x) & np.isfinite(t) & (True if steps is None else steps > 0)
    first = int(np.argmax(usable)) if usable.any() else t.size
    t, x = t[first:], x[first:]
    if t.size < FEWEST:
        raise InputError(
            f"a record needs at least {FEWEST} rows with numbers, got {t.size}",
            hint="a longer run",
        )
    if not usable[first:].all():
        raise InputError(
            f"the record is not finite at t = {t[np.argmin(usable[first:])]:g}",
            hint="the part before, or after",
        )
    if steps is None:
        _increasing(t)
        return Record(t, CubicSpline(t, x).antiderivative())
    steps = steps[first:]
    edges = np.concatenate([[t[0] - steps[0]], t])
    _increasing(edges)
    if np.abs(np.diff(edges) - steps).max() > 1e-6 * steps.max():
        raise InputError(
            "the steps dt leave gaps between the times", hint="dt=None for values at their times"
        )
    total = np.concatenate([[0.0], np.cumsum(x * np.diff(edges))])
    return Record(edges, CubicSpline(edges, total))


def _increasing(time: Values) -> None:
    if (np.diff(time) <= 0).any():
        where = int(np.argmax(np.diff(time) <= 0))
        raise InputError(
            f"times must increase, got {time[where + 1]:g} after {time[where]:g}",
            hint="the rows of one run, in their order",
        )
