"""The elliptical vortex of Koumoutsakos (1997), which sheds filaments and turns round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.moments import aspect_ratio, watch_moments
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, show_field, styled
from pmesh.run.summary import Metric
from pmesh.vortex.exact.patches import EllipticVortex
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher
    from pmesh.run.snapshots import Snapshot

PAPER = "Koumoutsakos, J. Comput. Phys. 138 (1997) 821"
LEVELS = (0.2, 1.0, 2.0, 5.0, 10.0, 15.0, 19.0)  # of the vorticity lines [1/T]
DRIFT = (1e-6, 1e-3)  # allowed of the circulation, and of the second moments' sum


@dataclass(frozen=True, kw_only=True)
class EllipticVortexCase(Case):
    """An elliptical vortex sheds filaments and turns round; its moments stay."""

    until: float = option(6.0, "end of the run", unit="T")
    kind: Literal["I", "II"] = option("I", "vorticity profile: I smooth and steep, II 20 (1 - z^4)")
    viscosity: float = option(0.0, "kinematic viscosity", unit="L^2/T")
    spacing: float = option(1 / 96, "mesh spacing", unit="L")
    kernel: str = option("M6'", "remeshing kernel")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    every: float = option(1.0, "time between snapshots", unit="T")

    title: ClassVar[str] = "Axisymmetrisation of an elliptical vortex"
    source: ClassVar[str] = PAPER
    size: ClassVar[str] = "spacing"
    short: ClassVar[Mapping[str, Any]] = {"spacing": 1 / 32, "until": 2.0, "every": 0.4}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("spacing", "deformation", "every")
        self.require(self.viscosity >= 0, "viscosity", "not negative")
        self.require(self.spacing <= 0.1, "spacing", "at most 0.1 to see the vortex")

    @property
    def drift(self) -> tuple[float, float]:
        """Allowed of the circulation, and of the second moments' sum."""
        return DRIFT

    @property
    def exact(self) -> EllipticVortex:
        """The start, and what is known of it."""
        return EllipticVortex(kind=self.kind)

    def recipe(self) -> Any:
        """The flow on a box that holds the filaments, and the vortex at rest in it."""
        from pmesh.vortex.flow import VortexFlow

        half = 1.4 + 2.0 * np.sqrt(4.0 * self.viscosity * self.until)
        cells = round(half / self.spacing)
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
        """What Euler flow keeps, and how round the vortex became."""
        series = outcome.series
        gamma, spread = (float(np.abs(drift).max()) for drift in self._drifts(series))
        ratio = aspect_ratio(series["moment_xx"], series["moment_yy"], series["moment_xy"])
        grown = series["enstrophy"][-1] / series["enstrophy"][0] - 1.0
        below = series["smallest"].min() / series["largest"][0]
        first, exact_gamma = float(series["circulation"][0]), self.exact.circulation
        kept, at_start = ("A", "Euler's equations"), ("A", PAPER)
        return [
            Metric("circulation at t = 0", first, exact_gamma, 1e-3, *at_start),
            Metric("aspect ratio at t = 0", ratio[0], 2.0, 1e-3, *at_start),
            Metric("drift of circulation", gamma, 0.0, self.drift[0], *kept, "absolute"),
            Metric("drift of second moments' sum", spread, 0.0, self.drift[1], *kept, "absolute"),
            Metric("change of enstrophy", grown, kind="report"),
            Metric("undershoot below zero", below, kind="report"),
            Metric("aspect ratio at the end", ratio[-1], kind="report"),
        ]  # fmt: skip

    def _drifts(self, series: Mapping[str, Any]) -> tuple[Any, Any]:
        """Relative departures of circulation and angular moment from what they should be."""
        gamma, spread = series["circulation"], series["angular_moment"]
        expected = spread[0] + 4.0 * self.viscosity * gamma[0] * series["time"]
        return gamma / gamma[0] - 1.0, spread / expected - 1.0

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Vorticity at six times as in the paper, the aspect ratio, and what is kept."""
        figure, axes = panels(2, 4, (12.0, 5.7))
        shots = outcome.snapshots()
        chosen = [
            shots[i] for i in np.unique(np.linspace(0, len(shots) - 1, 6).round().astype(int))
        ]
        for panel, shot in zip(axes[:, :3].ravel(), chosen, strict=False):
            self._portrait(panel, shot)
        for panel in axes[:, :3].ravel()[len(chosen) :]:
            panel.set_visible(False)
        bar = figure.colorbar(axes[0, 0].images[0], ax=axes[:, :3], shrink=0.6, pad=0.01)
        bar.set_label(r"vorticity $\omega$; lines at the ticks")
        bar.set_ticks(LEVELS, labels=[f"{level:g}" for level in LEVELS])
        self._roundness(axes[0, 3], outcome)
        self._kept(axes[1, 3], outcome)
        name_panels([*axes[0, :3], *axes[1, :3], axes[0, 3], axes[1, 3]])
        figure.suptitle(
            f"Elliptical vortex, type {self.kind}, {self._fluid()}: "
            f"kernel {self.kernel}, {self._resolution(outcome)}",
            fontsize=11,
        )
        return figure

    def _resolution(self, outcome: Outcome) -> str:
        return f"h = 1/{1 / self.spacing:.0f}"

    def _fluid(self) -> str:
        return f"viscosity {self.viscosity:g}" if self.viscosity else "inviscid"

    def _portrait(self, panel: Axes, shot: Snapshot) -> None:
        """Vorticity with lines at a few levels, as the paper draws it."""
        vorticity = shot["vorticity"]
        show_field(panel, vorticity, shot.grid, limit=20.0, colours="BuPu", power=0.6)
        x, y = shot.grid.axes()
        panel.contour(x, y, vorticity.T, levels=LEVELS, colors="#222222", linewidths=0.45)
        panel.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05), xticks=[-1, 0, 1], yticks=[-1, 0, 1])
        panel.set_title(f"$t$ = {shot.time:g}")

    def _roundness(self, panel: Axes, outcome: Outcome) -> None:
        """Aspect ratio from the second moments, over time."""
        series = outcome.series
        ratio = aspect_ratio(series["moment_xx"], series["moment_yy"], series["moment_xy"])
        panel.plot(series["time"], ratio, color=OURS, label="ours")
        panel.plot(0, 2.0, "o", color=REFERENCE, label="exact start", clip_on=False, zorder=5)
        panel.axhline(1.0, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)))
        panel.annotate("round", (series["time"][-1], 1.0), (0, 3), textcoords="offset points",
                       ha="right", color=OTHERS[2])  # fmt: skip
        panel.set(title="effective aspect ratio", xlabel="time $t$", ylim=(0.9, 2.1))
        panel.legend(loc="upper right")

    def _kept(self, panel: Axes, outcome: Outcome) -> None:
        """Drift of circulation and of the second moments' sum beside what is allowed."""
        gamma, spread = self._drifts(outcome.series)
        names = ("circulation", r"$\int\omega r^2$")
        for drift, allowed, colour, name in zip(
            (gamma, spread), self.drift, (OTHERS[0], OURS), names, strict=True
        ):
            size = np.maximum(np.abs(drift), 1e-16)
            panel.semilogy(outcome.series["time"], size, color=colour, label=name)
            panel.axhline(allowed, color=colour, lw=0.9, ls=(0, (4, 3)))
        panel.set(title="drift of what is conserved", xlabel="time $t$", ylim=(5e-17, 3e-2))
        panel.legend(loc="center right", title="dashed: allowed", title_fontsize=8)
