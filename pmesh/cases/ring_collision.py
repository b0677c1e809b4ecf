"""Two vortex rings collide head-on, stretch, and reconnect into small rings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Outcome
from pmesh.cases.coaxial import half_plane_flux, ring_below
from pmesh.cases.options import option
from pmesh.cases.rings import RingsCase, balance, departures, loss, staged_sheet
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.rings import head_on
from pmesh.vortex.exact.thin_rings import CoaxialRings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

PAPER = "Lim & Nickels, Nature 357 (1992) 225"
THEORY = "Dyson, Phil. Trans. R. Soc. A 184 (1893) 1041"
CLOSED, GROWTH = 1e-10, 0.05
ROUND_OFF = 1e-5  # of sums in single precision
APART = 4.0  # core radii between rings that thin-ring theory still tells


@dataclass(frozen=True, kw_only=True)
class RingCollision(RingsCase):
    """Two equal rings, slightly wavy, run into each other; circulation over viscosity 1000."""

    until: float = option(12.0, "end of the run", unit="T")
    reynolds: float = option(1000.0, "circulation over viscosity")
    core: float = option(0.2, "core radius a, of the ring's radius")
    spacing: float = option(1 / 24, "mesh spacing", unit="L")
    gap: float = option(2.0, "distance between the rings at the start", unit="L")
    amplitude: float = option(0.01, "of each wave around the rings, of the radius")
    waves: tuple[int, ...] = option((5, 8, 11), "waves around the rings")
    projection: int = option(1, "steps between projections onto solenoidal vorticity, 0: never")
    dtype: Literal["float64", "float32"] = option("float32", "precision")
    pictures: int = option(12, "snapshots after the start")

    title: ClassVar[str] = "Head-on collision of two vortex rings"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "core": 0.25, "spacing": 0.1, "gap": 1.25, "until": 0.6, "pictures": 1,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("reynolds")
        self.require(self.gap >= APART * self.core, "gap", "at least four core radii")
        self.require(0 <= self.amplitude <= 0.1, "amplitude", "at most 0.1, and not negative")
        self.require(all(n > 0 for n in self.waves), "waves", "whole numbers from 1 on")
        self.require(self.pictures > 0, "pictures", "at least 1")

    def recipe(self) -> Any:
        """The flow around both rings."""
        half = 0.5 * self.gap
        return self.flow(1.0 + len(self.waves) * self.amplitude, -half, half, 1.0 / self.reynolds)

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from: mirror images at z = 0."""
        flow = self.recipe()
        rings = head_on(
            gap=self.gap, core=self.core, amplitude=self.amplitude, modes=self.waves,
            phases=tuple(float(n * n) for n in self.waves),
        )  # fmt: skip
        return flow, flow.start(vorticity=rings.vorticity)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the lower ring, and snapshots."""
        return [*super().watchers(), watch_lower_ring, *self.seen(self.until / self.pictures)]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """What the laws of motion say, the growth of the radius, and what else is seen."""
        series = outcome.series
        scale = np.pi  # of the impulse of one ring
        drift = np.abs([series[f"impulse_{axis}"] for axis in "xyz"]).max() / scale
        twist = np.abs(series["helicity"]).max()  # of the circulation squared
        exact = CLOSED if self.dtype == "float64" else ROUND_OFF
        laws = ("A", "Navier-Stokes equations")
        metrics = [
            Metric("impulse, of one ring's", float(drift), 0.0, exact, *laws, "absolute"),
            Metric("helicity", float(twist), 0.0, exact, *laws, "absolute"),
            balance(series),
        ]  # fmt: skip
        theory = self._theory(series["time"])
        near = np.flatnonzero(-2.0 * theory[1] < APART * self._core(series["time"]))
        last = int(near[0]) - 1 if near.size else len(theory[0]) - 1
        if last > 0:
            metrics.append(
                Metric("radius while the rings are apart", series["lower_radius"][last],
                       float(theory[0][last]), GROWTH, "A", THEORY)
            )  # fmt: skip
        return [
            *metrics,
            Metric("largest radius", float(series["lower_radius"].max()), kind="report"),
            Metric("largest enstrophy, of the first", _most(series, "enstrophy"), kind="report"),
            Metric("energy at the end, of the first", series["energy"][-1] / series["energy"][0],
                   kind="report"),
            Metric("divergence, largest", float(series["divergence"][1:].max()), kind="report"),
        ]  # fmt: skip

    def _core(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Radius of a core that spreads, a^2 + 4 nu t."""
        return np.asarray(np.sqrt(self.core**2 + 4.0 * time / self.reynolds))

    def _theory(self, time: NDArray[np.float64]) -> tuple[Any, Any]:
        """Radius and height of the lower one of two thin, inviscid rings."""
        half = 0.5 * self.gap
        rings = CoaxialRings(
            heights=(-half, half), circulations=(1.0, -1.0), cores=(self.core,) * 2
        )
        path = rings.trajectory(time)
        return path.radii[0], path.heights[0]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Surfaces at stages, the radius beside thin rings, energy, and what is kept."""
        figure, axes = staged_sheet(
            outcome, self.until, self.pictures, (1.0, 1.0, 1.0), view=(-60.0, 35.0)
        )
        self._radius(axes[0], outcome.series)
        self._energy(axes[1], outcome.series)
        self._kept(axes[2], outcome.series)
        name_panels(axes)
        figure.suptitle(
            rf"Head-on collision of two rings, $\Gamma/\nu$ = {self.reynolds:g}, "
            f"core {self.core:g} R: {self.mesh()}",
            fontsize=11,
        )
        return figure

    def _radius(self, panel: Axes, series: Series) -> None:
        """Radius and distance over time beside thin rings."""
        time = series["time"]
        radius, height = self._theory(time)
        panel.plot(time, radius, color=REFERENCE, ls="--", label="thin inviscid rings")
        panel.plot(time, -2.0 * height, color=REFERENCE, ls="--")
        panel.plot(time, series["lower_radius"], color=OURS, label="ours, radius")
        panel.plot(time, -2.0 * series["lower_height"], color=OTHERS[0], label="ours, distance")
        top = 1.15 * max(self.gap, float(series["lower_radius"].max()))
        panel.set(title="radius and distance, in $R$", xlabel=r"time $t\,\Gamma/R^2$",
                  ylim=(0.0, top))  # fmt: skip
        panel.legend(loc="best")

    def _energy(self, panel: Axes, series: Series) -> None:
        """Energy lost beside the integral of the dissipation, and the enstrophy."""
        gone, spent = loss(series)
        first = series["energy"][0]
        panel.plot(series["time"], spent / first, color=REFERENCE, ls="--",
                   label=r"$\int\nu\,\omega^2$")  # fmt: skip
        panel.plot(series["time"], gone / first, color=OURS, label="energy lost")
        panel.plot(series["time"], 1.0 - series["lower_circulation"], color=OTHERS[1],
                   label="circulation lost at $y = 0$")  # fmt: skip
        panel.set(title="lost, of the first", xlabel=r"time $t\,\Gamma/R^2$")
        panel.legend(loc="best")

    def _kept(self, panel: Axes, series: Series) -> None:
        """Impulse and helicity, which are zero."""
        lines = [
            ("impulse", np.abs([series[f"impulse_{a}"] for a in "xyz"]).max(axis=0) / np.pi,
             OURS, None),
            ("helicity", series["helicity"], OTHERS[0], None),
            ("divergence", series["divergence"], OTHERS[1], None),
        ]  # fmt: skip
        departures(panel, series["time"], lines, "what should be zero")


def watch_lower_ring(moment: Moment) -> dict[str, float]:
    """Watcher: radius, height and circulation of the ring at z < 0."""
    vorticity, grid = moment.state.vorticity, moment.state.grid
    place = ring_below(vorticity, grid)
    count = int(np.searchsorted(grid.axes()[2], -1e-9 * grid.spacing))
    return {
        "lower_radius": place.radius,
        "lower_height": place.height,
        "lower_circulation": half_plane_flux(vorticity[..., :count], grid),
    }


def _most(series: Series, name: str) -> float:
    """Largest value of a column, of the first."""
    return float(series[name].max() / series[name][0])
