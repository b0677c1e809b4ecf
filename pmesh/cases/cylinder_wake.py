"""Long runs past a cylinder: its steady wake and its vortex street, beside published numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.shapes import Disk
from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.reference import read_table
from pmesh.cases.routes import Routes
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.wake import draw_vorticity
from pmesh.run.summary import Metric
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

Values = NDArray[np.float64]
ONSET = 47.0  # Reynolds number at which the wake begins to shed
PLACE, SIZE = 1.2, 0.1  # of the eddy that starts shedding: behind the centre, its core [D]
ROUTES_EVERY = 4  # steps between those at which the routes that cost more are asked
RESIDUAL = 1e-5  # of the slip's law, which the penalisation keeps
STARTED = 1.0  # time after which the start, which slips, is over [D/U]
WIDE = 8.0  # picture of the wake [inches]
LATE = 0.8  # part of a run after which a steady one is steady
FEWEST = 3  # steps in it from which its drag is told
NAMES = {
    "drag": "mean drag",
    "recirculation": "recirculation length / D",
    "lift": "lift amplitude",
    "strouhal": "Strouhal number",
}


@dataclass(frozen=True)
class Published:
    """A published number, and how far it is to be trusted."""

    value: float
    tolerance: float
    grade: str
    source: str


@dataclass(frozen=True, kw_only=True)
class CylinderWake(Case):
    """A cylinder in a stream, until its wake is steady (Re < 47) or sheds with one period.

    Lengths in diameters, velocities in the free stream's. An eddy without circulation, of
    transverse impulse ``kick``, starts behind the cylinder so that shedding need not wait for
    round-off to grow. The wake leaves through the end of a window.
    """

    until: float = option(80.0, "end of the run", unit="D/U")
    reynolds: float = option(100.0, "Reynolds number U D / nu, from 20 to 400")
    nodes: int = option(40, "mesh nodes per diameter")
    ahead: float = option(3.0, "window ahead of the cylinder's centre", unit="D")
    beside: float = option(4.0, "window to each side", unit="D")
    behind: float = option(12.0, "window behind", unit="D")
    fade: float = option(1.0, "width of the zone where vorticity fades", unit="D")
    wake: bool = option(True, "let the wake that left act on as a source")
    kick: float | None = option(
        None, "impulse of the eddy that starts shedding; 0.2, and 0 at Re < 47", unit="U D^2"
    )
    deformation: float = option(0.5, "largest dt * max|grad u|")
    kernel: str = option("M6'", "remeshing kernel")
    every: float = option(5.0, "time between snapshots", unit="D/U")

    title: ClassVar[str] = "Cylinder in a stream"
    source: ClassVar[str] = "Wu & Shu 2009; Williamson 1988"
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 16, "behind": 8.0, "reynolds": 40.0, "until": 10.0, "every": 2.5,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what is outside the case, a body of too few nodes and a window without room."""
        super().__post_init__()
        self.require(20 <= self.reynolds <= 400, "reynolds", "between 20 and 400")
        self.require(self.nodes >= 12, "nodes", "at least 12 per diameter")
        self.positive("fade", "deformation", "every")
        for name in ("ahead", "beside", "behind"):
            least = 1.0 + self.fade
            self.require(least <= getattr(self, name) <= 200, name, f"from {least:g} to 200")
        little = self.kick is None or abs(self.kick) <= 2
        self.require(little, "kick", "at most 2", "--kick 0.2")

    @property
    def layer(self) -> float:
        """Thickness of the boundary layer, D / sqrt(Re), in spacings."""
        return self.nodes / math.sqrt(self.reynolds)

    @property
    def sheds(self) -> bool:
        """Whether the wake sheds vortices."""
        return self.reynolds > ONSET

    @property
    def impulse(self) -> float:
        """Transverse impulse of the eddy at the start [U D^2]."""
        return self.kick if self.kick is not None else 0.2 * self.sheds

    def eddy(self, points: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
        """Vorticity of the eddy at points (2, ...): a Gaussian's slope along x."""
        x, y = points[0] - PLACE, points[1]
        peak = np.exp(-(x**2 + y**2) / (2 * SIZE**2)) / (2 * math.pi * SIZE**2)
        return np.asarray(-self.impulse * x / SIZE**2 * peak)

    def recipe(self) -> Any:
        """The flow on a box just larger than body and eddy; it grows to the window."""
        from pmesh.bodies.body import RigidBody
        from pmesh.vortex.flow import VortexFlow
        from pmesh.vortex.window import Window

        h = 1.0 / self.nodes
        cells = 8 * math.ceil(self.nodes / 8)
        grid = Grid((3 * cells, 2 * cells), h, ((0.5 - cells) * h,) * 2)
        return VortexFlow(
            grid=grid,
            viscosity=1.0 / self.reynolds,
            freestream=(1.0, 0.0),
            bodies=(RigidBody(Disk(radius=0.5)),),
            deformation=self.deformation,
            kernel=self.kernel,
            domain="follow",
            window=Window(
                lower=(self.ahead, self.beside),
                upper=(self.behind, self.beside),
                fade=self.fade,
                wake=self.wake,
            ),
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vorticity it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.eddy if self.impulse else None)

    def watchers(self) -> Sequence[Watcher]:
        """Forces by all routes, the ledger and snapshots."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Forces, Ledger

        return [Forces(routes=ROUTES_EVERY), Ledger(), Snapshots(self.every, dtype="float32")]

    def routes(self, outcome: Outcome) -> Routes:
        """Drag and lift coefficients by every route, force over rho U^2 D / 2."""
        return Routes.of(outcome.series, scale=2.0)

    def recirculation(self, outcome: Outcome) -> float:
        """Length of the recirculation behind the cylinder at the end [D]; NaN without one."""
        x, speed = centre_line(outcome.flow.velocity(outcome.state), outcome.state.grid)
        back = np.flatnonzero((x[:-1] > 0.55) & (speed[:-1] < 0) & (speed[1:] >= 0))
        if not back.size:
            return math.nan
        i = int(back[-1])
        return float(x[i] - speed[i] * (x[i + 1] - x[i]) / (speed[i + 1] - speed[i]) - 0.5)

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Drag, lift and frequency, or drag and recirculation, beside published ones; the slip."""
        routes, series = self.routes(outcome), outcome.series
        found = self._shedding(routes) if self.sheds else self._steady(routes, outcome)
        residual = float(np.nanmax(series["slip_residual"][1:]))
        slip = float(series["slip"][series["time"] > LATE * self.until].max())
        total = float(np.abs(series["circulation"] + series["lost_circulation"]).max())
        return [
            *found,
            Metric("slip residual, largest", residual, 0.0, RESIDUAL, kind="absolute"),
            Metric("slip, rms", slip, 0.0, 0.01,
                   kind="absolute" if LATE * self.until > STARTED else "report"),
            Metric("circulation, kept and lost", total, 0.0, 1e-9, "A", "Kelvin", "absolute"),
        ]  # fmt: skip

    def _shedding(self, routes: Routes) -> list[Metric]:
        """The numbers of whole cycles; reports only while they still change."""
        try:
            lift, drag = routes.statistics("lift"), routes.statistics("drag")
        except InputError:  # a run of a few steps
            return []
        cycle = lift.cycle
        if cycle is None:
            return [
                Metric(f"mean drag ({lift.note})", drag.mean.value, kind="report"),
                Metric("lift, rms", lift.rms.value, kind="report"),
            ]
        mean = routes.mean("drag", cycle)
        return [
            self._beside("drag", mean),
            self._beside("lift", cycle.amplitude.value),
            self._beside("strouhal", cycle.frequency.value),
            Metric("mean drag, uncertainty", drag.mean.uncertainty, kind="report"),
            Metric("lift amplitude, uncertainty", cycle.amplitude.uncertainty, kind="report"),
            Metric("Strouhal number, uncertainty", cycle.frequency.uncertainty, kind="report"),
            Metric("whole cycles", float(cycle.cycles), kind="report"),
            *routes.metrics(cycle, self.layer),
        ]

    def _steady(self, routes: Routes, outcome: Outcome) -> list[Metric]:
        """Drag and recirculation at the end, and what is still changing."""
        time, drag = routes.time, routes.of_main("drag")
        late = time > LATE * self.until
        if late.sum() < FEWEST:
            return []
        mean = float(np.average(drag[late], weights=routes.dt[late]))
        slope = float(np.polyfit(time[late], drag[late], 1)[0]) * (1 - LATE) * self.until / mean
        settled = abs(slope) < 0.01
        return [
            self._beside("drag", mean, judged=settled),
            self._beside("recirculation", self.recirculation(outcome), judged=settled),
            Metric(f"drag's change over the last {1 - LATE:.0%}", slope, kind="report"),
            *routes.apart("drag", late, self.layer),
        ]

    def _beside(self, quantity: str, value: float, *, judged: bool = True) -> Metric:
        """A number beside the published one, if there is one and the run has come that far."""
        known = published(self.reynolds).get(quantity)
        if known is None:
            return Metric(NAMES[quantity], value, kind="report")
        return Metric(
            NAMES[quantity], value, known.value, known.tolerance, known.grade, known.source,
            "relative" if judged else "report",
        )  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Drag and lift over time and published means; the lift's spectrum, or u; the wake."""
        from matplotlib.figure import Figure

        heights = 3.2, 0.7 + max(self._field_height, 1.0)  # the wake as wide as the page
        figure = Figure(figsize=(9.6, sum(heights)), layout="constrained")
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=heights).ravel()
        forces, side = top.subplots(1, 2, width_ratios=(2.2, 1.0))
        routes = self.routes(outcome)
        self._draw_forces(forces, routes)
        if self.sheds:
            self._draw_spectrum(side, routes)
        else:
            self._draw_centre_line(side, outcome)
        field = below.subplots()
        self._draw_wake(field, outcome)
        name_panels([forces, side, field])
        figure.suptitle(
            f"{self.title}, Re = {self.reynolds:g}: {self.nodes} nodes per diameter, "
            f"window {self.behind:g} D behind",
            fontsize=11,
        )
        return figure

    def _draw_forces(self, panel: Axes, routes: Routes) -> None:
        known = published(self.reynolds)
        panel.plot(routes.time, routes.of_main("drag"), color=OURS, label="$C_D$")
        panel.plot(routes.time, routes.of_main("lift"), color=OTHERS[0], lw=1.0, label="$C_L$")
        if "drag" in known:
            panel.axhline(known["drag"].value, color=REFERENCE, lw=1.0, ls="--",
                          label=f"mean $C_D$, {known['drag'].source}")  # fmt: skip
        if "lift" in known:
            wide, label = known["lift"].value, f"amplitude of $C_L$, {known['lift'].source}"
            panel.axhline(wide, color=REFERENCE, lw=1.0, ls=":", label=label)
            panel.axhline(-wide, color=REFERENCE, lw=1.0, ls=":")
        late = routes.time > 0.1 * self.until
        top = 1.5 * float(routes.of_main("drag")[late].max())
        low = -0.1 if not self.sheds else -1.3 * float(np.abs(routes.of_main("lift")).max()) - 0.1
        panel.set(xlim=(0, self.until), ylim=(low, top), xlabel="$t\\,U/D$")
        panel.set_title("force coefficients")
        panel.legend(loc="upper right", ncols=2)

    def _draw_spectrum(self, panel: Axes, routes: Routes) -> None:
        from pmesh.run.statistics import spectrum

        panel.set_title("spectrum of the lift")
        lift = routes.of_main("lift")
        try:
            found = spectrum(routes.time_end, lift, routes.dt, after=0.5 * self.until)
        except InputError:  # a run of a few steps
            panel.set_axis_off()
            panel.text(0.5, 0.5, "the run is too short", transform=panel.transAxes, ha="center")
            return
        panel.semilogy(found.frequency, found.power / found.power.max(), color=OURS)
        if known := published(self.reynolds).get("strouhal"):
            panel.axvline(known.value, color=REFERENCE, lw=1.0, ls="--", label=known.source)
            panel.legend(loc="upper right")
        panel.set(xlim=(0, 1.0), ylim=(1e-8, 3), xlabel="$f\\,D/U$")

    def _draw_centre_line(self, panel: Axes, outcome: Outcome) -> None:
        x, speed = centre_line(outcome.flow.velocity(outcome.state), outcome.state.grid)
        panel.plot(x - 0.5, speed, color=OURS, label="$u / U$ behind")
        if known := published(self.reynolds).get("recirculation"):
            panel.axvline(known.value, color=REFERENCE, lw=1.0, ls="--", label=known.source)
        panel.axhline(0.0, color="k", lw=0.6)
        panel.set(xlim=(0, min(6.0, self.behind - 1)), ylim=(-0.25, 1), xlabel="$x/D - 1/2$")
        panel.set_title("velocity on the centre line")
        panel.legend(loc="best")

    def _draw_wake(self, panel: Axes, outcome: Outcome) -> None:
        state = outcome.state
        around = np.linspace(0, 2 * math.pi, 256, endpoint=False)
        circle = 0.5 * np.stack([np.cos(around), np.sin(around)], axis=1)
        limit = 0.2 * math.sqrt(self.reynolds)
        draw_vorticity(
            panel, state.vorticity, state.grid, limit, outlines=[circle], label=r"$\omega D/U$"
        )
        half = self._half
        panel.set(xlim=(-1.5, self.behind), ylim=(-half, half), xlabel="$x/D$", ylabel="$y/D$")
        panel.set_title(f"vorticity at t = {state.time:.4g}")
        panel.set_anchor("C")

    @property
    def _half(self) -> float:
        """Height of the wake's picture above its middle [D]."""
        return min(self.beside, 2.6 if self.sheds else 2.0)

    @property
    def _field_height(self) -> float:
        """Height of the wake's picture [inches]."""
        return WIDE * 2 * self._half / (1.5 + self.behind)


def centre_line(velocity: NDArray[Any], grid: Grid) -> tuple[Values, Values]:
    """x and the velocity along it on the line y = 0, cubic through the four rows about it."""
    x, y = grid.axes()
    row = int(np.searchsorted(y, 0.0))
    t = float(-y[row - 1] / grid.spacing)
    weights = (-t * (t - 1) * (t - 2) / 6, (t * t - 1) * (t - 2) / 2,
               -t * (t + 1) * (t - 2) / 2, t * (t * t - 1) / 6)  # fmt: skip
    rows = velocity[0][:, row - 2 : row + 2]
    return np.asarray(x), np.asarray(rows @ np.array(weights), np.float64)


def published(reynolds: float) -> dict[str, Published]:
    """Published numbers at a Reynolds number; none at most."""
    return {
        row["quantity"]: Published(
            float(row["value"]), float(row["tolerance"]), row["grade"], row["source"]
        )
        for row in read_table("cylinder_wake.csv")
        if float(row["reynolds"]) == reynolds
    }
