"""What the swimmers' cases share: their options, the flow around them, pictures of their wake."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS
from pmesh.cases.track import Track, deformation_drift, imbalance
from pmesh.cases.wake import Window as Part
from pmesh.cases.wake import colour_limit, draw_vorticity, frame, plane, window
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

    from pmesh.bodies.body import Body
    from pmesh.bodies.penalise import Penalisation
    from pmesh.bodies.swimmer import Swimmer
    from pmesh.run.snapshots import Snapshot
    from pmesh.vortex.flow import VortexFlow
    from pmesh.vortex.window import Window

Values = NDArray[np.float64]
KERN = "Kern & Koumoutsakos 2006"
VISCOSITY = 1.4e-4  # [L^2/T] of the published swimmer: L^2/(nu T) = 7143
RAMP = 1.0  # periods over which the wave starts
COUNTED = 2.0  # periods at the end that means are taken over
ROOM = 0.2  # [L] of mesh around the bodies at the start
FEWEST = 104  # nodes per length at which the body is the eight spacings thick it has to be
AHEAD = 2.5  # [L] of mesh before and beside the bodies, where a window cuts the wake
FADE = 0.5  # [L] over which it fades
WAVES = {  # the gaits in words
    "carling": "Carling's wave",
    "anguilliform": "anguilliform wave",
    "carangiform": "carangiform wave",
}
PAGE, TALL = 8.6, 6.0  # width and height of pictures of a wake [inches]


@dataclass(frozen=True, kw_only=True)
class Swimming(Case):
    """Base of the cases with swimmers: body lengths L, periods T of the wave."""

    until: float = option(8.0, "end of the run; the last two periods are counted", unit="T")
    nodes: int = option(256, "mesh nodes per body length")
    gait: Literal["carling", "anguilliform", "carangiform"] = option("carling", "how it bends")
    viscosity: float = option(VISCOSITY, "kinematic viscosity", unit="L^2/T")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    kernel: str = option("M6'", "remeshing kernel")
    strength: float | None = option(
        None, "penalisation lambda h^2 / nu; the flow's default if not given"
    )
    width: float | None = option(None, "half width of the bodies' indicator; likewise", unit="h")
    tolerance: float = option(1e-5, "slip residual of the penalisation")
    wake: float | None = option(None, "wake that is kept; all of it if not given", unit="L")
    every: float = option(0.25, "time between snapshots", unit="T")

    fewest: ClassVar[int] = FEWEST  # nodes per length
    room: ClassVar[float] = ROOM  # [L] of mesh around the bodies at the start

    def __post_init__(self) -> None:
        """Refuse bodies of too few nodes, and a window that holds no wake."""
        super().__post_init__()
        self.require(self.nodes >= self.fewest, "nodes", f"at least {self.fewest} per length")
        self.positive("viscosity", "deformation", "strength", "width", "tolerance", "every")
        enough = self.wake is None or self.wake > FADE + 0.5
        self.require(enough, "wake", f"more than {FADE + 0.5:g} lengths", "--wake 3")

    @property
    def spacing(self) -> float:
        """Mesh spacing [L]."""
        return 1.0 / self.nodes

    @property
    def counted(self) -> tuple[float, float]:
        """First and last of the whole periods that means are taken over; one in a short run."""
        length = COUNTED if self.until >= RAMP + COUNTED else 1.0
        return max(self.until - length, 0.0), self.until

    def swimmer(self, **more: Any) -> Swimmer:
        """A swimmer of this gait: see `Swimmer.carling`."""
        from pmesh.bodies.swimmer import Swimmer

        make = {
            "carling": Swimmer.carling,
            "anguilliform": Swimmer.anguilliform,
            "carangiform": Swimmer.carangiform,
        }[self.gait]
        return make(start=RAMP, **more)

    def flow(self, bodies: tuple[Swimmer, ...], **more: Any) -> VortexFlow:
        """The flow on a mesh just larger than the bodies; it grows with the wake."""
        from pmesh.vortex.flow import VortexFlow

        return VortexFlow(
            grid=start_grid(bodies, self.spacing, self.room),
            viscosity=self.viscosity,
            bodies=bodies,
            deformation=self.deformation,
            kernel=self.kernel,
            domain="follow",
            window=self.window(bodies),
            penalisation=self.held(),
            **more,
        )

    def held(self, **more: Any) -> Penalisation:
        """How the fluid is held to the bodies."""
        from pmesh.bodies.penalise import Penalisation

        usual = Penalisation()
        return Penalisation(
            strength=self.strength or usual.strength,
            width=self.width or usual.width,
            tolerance=self.tolerance,
            **more,
        )

    def deformation_metrics(self, outcome: Outcome, track: Track) -> list[Metric]:
        """Momentum of the deformation on the mesh, largest over the counted periods."""
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

    def balance_metrics(self, outcome: Outcome, track: Track, allowed: float) -> list[Metric]:
        """Momentum that body and fluid gained together over the last period, all wake kept."""
        if self.wake is not None or self.until < 1.0:
            return []
        axes = "xyz"[: track.place.shape[1]]
        impulse = np.stack([outcome.series[f"impulse_{axis}"] for axis in axes], axis=1)
        part = imbalance(track, impulse, self.until - 1.0, self.until)
        name = "momentum of body and fluid, change over a period"
        return [Metric(name, part, 0.0, allowed, kind="absolute")]

    def slip_metrics(self, outcome: Outcome, track: Track) -> list[Metric]:
        """How well the bodies hold the fluid."""
        residual = float(np.nanmax(outcome.series["slip_residual"][1:]))
        slip = float(np.max(outcome.series["slip"][track.within(*self.counted)]))
        return [
            Metric("slip residual, largest", residual, 0.0, self.tolerance, kind="absolute"),
            Metric("slip, rms, in L/T", slip, kind="report"),
        ]

    def window(self, bodies: Sequence[Swimmer]) -> Window | None:
        """The part of space that is kept, if the wake may leave. Its momentum is nearly none."""
        if self.wake is None:
            return None
        from pmesh.vortex.window import Window

        places = np.array([body.position for body in bodies])
        spread = 0.5 * np.ptp(places, axis=0)
        heading = bodies[0].heading
        back = self.wake * np.array([math.cos(heading), math.sin(heading)])
        lower = np.maximum(AHEAD, -back) + spread
        upper = np.maximum(AHEAD, back) + spread
        return Window(
            lower=(float(lower[0]), float(lower[1])),
            upper=(float(upper[0]), float(upper[1])),
            fade=FADE,
            wake=False,
        )


def start_grid(bodies: Sequence[Body], spacing: float, room: float = ROOM) -> Grid:
    """A mesh just larger than the bodies, with a node at the origin; ``room`` [L] around them."""
    corners = [body.bounds(body.start()) for body in bodies]
    low = np.min([lower for lower, _ in corners], axis=0) - room
    high = np.max([upper for _, upper in corners], axis=0) + room
    first = 8 * np.floor(low / (8 * spacing)).astype(int)
    last = 8 * np.ceil(high / (8 * spacing)).astype(int)
    shape = -(-(last - first) // 16) * 16
    return Grid([int(n) for n in shape], spacing, [float(x) for x in first * spacing])


def draw_ways(panel: Axes, tracks: Sequence[Track]) -> None:
    """The ways of the centres of mass, seen along z, from a ring at the start."""
    for number, track in enumerate(tracks):
        colour = (OURS, *OTHERS)[number % 4]
        panel.plot(*track.place[:, :2].T, color=colour)
        panel.plot(*track.place[0, :2], "o", color=colour, mfc="white")
    panel.set(xlabel="$x / L$", ylabel="$y / L$", title="way of the centre of mass")
    panel.set_aspect("equal", adjustable="datalim")
    panel.locator_params(axis="x", nbins=5)


class Stages(NamedTuple):
    """Snapshots to be drawn one beside the other: wide ones in rows, tall ones in columns."""

    shots: list[Snapshot]
    parts: list[Part]  # of the plane: the same along the wake, what is seen across it
    limit: float  # vorticity at which colours saturate
    tall: bool

    @classmethod
    def of(cls, outcome: Outcome, times: Sequence[float]) -> Self:
        """The snapshots closest to some times."""
        chosen = outcome.stages(times)
        limit = colour_limit(chosen)
        whole, parts = window(chosen, limit=limit), []
        tall = whole.size[1] > whole.size[0]
        for shot in chosen:
            part = window([shot], limit=limit)
            if tall:
                parts.append(part._replace(bottom=whole.bottom, top=whole.top))
            else:
                parts.append(part._replace(left=whole.left, right=whole.right))
        return cls(chosen, parts, limit, tall)

    @property
    def height(self) -> float:
        """Of the picture, as wide as a page [inches]."""
        if self.tall:
            return TALL
        rows = [part.size[1] / part.size[0] for part in self.parts]
        return min(PAGE * sum(rows) + 0.4 * len(rows) + 0.2, 2.2 * TALL)


def draw_wake(
    figure: SubFigure, stages: Stages, swimmers: Sequence[tuple[Body, Track]]
) -> list[Axes]:
    """Vorticity and bodies at some times, to one scale."""
    n, tall = len(stages.shots), stages.tall
    if tall:
        widths = [part.size[0] for part in stages.parts]
        panels = figure.subplots(1, n, sharey=True, squeeze=False, width_ratios=widths).ravel()
    else:
        heights = [part.size[1] for part in stages.parts]
        panels = figure.subplots(n, 1, sharex=True, squeeze=False, height_ratios=heights).ravel()
    for panel, shot, part in zip(panels, stages.shots, stages.parts, strict=True):
        outlines = [
            body.outlines(track.pose(track.row(shot.time)), shot.grid.spacing)[0]
            for body, track in swimmers
        ]
        draw_vorticity(panel, plane(shot, "vorticity"), shot.grid, stages.limit, outlines=outlines)
        frame(panel, part)
        panel.set(xlabel="", ylabel="$y / L$" if panel is panels[0] or not tall else "")
        panel.set_title(f"vorticity at $t$ = {shot.time:.3g}")
    for panel in panels if tall else panels[-1:]:
        panel.set_xlabel("$x / L$")
    return list(panels)
