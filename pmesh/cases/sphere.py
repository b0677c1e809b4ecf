"""A sphere in a stream, set in motion at once: its first drag, its steady wake, its hairpins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.shapes import Sphere
from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.routes import Routes
from pmesh.cases.sphere_laws import axis_velocity, published, stokes_drag
from pmesh.run.summary import Metric
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

Values = NDArray[np.float64]
TILT, ONSET = 211.0, 272.0  # Reynolds numbers from which the wake has a side, and sheds
FORCE = 8 / math.pi  # coefficients are forces over rho U^2 / 2 times pi D^2 / 4
SHORT = 0.1  # T up to which inertia changes the drag by 1 to 2 %: see `stokes_drag`
LAYER = 0.6  # sqrt(nu t) over the spacing, from where a boundary layer can be seen
STEPS = 2  # of the start, which blur the impulse that set it in motion
LATE = 0.8  # part of a run after which a steady one is steady
FEWEST = 3  # steps from which a mean is told
SHEDS, SURE = 30.0, 0.01  # T after which the mean drag is judged if it is that certain
PLACE, SIZE = 1.1, 0.2  # of the eddy that starts shedding: behind the centre, its core [D]
BASSET = "unsteady Stokes flow, Basset 1888"


class Drag(NamedTuple):
    """Drag coefficients over T = U t / D; each is the mean over a step that begins and ends."""

    begin: Values
    end: Values
    momentum: Values  # of the penalisation
    impulse: Values  # of the vorticity

    @property
    def time(self) -> Values:
        """Middles of the steps."""
        return 0.5 * (self.begin + self.end)


@dataclass(frozen=True, kw_only=True)
class SphereCase(Case):
    """A sphere in a stream, set in motion at once: steady wake (Re < 211), or hairpins (Re > 272).

    Lengths in diameters, velocities in the free stream's. The first drag is that of unsteady
    Stokes flow. Above Re = 211 an eddy of transverse impulse ``kick`` starts behind the sphere, so
    that the wake need not wait for round-off to lose its axis; the plane z = 0 stays one of
    symmetry. The wake leaves through the end of a window.
    """

    until: float = option(15.0, "end of the run, T = U t / D", unit="D/U")
    reynolds: float = option(100.0, "Reynolds number U D / nu, from 20 to 400")
    nodes: int = option(20, "mesh nodes per diameter")
    ahead: float = option(1.4, "window ahead of the sphere's centre", unit="D")
    beside: float = option(1.6, "window to each side", unit="D")
    behind: float = option(5.0, "window behind", unit="D")
    fade: float = option(0.4, "width of the zone where vorticity fades", unit="D")
    kick: float | None = option(
        None, "impulse of the eddy that starts shedding; 0.1, and 0 at Re < 211", unit="U D^3"
    )
    deformation: float = option(0.25, "largest dt * max|grad u|")
    stretching: str = option(
        "classical", "form of the stretching; both are stable, this one carries divergence off",
        choices=("classical", "conservative"),
    )  # fmt: skip
    kernel: str = option("M6'", "remeshing kernel")
    tolerance: float = option(1e-4, "slip residual of the penalisation", unit="U")
    every: float = option(5.0, "largest time between snapshots, one at the end", unit="D/U")
    dtype: str = option("float64", "precision of the fields", choices=("float64", "float32"))

    title: ClassVar[str] = "Sphere in a stream"
    source: ClassVar[str] = "Basset 1888; Johnson & Patel 1999"
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {
        "nodes": 22, "until": 0.1, "ahead": 0.9, "beside": 0.9, "behind": 1.2, "fade": 0.3,
        "every": 0.1,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what is outside the case, a body of too few nodes and a window without room."""
        super().__post_init__()
        self.require(20 <= self.reynolds <= 400, "reynolds", "between 20 and 400")
        self.require(self.nodes >= 10, "nodes", "at least 10 per diameter")
        self.positive("fade", "deformation", "tolerance", "every")
        for name in ("ahead", "beside", "behind"):
            least = 0.6 + self.fade
            self.require(least <= getattr(self, name) <= 100, name, f"from {least:g} to 100")
        little = self.kick is None or abs(self.kick) <= 1
        self.require(little, "kick", "at most 1", "--kick 0.1")

    @property
    def sheds(self) -> bool:
        """Whether the wake sheds vortices."""
        return self.reynolds > ONSET

    @property
    def impulse(self) -> float:
        """Transverse impulse of the eddy at the start [U D^3]."""
        return self.kick if self.kick is not None else 0.1 * (self.reynolds > TILT)

    def eddy(self, points: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
        """Vorticity of the eddy at points (3, ...): the curl of a Gaussian impulse along y."""
        x, y, z = points[0] - PLACE, points[1], points[2]
        peak = np.exp(-(x**2 + y**2 + z**2) / (2 * SIZE**2)) / (2 * math.pi * SIZE**2) ** 1.5
        scale = self.impulse * peak / SIZE**2
        return np.stack([z * scale, np.zeros_like(scale), -x * scale])

    def recipe(self) -> Any:
        """The flow on a box around body and eddy, as wide as the window; it grows behind."""
        from pmesh.bodies.body import RigidBody
        from pmesh.bodies.penalise import Penalisation
        from pmesh.vortex.flow import VortexFlow
        from pmesh.vortex.window import Window

        h = 1.0 / self.nodes
        back = min(self.behind, PLACE + 6 * SIZE if self.impulse else self.ahead)
        side, ahead, behind = (_cells(reach, h) for reach in (self.beside, self.ahead, back))
        grid = Grid(
            (ahead + behind, 2 * side, 2 * side),
            h,
            ((0.5 - ahead) * h, (0.5 - side) * h, (0.5 - side) * h),
        )
        return VortexFlow(
            grid=grid,
            viscosity=1.0 / self.reynolds,
            freestream=(1.0, 0.0, 0.0),
            bodies=(RigidBody(Sphere(radius=0.5)),),
            deformation=self.deformation,
            kernel=self.kernel,
            stretching=self.stretching,  # type: ignore[arg-type]  # one of its choices
            domain="follow",
            penalisation=Penalisation(tolerance=self.tolerance),
            window=Window(
                lower=(self.ahead, self.beside, self.beside),
                upper=(self.behind, self.beside, self.beside),
                fade=self.fade,
            ),
            dtype=self.dtype,  # type: ignore[arg-type]  # one of its choices
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and its impulsive start."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.eddy if self.impulse else None)

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger and snapshots."""
        from pmesh.run.snapshots import Snapshots

        even = self.until / math.ceil(self.until / self.every - 1e-9)
        return [*super().watchers(), Snapshots(even, dtype="float32")]

    def drag(self, outcome: Outcome) -> Drag:
        """Drag coefficients of a run."""
        series = {name: np.asarray(column)[1:] for name, column in outcome.series.items()}
        end = np.asarray(series["time"], np.float64)
        momentum, impulse = (FORCE * series[f"{r}_force_x"] for r in ("body0", "impulse"))
        return Drag(end - series["dt"], end, momentum, impulse)

    def routes(self, outcome: Outcome) -> Routes:
        """Drag and side force along y by every route, as coefficients."""
        return Routes.of(outcome.series, scale=FORCE)

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """First drag beside the exact law; steady drag or cycles beside published ones; routes."""
        routes = self.routes(outcome)
        found = self._at_first(self.drag(outcome))
        found += self._shedding(routes) if self.sheds else self._steady(routes, outcome)
        series = outcome.series
        residual = float(np.nanmax(series["slip_residual"][1:]))
        return [
            *found,
            *self._symmetry(series),
            Metric("slip residual, largest", residual, 0.0, self.tolerance, kind="absolute"),
            Metric("slip at the end, rms", float(series["slip"][-1]), kind="report"),
            Metric("divergence of the vorticity, relative", float(series["divergence"][-1]),
                   kind="report"),
        ]  # fmt: skip

    def _at_first(self, drag: Drag) -> list[Metric]:
        """Largest deviation from the law of unsteady Stokes flow, once the mesh sees the layer."""
        within = self.early(drag)
        if not within.any():
            return []
        law = stokes_drag(self.reynolds, drag.begin[within], drag.end[within])
        off = float(np.abs(drag.momentum[within] / law - 1.0).max())
        name = f"drag off the first law, {drag.begin[within][0]:.3f} < T < {SHORT}"
        return [Metric(name, off, 0.0, 0.05, "A", BASSET, "absolute")]

    def early(self, drag: Drag) -> NDArray[np.bool_]:
        """Steps that are compared with the law: after the start, before inertia counts."""
        seen = LAYER**2 * self.reynolds / self.nodes**2
        after = (drag.time > seen) & (np.arange(drag.time.size) >= STEPS)
        return np.asarray(after & (drag.end <= SHORT))

    def _steady(self, routes: Routes, outcome: Outcome) -> list[Metric]:
        """Drag and recirculation at the end, and what is still changing."""
        time, drag = routes.time, routes.of_main("drag")
        late = time > LATE * self.until
        if late.sum() < FEWEST:
            return []
        mean = float(np.average(drag[late], weights=routes.dt[late]))
        slope = float(np.polyfit(time[late], drag[late], 1)[0]) * (1 - LATE) * self.until / mean
        return [
            self._beside("drag", mean, judged=abs(slope) < 0.01),
            Metric(f"drag's change over the last {1 - LATE:.0%}", slope, kind="report"),
            Metric("recirculation length / D", self.recirculation(outcome), kind="report"),
            *routes.apart("drag", late, 0.0),
        ]

    def _shedding(self, routes: Routes) -> list[Metric]:
        """The numbers of whole cycles; reports only while they still change."""
        try:
            lift, drag = routes.statistics("lift"), routes.statistics("drag")
        except InputError:  # a run of a few steps
            return []
        cycle = lift.cycle
        # eddies cut at the window's end show in single values of the impulse's route
        span = (0.5 * self.until, self.until) if cycle is None else (cycle.start, cycle.end)
        apart = routes.means_apart(span, 0.0)
        if cycle is None:
            sure = drag.mean.uncertainty < SURE * drag.mean.value
            return [
                self._beside("drag", drag.mean.value, judged=sure and span[0] >= SHEDS),
                Metric(f"mean side force ({lift.note})", abs(lift.mean.value), kind="report"),
                *self._frequency(routes, span[0]),
                *apart,
            ]
        return [
            self._beside("drag", routes.mean("drag", cycle)),
            self._beside("lift", abs(cycle.mean.value), judged=False),
            self._beside("strouhal", cycle.frequency.value, judged=False),
            Metric("side force, amplitude", cycle.amplitude.value, kind="report"),
            Metric("Strouhal number, uncertainty", cycle.frequency.uncertainty, kind="report"),
            Metric("whole cycles", float(cycle.cycles), kind="report"),
            *apart,
        ]

    def _frequency(self, routes: Routes, after: float) -> list[Metric]:
        """Where the spectrum of the side force has its peak, for want of whole cycles."""
        from pmesh.run.statistics import spectrum

        if after < SHEDS:
            return []
        peak = spectrum(routes.time_end, routes.of_main("lift"), routes.dt, after=after).peak()
        return [
            self._beside("strouhal", peak.value, judged=False),
            Metric("Strouhal number, uncertainty", peak.uncertainty, kind="report"),
        ]

    def _symmetry(self, series: Mapping[str, NDArray[Any]]) -> list[Metric]:
        """Side forces and torques that symmetry forbids: all, or those out of the eddy's plane."""
        names = ["force_z", "torque_x", "torque_y"]
        kind = "on the plane z = 0"
        if not self.impulse:
            names, kind = [*names, "force_y", "torque_z"], "about the axis"
        columns = np.abs([FORCE * series[f"body0_{name}"][1:] for name in names])
        judged = bool(self.impulse) or self.reynolds < TILT
        return [
            Metric(f"what symmetry {kind} forbids, largest", float(columns.max()), 0.0, 1e-3,
                   kind="absolute" if judged else "report")
        ]  # fmt: skip

    def recirculation(self, outcome: Outcome) -> float:
        """Length of the recirculation behind the sphere at the end [D]; NaN without one."""
        x, speed = axis_velocity(outcome.flow.velocity(outcome.state), outcome.state.grid)
        back = np.flatnonzero((x[:-1] > 0.5) & (speed[:-1] < 0) & (speed[1:] >= 0))
        if not back.size:
            return math.nan
        i = int(back[-1])
        return float(x[i] - speed[i] * (x[i + 1] - x[i]) / (speed[i + 1] - speed[i]) - 0.5)

    def _beside(self, quantity: str, value: float, *, judged: bool = True) -> Metric:
        """A number beside the published one, if there is one."""
        name = NAMES[quantity]
        known = published(self.reynolds).get(quantity)
        if known is None:
            return Metric(name, value, kind="report")
        return Metric(
            name, value, known.value, known.tolerance, known.grade, known.source,
            "relative" if judged else "report",
        )  # fmt: skip

    def draw(self, outcome: Outcome) -> Figure:
        """Drag beside laws and published means, first drag or side forces; the vortices, a cut."""
        from pmesh.cases.sphere_figure import sphere_figure

        return sphere_figure(self, outcome)


NAMES = {"drag": "mean drag", "lift": "mean side force", "strouhal": "Strouhal number"}


def _cells(reach: float, spacing: float) -> int:
    """Whole cells in a reach, a multiple of 4."""
    return 4 * math.ceil(reach / spacing / 4 - 1e-9)
