"""What the cases of vortex rings share: options of the mesh, the flow around rings, panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.kernels import get_kernel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

SOLVE: dict[str, Any] = {"order": 10, "radius": 1.4}  # the velocity's error 20 times less
TAIL = 3.8  # core radii from a core's middle to where its vorticity is 1e-6 of it
BALANCE = 0.05  # allowed of the energy lost beyond viscosity
LITTLE = 0.1  # of the first energy: a smaller loss to viscosity is no yardstick
NEGLIGIBLE = 1e-4  # part of the largest vorticity that no room is made for: it keeps the impulse
SPARE = 6  # nodes between that and the edge, beside the kernel's


@dataclass(frozen=True, kw_only=True)
class RingsCase(Case):
    """Rings of radius 1 and circulation 1 about the z axis, in fluid at rest far away."""

    core: float = option(0.1, "core radius a, of the ring's radius")
    spacing: float = option(1 / 40, "mesh spacing", unit="L")
    kernel: str = option("M8'", "remeshing kernel")
    stretching: Literal["conservative", "classical"] = option(
        "conservative", "form of the stretching"
    )
    projection: int = option(0, "steps between projections onto solenoidal vorticity, 0: never")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    dtype: Literal["float64", "float32"] = option("float64", "precision")

    size: ClassVar[str] = "spacing"

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("core", "spacing", "deformation")
        self.require(self.core <= 0.5, "core", "at most half of the ring's radius")
        self.require(
            self.spacing <= self.core / 2.5, "spacing", "at most the core radius over 2.5",
            hint=f"--spacing {self.core / 4:.3g}",
        )  # fmt: skip
        self.require(self.projection >= 0, "projection", "not negative")

    def flow(
        self, radius: float, low: float, high: float, viscosity: float, core: float | None = None
    ) -> Any:
        """The flow on a box around cores within ``radius`` of the axis and from low to high z."""
        from pmesh.vortex.flow import VortexFlow

        tail = TAIL * (self.core if core is None else core) / self.spacing
        pad = tail + get_kernel(self.kernel).half_width + SPARE
        half = 8 * math.ceil((radius / self.spacing + pad) / 8)
        first = math.floor(low / self.spacing - pad)
        tall = 8 * math.ceil((high / self.spacing + pad - first) / 8)
        corner = (-half * self.spacing, -half * self.spacing, first * self.spacing)
        return VortexFlow(
            grid=Grid((2 * half, 2 * half, tall), self.spacing, corner),
            viscosity=viscosity,
            kernel=self.kernel,
            stretching=self.stretching,
            projection=self.projection,
            deformation=self.deformation,
            domain="follow",
            negligible=NEGLIGIBLE,
            dtype=self.dtype,
            **SOLVE,
        )

    def seen(self, every: float) -> list[Watcher]:
        """Snapshots of the vorticity for pictures."""
        from pmesh.run.snapshots import Snapshots

        return [Snapshots(every, fields=["vorticity"], dtype="float32")]

    def mesh(self) -> str:
        """The mesh in words."""
        return f"{self.kernel}, h = 1/{1 / self.spacing:.3g}, a/h = {self.core / self.spacing:.3g}"


def drift(values: Any) -> float:
    """Largest departure of values from the first, over that."""
    return float(np.abs(np.asarray(values) / values[0] - 1.0).max())


def loss(series: Any) -> tuple[Any, Any]:
    """Energy that is gone [L^5/T^2], and the integral of the dissipation, over time."""
    time, rate = series["time"], series["dissipation"]
    pieces = 0.5 * (rate[1:] + rate[:-1]) * np.diff(time)
    return series["energy"][0] - series["energy"], np.concatenate([[0.0], np.cumsum(pieces)])


def imbalance(series: Any) -> float:
    """Energy lost at the end less the integral of the dissipation, over the latter.

    Over a tenth of the first energy where less than that was dissipated.
    """
    gone, spent = loss(series)
    return float((gone[-1] - spent[-1]) / max(spent[-1], LITTLE * series["energy"][0]))


def balance(series: Any) -> Metric:
    """The metric of `imbalance`, its name tells what it is a part of."""
    little = loss(series)[1][-1] < LITTLE * series["energy"][0]
    part = "of a tenth of the first" if little else "of what that took"
    return Metric(f"energy lost beyond viscosity, {part}", imbalance(series), 0.0, BALANCE, "A",
                  "Navier-Stokes equations", "absolute")  # fmt: skip


def portraits(
    figure: Figure, places: Sequence[Any], outcome: Outcome, times: Sequence[float], **options: Any
) -> None:
    """Surfaces of vorticity at the snapshots closest to some times."""
    from pmesh.cases.vortices import show_isosurface

    shots = outcome.stages(times)
    for place, shot in zip(places, shots, strict=False):
        panel = figure.add_subplot(place)
        show_isosurface(panel, shot, "vorticity", ground=False, size=(700, 620), **options)
        panel.set_title(f"$t$ = {shot.time:.3g}")


def staged_sheet(
    outcome: Outcome,
    until: float,
    pictures: int,
    widths: Sequence[float],
    view: tuple[float, float],
) -> tuple[Figure, list[Axes]]:
    """A figure with at most four stages in a row, and panels of these widths below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 6.6), layout="constrained")
    rows = figure.add_gridspec(2, 1, height_ratios=(1.15, 1.0))
    seen = min(4, pictures)
    times = np.linspace(until / seen, until, seen)
    top = rows[0].subgridspec(1, seen)
    portraits(figure, [top[k] for k in range(seen)], outcome, times.tolist(), view=view)
    below = rows[1].subgridspec(1, len(widths), width_ratios=tuple(widths))
    return figure, [figure.add_subplot(below[k]) for k in range(len(widths))]


def departures(
    panel: Axes, time: Any, lines: Sequence[tuple[str, Any, str, float | None]], title: str
) -> None:
    """Sizes of drifts over time, on a logarithmic axis, each with what is allowed, dashed."""
    for name, values, colour, allowed in lines:
        size = np.maximum(np.abs(values), 1e-16)
        panel.semilogy(time[1:], size[1:], color=colour, label=name)
        if allowed is not None:
            panel.axhline(allowed, color=colour, lw=0.9, ls=(0, (4, 3)))
    panel.set(title=title, xlabel="time $t$")
    judged = any(allowed is not None for *_, allowed in lines)
    panel.legend(loc="best", title="dashed: allowed" if judged else None, title_fontsize=8)
