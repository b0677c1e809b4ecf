"""A dumbbell that collapses by its mean curvature: it pinches off, and two drops vanish."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.solids import Dumbbell
from pmesh.cases.case import Case, Outcome
from pmesh.cases.dumbbell_curve import CURVE, Reference, followed
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

Values = NDArray[np.float64]
MARGIN = 0.2  # from the dumbbell to the edges of the box [L]
STAGES = (0.0, 0.55, 1.12, 2.8)  # drawn, in times of the pinch


@dataclass(frozen=True, kw_only=True)
class DumbbellCase(Case):
    """Two balls joined by a bar shrink at their mean curvature, part in the middle and vanish."""

    until: float = option(0.024, "end of the run", unit="L^2")
    radius: float = option(0.3, "of the balls", unit="L")
    separation: float = option(1.0, "of the balls' centres", unit="L")
    bar: float = option(0.1, "radius of the bar", unit="L")
    fillet: float = option(0.05, "radius of the round between bar and balls", unit="L")
    cells: int = option(64, "mesh cells per unit length")
    stretch: float = option(10.0, "time step over the explicit limit h^2/6")
    coarse: bool = option(True, "whether to run with half the cells as well")
    every: float = option(1e-3, "time between snapshots", unit="L^2")

    title: ClassVar[str] = "Collapsing dumbbell"
    source: ClassVar[str] = CURVE
    short: ClassVar[Mapping[str, Any]] = {
        "cells": 40,
        "until": 0.01,
        "coarse": False,
        "every": 2e-3,
    }

    def __post_init__(self) -> None:
        """Refuse what is no dumbbell, and a bar that the mesh does not see."""
        super().__post_init__()
        self.positive("radius", "separation", "bar", "stretch", "every")
        self.require(self.cells * self.bar >= 1.5, "cells", "at least 1.5 across the bar's radius")
        self.shape.bounds()

    @property
    def shape(self) -> Dumbbell:
        """The dumbbell at the start."""
        return Dumbbell(self.radius, separation=self.separation, bar=self.bar, fillet=self.fillet)

    def build(self) -> tuple[Any, Any]:
        """The flow on a box with a node in its middle, and the dumbbell's distance."""
        from levelset.curvature_flow import CurvatureFlow

        across = self.radius + MARGIN
        half = [math.ceil(self.cells * (0.5 * self.separation + across))]
        half += [math.ceil(self.cells * across)] * 2
        h = 1.0 / self.cells
        grid = Grid([2 * n + 1 for n in half], h, [-n * h for n in half])
        flow = CurvatureFlow(grid=grid, stretch=self.stretch)
        return flow, flow.start(self.shape)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the middle, the pieces and the symmetry, and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), watch_pieces, Snapshots(self.every, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Pinch, volumes and end beside the curve; symmetry; the coarse run."""
        series, known = outcome.series, self.reference()
        time, volume = series["time"], series["volume"]
        found = [
            Metric("volume at t = 0", volume[0], self.shape.volume, 0.002, "A", "closed form"),
            self._symmetry(float(series["asymmetry"].max())),
        ]
        exact = np.interp(time, *known.volume)
        off = float(np.abs(volume - exact).max() / volume[0])
        found.append(
            Metric("volume against time, largest error over the start's", off, 0.0, 0.01,
                   "A-num", CURVE, "absolute")
        )  # fmt: skip
        pinch, gone = zero_of(time, series["middle"]), zero_of(time, series["lowest"])
        if pinch is not None:
            after = (time > 1.05 * pinch) & (volume > 0.02 * volume[0])
            found.append(Metric("pinch-off time", pinch, known.pinch, 0.02, "A-num", CURVE))
            if after.any():
                pieces = float(series["pieces"][after].max())
                found.append(Metric("pieces after the pinch", pieces, 2.0, 0.0, "A-num", CURVE))
        if gone is not None:
            found.append(Metric("time at which all is gone", gone, known.end, 0.01, "A-num", CURVE))
        return [*found, *self._of_coarse(known)]

    def _symmetry(self, largest: float) -> Metric:
        """Whether the mirror images stay equal."""
        source = "the start is its own mirror image"
        name = "asymmetry, largest over max |phi|"
        return Metric(name, largest, 0.0, 1e-12, "A", source, "absolute")

    @property
    def other(self) -> str:
        """What the case that it is compared with is called."""
        return f"{self.rougher().cells} cells"

    def rougher(self) -> DumbbellCase:
        """The case that it is compared with: half the cells."""
        least = math.ceil(1.5 / self.bar)
        return replace(self, cells=max(self.cells // 2, least), coarse=False)

    def _of_coarse(self, known: Reference) -> list[Metric]:
        """The same on half the cells."""
        if not self.coarse:
            return []
        series = _coarse(self)
        exact = np.interp(series["time"], *known.volume)
        off = float(np.abs(series["volume"] - exact).max() / series["volume"][0])
        found = [Metric("volume on half the cells, largest error", off, 0.0, kind="report")]
        pinch = zero_of(series["time"], series["middle"])
        if pinch is not None:
            name = "pinch-off time on half the cells"
            found.append(Metric(name, pinch, known.pinch, None, "A-num", CURVE, "report"))
        return found

    def reference(self) -> Reference:
        """The curve of this dumbbell."""
        return followed(self.shape)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The surface at four stages; volume and middle over time; outlines over the curve."""
        from matplotlib.figure import Figure

        known = self.reference()
        figure = Figure(figsize=(11.0, 5.7), layout="constrained")
        halves: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.5))
        above, below = halves
        panels = below.subplots(1, 3, width_ratios=(1.0, 1.0, 1.35))
        shots = outcome.stages([known.pinch * part for part in STAGES])
        shots = [*outcome.snapshots()[:1], *shots[1:]] if len(shots) > 1 else shots
        stages = above.subplots(1, len(shots), squeeze=False)[0]
        for panel, shot in zip(stages, shots, strict=True):
            self._portrait(panel, shot)
        self._volume(panels[0], outcome.series, known)
        self._middle(panels[1], outcome.series, known)
        self._outlines(panels[2], shots, known)
        name_panels([*stages, *panels])
        figure.suptitle(
            f"Dumbbell collapsing by its mean curvature: {self.cells} cells per unit length, "
            f"time step {self.stretch:g} times the explicit limit",
            fontsize=11,
        )
        return figure

    def _portrait(self, panel: Axes, shot: Any) -> None:
        """The surface, lit."""
        from pmesh.cases.surfaces import STEEL, Layer, render, show_surface

        panel.set_title(f"$t$ = {shot.time:g}")
        panel.set_axis_off()
        phi = shot["phi"].astype(np.float64)
        if not phi.min() < 0 < phi.max():  # nothing is left
            return
        low, high = self.shape.bounds()
        layer = Layer(surface=(phi, shot.grid), colour=STEEL)
        picture = render(layer, bounds=(low, high), view=(-68.0, 18.0), size=(900, 540))
        show_surface(panel, picture, title=f"$t$ = {shot.time:g}")

    def _volume(self, panel: Axes, series: Series, known: Reference) -> None:
        """Volume over time at both resolutions."""
        panel.plot(*known.volume, color=REFERENCE, label="curve, converged")
        _dots(panel, series["time"], series["volume"], OURS, f"{self.cells} cells")
        if self.coarse:
            other = _coarse(self)
            panel.plot(other["time"], other["volume"], "+", color=OTHERS[0], ms=5,
                       label=self.other)  # fmt: skip
        panel.set(title="volume", xlabel="time $t$", ylim=(0, None), xlim=(0, None))
        panel.legend()

    def _middle(self, panel: Axes, series: Series, known: Reference) -> None:
        """Radius of the neck, squared: it falls to zero at the pinch."""
        neck = known.before.curves[:, 0, 1] ** 2
        panel.plot(known.before.time, neck, color=REFERENCE, label="curve, converged")
        _dots(panel, series["time"], series["neck"] ** 2, OURS, f"{self.cells} cells")
        if self.coarse:
            other = _coarse(self)
            panel.plot(other["time"], other["neck"] ** 2, "+", color=OTHERS[0], ms=5,
                       label=self.other)  # fmt: skip
        panel.set(title="squared radius of the neck", xlabel="time $t$")
        panel.set(xlim=(0, 1.6 * known.pinch), ylim=(0, 1.1 * self.bar**2))
        panel.legend()

    def _outlines(self, panel: Axes, shots: Sequence[Any], known: Reference) -> None:
        """The level set cut through its axis, over the curve."""
        for shot in shots:
            x, y, z = shot.grid.axes()
            cut = shot["phi"][:, :, len(z) // 2].T
            px, py = known.curve(shot.time).T
            for way, side in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                panel.plot(way * px, side * py, color=REFERENCE, lw=2.6, alpha=0.5)
            panel.contour(x, y, cut, levels=[0.0], colors=[OURS], linewidths=0.9)
        panel.plot([], [], color=OURS, lw=0.9, label="ours")
        panel.plot([], [], color=REFERENCE, lw=2.6, alpha=0.5, label="curve, converged")
        panel.set_aspect("equal")
        top = 1.2 * self.radius
        panel.set(title="outlines at these times", xlabel="$x$", ylim=(-top, 1.5 * top))
        panel.legend(loc="upper center", ncols=2)


def watch_pieces(moment: Moment) -> dict[str, float]:
    """Watcher: phi in the middle, the neck's radius, pieces, and the largest asymmetry."""
    from scipy.ndimage import label

    phi = moment.state.phi
    i, j, k = (n // 2 for n in phi.shape)
    line: Values = np.asarray(phi[i, j:, k], np.float64)
    mirrored = max(float(np.abs(phi - np.flip(phi, axis)).max()) for axis in range(3))
    return {
        "middle": float(phi[i, j, k]),
        "neck": neck_of(line, float(moment.state.grid.spacing)),
        "pieces": float(label(phi < 0)[1]),
        "asymmetry": mirrored / float(np.abs(phi).max()),
    }


def neck_of(line: Values, spacing: float) -> float:
    """Where phi along a line from the middle out crosses zero [L]; 0 if it is not negative."""
    found = zero_of(spacing * np.arange(len(line), dtype=np.float64), line)
    return found if found is not None and line[0] < 0 else 0.0


def zero_of(time: Values, values: Values) -> float | None:
    """When values first rise through zero, by the cubic through four of them around."""
    risen = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if not len(risen):
        return None
    i = int(risen[0])
    first = min(max(i - 1, 0), max(len(time) - 4, 0))
    scale = time[i + 1] - time[i]
    near = (time[first : first + 4] - time[i]) / scale
    cubic = np.polynomial.Polynomial.fit(near, values[first : first + 4], len(near) - 1)
    roots = cubic.roots()
    real = roots[np.isreal(roots)].real
    inside = real[(real >= 0.0) & (real <= 1.0)]
    share = float(inside[0]) if len(inside) else float(values[i] / (values[i] - values[i + 1]))
    return float(time[i] + scale * share)


@lru_cache(maxsize=4)
def _coarse(case: DumbbellCase) -> Series:
    """The series of the case that this one is compared with."""
    from pmesh.run.loop import run
    from pmesh.run.watchers import Ledger

    flow, state = case.rougher().build()
    ledger, rows = Ledger(), []

    def watch(moment: Moment) -> None:
        rows.append(watch_pieces(moment))

    run(flow, state, until=case.until, watch=[ledger, watch])
    series = dict(ledger.series)
    series |= {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return series


def _dots(panel: Axes, time: Values, values: Values, colour: str, label: str) -> None:
    """At most about thirty dots of a history."""
    every = max(1, len(time) // 30)
    panel.plot(time[::every], values[::every], "o", color=colour, ms=3.4, mew=0, label=label)
