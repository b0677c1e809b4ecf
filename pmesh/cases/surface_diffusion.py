"""Diffusion along a sphere or a torus: waves that keep their shape decay at known rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.cases.surface_modes import Modes
    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

Values = NDArray[np.float64]
COLOURS = (OURS, OTHERS[0], OTHERS[1])
SIDE = 6  # cells from the surface to the edges of the box
LEAST = {"sphere": 8, "torus": 12}  # cells
SOURCES = {
    "sphere": ("A", "spherical harmonics decay as exp(-l (l+1) D t/R^2)"),
    "torus": ("A-num", "eigenvalues of the torus's own ordinary equation, by Fourier series"),
}


@dataclass(frozen=True, kw_only=True)
class SurfaceDiffusionCase(Case):
    """A quantity spreads along a sphere of radius 1, or a torus of radii 1 and 0.5."""

    until: float = option(0.1, "end of the run", unit="R^2/D")
    surface: Literal["sphere", "torus"] = option("sphere", "along what")
    cells: int = option(32, "mesh cells per radius of the sphere, or of the torus's ring")
    stretch: float = option(20.0, "time step over the explicit limit h^2/(6 D)")
    coarse: bool = option(True, "whether to run with half the cells as well, for the order")
    every: float = option(0.025, "time between snapshots", unit="R^2/D")

    title: ClassVar[str] = "Diffusion along a surface"
    source: ClassVar[str] = SOURCES["sphere"][1]
    short: ClassVar[Mapping[str, Any]] = {"cells": 12, "coarse": False, "every": 0.05}

    def __post_init__(self) -> None:
        """Refuse a mesh that does not see the waves."""
        super().__post_init__()
        self.positive("stretch", "every")
        least = LEAST[self.surface]
        self.require(self.cells >= least, "cells", f"at least {least}")
        enough = not self.coarse or self.cells > least
        self.require(enough, "cells", f"more than {least} for an order", "--coarse false")

    @property
    def modes(self) -> Modes:
        """The waves, and what is known of them."""
        from pmesh.cases import surface_modes

        return surface_modes.sphere() if self.surface == "sphere" else surface_modes.torus()

    def build(self) -> tuple[Any, Any]:
        """The flow on a box around the surface, its nodes not aligned with it, and all waves."""
        from levelset.surface_diffusion import SurfaceDiffusion

        low, high = (np.array(corner) for corner in self.modes.shape.bounds())
        h = 1.0 / self.cells
        shift = h * np.array([0.31, 0.17, 0.43])
        counts = [int(n) for n in np.ceil((high - low) / h) + 2 * SIDE + 1]
        grid = Grid(counts, h, (low - SIDE * h - shift).tolist())
        flow = SurfaceDiffusion(grid=grid, diffusivity=1.0, stretch=self.stretch)
        return flow, flow.start(self.modes.shape, self.modes.start)

    def watch_modes(self, moment: Moment) -> dict[str, float]:
        """Watcher: the amplitudes of the waves."""
        surface, modes = moment.state.surface, self.modes
        found = modes.amplitudes(surface.at(moment.state.values, modes.points))
        return {f"mode{k + 1}": float(a) for k, a in enumerate(found)}

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the amplitudes, and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), self.watch_modes, Snapshots(self.every, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Amplitudes beside their decay, the integral kept, the order from half the cells."""
        series, modes, known = outcome.series, self.modes, SOURCES[self.surface]
        time, found = outcome.state.time, []
        for k, (name, rate) in enumerate(zip(modes.names, modes.rates, strict=True)):
            exact = float(np.exp(-rate * time))
            ours = float(series[f"mode{k + 1}"][-1])
            found.append(Metric(f"amplitude of {name}", ours, exact, 0.01, *known))
        drift = float(np.abs(series["mass"] / series["mass"][0] - 1.0).max())
        found.append(Metric("drift of the surface integral", drift, 0.0, 1e-11, "A",
                            "conservation", "absolute"))  # fmt: skip
        area, whole = outcome.state.surface.area, self.modes.shape.surface
        found.append(Metric("area of the surface", area, whole, 1e-4, "A", "closed form"))
        if self.coarse:
            coarse, fine = (self.rate_errors(s)[0] for s in (_coarse(self), series))
            order = float(np.log(abs(coarse / fine)) / np.log(self.cells / _half(self)))
            found.append(Metric(f"order of the decay rate of {modes.names[0]}", order, 2.0, 0.3,
                                "", "claimed", "absolute"))  # fmt: skip
        return found

    def rate_errors(self, series: Series) -> Values:
        """Relative errors of the rates of decay over the whole run."""
        time = series["time"][-1]
        ours = [np.log(series[f"mode{k}"][0] / series[f"mode{k}"][-1]) / time for k in (1, 2, 3)]
        return np.asarray(np.array(ours) / np.array(self.modes.rates) - 1.0)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The surface, coloured, at three times; amplitudes over the exact decay; errors."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 6.4), layout="constrained")
        halves: Any = figure.subfigures(2, 1, height_ratios=(1.1, 1.0))
        stages = halves[0].subplots(1, 3)
        panels = halves[1].subplots(1, 3)
        shots = outcome.snapshots()
        last = len(shots) - 1
        shots = [shots[k] for k in sorted({0, max(last // 3, min(last, 1)), last})]
        top = np.abs(self.modes.start(self.modes.points.T) - 1.0).max()
        for k, (panel, shot) in enumerate(zip(stages, shots, strict=False)):
            self._portrait(panel, shot, float(top), bar=k == len(shots) - 1)
        for panel in stages[len(shots) :]:
            panel.set_visible(False)
        self._decay(panels[0], outcome.series)
        self._errors(panels[1], outcome.series)
        self._kept(panels[2], outcome.series)
        name_panels([*stages, *panels])
        figure.suptitle(
            f"Diffusion along a {self.surface}: {self.cells} cells per radius, "
            f"time step {self.stretch:g} times the explicit limit",
            fontsize=11,
        )
        return figure

    def _portrait(self, panel: Axes, shot: Any, top: float, *, bar: bool) -> None:
        """The surface in the colours of its values."""
        from pmesh.cases.surfaces import Layer, render, show_surface

        limits = (1.0 - top, 1.0 + top)
        layer = Layer(
            surface=(shot["phi"].astype(np.float64), shot.grid),
            values=shot["values"].astype(np.float64),
            colours="viridis",
            limits=limits,
        )
        picture = render(layer, view=(-40.0, 28.0), size=(900, 720))
        show_surface(panel, picture, title=f"$t$ = {shot.time:g}", colours="viridis",
                     limits=limits if bar else None, label="$c$")  # fmt: skip

    def _decay(self, panel: Axes, series: Series) -> None:
        """Amplitudes over time, ours over the exact ones."""
        time = series["time"]
        every = max(1, len(time) // 20)
        for k, (name, rate) in enumerate(zip(self.modes.names, self.modes.rates, strict=True)):
            panel.semilogy(time, np.exp(-rate * time), color=REFERENCE, lw=1.1,
                           label="exact" if k == 0 else None)  # fmt: skip
            panel.semilogy(time[::every], series[f"mode{k + 1}"][::every], "o", ms=3.6, mew=0,
                           color=COLOURS[k], label=f"ours, {name}")  # fmt: skip
        panel.set(title="amplitudes", xlabel="time $t$", xlim=(0, None))
        panel.legend(loc="lower left")

    def _errors(self, panel: Axes, series: Series) -> None:
        """Relative errors of the amplitudes, with half the cells dashed."""
        runs = [(series, "-")] + ([(_coarse(self), "--")] if self.coarse else [])
        for one, line in runs:
            for k, rate in enumerate(self.modes.rates):
                off = np.abs(one[f"mode{k + 1}"] / np.exp(-rate * one["time"]) - 1.0)
                panel.semilogy(one["time"][1:], np.maximum(off[1:], 1e-16), line, lw=1.3,
                               color=COLOURS[k])  # fmt: skip
        panel.axhline(0.01, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)))
        dashed = f"; dashed: {_half(self)} cells" if self.coarse else ""
        panel.set(title="relative error" + dashed, xlabel="time $t$", xlim=(0, None))

    def _kept(self, panel: Axes, series: Series) -> None:
        """Drift of the surface integral."""
        drift = np.abs(series["mass"] / series["mass"][0] - 1.0)
        panel.semilogy(series["time"], np.maximum(drift, 1e-17), "o", ms=3, color=OURS)
        panel.set(title="drift of the surface integral", xlabel="time $t$", ylim=(5e-18, 1e-9))


def _half(case: SurfaceDiffusionCase) -> int:
    """Half the cells, as far as they suffice."""
    return max(case.cells // 2, LEAST[case.surface])


@lru_cache(maxsize=4)
def _coarse(case: SurfaceDiffusionCase) -> Series:
    """The series of the run on half the cells."""
    from pmesh.run.loop import run

    other = replace(case, cells=_half(case), coarse=False)
    flow, state = other.build()
    rows: list[dict[str, float]] = []

    def watch(moment: Moment) -> None:
        rows.append({"time": moment.time, **other.watch_modes(moment)})

    run(flow, state, until=case.until, watch=[watch])
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
