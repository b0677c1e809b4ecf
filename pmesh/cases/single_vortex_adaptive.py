"""A disk drawn out into a spiral and back, carried by particles of several spacings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.adaptive_interface import (
    COLOURS,
    AdaptiveReversed,
    active_particles,
    draw_counts,
    draw_errors,
    draw_study,
    draw_volume,
)
from pmesh.cases.case import Outcome
from pmesh.cases.deformation import TRACED, exact_surface, refined
from pmesh.cases.options import option
from pmesh.cases.single_vortex import SingleVortexCase, Spiral, draw_exact, frame
from pmesh.cases.style import OURS, name_panels, styled
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.snapshots import Snapshot

PAPER = (
    "Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5 (2006) 980; "
    "Bell, Colella & Glaz, J. Comput. Phys. 85 (1989) 257"
)
FEW = 128**2  # nodes of the mesh that has more than there are active particles
ALLOWED = 2e-3  # of the area


@dataclass(frozen=True, kw_only=True)
class SingleVortexAdaptive(Spiral, AdaptiveReversed):
    """A disk is drawn out into a thin spiral and back: fine where the spiral is thin."""

    until: float = option(8.0, "end of the run", unit="T")
    nodes: int = option(512, "mesh cells per unit length on the finest level")
    period: float = option(8.0, "of the flow; all is back after it", unit="T")
    band: float = option(0.15625, "half width of the band on the coarsest level", unit="L")
    courant: float = option(40.0, "time step times largest speed over the finest cell size")
    substeps: int = option(4, "RK4 steps in a step; 0: as many as the deformation asks for")
    every: float = option(1.0, "time between snapshots", unit="T")

    title: ClassVar[str] = "Single vortex, reversed, on an adaptive mesh"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 256, "levels": 3, "period": 4.0, "until": 4.0, "courant": 20.0, "every": 0.5,
        "study": False,
    }  # fmt: skip

    def uniform(self, nodes: int) -> SingleVortexCase:
        """The same on a uniform mesh, with the same time step."""
        return SingleVortexCase(
            nodes=nodes, period=self.period, until=self.period, radius=self.radius,
            kernel=self.kernel, band=self.band, courant=self.courant * nodes / self.nodes,
            substeps=self.substeps, coarse=False, fine=False,
        )  # fmt: skip

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Area kept, particles it took, length of the spiral, error of the disk that is back."""
        found = self.of_volume(outcome, "area", ALLOWED)
        most = float(outcome.series["active"].max())
        found.append(
            Metric("active particles at the most over the nodes of a 128^2 mesh", most / FEW, 0.0,
                   1.0, "A", "a uniform mesh that misses the filament", "absolute")
        )  # fmt: skip
        found += self.of_particles(outcome)
        if (length := self.at(outcome, "surface", 0.5 * self.period)) is not None:
            exact = exact_surface(self.law, self.shape, 0.5 * self.period)
            found.append(
                Metric("length at half the period", length, exact, None, "A-num", TRACED, "report")
            )
        return [*found, *self.of_error(outcome)]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The levels of the particles on the spiral, the disk that is back, and the study."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(12.4, 7.6), layout="constrained")
        columns = figure.add_gridspec(1, 3, width_ratios=(0.68, 2.0, 0.95))
        left, right = columns[0].subgridspec(3, 1), columns[2].subgridspec(4, 1)
        small = [figure.add_subplot(left[i]) for i in range(3)]
        side = [figure.add_subplot(right[i]) for i in range(4)]
        big = figure.add_subplot(columns[1])
        shots = outcome.snapshots()
        half = min(shots, key=lambda shot: abs(shot.time - 0.5 * self.period))
        self._spiral(big, half)
        for panel, part in zip(small, (0.0, 0.25, 1.0), strict=True):
            shot = min(shots, key=lambda one: abs(one.time - part * self.period))
            self._small(panel, shot)
        draw_counts(side[0], outcome, FEW, "nodes of a 128$^2$ mesh")
        draw_volume(side[1], outcome, self.shape.volume, ALLOWED, "area")
        if self.back(outcome):
            adaptive, uniform = self.runs(outcome)
            draw_study(side[2], adaptive, uniform, "area")
            draw_errors(side[3], adaptive, uniform, self.band)
        else:
            for panel, name in zip(side[2:], ("surface", "finest_level"), strict=True):
                panel.plot(outcome.series["time"], outcome.series[name], color=OURS)
                panel.set(title=name.replace("_", " "), xlabel="time $t$")
        name_panels([*small, big, *side])
        figure.suptitle(
            f"Disk in a reversed vortex, T = {self.period:g}: up to {self.nodes} cells per unit "
            f"length, tolerance {self.tolerance:g}, kernel {self.kernel}, CFL {self.courant:g}",
            fontsize=11,
        )
        return figure

    def _spiral(self, panel: Axes, shot: Snapshot) -> None:
        """The active particles in the colours of their levels, the interface, and the exact one."""
        self._particles(panel, shot, 2.2)
        field, finer = refined(shot["level_set"], shot.grid, 2)
        panel.contour(*finer.axes(), field.T, levels=[0.0], colors=["black"], linewidths=0.5)
        draw_exact(panel, self.shape, self.law, shot.time)
        frame(panel, f"$t$ = {shot.time:g}: particles by level, interface; line: exact")
        for level in range(self.levels + 1):
            panel.plot([], [], "s", color=COLOURS[level % len(COLOURS)],
                       label=f"1/{self.nodes // 2 ** (self.levels - level)}")  # fmt: skip
        panel.legend(loc="lower left", ncols=self.levels + 1, handletextpad=0.1, fontsize=7.5)

    def _small(self, panel: Axes, shot: Snapshot) -> None:
        """The same, small; and the inside."""
        self._particles(panel, shot, 0.7)
        field, finer = refined(shot["level_set"], shot.grid, 1)
        panel.contour(*finer.axes(), field.T, levels=[0.0], colors=["black"], linewidths=0.7)
        draw_exact(panel, self.shape, self.law, shot.time)
        count = len(active_particles(shot, self.levels)[1])
        frame(panel, f"$t$ = {shot.time:g}: {count} active")

    def _particles(self, panel: Axes, shot: Snapshot, size: float) -> None:
        """Active particles as squares."""
        places, levels = active_particles(shot, self.levels)
        colours = np.array(COLOURS)[levels % len(COLOURS)]
        panel.scatter(places[:, 0], places[:, 1], c=colours, s=size, lw=0, marker="s")
