"""Taylor and Green's vortices in space, which stretch, break down and decay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.reference import Curve, read_table
from pmesh.cases.rings import balance, loss
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.periodic import TaylorGreenCube
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

Array = NDArray[np.floating[Any]]

SOURCE = "Taylor & Green, Proc. R. Soc. A 158 (1937) 499"
PEAK, PEAK_TIME = 1.28575e-2, 8.97  # of the dissipation at Re = 1600
PUBLISHED = "High-order CFD workshop, Fourier method on 512^3, as tabulated by others"
FOURIER = "Fourier method on {nodes}^3, benchmarks/taylor_green_spectral.py"
STAGES = (3.0, 6.0, 9.0)  # drawn [T]
LOOK = (-60.0, 24.0)  # azimuth and elevation [degrees]
SMOOTH = 5.0  # until then the vortices roll up; later they break down, and round-off grows [T]
BROKEN = {"float64": 1e-9, "float32": 1e-4}  # allowed of the symmetries until then
STORED = 2e-7  # a rounding to the single precision of snapshots breaks


def asymmetry(vorticity: Array) -> float:
    """Largest departure from the flow's symmetries over the largest vorticity component.

    Mirrors across x = 0, y = 0, z = 0, and x and y exchanged with half a period along z: all of
    them reflections, under which a vorticity also changes its sign. Refuses nothing; the nodes of
    each axis are even in number and begin at 0.
    """
    worst = 0.0
    for axis in range(3):
        place = np.arange(-1, -1 - vorticity.shape[axis + 1], -1)
        mirrored = np.take(vorticity, np.roll(place, 1), axis=axis + 1)
        signs = [1.0 if part == axis else -1.0 for part in range(3)]
        for part, sign in enumerate(signs):
            worst = max(worst, float(np.abs(vorticity[part] - sign * mirrored[part]).max()))
    half = vorticity.shape[3] // 2
    for part, other in ((0, 1), (1, 0), (2, 2)):
        turned = -np.roll(vorticity[other], -half, axis=2).swapaxes(0, 1)
        worst = max(worst, float(np.abs(vorticity[part] - turned).max()))
    return worst / float(np.abs(vorticity).max())


def _vertex(time: Array, value: Array, top: int) -> tuple[float, float]:
    """Place and height of the parabola through three neighbours."""
    a, b, c = np.polyfit(time[top - 1 : top + 2] - time[top], value[top - 1 : top + 2], 2)
    return float(time[top] - 0.5 * b / a), float(c - 0.25 * b * b / a)


@dataclass(frozen=True, kw_only=True)
class TaylorGreenCubeCase(Case):
    """Taylor and Green's vortices break down: energy, dissipation, symmetries."""

    until: float = option(10.0, "end of the run", unit="L/U")
    reynolds: float = option(1600.0, "Reynolds number, speed / (wave number * viscosity)")
    nodes: int = option(128, "mesh nodes per period")
    kernel: str = option("L6,4", "remeshing kernel")
    stretching: Literal["conservative", "classical"] = option("conservative", "form of stretching")
    time_scheme: Literal["RK2", "RK3", "RK4"] = option("RK2", "Runge-Kutta scheme")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    projection: int = option(1, "steps between projections onto divergence-free vorticity; 0: none")
    dtype: Literal["float64", "float32"] = option("float64", "precision")
    every: float = option(3.0, "time between snapshots", unit="L/U")

    title: ClassVar[str] = "Taylor-Green vortices in space"
    source: ClassVar[str] = SOURCE
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {
        "reynolds": 100.0, "nodes": 24, "until": 1.2, "every": 0.4,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("reynolds", "deformation", "every")
        self.require(self.nodes >= 16 and self.nodes % 2 == 0, "nodes", "an even number from 16 on")
        self.require(self.projection >= 0, "projection", "not negative")

    @property
    def exact(self) -> TaylorGreenCube:
        """The start: period 2 pi, speed 1."""
        return TaylorGreenCube()

    @property
    def volume(self) -> float:
        """Of a period [L^3]."""
        return self.exact.length**3

    def recipe(self) -> Any:
        """The flow on one period."""
        from pmesh.vortex.flow import VortexFlow

        grid = Grid((self.nodes,) * 3, self.exact.length / self.nodes, boundary="periodic")
        return VortexFlow(
            grid=grid,
            viscosity=1.0 / self.reynolds,
            kernel=self.kernel,
            stretching=self.stretching,
            time_scheme=self.time_scheme,
            deformation=self.deformation,
            projection=self.projection,
            dtype=self.dtype,
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vortices it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, fields=["vorticity"], dtype="float32")]

    def published(self) -> Mapping[str, Curve]:
        """The dissipation by a Fourier method, where there is one of this Reynolds number."""
        curve = self._known("dissipation")
        return {} if curve is None else {"dissipation": curve}

    def _known(self, name: str) -> Curve | None:
        """A history by a Fourier method, over the period; None at other Reynolds numbers."""
        rows = [
            row for row in read_table("taylor_green_cube.csv")
            if float(row["reynolds"]) == self.reynolds and float(row["time"]) > 0
        ]  # fmt: skip
        if not rows:
            return None
        time, value = (np.array([float(row[key]) for row in rows]) for key in ("time", name))
        return Curve(time, value * self.volume, "A-num", FOURIER.format(nodes=rows[0]["nodes"]))

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Energy and dissipation beside what is known, what remeshing takes, symmetries."""
        series, time = outcome.series, float(outcome.state.time)
        energy = series["energy"] / self.volume
        known = self._known("energy")
        found = [Metric("energy at t = 0", energy[0], 0.125, 1e-3, "A", SOURCE)]
        if known is not None and time >= known.span[0]:
            end = min(time, known.span[1])
            ours, expected = np.interp(end, series["time"], energy), known.at(end) / self.volume
            found.append(
                Metric(f"energy at t = {end:.4g}", float(ours), float(expected), 0.01, known.grade,
                       known.source)
            )  # fmt: skip
        found += self._peak(series)
        found += [
            *self._symmetries(outcome),
            balance(series),
            Metric("rms div w over rms |grad w|", series["divergence"][-1], kind="report"),
        ]
        return found

    def _symmetries(self, outcome: Outcome) -> list[Metric]:
        """The departure from them while the vortices are smooth, judged, and at the end, told."""
        name, allowed = "departure from the symmetries", BROKEN[self.dtype]
        end = float(outcome.state.time)
        last = asymmetry(outcome.state.vorticity)
        if end <= SMOOTH:
            return [Metric(name, last, 0.0, allowed, "A", SOURCE, "absolute")]
        found = [Metric(f"{name}, at the end", last, kind="report")]
        early = [shot for shot in outcome.snapshots() if shot.time <= SMOOTH]
        if early:
            broken = asymmetry(early[-1]["vorticity"].astype(np.float64))
            label = f"{name}, t = {early[-1].time:.3g}"
            allowed = max(allowed, STORED)
            found.insert(0, Metric(label, broken, 0.0, allowed, "A", SOURCE, "absolute"))
        return found

    def _peak(self, series: Mapping[str, Any]) -> list[Metric]:
        """The largest dissipation and its time, if the run passed it."""
        rate = self._rate(series)
        top = int(rate.argmax())
        if top == 0 or series["time"][top] > 0.97 * series["time"][-1]:
            return []
        time, value = _vertex(series["time"], rate, top)
        given: tuple[Any, ...] = (None, None, "", "")
        if self.reynolds == 1600.0:
            given = (PEAK, PEAK_TIME, "B", PUBLISHED)
        elif (known := self._known("dissipation")) is not None:
            best = int(known.value.argmax())
            if 0 < best < len(known.time) - 1:
                when, value_there = _vertex(known.time, known.value / self.volume, best)
                given = (value_there, when, known.grade, known.source)
        peak, moment, grade, source = given
        if peak is None:
            return [Metric("largest dissipation -dE/dt", value, kind="report"),
                    Metric("time of it", time, kind="report")]  # fmt: skip
        return [
            Metric("largest dissipation -dE/dt", value, float(peak), 0.08, grade, source),
            Metric("time of it", time, float(moment), 0.03, grade, source),
        ]

    def _rate(self, series: Mapping[str, Any]) -> Array:
        """-dE/dt per unit volume."""
        if len(series["time"]) < 3:
            return np.asarray(series["dissipation"]) / self.volume
        return np.asarray(-np.gradient(series["energy"], series["time"]) / self.volume)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The vortices at three times; energy, dissipation, and what remeshing takes over time."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 7.3), layout="constrained")
        grid = figure.add_gridspec(2, 3, height_ratios=(1.1, 1))
        lit, below = ([figure.add_subplot(grid[row, i]) for i in range(3)] for row in (0, 1))
        shown = self._portraits(lit, outcome)
        self._energy(below[0], outcome.series)
        self._dissipation(below[1], outcome.series)
        self._beyond(below[2], outcome.series)
        name_panels([*lit[:shown], *below])
        figure.suptitle(
            f"Taylor-Green vortices, Re = {self.reynolds:g}: {self.nodes}³ nodes, kernel "
            f"{self.kernel}, {self.stretching} stretching, {self.dtype}",
            fontsize=11,
        )
        return figure

    def _portraits(self, row: Sequence[Axes], outcome: Outcome) -> int:
        """Surfaces of Q in the colours of w_z; how many."""
        from pmesh.cases.vortices import show_isosurface

        shots = outcome.stages([part / 9.0 * outcome.state.time for part in STAGES])
        for panel, shot in zip(row, shots, strict=False):
            show_isosurface(panel, shot, "q", colour_by="vorticity_z", label="", view=LOOK,
                            size=(900, 860))  # fmt: skip
            panel.set_title(f"$Q$ in the colours of $\\omega_z$, $t$ = {shot.time:.3g}")
        for panel in row[len(shots) :]:
            panel.set_axis_off()
        return len(shots)

    def _energy(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Kinetic energy per unit volume."""
        known = self._known("energy")
        if known is not None:
            panel.plot(known.time, known.value / self.volume, color=REFERENCE, lw=2.2, alpha=0.7,
                       label="Fourier method")  # fmt: skip
        panel.plot(series["time"], series["energy"] / self.volume, color=OURS, label="ours")
        panel.set(title="energy per unit volume", xlabel="time $t$", ylim=(0.0, 0.135))
        panel.set_xlim(0.0, 1.02 * series["time"][-1])
        panel.legend(loc="lower left")

    def _dissipation(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Loss of energy, and what viscosity takes of it."""
        time = series["time"]
        known = self._known("dissipation")
        if known is not None:
            panel.plot(known.time, known.value / self.volume, color=REFERENCE, lw=2.2, alpha=0.7,
                       label="Fourier method")  # fmt: skip
        panel.plot(time, self._rate(series), color=OURS, label=r"ours: $-dE/dt$")
        panel.plot(time, series["dissipation"] / self.volume, color=OTHERS[0], lw=1.1,
                   label=r"ours: $\nu\langle\omega^2\rangle$")  # fmt: skip
        if self.reynolds == 1600.0 and time[-1] > 0.9 * PEAK_TIME:
            panel.plot([PEAK_TIME], [PEAK], "D", color=REFERENCE, label="peak, published", zorder=5)
        panel.set(title="dissipation per unit volume", xlabel="time $t$")
        panel.set_xlim(0.0, 1.02 * time[-1])
        panel.set_ylim(bottom=0.0)
        panel.legend(loc="upper left")

    def _beyond(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """What remeshing takes beside what viscosity does, and the divergence."""
        time = series["time"]
        gone, viscous = loss(series)
        lost = (gone - viscous) / series["energy"][0]
        panel.semilogy(time[1:], np.maximum(np.abs(lost[1:]), 1e-16), color=OURS,
                       label="energy lost beyond viscosity")  # fmt: skip
        panel.semilogy(time, np.maximum(series["divergence"], 1e-17), color=OTHERS[2], lw=1.1,
                       label=r"rms div $\omega$ / rms $|\nabla\omega|$")  # fmt: skip
        panel.set(title="what should be zero", xlabel="time $t$")
        panel.set_xlim(0.0, 1.02 * time[-1])
        panel.legend(loc="center right")
