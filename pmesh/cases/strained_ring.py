"""A "spherical" vortex ring in a straining flow: its linear evolution beside the exact one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.moments import relative_error
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.strained import StrainedRing
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

EXACT = "closed form of the linear evolution"
LAW = "dI/dt = -A^T I"
REACH = 4.0  # widths from the ring's centre to the mesh's end at the start
STAGES = (0.0, 0.5, 1.0)  # drawn, in parts of the run
LOOK = (-62.0, 24.0)  # azimuth and elevation [degrees]


@dataclass(frozen=True, kw_only=True)
class StrainedRingCase(Case):
    """A ring of vorticity is strained by an irrotational flow: impulse, energy, vorticity."""

    until: float = option(1.0, "end of the run; the default is an e-fold of the strain", unit="T")
    strain: tuple[float, float, float] = option(
        (1.0, -0.5, -0.5), "dU/dx, dV/dy, dW/dz of the base flow; their sum is zero", unit="1/T"
    )
    shear: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), "dU/dy = dV/dx, dU/dz = dW/dx, dV/dz = dW/dy", unit="1/T"
    )
    amplitude: tuple[float, float, float] = option(
        (0.6, 0.0, 0.8), "a of w = curl(a exp(-x^2/width^2))", unit="L/T"
    )
    width: float = option(1.0, "of the ring", unit="L")
    viscosity: float = option(0.0, "kinematic viscosity", unit="L^2/T")
    nonlinear: bool = option(False, "the ring also moves itself: the whole equation")
    spacing: float = option(1 / 8, "mesh spacing", unit="L")
    kernel: str = option("M6'", "remeshing kernel")
    stretching: Literal["conservative", "classical"] = option("conservative", "form of stretching")
    time_scheme: Literal["RK2", "RK3", "RK4"] = option("RK3", "Runge-Kutta scheme")
    deformation: float = option(0.1, "largest dt * max|grad u|")
    projection: int = option(1, "steps between projections onto divergence-free vorticity; 0: none")
    dtype: Literal["float64", "float32"] = option("float64", "precision")
    every: float = option(0.25, "time between snapshots", unit="T")

    title: ClassVar[str] = "A vortex ring in a straining flow"
    source: ClassVar[str] = "Cauchy's formula for a linear flow"
    size: ClassVar[str] = "spacing"
    short: ClassVar[Mapping[str, Any]] = {"spacing": 1 / 5, "until": 0.4, "every": 0.2}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("width", "spacing", "deformation", "every")
        self.require(self.viscosity >= 0, "viscosity", "not negative")
        self.require(self.projection >= 0, "projection", "not negative")
        rates = np.array([*self.strain, *self.shear])
        self.require(bool(rates.any()), "strain", "a flow, and not all zero")
        self.require(
            abs(sum(self.strain)) <= 1e-12 * np.abs(rates).max(), "strain", "three that add up to 0"
        )
        self.require(any(self.amplitude), "amplitude", "not all zero")
        self.require(
            self.spacing <= self.width / 4, "spacing", "at most a quarter of the width",
            hint=f"--spacing {self.width / 8:g}",
        )  # fmt: skip

    @property
    def exact(self) -> StrainedRing:
        """The ring, and its linear evolution."""
        (xx, yy, zz), (xy, xz, yz) = self.strain, self.shear
        return StrainedRing(
            strain=((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)),
            amplitude=self.amplitude, width=self.width, viscosity=self.viscosity,
        )  # fmt: skip

    def recipe(self) -> Any:
        """The vorticity in its base flow, on a box that follows it."""
        from pmesh.vortex.perturbed import PerturbedFlow

        cells = 8 * int(np.ceil(REACH * self.width / self.spacing / 8))
        grid = Grid((2 * cells,) * 3, self.spacing, (-cells * self.spacing,) * 3)
        return PerturbedFlow(
            grid=grid,
            base=self.exact.strain,
            nonlinear=self.nonlinear,
            viscosity=self.viscosity,
            kernel=self.kernel,
            stretching=self.stretching,
            time_scheme=self.time_scheme,
            deformation=self.deformation,
            projection=self.projection,
            domain="follow",
            dtype=self.dtype,
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the ring it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity(flow.grid.points()))

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, fields=["vorticity"], dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Impulse, in either evolution; energy, enstrophy and vorticity of the linear one."""
        series, exact, state = outcome.series, self.exact, outcome.state
        off = self._impulse_errors(series)
        start = series["energy"][0]
        found = [
            Metric("energy at t = 0", start, exact.energy(), 0.01, "A", EXACT),
            Metric("impulse, largest error", float(off.max()), 0.0, 0.01, "A", LAW, "absolute"),
        ]
        if not self.nonlinear:
            apart = relative_error(
                state.vorticity, exact.vorticity(state.grid.points(), state.time)
            )
            energy, enstrophy = exact.energy(state.time), exact.enstrophy(state.time)
            found += [
                Metric("energy at the end", series["energy"][-1], energy, 0.01, "A", EXACT),
                Metric("enstrophy at the end", series["enstrophy"][-1], enstrophy, 0.01, "A",
                       EXACT),
                Metric("vorticity, rel. L2 error", apart, 0.0, 0.02, "A", EXACT, "absolute"),
            ]  # fmt: skip
        found.append(Metric("rms div w over rms |grad w|", series["divergence"][-1], kind="report"))
        return found

    def _impulse_errors(self, series: Mapping[str, Any]) -> Any:
        """|I - exact| over |exact| at each step."""
        ours = np.stack([series[f"impulse_{axis}"] for axis in "xyz"], axis=1)
        exact = np.array([self.exact.impulse(float(time)) for time in series["time"]])
        return np.linalg.norm(ours - exact, axis=1) / np.linalg.norm(exact, axis=1)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The ring at three times; impulse, energy and their errors over time."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.5, 6.9), layout="constrained")
        grid = figure.add_gridspec(2, 3, height_ratios=(1, 0.95))
        above = [figure.add_subplot(grid[0, i]) for i in range(3)]
        below = [figure.add_subplot(grid[1, i]) for i in range(3)]
        self._portraits(above, outcome)
        self._impulse(below[0], outcome.series)
        self._energy(below[1], outcome.series)
        self._errors(below[2], outcome.series)
        name_panels([*above, *below])
        kind = "with its own velocity" if self.nonlinear else "linear evolution"
        figure.suptitle(
            f"Vortex ring in a straining flow, {kind}: width/h = {self.width / self.spacing:g}, "
            f"kernel {self.kernel}, {self.time_scheme}",
            fontsize=11,
        )
        return figure

    def _portraits(self, row: Sequence[Axes], outcome: Outcome) -> None:
        """Surfaces of the vorticity at one level of each moment's own largest."""
        from pmesh.cases.vortices import show_isosurface

        shots = outcome.snapshots()
        end = shots[-1].time
        chosen = [min(shots, key=lambda shot: abs(shot.time - part * end)) for part in STAGES]
        half = self._half_box(chosen)
        bounds = (tuple((-half).tolist()), tuple(half.tolist()))
        for panel, shot in zip(row, chosen, strict=True):
            top = float(np.sqrt((shot["vorticity"] ** 2).sum(axis=0)).max())
            show_isosurface(
                panel, shot, "vorticity", levels=[0.5 * top], colour_by="vorticity_z",
                label="", view=LOOK, bounds=bounds, size=(900, 800), ground=False,
            )  # fmt: skip
            panel.set_title(f"$|\\omega|$ = half its largest, $t$ = {shot.time:.3g}")

    def _half_box(self, shots: Sequence[Any]) -> Any:
        """Half the sides of a box that holds the surfaces of all snapshots."""
        shapes = [self.exact.shape(shot.time) for shot in shots]
        return 1.25 * np.max([np.sqrt(np.diag(shape)) for shape in shapes], axis=0)

    def _impulse(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Components of the impulse over the exact ones."""
        times = np.linspace(0.0, series["time"][-1], 60)
        exact = np.array([self.exact.impulse(float(time)) for time in times])
        every = max(1, len(series["time"]) // 12)
        for part, colour in zip(range(3), (OURS, *OTHERS), strict=False):
            if not np.abs(exact[:, part]).any():
                continue
            name = "xyz"[part]
            panel.plot(times, exact[:, part], color=REFERENCE, lw=1.2)
            panel.plot(series["time"][::every], series[f"impulse_{name}"][::every], "o",
                       color=colour, label=f"$I_{name}$")  # fmt: skip
        panel.plot([], [], color=REFERENCE, lw=1.2, label=r"exact: $e^{-A^T t} I_0$")
        panel.set(title="impulse", xlabel="time $t$")
        panel.legend(loc="best")

    def _energy(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Energy and enstrophy, as parts of their first values, over the exact ones."""
        times = np.linspace(0.0, series["time"][-1], 40)
        every = max(1, len(series["time"]) // 12)
        for name, colour in (("energy", OURS), ("enstrophy", OTHERS[0])):
            law = getattr(self.exact, name)
            exact = np.array([law(float(time)) for time in times]) / law(0.0)
            panel.plot(times, exact, color=REFERENCE, lw=1.2)
            panel.plot(series["time"][::every], series[name][::every] / law(0.0), "o",
                       color=colour, label=name)  # fmt: skip
        told = "exact, linear" if self.nonlinear else "exact"
        panel.plot([], [], color=REFERENCE, lw=1.2, label=told)
        panel.set(title="energy and enstrophy over those at $t$ = 0", xlabel="time $t$")
        panel.set_ylim(bottom=0.0)
        panel.legend(loc="best")

    def _errors(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Relative errors over time, beside what is allowed."""
        time = series["time"]
        panel.semilogy(time[1:], self._impulse_errors(series)[1:], color=OURS, label="impulse")
        if not self.nonlinear:
            for name, colour in (("energy", OTHERS[0]), ("enstrophy", OTHERS[1])):
                exact = np.array([getattr(self.exact, name)(float(t)) for t in time])
                panel.semilogy(time, np.maximum(np.abs(series[name] / exact - 1.0), 1e-16),
                               color=colour, label=name)  # fmt: skip
        panel.axhline(0.01, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)), label="allowed")
        panel.set(title="relative error", xlabel="time $t$", ylim=(1e-7, 5e-2))
        panel.legend(loc="lower right")
