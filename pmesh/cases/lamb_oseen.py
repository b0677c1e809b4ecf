"""The Lamb-Oseen vortex, which spreads by viscosity while it turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.moments import relative_error, watch_moments
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.viscous import LambOseen
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

ALLOWED = 0.005
SOURCE = "Lamb, Hydrodynamics, art. 334a"


@dataclass(frozen=True, kw_only=True)
class LambOseenCase(Case):
    """A Gaussian vortex spreads: core, circulation and angular moment beside the exact law."""

    until: float = option(10.0, "end of the run", unit="T")
    circulation: float = option(1.0, "circulation Gamma", unit="L^2/T")
    core: float = option(0.2, "core radius at the start, of exp(-r^2/core^2)", unit="L")
    viscosity: float = option(1e-3, "kinematic viscosity", unit="L^2/T")
    spacing: float = option(1 / 60, "mesh spacing", unit="L")
    kernel: str = option("M6'", "remeshing kernel")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    every: float = option(2.5, "time between snapshots", unit="T")

    title: ClassVar[str] = "Lamb-Oseen vortex"
    source: ClassVar[str] = SOURCE
    size: ClassVar[str] = "spacing"
    short: ClassVar[Mapping[str, Any]] = {"spacing": 1 / 40, "until": 2.5, "every": 1.25}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed, and a core thinner than four cells."""
        super().__post_init__()
        self.positive("core", "viscosity", "spacing", "deformation", "every")
        self.require(self.circulation != 0, "circulation", "not zero")
        self.require(self.spacing <= 0.25 * self.core, "spacing", "at most a quarter of the core")

    @property
    def exact(self) -> LambOseen:
        """The exact flow."""
        return LambOseen(circulation=self.circulation, core=self.core, viscosity=self.viscosity)

    def recipe(self) -> Any:
        """The flow on a box of six final cores either way, and the vortex in its middle."""
        from pmesh.vortex.flow import VortexFlow

        cells = round(6.0 * self.exact.radius(self.until) / self.spacing)
        grid = Grid((2 * cells + 1,) * 2, self.spacing, (-cells * self.spacing,) * 2)
        return VortexFlow(
            grid=grid,
            viscosity=self.viscosity,
            kernel=self.kernel,
            deformation=self.deformation,
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity(flow.grid.points()))

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the moments, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), watch_moments, Snapshots(self.every, fields=["vorticity"])]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Growth and invariants beside the exact law; the whole fields at the end."""
        from pmesh.spectral.poisson import velocity

        series, exact, state = outcome.series, self.exact, outcome.state
        time, points = state.time, state.grid.points()
        square = series["angular_moment"] / series["circulation"]
        growth = (square[-1] - square[0]) / (series["time"][-1] - series["time"][0])
        peak = exact.circulation / (np.pi * exact.radius(time) ** 2)
        turning = velocity(state.vorticity, state.grid)
        known = ("A", SOURCE)
        speed = relative_error(turning, exact.velocity(points, time))
        spin = relative_error(state.vorticity, exact.vorticity(points, time))
        gamma, spread = series["circulation"][-1], series["angular_moment"][-1]
        return [
            Metric("core growth d(a^2)/dt", growth, 4.0 * self.viscosity, ALLOWED, *known),
            Metric("circulation", gamma, exact.circulation, ALLOWED, *known),
            Metric("angular moment", spread, exact.angular_moment(time), ALLOWED, *known),
            Metric("vorticity at the centre", _strongest(state.vorticity), peak, ALLOWED, *known),
            Metric("velocity, rel. L2 error", speed, 0.0, ALLOWED, *known, "absolute"),
            Metric("vorticity, rel. L2 error", spin, 0.0, ALLOWED, *known, "absolute"),
        ]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Profiles at several times, the growing core, and the errors over time."""
        figure, axes = panels(1, 3, (11.0, 3.7))
        self._profiles(axes[0, 0], outcome)
        self._growth(axes[0, 1], outcome)
        self._errors(axes[0, 2], outcome)
        name_panels(axes)
        figure.suptitle(
            rf"Lamb-Oseen vortex, $\Gamma/\nu$ = {abs(self.circulation) / self.viscosity:.0f}: "
            f"kernel {self.kernel}, {self.core / self.spacing:.0f} cells per core",
            fontsize=11,
        )
        return figure

    def _profiles(self, panel: Axes, outcome: Outcome) -> None:
        """Vorticity along the x axis over the exact profile, darker with time."""
        shots = outcome.snapshots()
        far = 3.0 * self.exact.radius(outcome.state.time)
        fine = np.linspace(0.0, far, 300)
        for i, shot in enumerate(shots):
            x, y = shot.grid.axes()
            row = int(np.abs(y).argmin())
            kept = (x >= -1e-9) & (x <= far)
            exact = self.exact.vorticity(np.stack([fine, np.full_like(fine, y[row])]), shot.time)
            shade = 0.35 + 0.65 * i / max(1, len(shots) - 1)
            panel.plot(fine, exact, color=REFERENCE, lw=1.1, label=None if i else "exact")
            panel.plot(x[kept][::2], shot["vorticity"][kept, row][::2], "o", color=OURS, ms=3.2,
                       alpha=shade, mew=0, label=f"ours, $t$ = {shot.time:g}")  # fmt: skip
        panel.set(title="vorticity", xlabel="$r$", xlim=(0, far))
        panel.legend()

    def _growth(self, panel: Axes, outcome: Outcome) -> None:
        """Squared core radius, from the moments, beside core^2 + 4 nu t."""
        series = outcome.series
        square = series["angular_moment"] / series["circulation"]
        every = max(1, len(square) // 24)
        ends = series["time"][[0, -1]]
        panel.plot(ends, [self.exact.radius(t) ** 2 for t in ends], color=REFERENCE,
                   label=r"exact: $a_0^2 + 4\nu t$")  # fmt: skip
        panel.plot(series["time"][::every], square[::every], "o", color=OURS, ms=3.6, mew=0,
                   label=r"ours: $\int\omega r^2\,/\,\int\omega$")  # fmt: skip
        panel.set(title="core radius squared $a^2$", xlabel="time $t$", ylim=(0, None))
        panel.legend(loc="lower right")

    def _errors(self, panel: Axes, outcome: Outcome) -> None:
        """Relative errors of circulation, angular moment and peak beside what is allowed."""
        series, exact = outcome.series, self.exact
        time = series["time"]
        peak = np.where(self.circulation > 0, series["largest"], series["smallest"])
        square = np.array([exact.radius(t) ** 2 for t in time])
        for ours, true, colour, name in (
            (series["circulation"], exact.circulation, OTHERS[0], "circulation"),
            (series["angular_moment"], exact.circulation * square, OURS, "angular moment"),
            (peak, exact.circulation / (np.pi * square), OTHERS[1], "peak vorticity"),
        ):
            panel.semilogy(
                time, np.maximum(np.abs(ours / true - 1.0), 1e-16), color=colour, label=name
            )
        panel.axhline(ALLOWED, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)), label="allowed")
        panel.set(title="relative error", xlabel="time $t$", ylim=(5e-17, 1e2))
        panel.legend(loc="upper right", ncols=2)


def _strongest(vorticity: Any) -> float:
    """The value of largest size, with its sign."""
    return float(vorticity.flat[np.abs(vorticity).argmax()])
