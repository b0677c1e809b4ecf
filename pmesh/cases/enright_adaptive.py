"""A ball drawn out into a sheet and back, carried by particles of several spacings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.adaptive_interface import (
    COLOURS,
    AdaptiveReversed,
    draw_counts,
    draw_errors,
    draw_study,
    draw_volume,
)
from pmesh.cases.case import Outcome
from pmesh.cases.deformation import TRACED, exact_level_set, exact_surface, topology
from pmesh.cases.enright import CUT, Ball, EnrightCase
from pmesh.cases.options import option
from pmesh.cases.style import OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.snapshots import Snapshot

PAPER = (
    "Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5 (2006) 980; "
    "Enright et al., J. Comput. Phys. 183 (2002) 83"
)
ALLOWED = 0.01  # of the volume
SEEN = 128  # nodes per unit length at which pieces are counted, at most
WHOLE = "a flow keeps a ball in one piece, without holes"


@dataclass(frozen=True, kw_only=True)
class EnrightAdaptive(Ball, AdaptiveReversed):
    """A ball is drawn out into a thin sheet and back: fine where the sheet is thin or curved."""

    until: float = option(3.0, "end of the run", unit="T")
    nodes: int = option(256, "mesh cells per unit length on the finest level")
    levels: int = option(3, "how often the finest mesh is halved")
    period: float = option(3.0, "of the flow; all is back after it", unit="T")
    tolerance: float = option(0.003, "displacement of the interface over the band's half width")
    band: float = option(0.15625, "half width of the band on the coarsest level", unit="L")
    courant: float = option(32.0, "time step times largest speed over the finest cell size")
    every: float = option(1.5, "time between snapshots", unit="T")

    title: ClassVar[str] = "Deformation of a ball, reversed, on an adaptive mesh"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 64, "levels": 2, "period": 1.0, "until": 1.0, "courant": 8.0, "every": 0.5,
        "band": 0.25, "tolerance": 0.01, "study": False,
    }  # fmt: skip

    @property
    def parts(self) -> tuple[float, ...]:
        """Tolerances of the study over that of the run."""
        return (4.0, 2.0)

    def uniform(self, nodes: int) -> EnrightCase:
        """The same on a uniform mesh, with the same time step."""
        return EnrightCase(
            nodes=nodes, period=self.period, until=self.period, radius=self.radius,
            kernel=self.kernel, band=self.band, courant=self.courant * nodes / self.nodes,
            substeps=self.substeps, coarse=False,
        )  # fmt: skip

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Volume kept, particles it took, area and wholeness of the sheet, error at the end."""
        found = [*self.of_volume(outcome, "volume", ALLOWED), *self.of_particles(outcome)]
        middle = 0.5 * self.period
        if (area := self.at(outcome, "surface", middle)) is not None:
            known = exact_surface(self.law, self.shape, middle)
            found.append(
                Metric("area at half the period", area, known, 0.025, "A-num", TRACED)
            )  # fmt: skip
        if (shot := self.half(outcome)) is not None:
            every = max(1, self.nodes // SEEN)
            phi = np.ascontiguousarray(shot["level_set"][::every, ::every, ::every])
            pieces, holes = topology(phi, Grid(phi.shape, every * self.spacing))
            found += [
                Metric("pieces at half the period", pieces, 1.0, 0.0, "A", WHOLE, "absolute"),
                Metric("holes in the sheet at half the period", holes, 0.0, 0.0, "A", WHOLE,
                       "absolute"),
            ]  # fmt: skip
        return [*found, *self.of_error(outcome)]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The surface at three times; the levels on a cut; particles, volume and errors."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(12.4, 7.2), layout="constrained")
        studied = self.study and self.back(outcome)
        rows = figure.add_gridspec(2, 1, height_ratios=(1, 0.8))
        upper, lower = rows[0].subgridspec(1, 3), rows[1].subgridspec(1, 4 if studied else 3)
        above = [figure.add_subplot(upper[i]) for i in range(3)]
        below = [figure.add_subplot(lower[i]) for i in range(lower.ncols)]
        shots = outcome.snapshots()
        half = min(shots, key=lambda shot: abs(shot.time - 0.5 * self.period))
        self._portrait(above[0], half)
        self._portrait(above[1], shots[-1])
        self._cut(above[2], half)
        draw_counts(below[0], outcome, 100**3, "nodes of a 100$^3$ mesh")
        draw_volume(below[1], outcome, self.shape.volume, ALLOWED, "volume")
        if studied:
            adaptive, uniform = self.runs(outcome)
            draw_study(below[2], adaptive, uniform, "volume")
            draw_errors(below[3], adaptive, uniform, self.band)
        else:
            self._area(below[2], outcome)
        name_panels([*above, *below])
        figure.suptitle(
            f"Ball in a reversed deformation, T = {self.period:g}: up to {self.nodes} cells per "
            f"unit length, tolerance {self.tolerance:g}, kernel {self.kernel}, "
            f"CFL {self.courant:g}",
            fontsize=11,
        )
        return figure

    def _cut(self, panel: Axes, shot: Snapshot) -> None:
        """Levels and interface on a plane, over the exact interface."""
        from matplotlib.colors import ListedColormap

        k = round(CUT * self.nodes)
        x, y, z = shot.grid.axes()
        colours = ListedColormap(["white", *COLOURS[: self.levels + 1]])
        panel.pcolormesh(x, y, shot["level"][:, :, k].T, cmap=colours, vmin=-1.5,
                         vmax=self.levels + 0.5, alpha=0.55, rasterized=True)  # fmt: skip
        panel.contour(x, y, shot["level_set"][:, :, k].T, levels=[0.0], colors=[OURS],
                      linewidths=1.2)  # fmt: skip
        side = np.linspace(0.0, 1.0, 401)
        plane = np.stack([*np.meshgrid(side, side, indexing="ij"), np.full((401, 401), z[k])], -1)
        exact = exact_level_set(plane.reshape(-1, 3), self.law, self.shape, shot.time)
        panel.contour(side, side, exact.reshape(401, 401).T, levels=[0.0], colors=[REFERENCE],
                      linewidths=0.8)  # fmt: skip
        for level in range(self.levels + 1):
            panel.plot([], [], "s", color=COLOURS[level], alpha=0.55,
                       label=f"1/{self.nodes // 2 ** (self.levels - level)}")  # fmt: skip
        panel.legend(loc="lower right", fontsize=7, handletextpad=0.1)
        panel.set_aspect("equal")
        panel.grid(False)
        panel.set(xlim=(0.05, 0.95), ylim=(0.05, 0.95))
        panel.set_title(f"levels on $z$ = {z[k]:.3g}, $t$ = {shot.time:g}; line: exact")

    def _area(self, panel: Axes, outcome: Outcome) -> None:
        """Area over time over the exact one."""
        series = outcome.series
        times = np.linspace(0.0, min(0.5 * self.period, series["time"][-1]), 7)
        exact = [exact_surface(self.law, self.shape, float(time)) for time in times]
        panel.plot(series["time"], series["surface"], color=OURS, label="ours")
        panel.plot(times, exact, "o", color=REFERENCE, label="exact")
        panel.set(title="area of the surface", xlabel="time $t$")
        panel.set_ylim(0.0, 1.12 * max(*exact, float(series["surface"].max())))
        panel.legend(loc="lower center")
