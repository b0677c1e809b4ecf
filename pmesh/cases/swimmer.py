"""The self-propelled anguilliform swimmer of Kern & Koumoutsakos (2006), in the plane."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.swim import Track, deformation_drift, efficiency, imbalance
from pmesh.cases.wake import colour_limit, draw_vorticity, frame, plane, window
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from pmesh.bodies.motion import Motion
    from pmesh.bodies.swimmer import Swimmer
    from pmesh.run.protocols import Watcher
    from pmesh.vortex.window import Window

Values = NDArray[np.float64]
KERN = "Kern & Koumoutsakos 2006"
PUBLISHED = 0.54  # [L/T], of Carling's swimmer at nu = 1.4e-4 L^2/T, +-0.04
VISCOSITY = 1.4e-4  # [L^2/T]: L^2/(nu T) = 7143
FINE = 256  # nodes per length from which the published speed is judged
SETTLED = 6.0  # periods before the ones that are counted as steady
COUNTED = 2.0  # periods at the end that the means are taken over
RAMP = 1.0  # periods over which the wave starts
ROOM = 0.2  # [L] of mesh around the body at the start
FEWEST = 104  # nodes per length at which the body is the eight spacings thick it has to be
AHEAD = 2.5  # [L] of mesh before and beside the body, where a window cuts the wake
FADE = 0.5  # [L] over which it fades


@dataclass(frozen=True, kw_only=True)
class SwimmerCase(Case):
    """A swimmer starts from rest and goes where the fluid lets it: its speed and its wake.

    Lengths in body lengths L, times in periods T of the wave.
    """

    until: float = option(8.0, "end of the run; the last two periods are counted", unit="T")
    nodes: int = option(256, "mesh nodes per body length")
    gait: Literal["carling", "seed", "carangiform"] = option("carling", "how it bends")
    heading: float = option(0.0, "turned by; at 0 it swims towards -x", unit="degrees")
    mirrored: bool = option(False, "bends to the other side: half a period later in its wave")
    tether: Literal["free", "tethered", "fixed"] = option(
        "free", "what holds it: nothing, its way along x, or all of it"
    )
    viscosity: float = option(VISCOSITY, "kinematic viscosity", unit="L^2/T")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    kernel: str = option("M6'", "remeshing kernel")
    strength: float = option(1000.0, "penalisation lambda h^2 / nu")
    width: float = option(1.5, "half width of the body's indicator", unit="h")
    tolerance: float = option(1e-5, "slip residual of the penalisation")
    wake: float | None = option(None, "wake that is kept; all of it if not given", unit="L")
    every: float = option(0.25, "time between snapshots", unit="T")

    title: ClassVar[str] = "Self-propelled swimmer"
    source: ClassVar[str] = KERN
    short: ClassVar[Mapping[str, Any]] = {"nodes": 112, "until": 2.0}

    def __post_init__(self) -> None:
        """Refuse what makes no swimmer, and a body of too few nodes."""
        super().__post_init__()
        self.require(self.nodes >= FEWEST, "nodes", f"at least {FEWEST} per length")
        self.positive("viscosity", "deformation", "strength", "width", "tolerance", "every")
        enough = self.wake is None or self.wake > FADE + 0.5
        self.require(enough, "wake", f"more than {FADE + 0.5:g} lengths", "--wake 3")
        along = self.tether != "tethered" or self.heading % 180 == 0
        self.require(along, "heading", "along x for a tethered swimmer", "--heading 0")

    @property
    def spacing(self) -> float:
        """Mesh spacing [L]."""
        return 1.0 / self.nodes

    @property
    def judged(self) -> bool:
        """Whether the published speed is meant: its gait, viscosity and time, and a fine mesh."""
        known = self.gait == "carling" and self.viscosity == VISCOSITY and self.tether == "free"
        return known and self.nodes >= FINE and self.until >= SETTLED + COUNTED

    @property
    def counted(self) -> tuple[float, float]:
        """The whole periods at the end over which means are taken; one if there is no more."""
        length = COUNTED if self.until >= RAMP + COUNTED else 1.0
        return max(self.until - length, 0.0), self.until

    def motion(self) -> Motion:
        """How it is held."""
        from pmesh.bodies.motion import Fixed, Free

        if self.tether == "fixed":
            return Fixed()
        return Free(density=1.0, locked=("x",) if self.tether == "tethered" else ())

    def swimmers(self) -> tuple[Swimmer, ...]:
        """The swimmer."""
        from pmesh.bodies.swimmer import Swimmer

        make = {
            "carling": Swimmer.carling,
            "seed": Swimmer.seed,
            "carangiform": Swimmer.carangiform,
        }[self.gait]
        phase = 0.5 if self.mirrored else 0.0
        heading = math.radians(self.heading)
        return (make(phase=phase, start=RAMP, heading=heading, motion=self.motion()),)

    def build(self) -> tuple[Any, Any]:
        """The flow on a mesh just larger than the body; it grows with the wake."""
        from pmesh.bodies.penalise import Penalisation
        from pmesh.vortex.flow import VortexFlow

        bodies = self.swimmers()
        flow = VortexFlow(
            grid=start_grid(bodies, self.spacing),
            viscosity=self.viscosity,
            bodies=bodies,
            deformation=self.deformation,
            kernel=self.kernel,
            domain="follow",
            window=self.window(),
            penalisation=Penalisation(
                strength=self.strength, width=self.width, tolerance=self.tolerance
            ),
        )
        return flow, flow.start()

    def window(self) -> Window | None:
        """The part of space that is kept, if the wake may leave. Its momentum is nearly none."""
        if self.wake is None:
            return None
        from pmesh.vortex.window import Window

        heading = math.radians(self.heading)
        back = self.wake * np.array([math.cos(heading), math.sin(heading)])
        lower, upper = np.maximum(AHEAD, -back), np.maximum(AHEAD, back)
        return Window(
            lower=(float(lower[0]), float(lower[1])),
            upper=(float(upper[0]), float(upper[1])),
            fade=FADE,
            wake=False,
        )

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed beside the published one, what swimming costs, momenta, the slip."""
        track = Track.read(outcome.series)
        body = outcome.flow.bodies[0]
        found = [
            *self._swimming(track, body.measure.volume),
            *self._deformation(outcome, track),
            *self._balance(outcome, track),
        ]
        residual = float(np.nanmax(outcome.series["slip_residual"][1:]))
        found.append(
            Metric("slip residual, largest", residual, 0.0, self.tolerance, kind="absolute")
        )
        settled = track.within(*self.counted)
        slip = float(np.max(outcome.series["slip"][settled]))
        found.append(Metric("slip, rms, in L/T", slip, kind="report"))
        return found

    def _swimming(self, track: Track, mass: float) -> list[Metric]:
        """Speed, lateral velocity, power and efficiency over the counted periods."""
        first, last = self.counted
        work = float(track.integral(track.power, first, last)) / (last - first)
        if self.tether == "fixed":
            return [Metric("power, L^4/T^3", work, kind="report")]
        _, speed = track.way(first, last)
        known = (0.1, "C", KERN)
        kind: Literal["relative", "report"] = "relative" if self.judged else "report"
        name = f"mean speed, t = {first:g} to {last:g}"
        found = [
            Metric(name, speed, PUBLISHED if self.gait == "carling" else None, *known, kind),
            Metric("lateral velocity, amplitude", track.lateral(first, last), kind="report"),
            Metric("power, L^4/T^3", work, kind="report"),
        ]
        if self.tether == "tethered":
            pull = float(track.integral(track.force, first, last)[0]) / (last - first)
            return [*found[1:], Metric("mean force along x, L^3/T^2", pull, kind="report")]
        return [*found, Metric("efficiency", efficiency(mass, speed, work), kind="report")]

    def _deformation(self, outcome: Outcome, track: Track) -> list[Metric]:
        """Momentum of the deformation on the mesh, largest over the counted periods."""
        if self.tether != "free":
            return []
        first, last = self.counted
        rows = [track.row(time) for time in np.linspace(first, last, 9)]
        drifts = [
            deformation_drift(outcome.flow, outcome.state.grid, (track.pose(row),))[0]
            for row in rows
        ]
        linear, angular = (max(values) for values in zip(*drifts, strict=True))
        return [
            Metric("deformation's momentum on the mesh", linear, 0.0, 1e-12, kind="absolute"),
            Metric("and angular momentum", angular, 0.0, 1e-12, kind="absolute"),
        ]

    def _balance(self, outcome: Outcome, track: Track) -> list[Metric]:
        """Momentum that body and fluid lost together over the last period."""
        if self.tether != "free" or self.wake is not None or self.until < 1.0:
            return []
        impulse = np.stack([outcome.series[f"impulse_{axis}"] for axis in "xy"], axis=1)
        lost, exchanged = imbalance(track, impulse, self.until - 1.0, self.until)
        name = "momentum of body and fluid, change over a period"
        return [Metric(name, lost / exchanged, 0.0, 0.01, kind="absolute")]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Velocities over the published speed, the way, and the wake at three times."""
        from matplotlib.figure import Figure

        track = Track.read(outcome.series)
        figure = Figure(figsize=(9.6, 9.0), layout="constrained")
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 2.2)).ravel()
        speeds, way = top.subplots(1, 2, width_ratios=(1.6, 1.0))
        self._draw_speeds(speeds, track)
        draw_ways(way, [track])
        fields = draw_wake(
            below, outcome, [track], [0.25 * self.until, 0.5 * self.until, self.until]
        )
        name_panels([speeds, way, *fields])
        figure.suptitle(
            rf"{self.title}, {self.gait}, $L^2/\nu T$ = {1 / self.viscosity:.0f}: "
            f"{self.nodes} nodes per length",
            fontsize=11,
        )
        return figure

    def _draw_speeds(self, panel: Axes, track: Track) -> None:
        """Velocity along and across the mean way."""
        (x, y), _ = track.way(*self.counted)
        along, across = (track.velocity @ np.array([[x, -y], [y, x]])).T
        panel.plot(track.time, along, color=OURS, label="along its way")
        panel.plot(track.time, across, color=OTHERS[0], lw=1.2, label="across")
        if self.gait == "carling" and self.viscosity == VISCOSITY:
            panel.axhline(PUBLISHED, color=REFERENCE, ls="--", lw=1.2, label=KERN)
            panel.axhspan(0.9 * PUBLISHED, 1.1 * PUBLISHED, color=REFERENCE, alpha=0.12, lw=0)
        panel.set(xlim=(0, self.until), xlabel="$t / T$", ylabel="velocity $[L/T]$")
        panel.set_title("velocity of the centre of mass")
        panel.legend(loc="center right")


def start_grid(bodies: Sequence[Swimmer], spacing: float) -> Grid:
    """A mesh just larger than the bodies, its lattice symmetric about their place on it."""
    corners = [body.bounds(body.start()) for body in bodies]
    low = np.min([lower for lower, _ in corners], axis=0) - ROOM
    high = np.max([upper for _, upper in corners], axis=0) + ROOM
    first = 8 * np.floor(low / (8 * spacing)).astype(int)
    last = 8 * np.ceil(high / (8 * spacing)).astype(int)
    shape = -(-(last - first) // 16) * 16
    return Grid((int(shape[0]), int(shape[1])), spacing, tuple(float(x) for x in first * spacing))


def draw_ways(panel: Axes, tracks: Sequence[Track]) -> None:
    """The ways of the centres of mass."""
    for number, track in enumerate(tracks):
        colour = (OURS, *OTHERS)[number % 4]
        panel.plot(*track.place.T, color=colour)
        panel.plot(*track.place[0], "o", color=colour, mfc="white")
    panel.set(xlabel="$x / L$", ylabel="$y / L$", title="way of the centre of mass")
    panel.set_aspect("equal", adjustable="datalim")


def draw_wake(
    figure: SubFigure, outcome: Outcome, tracks: Sequence[Track], times: Sequence[float]
) -> list[Axes]:
    """Vorticity and bodies at some times, to one scale, over one part of the plane."""
    shots = outcome.snapshots()[1:]
    chosen = [min(shots, key=lambda shot: abs(shot.time - t)) for t in times]
    limit = colour_limit(chosen)
    part = window(chosen, limit=limit)
    tall = part.size[1] > part.size[0]
    rows, columns = (1, len(chosen)) if tall else (len(chosen), 1)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, shot in zip(panels, chosen, strict=True):
        outlines = [
            body.outline_points(track.pose(track.row(shot.time)))
            for body, track in zip(outcome.flow.bodies, tracks, strict=True)
        ]
        draw_vorticity(panel, plane(shot, "vorticity"), shot.grid, limit, outlines=outlines)
        frame(panel, part)
        panel.set(xlabel="", ylabel="$y / L$" if panel is panels[0] or not tall else "")
        panel.set_title(f"vorticity at $t$ = {shot.time:.3g}")
    for panel in panels if tall else panels[-1:]:
        panel.set_xlabel("$x / L$")
    return list(panels)
