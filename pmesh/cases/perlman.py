"""Perlman's patch: the accuracy of the velocity, and of advection by remeshed particles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.moments import relative_error, watch_moments
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, show_field, styled
from pmesh.run.summary import Kind, Metric
from pmesh.vortex.exact.patches import PerlmanPatch
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

ALLOWED = 1e-3
ORDERS = {"M4'": 2.0, "M6'": 4.0}  # of the velocity when dt follows h: 1/h remeshings
SOURCE = "Perlman, J. Comput. Phys. 59 (1985) 200"
Errors = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class PerlmanCase(Case):
    """Perlman's steady patch turns once: error of the velocity, order of the advection."""

    until: float = option(4.0 * math.pi, "end of the run; 4 pi is a turn of the centre", unit="T")
    p: int = option(7, "power in w = (1 - r^2)^p")
    spacing: float = option(1 / 64, "mesh spacing; the order is taken from 2h, h, h/2", unit="L")
    kernel: str = option("M6'", "remeshing kernel")
    deformation: float = option(0.1, "largest dt * max|grad u| at spacing h; dt follows h")

    title: ClassVar[str] = "Perlman's patch"
    source: ClassVar[str] = SOURCE
    size: ClassVar[str] = "spacing"
    short: ClassVar[Mapping[str, Any]] = {"until": math.pi}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("p", "spacing", "deformation")
        self.require(self.spacing <= 1 / 8, "spacing", "at most 1/8 of the radius")

    @property
    def exact(self) -> PerlmanPatch:
        """The exact flow: radius 1, vorticity 1 at the centre."""
        return PerlmanPatch(p=self.p)

    def recipe(self) -> Any:
        """The inviscid flow on a box of 2.5 radii, and the patch in its middle."""
        from pmesh.vortex.flow import VortexFlow

        cells = math.ceil(1.25 / self.spacing)
        grid = Grid((2 * cells + 1,) * 2, self.spacing, (-cells * self.spacing,) * 2)
        return VortexFlow(
            grid=grid, viscosity=0.0, kernel=self.kernel, deformation=self.deformation
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.exact.vorticity(flow.grid.points()))

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the moments, and snapshots of the start and of the end."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), watch_moments, Snapshots(self.until)]

    def errors(self, state: Any) -> tuple[float, float]:
        """Relative L2 errors of velocity and vorticity; the patch is steady, so at any time."""
        from pmesh.spectral.poisson import velocity

        points = state.grid.points()
        ours = velocity(state.vorticity, state.grid)
        return (
            relative_error(ours, self.exact.velocity(points)),
            relative_error(state.vorticity, self.exact.vorticity(points)),
        )

    def scaled(self, factor: float) -> PerlmanCase:
        """The case at ``factor`` times the spacing and the time step."""
        return replace(self, spacing=factor * self.spacing, deformation=factor * self.deformation)

    def convergence(self, state: Any) -> dict[float, Errors]:
        """Errors at 2h, h, h/2: velocity at the start, velocity and vorticity at the end."""
        h, start = self.spacing, self.errors(self.build()[1])[0]
        return {
            2 * h: _solved(self.scaled(2)),
            h: (start, *self.errors(state)),
            h / 2: _solved(self.scaled(0.5)),
        }

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Errors at the spacing, and the order from there to half of it."""
        table, series = self.convergence(outcome.state), outcome.series
        start, end, spin = table[self.spacing]
        order, claimed = math.log2(end / table[self.spacing / 2][1]), ORDERS.get(self.kernel)
        gamma = float(np.abs(series["circulation"] / series["circulation"][0] - 1.0).max())
        spread = float(np.abs(series["angular_moment"] / series["angular_moment"][0] - 1.0).max())
        judged: Kind = "absolute" if self.kernel == "M6'" else "report"
        known, kept = ("A", SOURCE), ("A", "Euler's equations")
        return [
            Metric("velocity at t = 0, rel. L2 error", start, 0.0, ALLOWED, *known, "absolute"),
            Metric("velocity at the end, rel. L2 error", end, 0.0, ALLOWED, *known, "absolute"),
            Metric("vorticity at the end, rel. L2 error", spin, kind="report"),
            Metric("order of the velocity at the end", order, claimed, 0.2, "",
                   "moments that the kernel keeps", judged),
            Metric("drift of circulation", gamma, 0.0, 1e-12, *kept, "absolute"),
            Metric("drift of second moments' sum", spread, 0.0, 1e-3, *kept, "absolute"),
        ]  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The speed over the exact profile, where the error sits, and its fall with the spacing."""
        figure, axes = panels(1, 3, (11.0, 3.7), width_ratios=(1, 1.15, 1))
        self._profile(axes[0, 0], outcome.state)
        self._error(axes[0, 1], outcome.state)
        self._orders(axes[0, 2], outcome.state)
        name_panels(axes)
        figure.suptitle(
            rf"Perlman's patch, $\omega = (1-r^2)^{self.p}$, after $t$ = {outcome.state.time:.4g}: "
            f"kernel {self.kernel}, h = 1/{1 / self.spacing:.0f}",
            fontsize=11,
        )
        return figure

    def _profile(self, panel: Axes, state: Any) -> None:
        """Speed of the nodes over their distance from the centre."""
        from pmesh.spectral.poisson import velocity

        x, y = state.grid.points()
        speed = np.hypot(*velocity(state.vorticity, state.grid))
        radius = np.hypot(x, y)
        some = np.random.default_rng(1).permutation(np.flatnonzero(radius.ravel() < 1.25))[:250]
        fine = np.linspace(0.0, 1.25, 300)
        exact = self.exact.velocity(np.stack([fine, np.zeros_like(fine)]))[1]
        panel.plot(fine, exact, color=REFERENCE, label="exact")
        panel.plot(radius.ravel()[some], speed.ravel()[some], "o", ms=2.6, mew=0, color=OURS,
                   alpha=0.6, label="ours, 250 nodes")  # fmt: skip
        panel.set(title="speed", xlabel="$r$", xlim=(0, 1.25), ylim=(0, None))
        panel.legend(loc="lower center")

    def _error(self, panel: Axes, state: Any) -> None:
        """Our vorticity less the exact one."""
        apart = state.vorticity - self.exact.vorticity(state.grid.points())
        most = float(np.quantile(np.abs(apart), 0.998))
        show_field(panel, apart, state.grid, limit=most, label="ours less exact, of a largest 1")
        angle = np.linspace(0, 2 * np.pi, 200)
        panel.plot(np.cos(angle), np.sin(angle), color="k", lw=0.6, ls=(0, (4, 3)))
        panel.set(title="error of the vorticity", xlabel="$x$", ylabel="$y$")

    def _orders(self, panel: Axes, state: Any) -> None:
        """Errors over the spacing, with the slope of the claimed order."""
        table = self.convergence(state)
        spacing = np.array(list(table))
        names = ("velocity, $t$ = 0", "velocity, end", "vorticity, end")
        for name, error, colour, mark in zip(
            names,
            zip(*table.values(), strict=True),
            (OTHERS[0], OURS, OTHERS[1]),
            "sod",
            strict=True,
        ):
            slope = math.log2(error[-2] / error[-1])
            panel.loglog(spacing, error, f"{mark}-", color=colour, label=f"{name}: {slope:.1f}")
        if self.kernel in ORDERS:
            order = ORDERS[self.kernel]
            guide = 0.4 * table[self.spacing][1] * (spacing / self.spacing) ** order
            panel.loglog(spacing, guide, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)),
                         label=f"slope {order:g}")  # fmt: skip
        panel.axhline(ALLOWED, color=REFERENCE, lw=0.9, ls=":", label="allowed at 1/64")
        panel.set_xticks(spacing, labels=[f"1/{1 / h:.0f}" for h in spacing])
        panel.minorticks_off()
        panel.set(title="relative L2 error, last slope", xlabel="spacing $h$")
        panel.set_ylim(bottom=1e-2 * min(map(min, table.values())))
        panel.legend(loc="lower right", fontsize=7.5)


@lru_cache(maxsize=8)
def _solved(case: PerlmanCase) -> Errors:
    """The errors of the case at another spacing, run to its end."""
    from pmesh.run.loop import run

    flow, start = case.build()
    end = run(flow, start, until=case.until)
    return (case.errors(start)[0], *case.errors(end))
