"""What remeshing is for: one interface in a vortex, on particles with and without it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.comparison import (
    Both,
    Comparison,
    inside,
    largest_gap,
    polygon_area,
    polygon_length,
)
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
RADIUS, CENTER = 0.15, (0.5, 0.75)  # of the disk in the unit box [L]
AREA = math.pi * RADIUS**2
MARKERS = 40_000  # of the reference line
LOOKS = 4  # at the interfaces between two snapshots
SERIES, FINE = 2, 4  # points per spacing where they are rebuilt: for the series, at the end
STAGES = (0.25, 0.5, 1.0)  # of the run, in the figure
ENDS = (0.06, 0.94)  # of its panels [L]
CLOSE = (0.66, 0.38, 0.24)  # x, y and width of its close-up of the end [L]
WAYS = ("without", "with")


@dataclass(frozen=True, kw_only=True)
class RemeshingEffect(Case):
    """A disk is drawn out by a vortex: particles lose their overlap, unless they are remeshed."""

    until: float = option(3.0, "end of the run", unit="T")
    nodes: int = option(128, "mesh cells along the unit box")
    courant: float = option(1.0, "time step over h / max|u| (RK4)")
    remeshing: str = option("distorted", "distorted, always, or every so many steps")
    kernel: str = option("L6,4", "remeshing kernel")
    width: float = option(4.0, "half width of the band, in spacings")
    radius: float = option(1.2, "of the mollifier, in spacings: particles must overlap")
    order: int = option(4, "of the mollifier: 2, 4 or 6")
    every: float = option(0.75, "time between snapshots", unit="T")

    title: ClassVar[str] = "Effect of remeshing"
    source: ClassVar[str] = "Hieber & Koumoutsakos, J. Comput. Phys. 210 (2005) 342"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 64, "until": 1.5, "every": 0.375}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("courant", "width", "radius", "every")
        self.require(self.nodes >= 16, "nodes", "at least 16 to see the disk")
        self.require(self.order in (2, 4, 6), "order", "2, 4 or 6")
        known = self.remeshing in ("distorted", "always") or (
            self.remeshing.isdigit() and int(self.remeshing) > 0
        )
        self.require(known, "remeshing", "distorted, always or a number of steps")

    @property
    def spacing(self) -> float:
        """Of the mesh [L]."""
        return 1.0 / self.nodes

    def build(self) -> tuple[Any, Any]:
        """Both particle level sets of the disk, and the markers on its circle."""
        from levelset.laws import SingleVortex
        from levelset.profile import profile
        from levelset.shapes import Disk
        from levelset.transport import ParticleLevelSet

        grid = Grid((self.nodes + 1,) * 2, self.spacing)
        often = self.remeshing
        remeshed = ParticleLevelSet(
            grid=grid,
            velocity=SingleVortex(period=math.inf),
            kernel=self.kernel,
            width=self.width,
            remeshing=int(often) if often.isdigit() else often,  # type: ignore[arg-type]
        )
        without = replace(remeshed, remeshing="never")
        disk = Disk(RADIUS, center=CENTER)
        band = without.start(disk)
        points = grid.points().reshape(2, -1)
        away = disk.distance(points)
        nodes = np.flatnonzero(away < without.reach)  # the middle too: nobody will fill it later
        solid = replace(
            band,
            nodes=nodes,
            positions=points.T[nodes].copy(),
            values=profile(away[nodes], without.reach),
        )
        turn = 2.0 * math.pi * np.arange(MARKERS) / MARKERS
        markers = CENTER + RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        flow = Comparison(without=without, remeshed=remeshed, dt=self.courant * self.spacing)
        start = remeshed.start(disk)
        return flow, Both(time=0.0, step=0, without=solid, remeshed=start, markers=markers)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the interfaces now and then, and snapshots."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Ledger

        return [Ledger(), self.watch, Snapshots(self.every, dtype="float32")]

    def watch(self, moment: Moment) -> dict[str, float]:
        """Watcher: gaps between particles; now and then areas and errors of both interfaces."""
        state = moment.state
        both = (state.without, state.remeshed)
        gaps = {f"gap_{way}": largest_gap(each) for way, each in zip(WAYS, both, strict=True)}
        names = [f"{name}_{way}" for way in WAYS for name in ("area", "error")]
        stride = max(1, round(self.every / LOOKS / (self.courant * self.spacing)))
        if state.step % stride and not moment.on(self.every):
            return {**gaps, **dict.fromkeys(names, math.nan)}
        return {**gaps, **dict(zip(names, self.measured(moment.flow, state, SERIES), strict=True))}

    def measured(self, flow: Comparison, state: Both, fine: int) -> list[float]:
        """Area and mean interface error in spacings, without and with remeshing."""
        from levelset.quadrature import volume

        grid = self.fine_grid(fine)
        exact, length = inside(state.markers, grid), polygon_length(state.markers)
        found: list[float] = []
        for phi in self.rebuilt(flow, state, grid):
            between = float(((phi < 0) != exact).sum()) * grid.cell_volume
            found += [volume(phi, grid), between / length / self.spacing]
        return found

    def fine_grid(self, fine: int) -> Grid:
        """The mesh where interfaces are rebuilt, ``fine`` nodes per spacing."""
        return Grid((fine * self.nodes + 1,) * 2, self.spacing / fine)

    def particles(self, flow: Comparison, state: Both) -> list[tuple[Values, Values]]:
        """Positions and values of the particles of both ways, those inside included."""
        from levelset.profile import LEVEL

        level = LEVEL * flow.remeshed.reach
        full = flow.remeshed.band(state.remeshed).filled(level).ravel()
        kept = np.flatnonzero(full < 0.9999 * level)
        nodes = state.grid.points().reshape(2, -1).T[kept]
        pairs = (state.without.positions, state.without.values), (nodes, full[kept])
        return [(np.asarray(x), np.asarray(values)) for x, values in pairs]

    def rebuilt(self, flow: Comparison, state: Both, grid: Grid) -> list[Values]:
        """The level sets that both sets of particles stand for: the mollified sum on a mesh.

        ``phi(x) = L + sum_p h^2 (phi_p - L) zeta(x - x_p)``, L the level outside: no particle, no
        change of it.
        """
        from levelset.profile import LEVEL
        from remesh.mollifier import mollify

        level, h = LEVEL * flow.remeshed.reach, self.spacing
        points = grid.points().reshape(2, -1).T
        found = []
        for positions, values in self.particles(flow, state):
            change = mollify(
                positions, values - level, h * h, points, self.radius * h, order=self.order
            )
            found.append(np.asarray(level + change, np.float64).reshape(grid.shape))
        return found

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Areas and errors of both at the end; how far particles are apart; the markers."""
        state = outcome.state
        (area, error, kept, small) = self.measured(outcome.flow, state, FINE)
        gap = largest_gap(state.without)
        drift = polygon_area(state.markers) / AREA - 1.0
        keeps = "the flow keeps areas"
        return [
            Metric("area with remeshing", kept, AREA, 0.02, "A", keeps),
            Metric("area without remeshing", area, AREA, None, "A", keeps, "report"),
            Metric("mean error with remeshing, in cells", small, kind="report"),
            Metric("mean error without remeshing, in cells", error, kind="report"),
            Metric("largest gap between neighbours without, in cells", gap, kind="report"),
            Metric("change of the markers' area", drift, 0.0, 1e-5, "A", keeps, "absolute"),
            Metric("remeshings", float(state.remeshed.remeshings), kind="report"),
        ]  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Particles and rebuilt interfaces over time, without above with; areas, errors, gaps."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(12.0, 9.0), layout="constrained")
        halves: Any = figure.subfigures(2, 1, height_ratios=(2.4, 1.0))
        rows = halves[0].subplots(2, len(STAGES) + 1)
        below = halves[1].subplots(1, 3)
        dots = None
        for column, state in enumerate(_stages(self, outcome.state.time)):
            ends = rows[:, -1] if column == len(STAGES) - 1 else (None, None)
            dots = self._stage(rows[:, column], ends, outcome.flow, state)
        bar = halves[0].colorbar(dots, ax=rows, shrink=0.6, pad=0.01)
        bar.set_label(r"level set $\phi_p$ of the particles, in cells")
        for row, told in zip(rows, ("never remeshed", self._how()), strict=True):
            row[0].set_ylabel(told)
        self._histories(below, outcome.series)
        name_panels([*rows.ravel(), *below])
        halves[0].suptitle(
            f"Effect of remeshing: a disk in a vortex, {self.nodes} x {self.nodes} cells; "
            f"blue: rebuilt by a mollifier of order {self.order}, radius {self.radius:g} cells; "
            "orange: exact",
            fontsize=10.5,
        )
        return figure

    def _how(self) -> str:
        if self.remeshing.isdigit():
            return f"remeshed every {self.remeshing} steps"
        return {"always": "remeshed at every step"}.get(self.remeshing, "remeshed when distorted")

    def _stage(self, column: Any, ends: Any, flow: Comparison, state: Both) -> Any:
        """Both rebuilt interfaces at one time; at the end the particles close up."""
        grid, dots = self.fine_grid(FINE), None
        both = zip(self.rebuilt(flow, state, grid), self.particles(flow, state), strict=True)
        for panel, end, (phi, (positions, values)) in zip(column, ends, both, strict=True):
            for axes, colour in ((panel, "#3c78b4"), (end, "#c9d8e6")):
                if axes is None:
                    continue
                axes.contourf(*grid.axes(), phi.T, levels=[-1e9, 0.0], colors=[colour])
                axes.plot(*state.markers[::4].T, color=REFERENCE, lw=0.8)
                axes.set(title=f"$t$ = {state.time:.3g}", xlim=ENDS, ylim=ENDS)
                axes.set_aspect("equal")
                axes.grid(False)
            if end is None:
                continue
            x, y, wide = CLOSE
            panel.add_patch(_square(CLOSE))
            near = values < 0.97 * values.max()
            u, v = positions[near].T
            cells = values[near] / self.spacing
            dots = end.scatter(u, v, c=cells, s=14, cmap="RdBu_r", edgecolors="none")
            dots.set_clim(-0.5 * self.width, 0.5 * self.width)
            end.set(title="its particles", xlim=(x, x + wide), ylim=(y, y + wide))
        return dots

    def _histories(self, row: Sequence[Axes], series: Series) -> None:
        """Area, error and gap over time."""
        time = series["time"]
        told = ("never remeshed", self._how())
        for way, label, colour in zip(WAYS, told, (OTHERS[0], OURS), strict=True):
            area, error = (np.asarray(series[f"{name}_{way}"]) for name in ("area", "error"))
            seen = np.isfinite(area)
            row[0].plot(time[seen], area[seen] / AREA, "o-", ms=3, color=colour, label=label)
            row[1].plot(time[seen], error[seen], "o-", ms=3, color=colour)
            row[2].semilogy(time, series[f"gap_{way}"], color=colour)
        row[0].axhline(1.0, color=REFERENCE, lw=1.0, ls=(0, (4, 3)), label="exact")
        row[0].set(title="area over the exact one", xlabel="$t$")
        row[0].legend(loc="lower left")
        row[1].set(title="mean distance from the markers, in cells", xlabel="$t$", ylim=(0, None))
        row[2].axhline(self.radius, color=REFERENCE, lw=1.0, ls=(0, (4, 3)), label="mollifier")
        row[2].set(title="largest gap between neighbours, in cells", xlabel="$t$")
        row[2].legend(loc="upper left")


def _square(place: tuple[float, float, float]) -> Any:
    """The frame of a close-up."""
    from matplotlib.patches import Rectangle

    x, y, wide = place
    return Rectangle((x, y), wide, wide, fill=False, ec="#404040", lw=0.9)


@lru_cache(maxsize=2)
def _stages(case: RemeshingEffect, until: float) -> list[Both]:
    """The states at the figure's times, run once more: particles are no fields of a snapshot."""
    from pmesh.run.loop import run

    flow, state = case.build()
    found = []
    for part in STAGES:
        state = run(flow, state, until=part * until)
        found.append(state)
    return found
