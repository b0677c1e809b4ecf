"""A disk that a vortex draws out into a spiral, and back: how much of it comes home."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from levelset.laws import SingleVortex
from levelset.profile import LEVEL
from levelset.shapes import Disk
from pmesh.cases.case import Outcome
from pmesh.cases.deformation import (
    BACK,
    KEPT,
    TRACED,
    Reversed,
    ReversedCase,
    exact_surface,
    refined,
    traced,
)
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.snapshots import Snapshot

PAPER = "Bell, Colella & Glaz, J. Comput. Phys. 85 (1989) 257; LeVeque (1996)"
PUBLISHED = "Enright et al., J. Comput. Phys. 183 (2002) 83, particle level set, recalled"
LOSS = 0.0071  # of the area at 128 cells per unit length, there
CENTER = (0.5, 0.75)  # of the disk at the start
STAGES = (0.0, 1 / 8, 1 / 4)  # drawn small, in periods
INSIDE = (-1e3, 0.0)  # of the level set
COLOURS = "YlGnBu_r"  # of particles outside, by their level set


@dataclass(frozen=True, kw_only=True)
class Spiral(Reversed):
    """Base: the disk and the vortex that draws it out, on any mesh."""

    @property
    def law(self) -> SingleVortex:
        """The vortex."""
        return SingleVortex(period=self.period)

    @property
    def shape(self) -> Disk:
        """The disk."""
        return Disk(self.radius, center=CENTER)


@dataclass(frozen=True, kw_only=True)
class SingleVortexCase(Spiral, ReversedCase):
    """A disk is drawn out into a thin spiral by a vortex that turns back at half its period."""

    until: float = option(8.0, "end of the run", unit="T")
    nodes: int = option(128, "mesh cells per unit length")
    period: float = option(8.0, "of the flow; all is back after it", unit="T")
    band: float = option(0.1875, "half width of the band of particles", unit="L")
    courant: float = option(2.0, "time step times largest speed over the cell size")
    fine: bool = option(True, "whether to run with twice the cells as well, for the order")
    every: float = option(1.0, "time between snapshots", unit="T")

    title: ClassVar[str] = "Single vortex, reversed"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 64, "period": 4.0, "until": 4.0, "every": 0.5, "fine": False,
    }  # fmt: skip

    def others(self) -> Sequence[int]:
        """Half and twice the cells, if asked for."""
        return [*super().others(), *([2 * self.nodes] if self.fine else [])]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Area kept, length of the spiral, error and order of the interface that is back."""
        exact, middle = self.shape.volume, 0.5 * self.period
        found = [
            Metric("area at t = 0", outcome.series["volume"][0], exact, 1e-3, "A", "closed form")
        ]
        if (area := self.at(outcome, "volume", middle)) is not None:
            length = exact_surface(self.law, self.shape, middle)
            ours = self.at(outcome, "surface", middle)
            found += [
                Metric("area at half the period", area, exact, 0.01, "A", KEPT),
                Metric("length at half the period", ours or 0.0, length, None, "A-num", TRACED,
                       "report"),
            ]  # fmt: skip
        if self.back(outcome):
            area = float(outcome.series["volume"][-1])
            found.append(Metric("area back at the start", area, exact, 0.01, "A", BACK))
            lost = abs(1.0 - area / exact)
            if self.period == 8.0 and self.nodes == 128:
                found.append(
                    Metric("part of the area lost or won", lost, LOSS, None, "C", PUBLISHED,
                           "report")
                )  # fmt: skip
        return [*found, *self.of_errors(outcome)]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The way out, the spiral on its particles, the disk that is back, area and errors."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 6.2), layout="constrained")
        grid = figure.add_gridspec(3, 4, width_ratios=(0.62, 1, 1, 1.1))
        big = figure.add_subplot(grid[:, 1:3])
        small = [figure.add_subplot(grid[i, 0]) for i in range(3)]
        back, area = figure.add_subplot(grid[0, 3]), figure.add_subplot(grid[1, 3])
        errors = figure.add_subplot(grid[2, 3])
        shots = outcome.snapshots()
        for panel, part in zip(small, STAGES, strict=True):
            self._small(panel, min(shots, key=lambda s: abs(s.time - part * self.period)))
        self._spiral(big, min(shots, key=lambda s: abs(s.time - 0.5 * self.period)))
        self._home(back, shots[-1])
        self._area(area, outcome)
        self._errors(errors, outcome)
        name_panels([*small, big, back, area, errors])
        figure.suptitle(
            f"Disk in a reversed vortex, T = {self.period:g}: {self.nodes} cells per unit length, "
            f"kernel {self.kernel}, CFL {self.courant:g}",
            fontsize=11,
        )
        return figure

    def _small(self, panel: Axes, shot: Snapshot) -> None:
        """The body, filled, over the whole box."""
        field, finer = refined(shot["level_set"], shot.grid, 3)
        x, y = finer.axes()
        panel.contourf(x, y, field.T, levels=INSIDE, colors=[OURS], antialiased=True)
        frame(panel, f"$t$ = {shot.time:g}")

    def _spiral(self, panel: Axes, shot: Snapshot) -> None:
        """Particles coloured by their level set, the interface, and the exact one."""
        phi = np.asarray(shot["level_set"], np.float64)
        level = LEVEL * self.width * self.spacing
        near = np.abs(phi) < 0.99995 * level
        x, y = shot.grid.points()[:, near]
        size = 3.2 * (128 / self.nodes) ** 2
        panel.scatter(x, y, c=phi[near] / level, s=size, cmap=COLOURS, vmin=-0.1, vmax=1.35, lw=0)
        field, finer = refined(phi, shot.grid, 4)
        x, y = finer.axes()
        panel.contourf(x, y, field.T, levels=INSIDE, colors=[OURS], antialiased=True)
        draw_exact(panel, self.shape, self.law, shot.time)
        frame(panel, f"$t$ = {shot.time:g}: interface and particles; line: exact")

    def _home(self, panel: Axes, shot: Snapshot) -> None:
        """The end of the run over the exact interface, close by."""
        field, finer = refined(shot["level_set"], shot.grid, 4)
        x, y = finer.axes()
        panel.contourf(x, y, field.T, levels=INSIDE, colors=[OURS], alpha=0.25, antialiased=True)
        panel.contour(x, y, field.T, levels=[0.0], colors=[OURS], linewidths=1.4)
        draw_exact(panel, self.shape, self.law, shot.time)
        frame(panel, f"$t$ = {shot.time:g}")
        if math.isclose(shot.time, self.period):
            reach = 1.35 * self.radius
            panel.set(xlim=(CENTER[0] - reach, CENTER[0] + reach))
            panel.set(ylim=(CENTER[1] - reach, CENTER[1] + reach))

    def _area(self, panel: Axes, outcome: Outcome) -> None:
        """Error of the area over time."""
        series = outcome.series
        off = 100.0 * (series["volume"] / self.shape.volume - 1.0)
        panel.axhspan(-1.0, 1.0, color=REFERENCE, alpha=0.12, lw=0, label="within 1 %")
        panel.plot(series["time"], off, color=OURS)
        top = max(1.3, 1.1 * float(np.abs(off).max()))
        panel.set(title="error of the area [%]", xlabel="time $t$", ylim=(-top, top))
        panel.legend(loc="upper left")

    def _errors(self, panel: Axes, outcome: Outcome) -> None:
        """L1 errors of the interface after the period, and slopes; the length before that."""
        if not self.back(outcome):
            series = outcome.series
            panel.plot(series["time"], series["surface"], color=OURS)
            panel.set(title="length of the interface", xlabel="time $t$")
            return
        errors = self.errors(outcome)
        spacing = 1.0 / np.array(list(errors))
        values = np.array(list(errors.values()))
        panel.loglog(spacing, values, "o-", color=OURS, label="ours")
        for order, colour in ((1, OTHERS[2]), (2, OTHERS[0])):
            guide = values[0] * (spacing / spacing[0]) ** order
            panel.loglog(spacing, guide, color=colour, lw=0.9, ls=(0, (4, 3)),
                         label=f"slope {order}")  # fmt: skip
        panel.set_xticks(spacing, labels=[f"1/{nodes}" for nodes in errors])
        panel.minorticks_off()
        panel.set(title="L1 error of the interface at the end", xlabel="spacing $h$")
        panel.legend(loc="lower right")


def draw_exact(panel: Axes, disk: Disk, law: SingleVortex, time: float) -> None:
    """The exact interface: points of the circle on their way."""
    angle = np.linspace(0.0, 2.0 * np.pi, 12_000)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    x, y = traced(np.array(disk.center) + disk.radius * circle, law, 0.0, time).T
    panel.plot(x, y, color=REFERENCE, lw=0.7)


def frame(panel: Axes, title: str) -> None:
    """The unit box, without ticks."""
    panel.set_aspect("equal")
    panel.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[], title=title)
    for side in panel.spines.values():
        side.set(visible=True, color="#9a9a9a")
