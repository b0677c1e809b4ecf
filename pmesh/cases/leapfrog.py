"""Two coaxial vortex rings pass through each other in turn, beside the theory of thin rings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Outcome
from pmesh.cases.coaxial import cores, half_plane_flux, whole_ring
from pmesh.cases.options import option
from pmesh.cases.rings import RingsCase, drift, portraits
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.rings import leapfrogging
from pmesh.vortex.exact.thin_rings import CoaxialRings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

Values = NDArray[np.float64]
PAPER = "Borisov, Kilin & Mamaev, Regul. Chaotic Dyn. 18 (2013) 33"
ALLOWED, KEPT = 0.05, 1e-3
THIN = 0.1  # core radii for which the theory of thin rings is a yardstick


class Tracks(NamedTuple):
    """Two rings over time, each under its own name: the first is the one that began behind."""

    times: Values  # (t,)
    radii: Values  # (2, t)
    heights: Values  # (2, t)


@dataclass(frozen=True, kw_only=True)
class LeapfrogCase(RingsCase):
    """Two equal rings on one axis pass through each other in turn; inviscid."""

    until: float = option(4.2, "end of the run; half a period, and a little more", unit="T")
    gap: float = option(0.7, "distance between the rings at the start", unit="L")
    pictures: int = option(6, "snapshots after the start")

    title: ClassVar[str] = "Leapfrogging vortex rings"
    source: ClassVar[str] = PAPER
    short: ClassVar[Mapping[str, Any]] = {
        "core": 0.25, "spacing": 0.25 / 2.5, "gap": 1.0, "until": 0.4, "pictures": 1,
        "dtype": "float32",
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.require(self.gap >= 4.0 * self.core, "gap", "at least four core radii")
        self.require(self.pictures > 0, "pictures", "at least 1")

    @property
    def theory(self) -> CoaxialRings:
        """The same two rings as thin ones."""
        half = 0.5 * self.gap
        return CoaxialRings(heights=(-half, half), cores=(self.core,) * 2)

    def recipe(self) -> Any:
        """The flow around both rings."""
        return self.flow(1.0, -0.5 * self.gap, 0.5 * self.gap, 0.0)

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=leapfrogging(gap=self.gap, core=self.core).vorticity)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the cores in a half plane, and snapshots."""
        return [*super().watchers(), self._watch, *self.seen(self.until / self.pictures)]

    def _watch(self, moment: Moment) -> dict[str, float]:
        """Where the two cores are, the stronger first, and the centroid of both."""
        vorticity, grid = moment.state.vorticity, moment.state.grid
        columns = {
            "ring_circulation": half_plane_flux(vorticity, grid),
            "ring_height": whole_ring(vorticity, grid).height,
        }
        for number, one in enumerate(cores(vorticity, grid, self.core)):
            columns |= {f"core{number}_r": one.radius, f"core{number}_z": one.height}
        return columns

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Period, path and travel beside thin rings, and what is kept."""
        series = outcome.series
        ours = tracks(series)
        theory = self.theory.trajectory(ours.times)
        apart = np.nanmax(np.abs(ours.radii - theory.radii))
        height = series["ring_height"] - series["ring_height"][0]
        weights = theory.radii**2
        far = (weights * theory.heights).sum(axis=0) / weights.sum(axis=0)
        thick = "" if self.core <= THIN else ", of cores too thick for it"
        metrics = [
            Metric(f"travel of the centroid, beside thin rings{thick}", height[-1],
                   float(far[-1] - far[0]), ALLOWED, "A", PAPER,
                   "relative" if self.core <= THIN else "report"),
            Metric("largest difference of a radius", float(apart), kind="report"),
        ]  # fmt: skip
        metrics += self._turns(ours)
        kept = ("A", "Euler's equations")
        return [
            *metrics,
            Metric("drift of impulse", drift(series["impulse_z"]), 0.0, KEPT, *kept, "absolute"),
            Metric("drift of circulation", drift(series["ring_circulation"]), 0.0, KEPT, *kept,
                   "absolute"),
            Metric("drift of energy", drift(series["energy"]), kind="report"),
            Metric("divergence, largest", float(series["divergence"][1:].max()), kind="report"),
        ]  # fmt: skip

    def _turns(self, ours: Tracks) -> list[Metric]:
        """The first passage and the period beside theory; rings that merge before them fail."""
        (times, halves), (known, half) = self._moments(ours), self._known()
        found = []
        for name, moments, due, share in (
            ("first passage", times, known[0], 1.0),
            ("period, twice that from equal radii to equal radii", halves, half, 2.0),
        ):
            if len(moments) or due < (1.0 - ALLOWED) * ours.times[-1]:
                value = moments[0] if len(moments) else np.nan
                found.append(Metric(name, share * value, share * due, ALLOWED, "A", PAPER))
        if len(times) > 1:
            period = 2.0 * (times[-1] - times[0]) / (len(times) - 1)
            passed = 2.0 * (known[1] - known[0])
            found.append(Metric("period, by passages", period, passed, ALLOWED, "A", PAPER))
        return found

    def _known(self) -> tuple[Values, float]:
        """By thin-ring theory: the first two passages, half a period apart, and half a period."""
        period = self.theory.leapfrog_period()
        if not np.isfinite(period):  # rings too far apart for it
            return np.full(2, np.nan), np.nan
        times = np.linspace(0.0, period, 4001)
        path = self.theory.trajectory(times)
        passed, halves = self._moments(Tracks(times, path.radii, path.heights))
        return passed[:2], float(halves[0])

    @staticmethod
    def _moments(path: Tracks) -> tuple[Values, Values]:
        """Passages, and when after the first of them the radii are equal, as at the start."""
        passed = passages(path)
        equal = crossings(path.times, path.radii[0] - path.radii[1])
        return passed, equal[equal > (passed[0] if len(passed) else np.inf)]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Paths of both cores over the theory's, heights over time, surfaces at stages."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 6.6), layout="constrained")
        rows = figure.add_gridspec(2, 1, height_ratios=(1.0, 1.25))
        seen = min(4, self.pictures)
        times = np.linspace(self.until / seen, self.until, seen)
        portraits(figure, [rows[0].subgridspec(1, seen)[k] for k in range(seen)], outcome,
                  times.tolist(), view=(-60.0, 12.0))  # fmt: skip
        below = rows[1].subgridspec(1, 2, width_ratios=(1.3, 1))
        axes = [figure.add_subplot(below[k]) for k in range(2)]
        ours = tracks(outcome.series)
        self._paths(axes[0], ours)
        self._distance(axes[1], ours)
        name_panels(axes)
        figure.suptitle(
            f"Leapfrogging rings, gap {self.gap:g} R, core {self.core:g} R, inviscid: "
            f"{self.mesh()}",
            fontsize=11,
        )
        return figure

    def _paths(self, panel: Axes, ours: Tracks) -> None:
        """Radius against height of both cores."""
        theory = self.theory.trajectory(np.linspace(0.0, ours.times[-1], 600))
        for k, colour in ((0, OURS), (1, OTHERS[0])):
            panel.plot(theory.heights[k], theory.radii[k], color=REFERENCE, ls="--", lw=1.1,
                       label="thin rings" if k == 0 else None)  # fmt: skip
            panel.plot(ours.heights[k], ours.radii[k], color=colour,
                       label=f"ours, {('rear', 'front')[k]} at the start")  # fmt: skip
            panel.plot(ours.heights[k, 0], ours.radii[k, 0], "o", color=colour)
        panel.set(title="paths of the cores", xlabel="height, in $R$",
                  ylabel="mean radius of a core, in $R$")  # fmt: skip
        panel.legend(loc="best")

    def _distance(self, panel: Axes, ours: Tracks) -> None:
        """How far the first ring is ahead of the second."""
        theory = self.theory.trajectory(np.linspace(0.0, ours.times[-1], 600))
        panel.plot(theory.times, theory.heights[0] - theory.heights[1], color=REFERENCE, ls="--",
                   label="thin rings")  # fmt: skip
        panel.plot(ours.times, ours.heights[0] - ours.heights[1], color=OURS, label="ours")
        panel.axhline(0.0, color=OTHERS[2], lw=0.8)
        panel.set(title="lead of the ring that began behind, in $R$",
                  xlabel=r"time $t\,\Gamma/R^2$")  # fmt: skip
        panel.margins(y=0.2)
        panel.legend(loc="best")


def tracks(series: Series) -> Tracks:
    """The two cores under names of their own: each goes on as the one that comes closest.

    Where one was not found it is taken to be where it was.
    """
    places = np.stack([[series[f"core{k}_r"], series[f"core{k}_z"]] for k in (0, 1)])
    rows = [places[:, :, 0][np.argsort(places[:, 1, 0])]]
    for now in np.moveaxis(places[:, :, 1:], -1, 0):
        before = rows[-1]
        straight, crossed = (np.nansum((one - before) ** 2) for one in (now, now[::-1]))
        now = now if straight <= crossed else now[::-1]
        rows.append(np.where(np.isnan(now), before, now))
    path = np.stack(rows, axis=-1)
    return Tracks(np.asarray(series["time"], np.float64), path[:, 0], path[:, 1])


def passages(path: Tracks) -> Values:
    """Times at which both rings have one height."""
    return crossings(path.times, path.heights[0] - path.heights[1])


def crossings(times: Values, values: Values) -> Values:
    """Times at which values change their sign, straight between those known."""
    at = np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))
    share = values[at] / (values[at] - values[at + 1])
    return np.asarray(times[at] + share * (times[at + 1] - times[at]))
