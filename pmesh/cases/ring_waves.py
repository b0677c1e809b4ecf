"""The azimuthal instability of a vortex ring: waves grow around it until it breaks up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Outcome
from pmesh.cases.coaxial import half_plane_flux, waves, whole_ring
from pmesh.cases.options import option
from pmesh.cases.rings import RingsCase, balance, drift, loss, staged_sheet
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.rings import GaussianRing, VortexRing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

PAPER = "Widnall & Sullivan, Proc. R. Soc. A 332 (1973) 335"
CORE = 1 / 3.523  # of the radius: the ring of OpenFPM's vortex-in-cell example
IMPULSE = 3.268152  # of that ring, in rho Gamma R^2
KEPT = 1e-3
SEEN = 5.0  # nodes per core radius from which a growth rate is told
SEEDS = 12  # waves 1 to this, each with the amplitude given
LOW, HIGH = 3.0, 0.1  # growth is fitted from this times the seed to this share of the mean


@dataclass(frozen=True, kw_only=True)
class RingWaves(RingsCase):
    """A thick ring with waves of every number around it: which grow, and how fast."""

    until: float = option(60.0, "end of the run", unit="T")
    reynolds: float = option(7500.0, "circulation over viscosity")
    core: float = option(CORE, "core radius a, of the ring's radius")
    spacing: float = option(1 / 40, "mesh spacing; --nodes sets it", unit="L")
    nodes: int = option(40, "mesh nodes per radius of the ring")
    amplitude: float = option(5e-4, "of each wave around the ring, of the radius")
    projection: int = option(1, "steps between projections onto solenoidal vorticity, 0: never")
    dtype: Literal["float64", "float32"] = option("float32", "precision")
    pictures: int = option(12, "snapshots after the start")

    title: ClassVar[str] = "Azimuthal instability of a vortex ring"
    source: ClassVar[str] = PAPER
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 9, "until": 1.0, "pictures": 1}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        object.__setattr__(self, "spacing", 1.0 / max(int(self.nodes), 1))
        super().__post_init__()
        self.positive("reynolds")
        self.require(0 < self.amplitude <= 0.01, "amplitude", "positive and at most 0.01")
        self.require(self.pictures > 0, "pictures", "at least 1")

    @property
    def exact(self) -> GaussianRing:
        """The ring without its waves."""
        return GaussianRing(core=self.core)

    def recipe(self) -> Any:
        """The flow around the ring."""
        return self.flow(1.0 + SEEDS * self.amplitude, 0.0, 0.0, 1.0 / self.reynolds)

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self._start)

    def _start(self, points: Any) -> Any:
        """The ring, and what waves add to a smoothed filament: solenoidal, all of it."""
        modes = tuple(range(1, SEEDS + 1))
        wavy = VortexRing(core=self.core, amplitude=self.amplitude, modes=modes,
                          phases=tuple(float(n * n) for n in modes))  # fmt: skip
        added = wavy.vorticity(points) - VortexRing(core=self.core).vorticity(points)
        return self.exact.vorticity(points) + added

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the waves, and snapshots."""
        return [*super().watchers(), self._watch, *self.seen(self.until / self.pictures)]

    def _watch(self, moment: Moment) -> dict[str, float]:
        """Amplitudes of the waves around the ring, its circulation and its place."""
        vorticity, grid = moment.state.vorticity, moment.state.grid
        place = whole_ring(vorticity, grid)
        found = waves(vorticity, grid, place, 2.5 * self.core, SEEDS, 0.25 * self.core)
        columns = {f"wave_{n}": float(found[n]) for n in range(1, SEEDS + 1)}
        return columns | {
            "ring_circulation": half_plane_flux(vorticity, grid),
            "ring_radius": place.radius,
            "ring_height": place.height,
        }

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Impulse, the energy's balance, and the wave that grows."""
        series = outcome.series
        laws = ("A", "Navier-Stokes equations")
        known = IMPULSE if abs(self.core - CORE) < 1e-9 else float(self.exact.impulse[2])
        strongest = self._strongest(series)
        rate, _ = growth(series["time"], series[f"wave_{strongest}"])
        grown = [] if self._coarse else [Metric("its growth rate", rate, kind="report")]
        return [
            Metric("impulse at t = 0", series["impulse_z"][0], known, 1e-4, "A",
                   "integral of the start"),
            Metric("drift of impulse", drift(series["impulse_z"]), 0.0, KEPT, *laws, "absolute"),
            balance(series),
            Metric(f"strongest wave{self._doubt(strongest)}", float(strongest), kind="report"),
            *grown,
            Metric("its amplitude at the end, of the mean", series[f"wave_{strongest}"][-1],
                   kind="report"),
            Metric("divergence, largest", float(series["divergence"][1:].max()), kind="report"),
        ]  # fmt: skip

    @property
    def _coarse(self) -> bool:
        """Whether waves of the mesh drown those of the ring."""
        return self.core < SEEN * self.spacing

    def _doubt(self, wave: int) -> str:
        """Words behind the number of a wave that may be the mesh's: it has four sides."""
        if self._coarse:
            return f", coarse: under {SEEN:g} nodes per core"
        return "" if wave % 4 else ", which the mesh makes too"

    def _strongest(self, series: Series) -> int:
        """The wave that grew most by the time at which the first reaches a tenth of the mean."""
        found = np.array([series[f"wave_{n}"] for n in range(1, SEEDS + 1)])
        tall = np.flatnonzero(found.max(axis=0) > HIGH)
        last = int(tall[0]) if tall.size else found.shape[1] - 1
        return 1 + int(np.argmax(found[:, last] / found[:, 0]))

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Surfaces at stages, waves over time with the fitted growth, energy."""
        figure, axes = staged_sheet(
            outcome, self.until, self.pictures, (1.4, 1.0), view=(-60.0, 50.0)
        )
        self._waves(axes[0], outcome.series)
        self._energy(axes[1], outcome.series)
        name_panels(axes)
        figure.suptitle(
            rf"Waves around a vortex ring, $\Gamma/\nu$ = {self.reynolds:g}, "
            f"core {self.core:.3g} R: {self.mesh()}",
            fontsize=11,
        )
        return figure

    def _waves(self, panel: Axes, series: Series) -> None:
        """Amplitude of every wave, the strongest in front with its fit."""
        time, best = series["time"], self._strongest(series)
        for n in range(1, SEEDS + 1):
            if n != best:
                panel.semilogy(time, series[f"wave_{n}"], color=OTHERS[2], lw=0.8)
        panel.semilogy(time, series[f"wave_{best}"], color=OURS, label=f"n = {best}, the strongest")
        panel.plot([], [], color=OTHERS[2], lw=0.8, label=f"the other waves to n = {SEEDS}")
        rate, line = growth(time, series[f"wave_{best}"])
        if np.isfinite(rate) and not self._coarse:
            panel.semilogy(time, np.where(line < 1.0, line, np.nan), color=REFERENCE, ls="--",
                           label=rf"$\exp({rate:.3g}\,t)$")  # fmt: skip
        panel.set(title="amplitude of waves, of the mean", xlabel=r"time $t\,\Gamma/R^2$")
        panel.legend(loc="upper left")

    def _energy(self, panel: Axes, series: Series) -> None:
        """Energy lost beside the integral of the dissipation."""
        gone, spent = loss(series)
        first = series["energy"][0]
        panel.plot(series["time"], spent / first, color=REFERENCE, ls="--",
                   label=r"$\int\nu\,\omega^2$")  # fmt: skip
        panel.plot(series["time"], gone / first, color=OURS, label="energy lost")
        panel.set(title="energy lost, of the first", xlabel=r"time $t\,\Gamma/R^2$")
        panel.legend(loc="upper left")


def growth(
    time: NDArray[np.float64], size: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """Rate [1/T] of the exponential through a wave's growth, and that exponential over time.

    Least squares of the logarithm while the wave is above three times its start and below a
    tenth of the mean; NaN where it never grows so far.
    """
    over = np.flatnonzero(size > LOW * size[0])
    first = int(over[0]) if over.size else len(size)
    tall = np.flatnonzero(size > HIGH)
    last = int(tall[0]) if tall.size else len(size)
    if last - first < 3:
        return float("nan"), np.full_like(time, np.nan)
    rate, level = np.polyfit(time[first:last], np.log(size[first:last]), 1)
    return float(rate), np.asarray(np.exp(level + rate * time))
