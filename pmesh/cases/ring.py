"""A thin vortex ring travels one diameter: its speed, and what it keeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.case import Outcome
from pmesh.cases.coaxial import half_plane_flux, whole_ring
from pmesh.cases.options import option
from pmesh.cases.rings import RingsCase, departures, drift, portraits
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Kind, Metric
from pmesh.vortex.exact.rings import VortexRing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher

PAPER = "Saffman, Stud. Appl. Math. 49 (1970) 371"
SPEED, KEPT = 0.02, 1e-4  # allowed of the speed, and of what Euler's equations keep
DIVERGENCE = 1e-3  # allowed without projection at every step
PROJECTED = {"float64": 1e-10, "float32": 1e-5}  # with it: round-off
THIN = 0.1  # core radii for which the law of thin rings is a yardstick


@dataclass(frozen=True, kw_only=True)
class RingCase(RingsCase):
    """A vortex ring with a Gaussian core travels along z by itself, one diameter by default."""

    until: float = option(6.6, "end of the run", unit="T")
    viscosity: float = option(0.0, "kinematic viscosity, of the circulation")
    pictures: int = option(3, "snapshots after the start")

    title: ClassVar[str] = "A vortex ring on its way"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "core": 0.25, "spacing": 0.25 / 3, "until": 0.5, "pictures": 1,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.require(self.viscosity >= 0, "viscosity", "not negative")
        self.require(self.pictures > 0, "pictures", "at least 1")

    @property
    def exact(self) -> VortexRing:
        """The start: the circular filament smoothed in space."""
        return VortexRing(core=self.core)

    @property
    def _divergence_allowed(self) -> float:
        """Round-off where the vorticity is projected at every step."""
        return PROJECTED[self.dtype] if self.projection == 1 else DIVERGENCE

    def recipe(self) -> Any:
        """The flow around the ring."""
        return self.flow(1.0, 0.0, 0.0, self.viscosity)

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the ring's circulation and place, and snapshots."""
        return [*super().watchers(), watch_ring, *self.seen(self.until / self.pictures)]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed beside the laws, and what is kept."""
        series, exact = outcome.series, self.exact
        height, time = series["ring_height"], series["time"]
        speed = (height[-1] - height[0]) / (time[-1] - time[0])
        euler = ("A", "Euler's equations")
        kept: Kind = "absolute" if self.viscosity == 0 else "report"
        thin: Kind = "relative" if self.core <= THIN and self.viscosity == 0 else "report"
        allowed = self._divergence_allowed
        return [
            Metric("speed, beside thin rings", speed, exact.speed, SPEED, "A", PAPER, thin),
            Metric("speed, beside the smoothed ring", speed, exact.centroid_speed, SPEED, "A",
                   "Biot-Savart integral at t = 0", "relative" if kept == "absolute" else "report"),
            Metric("drift of impulse", drift(series["impulse_z"]), 0.0, KEPT, "A",
                   "Navier-Stokes equations", "absolute"),
            Metric("drift of circulation", drift(series["ring_circulation"]), 0.0, KEPT, *euler,
                   kept),
            Metric("divergence, largest", _after(series["divergence"]), 0.0, allowed, "A",
                   "the vorticity is a curl", "absolute"),
            Metric("drift of energy", drift(series["energy"]), kind="report"),
            Metric("change of enstrophy", series["enstrophy"][-1] / series["enstrophy"][0] - 1.0,
                   kind="report"),
            Metric("travel, in diameters", 0.5 * (height[-1] - height[0]), kind="report"),
        ]  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The ring at the start and the end, its place over time, and what is kept."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 6.0), layout="constrained")
        panels = figure.add_gridspec(2, 3, width_ratios=(1, 1.15, 1.15))
        seen = outcome.stages([self.until / self.pictures, self.until])
        places = [panels[k, 0] for k in (0, 1)] if len(seen) > 1 else [panels[:, 0]]
        portraits(figure, places, outcome, [shot.time for shot in seen])
        axes = [figure.add_subplot(panels[row, col]) for row in (0, 1) for col in (1, 2)]
        self._place(axes[0], outcome)
        self._speed(axes[1], outcome)
        self._kept(axes[2], outcome)
        self._divergence(axes[3], outcome)
        name_panels(axes)
        fluid = f"viscosity {self.viscosity:g}" if self.viscosity else "inviscid"
        figure.suptitle(
            f"Vortex ring, core a = {self.core:g} R, {fluid}: {self.stretching}, {self.mesh()}",
            fontsize=11,
        )
        return figure

    def _place(self, panel: Axes, outcome: Outcome) -> None:
        """Height over time beside the laws."""
        time, height = outcome.series["time"], outcome.series["ring_height"]
        panel.plot(time, self.exact.speed * time, color=REFERENCE, ls="--",
                   label="thin ring, Saffman (1970)")  # fmt: skip
        panel.plot(time, height - height[0], color=OURS, label="ours, impulse centroid")
        panel.set(title="distance travelled, in $R$", xlabel=r"time $t\,\Gamma/R^2$")
        panel.legend(loc="upper left")

    def _speed(self, panel: Axes, outcome: Outcome) -> None:
        """Speed of every step beside the laws."""
        time, height = outcome.series["time"], outcome.series["ring_height"]
        panel.plot(0.5 * (time[1:] + time[:-1]), np.diff(height) / np.diff(time), color=OURS,
                   label="ours")  # fmt: skip
        for law, name, style in (
            (self.exact.speed, "thin ring", "--"),
            (self.exact.centroid_speed, "smoothed ring at $t$ = 0", ":"),
        ):
            panel.axhline(law, color=REFERENCE, ls=style, label=name)
        panel.set(title=r"speed, in $\Gamma/R$", xlabel=r"time $t\,\Gamma/R^2$")
        low, high = sorted((self.exact.speed, self.exact.centroid_speed))
        panel.set_ylim(0.96 * low, 1.05 * high)
        panel.legend(loc="upper right")

    def _kept(self, panel: Axes, outcome: Outcome) -> None:
        """Drifts of the integrals."""
        series = outcome.series
        departures(
            panel,
            series["time"],
            [
                ("circulation", series["ring_circulation"] / series["ring_circulation"][0] - 1,
                 OURS, KEPT),
                ("impulse", series["impulse_z"] / series["impulse_z"][0] - 1, OTHERS[0], KEPT),
                ("energy", series["energy"] / series["energy"][0] - 1, OTHERS[1], None),
            ],
            "drift of what Euler flow keeps",
        )  # fmt: skip

    def _divergence(self, panel: Axes, outcome: Outcome) -> None:
        """How solenoidal the vorticity stays."""
        series = outcome.series
        name = r"rms of $\nabla\cdot\omega$ over $|\nabla\omega|$"
        line = (name, series["divergence"], OURS, self._divergence_allowed)
        departures(panel, series["time"], [line], "divergence of the vorticity")


def watch_ring(moment: Moment) -> dict[str, float]:
    """Watcher: circulation, mean radius and height of one ring about the z axis."""
    vorticity, grid = moment.state.vorticity, moment.state.grid
    place = whole_ring(vorticity, grid)
    return {
        "ring_circulation": half_plane_flux(vorticity, grid),
        "ring_radius": place.radius,
        "ring_height": place.height,
    }


def _after(values: Any) -> float:
    """Largest of a column after the start, which no projection has touched."""
    return float(np.max(values[1:])) if len(values) > 1 else float(values[0])
