"""A ball that a flow draws out into a sheet thinner than a cell or two, and back."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from levelset.laws import Deformation
from levelset.shapes import Sphere
from pmesh.cases.case import Outcome
from pmesh.cases.deformation import (
    BACK,
    KEPT,
    TRACED,
    Reversed,
    ReversedCase,
    exact_level_set,
    exact_surface,
    refined,
    topology,
)
from pmesh.cases.options import option
from pmesh.cases.style import OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.snapshots import Snapshot

PAPER = "LeVeque, SIAM J. Numer. Anal. 33 (1996) 627; Enright et al., J. Comput. Phys. 183 (2002)"
PUBLISHED = "Enright et al., J. Comput. Phys. 183 (2002) 83, particle level set, recalled"
LOSS = 0.026  # of the volume at 100 cells per unit length, there
CENTER = (0.35, 0.35, 0.35)  # of the ball at the start
STAGES = (0.0, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 1.0)  # drawn, in periods
BOX = ((0.2, 0.19, 0.19), (0.87, 0.76, 0.76))  # of what the ball fills on its way; shown
VIEW = (-62.0, 16.0)  # azimuth and elevation [degrees]
CUT = 0.3  # height of the cut that is drawn [L]


@dataclass(frozen=True, kw_only=True)
class Ball(Reversed):
    """Base: the ball of Enright et al. and its flow, on any mesh."""

    finer: ClassVar[int] = 1  # times finer than its mesh that the surface is drawn

    @property
    def law(self) -> Deformation:
        """The flow."""
        return Deformation(period=self.period)

    @property
    def shape(self) -> Sphere:
        """The ball."""
        return Sphere(self.radius, center=CENTER)

    @property
    def most(self) -> float:
        """The largest radius that fits the box [L]."""
        return 0.3

    def _portrait(self, panel: Axes, shot: Snapshot) -> None:
        """The surface, lit."""
        from pmesh.cases.surfaces import STEEL, Layer, render, show_surface

        panel.set_axis_off()
        phi = np.asarray(shot["level_set"], np.float64)
        title = f"$t$ = {shot.time:g}"
        if not phi.min() < 0 < phi.max():
            panel.set_title(title)
            return
        surface = refined(phi, shot.grid, self.finer) if self.finer > 1 else (phi, shot.grid)
        layer = Layer(surface=surface, colour=STEEL)
        show_surface(panel, render(layer, bounds=BOX, view=VIEW, size=(900, 760)), title=title)


@dataclass(frozen=True, kw_only=True)
class EnrightCase(Ball, ReversedCase):
    """A ball is drawn out into a thin sheet by vortices that turn back at half their period."""

    until: float = option(3.0, "end of the run", unit="T")
    nodes: int = option(100, "mesh cells per unit length")
    period: float = option(3.0, "of the flow; all is back after it", unit="T")
    band: float = option(0.08, "half width of the band of particles", unit="L")
    courant: float = option(4.0, "time step times largest speed over the cell size")
    every: float = option(0.375, "time between snapshots", unit="T")

    finer: ClassVar[int] = 2
    title: ClassVar[str] = "Deformation of a ball, reversed"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 40, "band": 0.15, "period": 1.0, "until": 1.0, "every": 0.125, "coarse": False,
    }  # fmt: skip

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Volume kept, area and wholeness of the sheet, error of the interface that is back."""
        exact = self.shape.volume
        found = [
            Metric("volume at t = 0", outcome.series["volume"][0], exact, 2e-3, "A", "closed form"),
            *self._of_sheet(outcome),
        ]
        if self.back(outcome):
            volume = float(outcome.series["volume"][-1])
            found.append(Metric("volume back at the start", volume, exact, 0.025, "A", BACK))
            if self.period == 3.0 and self.nodes == 100:
                lost = abs(1.0 - volume / exact)
                found.append(
                    Metric("part of the volume lost or won", lost, LOSS, None, "C", PUBLISHED,
                           "report")
                )  # fmt: skip
        return [*found, *self.of_errors(outcome)]

    def _of_sheet(self, outcome: Outcome) -> list[Metric]:
        """The body at half the period."""
        middle = 0.5 * self.period
        volume, area = (self.at(outcome, name, middle) for name in ("volume", "surface"))
        if volume is None or area is None:
            return []
        known = exact_surface(self.law, self.shape, middle)
        found = [
            Metric("volume at half the period", volume, self.shape.volume, 0.025, "A", KEPT),
            Metric("area at half the period", area, known, 0.025, "A-num", TRACED),
            Metric("thickness of the sheet in cells", 2.0 * volume / area * self.nodes,
                   kind="report"),
        ]  # fmt: skip
        if (shot := self.half(outcome)) is not None:
            pieces, holes = topology(shot["level_set"], shot.grid)
            source = "a flow keeps a ball in one piece, without holes"
            found += [
                Metric("pieces at half the period", pieces, 1.0, 0.0, "A", source, "absolute"),
                Metric("holes in the sheet at half the period", holes, 0.0, 0.0, "A", source,
                       "absolute"),
            ]  # fmt: skip
        return found

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The surface, lit, at six times; a cut through the sheet; volume and area over time."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 8.4), layout="constrained")
        grid = figure.add_gridspec(3, 3, height_ratios=(1, 1, 0.8))
        stages = [figure.add_subplot(grid[i // 3, i % 3]) for i in range(len(STAGES))]
        below: Sequence[Axes] = [figure.add_subplot(grid[2, i]) for i in range(3)]
        shots = outcome.snapshots()
        for panel, part in zip(stages, STAGES, strict=True):
            shot = min(shots, key=lambda one: abs(one.time - part * self.period))
            self._portrait(panel, shot)
        self._cut(below[0], min(shots, key=lambda one: abs(one.time - 0.5 * self.period)))
        self._volume(below[1], outcome)
        self._area(below[2], outcome)
        name_panels([*stages, *below])
        figure.suptitle(
            f"Ball in a reversed deformation, T = {self.period:g}: {self.nodes} cells per unit "
            f"length, kernel {self.kernel}, CFL {self.courant:g}",
            fontsize=11,
        )
        return figure

    def _cut(self, panel: Axes, shot: Snapshot) -> None:
        """The body cut by a plane, over the exact one."""
        k = round(CUT * self.nodes)
        z = shot.grid.axes()[2]
        field, finer = refined(shot["level_set"], shot.grid, 2)
        x, y, _ = finer.axes()
        side = np.linspace(0.0, 1.0, 601)
        plane = np.stack([*np.meshgrid(side, side, indexing="ij"), np.full((601, 601), z[k])], -1)
        exact = exact_level_set(plane.reshape(-1, 3), self.law, self.shape, shot.time)
        panel.contour(side, side, exact.reshape(601, 601).T, levels=[0.0], colors=[REFERENCE],
                      linewidths=2.4, alpha=0.6)  # fmt: skip
        panel.contour(x, y, field[:, :, 2 * k].T, levels=[0.0], colors=[OURS],
                      linewidths=1.0)  # fmt: skip
        panel.plot([], [], color=OURS, lw=1.0, label="ours")
        panel.plot([], [], color=REFERENCE, lw=2.4, alpha=0.6, label="exact")
        panel.set_aspect("equal")
        panel.set(xlim=(0.15, 0.95), ylim=(0.15, 0.85), xlabel="$x$", ylabel="$y$")
        panel.set_title(f"cut at $z$ = {z[k]:g}, $t$ = {shot.time:g}")
        panel.legend(loc="upper right")

    def _volume(self, panel: Axes, outcome: Outcome) -> None:
        """Error of the volume over time."""
        series = outcome.series
        off = 100.0 * (series["volume"] / self.shape.volume - 1.0)
        panel.axhspan(-2.5, 2.5, color=REFERENCE, alpha=0.12, lw=0, label="within 2.5 %")
        panel.plot(series["time"], off, color=OURS)
        top = max(3.0, 1.1 * float(np.abs(off).max()))
        panel.set(title="error of the volume [%]", xlabel="time $t$", ylim=(-top, top))
        panel.legend(loc="upper left")

    def _area(self, panel: Axes, outcome: Outcome) -> None:
        """Area over time over the exact one."""
        series = outcome.series
        times = np.linspace(0.0, min(0.5 * self.period, series["time"][-1]), 9)
        exact = [exact_surface(self.law, self.shape, float(time)) for time in times]
        panel.plot(series["time"], series["surface"], color=OURS, label="ours")
        panel.plot(times, exact, "o", color=REFERENCE, label="exact")
        back = self.period - times[times > 0.0]
        if math.isclose(series["time"][-1], self.period):
            panel.plot(back, exact[1:], "o", color=REFERENCE)
        panel.set(title="area of the surface", xlabel="time $t$")
        panel.set_ylim(0.0, 1.12 * max(*exact, float(series["surface"].max())))
        panel.legend(loc="lower center")
