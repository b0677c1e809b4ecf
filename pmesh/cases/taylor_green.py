"""Taylor and Green's decaying vortices, carried across the mesh by a free stream."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.moments import relative_error
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, show_field, styled
from pmesh.run.protocols import Moment
from pmesh.run.summary import Metric
from pmesh.vortex.exact.viscous import TaylorGreen
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

ALLOWED = 0.01
SOURCE = "Taylor & Green, Proc. R. Soc. A 158 (1937) 499"


@dataclass(frozen=True, kw_only=True)
class TaylorGreenCase(Case):
    """Decaying periodic vortices in a free stream: velocity, energy and enstrophy beside exact."""

    until: float = option(1.0, "end of the run", unit="T")
    reynolds: float = option(100.0, "Reynolds number, speed * length / viscosity")
    nodes: int = option(128, "mesh nodes per period")
    drift: tuple[float, float] = option((1.0, 0.5), "free stream", unit="L/T")
    kernel: str = option("M6'", "remeshing kernel")
    deformation: float = option(0.25, "largest dt * max|grad u|")

    title: ClassVar[str] = "Taylor-Green vortices"
    source: ClassVar[str] = SOURCE
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 64, "until": 0.5}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("reynolds", "deformation")
        self.require(self.nodes >= 16, "nodes", "at least 16")

    @property
    def exact(self) -> TaylorGreen:
        """The exact flow: period 1, speed 1."""
        return TaylorGreen(viscosity=1.0 / self.reynolds, drift=self.drift)

    def recipe(self) -> Any:
        """The flow on one period, and the vortices in it."""
        from pmesh.vortex.flow import VortexFlow

        grid = Grid((self.nodes, self.nodes), 1.0 / self.nodes, boundary="periodic")
        return VortexFlow(
            grid=grid,
            viscosity=1.0 / self.reynolds,
            freestream=self.drift,
            kernel=self.kernel,
            deformation=self.deformation,
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity(flow.grid.points()))

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the energy, the velocity's error, and snapshots of the start and the end."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), self._watch, Snapshots(self.until)]

    def _watch(self, moment: Moment) -> dict[str, float]:
        """Energy of the period, drift left out, and the velocity's relative error."""
        grid, time = moment.state.grid, moment.time
        turning = self._turning(moment.state)
        exact = self.exact.velocity(grid.points(), time) - _column(self.drift)
        return {
            "energy": 0.5 * float(np.vdot(turning, turning)) * grid.cell_volume,
            "velocity_error": relative_error(turning, exact),
        }

    @staticmethod
    def _turning(state: Any) -> Any:
        """Velocity of the vortices, without the free stream."""
        from pmesh.spectral.poisson import velocity

        return velocity(state.vorticity, state.grid)

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Decay and errors at the end beside the exact flow."""
        series, exact, time = outcome.series, self.exact, outcome.state.time
        energy, enstrophy = series["energy"], series["enstrophy"]
        rate = -0.5 * np.log(energy[-1] / energy[0]) / (time - series["time"][0])
        spin = relative_error(
            outcome.state.vorticity, exact.vorticity(outcome.state.grid.points(), time)
        )
        law = 2.0 * exact.viscosity * exact.wavenumber**2
        known = ("A", SOURCE)
        return [
            Metric("decay rate 2 nu k^2", rate, law, ALLOWED, *known),
            Metric("energy", energy[-1], exact.energy(time), ALLOWED, *known),
            Metric("enstrophy", enstrophy[-1], exact.enstrophy(time), ALLOWED, *known),
            Metric("velocity, rel. L2 error", series["velocity_error"][-1], 0.0, ALLOWED, *known,
                   "absolute"),
            Metric("vorticity, rel. L2 error", spin, 0.0, ALLOWED, *known, "absolute"),
        ]  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The vorticity at the end over the exact lines, the decay, and the error over time."""
        figure, axes = panels(1, 3, (11.0, 3.7), width_ratios=(1.15, 1, 1))
        self._field(axes[0, 0], outcome)
        self._decay(axes[0, 1], outcome)
        series = outcome.series
        axes[0, 2].semilogy(
            series["time"][1:], series["velocity_error"][1:], color=OURS, label="ours"
        )
        axes[0, 2].axhline(ALLOWED, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)), label="allowed")
        axes[0, 2].set(title="relative L2 error of the velocity", xlabel="time $t$")
        axes[0, 2].set_ylim(1e-6, 3e-2)
        axes[0, 2].legend(loc="center right")
        name_panels(axes)
        figure.suptitle(
            f"Taylor-Green vortices in a free stream, Re = {self.reynolds:g}: "
            f"kernel {self.kernel}, {self.nodes} nodes per period",
            fontsize=11,
        )
        return figure

    def _field(self, panel: Axes, outcome: Outcome) -> None:
        """Our vorticity in colours, the exact one in lines."""
        state = outcome.state
        exact = self.exact.vorticity(state.grid.points(), state.time)
        top = float(np.abs(exact).max())
        show_field(panel, state.vorticity, state.grid, limit=top, label=r"vorticity $\omega$")
        levels = np.array([-0.8, -0.5, -0.2, 0.2, 0.5, 0.8]) * top
        panel.contour(*state.grid.axes(), exact.T, levels=levels, colors="k", linewidths=0.7,
                      linestyles=[(0, (4, 3))])  # fmt: skip
        panel.set(title=f"ours (colours), exact (dashed), $t$ = {state.time:g}", xlabel="$x$",
                  ylabel="$y$")  # fmt: skip

    def _decay(self, panel: Axes, outcome: Outcome) -> None:
        """Energy and enstrophy, as parts of their first values, beside exp(-4 nu k^2 t)."""
        series = outcome.series
        every = max(1, len(series["time"]) // 16)
        fine = np.linspace(0.0, outcome.state.time, 200)
        law = np.array([self.exact.decay(t) ** 2 for t in fine])
        panel.plot(fine, law, color=REFERENCE, label=r"exact: $e^{-4\nu k^2 t}$")
        for name, mark, colour in (("energy", "o", OURS), ("enstrophy", "x", OTHERS[0])):
            part = series[name] / series[name][0]
            panel.plot(series["time"][::every], part[::every], mark, color=colour, ms=4.5,
                       label=f"ours: {name}")  # fmt: skip
        panel.set(title="decay", xlabel="time $t$", ylim=(0, 1.05))
        panel.legend(loc="lower left")


def _column(pair: tuple[float, float]) -> Any:
    return np.array(pair).reshape(2, 1, 1)
