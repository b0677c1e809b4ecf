"""The self-propelled anguilliform swimmer of Kern & Koumoutsakos (2006), in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.swimming import AHEAD, FADE, KERN, VISCOSITY, WAVES, Swimming, draw_ways
from pmesh.cases.track import Track, efficiency
from pmesh.run.rundir import CASE, SERIES
from pmesh.run.series import read_series
from pmesh.run.summary import Metric
from remesh.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.bodies.swimmer import Swimmer
    from pmesh.run.protocols import Watcher
    from pmesh.vortex.window import Window

Values = NDArray[np.float64]
NAME = "swimmer-3d"
PUBLISHED = 0.40  # [L/T], of Carling's swimmer in space at this viscosity
SETTLED = 5.0  # periods from which the speed is compared
THINNEST = 4.0  # spacings across its widest place, where it is twice as tall


@dataclass(frozen=True, kw_only=True)
class SwimmerInSpace(Swimming):
    """A swimmer with elliptic sections starts from rest: its speed, its wake of rings.

    Lengths in body lengths L, times in periods T of the wave. It swims towards -x and bends in
    the plane z = 0. A wall that the mesh smears is drawn in, and a tail of few spacings would
    vanish: it is held harder, and drawn and felt sharper, than swimmers in the plane.
    """

    until: float = option(5.0, "end of the run; the last two periods are counted", unit="T")
    nodes: int = option(64, "mesh nodes per body length")
    gait: Literal["carling", "anguilliform"] = option("carling", "how it bends")
    strength: float | None = option(1e4, "penalisation lambda h^2 / nu")
    width: float | None = option(1.0, "half width of the body's indicator", unit="h")
    radius: float = option(1.5, "of the regularisation of the velocity", unit="h")
    tolerance: float = option(1e-4, "slip residual of the penalisation")
    every: float = option(0.5, "time between snapshots", unit="T")
    dtype: Literal["float32", "float64"] = option("float32", "precision of the fields")
    planar: bool = option(True, "stays in its plane, as symmetry asks; if false all of it is free")
    projection: int = option(0, "steps between projections of the vorticity; 0: never")
    beside: str = option("", "folder of a run with other nodes, to extrapolate the speed with")

    title: ClassVar[str] = "Swimmer in space"
    source: ClassVar[str] = KERN
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 52, "until": 0.12, "every": 0.06}
    fewest: ClassVar[int] = 52
    room: ClassVar[float] = 0.12

    def __post_init__(self) -> None:
        """Refuse projections that are none."""
        super().__post_init__()
        self.positive("radius")
        self.require(self.projection >= 0, "projection", "a number of steps, or 0")

    @property
    def known(self) -> bool:
        """Whether the speed of this swimmer is published."""
        return self.gait == "carling" and self.viscosity == VISCOSITY

    def recipe(self) -> Any:
        """The flow around the swimmer; its mesh grows with the wake."""
        from pmesh.bodies.motion import Free

        motion = Free(density=1.0, locked=("z", "turn_x", "turn_y") if self.planar else ())
        body = self.swimmer(ndim=3, motion=motion)
        return self.flow((body,), dtype=self.dtype, radius=self.radius, projection=self.projection)

    def held(self, **more: Any) -> Any:
        """How the fluid is held to the body; of a coarse mesh too."""
        return super().held(thinnest=THINNEST, **more)

    def build(self) -> tuple[Any, Any]:
        """The swimmer at rest, in fluid at rest."""
        if self.beside:
            Other.read(self.beside, self.nodes)
        flow = self.recipe()
        return flow, flow.start()

    def window(self, bodies: Sequence[Swimmer]) -> Window | None:
        """The part of space that is kept, if the wake may leave; its momentum is nearly none."""
        if self.wake is None:
            return None
        from pmesh.vortex.window import Window

        upper = (max(AHEAD, self.wake), AHEAD, AHEAD)
        return Window(lower=(AHEAD,) * 3, upper=upper, fade=FADE, wake=False)

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots

        fields = ("vorticity", "chi")
        return [*super().watchers(), Snapshots(self.every, fields=fields, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed beside the published one, what swimming costs, momenta, symmetry, the slip."""
        track, (first, last) = Track.read(outcome.series), self.counted
        body = outcome.flow.bodies[0]
        direction, speed = track.way(first, last)
        work = float(track.integral(track.power, first, last)) / (last - first)
        lateral = track.lateral(first, last, direction)
        divergence = float(np.max(outcome.series["divergence"]))
        return [
            self._speed(f"mean speed, t = {first:g} to {last:g}", speed),
            *self._extrapolated(track),
            Metric("lateral velocity, amplitude", lateral, kind="report"),
            Metric("drift to the side, of the way", abs(float(direction[1])), kind="report"),
            Metric("power, L^5/T^3", work, kind="report"),
            Metric("efficiency", efficiency(body.measure.volume, speed, work), kind="report"),
            self._symmetry(track),
            *self.deformation_metrics(outcome, track),
            *self.balance_metrics(outcome, track, 0.02),
            *self.slip_metrics(outcome, track),
            Metric("divergence of the vorticity, largest", divergence, kind="report"),
        ]

    def _speed(self, name: str, speed: float) -> Metric:
        """The speed beside the published one, where that is meant: of it no more is known."""
        if not self.known or self.until < SETTLED:
            return Metric(name, speed, kind="report")
        return Metric(name, speed, PUBLISHED, 0.1, "C", KERN, "report")

    def _extrapolated(self, track: Track) -> list[Metric]:
        """Speed of the run beside this one over the same time, and in the limit of no spacing."""
        if not self.beside:
            return []
        other, (first, last) = Other.read(self.beside, self.nodes), self.counted
        end = min(last, float(other.track.time[-1]))
        first = end - (last - first)
        speeds = [one.way(first, end)[1] for one in (track, other.track)]
        limit = extrapolated((self.nodes, other.nodes), (speeds[0], speeds[1]))
        span = f"t = {first:g} to {end:g}"
        return [
            Metric(f"mean speed with {other.nodes} nodes, {span}", speeds[1], kind="report"),
            self._speed(f"mean speed in the limit of no spacing, {span}", limit),
        ]

    def _symmetry(self, track: Track) -> Metric:
        """What leaves the plane in which it bends: its velocity, or the force that holds it there.

        The flow is symmetric, so that both are zero, to the solver's tolerance.
        """
        if not self.planar:
            out = float(np.abs(track.velocity[:, 2]).max())
            return Metric("speed out of its plane, L/T", out, 0.0, 1e-3, kind="absolute")
        sizes = np.linalg.norm(track.force[:, :2], axis=1)
        part = float(np.abs(track.force[:, 2]).max() / (sizes.max() or 1.0))
        return Metric("force out of its plane, of that in it", part, 0.0, 1e-3, kind="absolute")

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Velocities over the published speed, the way, vortices at two times, a cut."""
        from matplotlib.figure import Figure

        from pmesh.cases.swimmer_picture import draw_cut, draw_vortices

        track = Track.read(outcome.series)
        figure = Figure(figsize=(9.6, 8.6), layout="constrained")
        panels = figure.add_gridspec(3, 1, height_ratios=(2.5, 3.1, 2.6))
        top = panels[0].subgridspec(1, 2, width_ratios=(1.6, 1.0))
        speeds, way = figure.add_subplot(top[0]), figure.add_subplot(top[1])
        self._draw_speeds(speeds, track)
        draw_ways(way, [track])
        shots = outcome.stages([0.5 * self.until, self.until])
        middle = panels[1].subgridspec(1, len(shots))
        seen = [figure.add_subplot(middle[number]) for number in range(len(shots))]
        body = outcome.flow.bodies[0]
        draw_vortices(seen, shots, body, track)
        cut = figure.add_subplot(panels[2])
        draw_cut(cut, shots[-1], body, track)
        name_panels([speeds, way, *seen, cut])
        figure.suptitle(
            rf"Self-propelled swimmer in space, {WAVES[self.gait]}, "
            rf"$L^2/\nu T$ = {1 / self.viscosity:.0f}: {self.nodes} nodes per length",
            fontsize=11,
        )
        return figure

    def _draw_speeds(self, panel: Axes, track: Track) -> None:
        """Velocity along -x and to the side; of the run beside this one too."""
        if self.beside:
            other = Other.read(self.beside, self.nodes)
            late = other.track.time <= self.until
            told = f"forwards, {other.nodes} nodes"
            panel.plot(
                other.track.time[late], -other.track.velocity[late, 0], color=OTHERS[2], lw=1.2,
                label=told,
            )  # fmt: skip
        panel.plot(track.time, -track.velocity[:, 0], color=OURS, label="forwards")
        panel.plot(track.time, track.velocity[:, 1], color=OTHERS[0], lw=1.2, label="to the side")
        if self.known:
            panel.axhline(PUBLISHED, color=REFERENCE, ls="--", lw=1.2, label=KERN)
            panel.axhspan(0.9 * PUBLISHED, 1.1 * PUBLISHED, color=REFERENCE, alpha=0.12, lw=0)
        panel.set(xlim=(0, self.until), xlabel="$t / T$", ylabel="velocity $[L/T]$")
        panel.set_title("velocity of the centre of mass")
        panel.legend(loc="best")


@dataclass(frozen=True)
class Other:
    """A run of this case with other nodes."""

    nodes: int
    track: Track

    @classmethod
    def read(cls, folder: str, nodes: int) -> Other:
        """The run in a folder; refuses what is no run of this case with other nodes."""
        from pmesh.cases.runner import read_case

        hint = f"pmesh run {NAME} --nodes {nodes + 32}, and the folder that it wrote"
        name, values = read_case(Path(folder) / CASE)
        other = values.get("nodes")
        if name != NAME or not isinstance(other, int) or other == nodes:
            raise InputError(
                f"{folder} must hold a run of {NAME} with other nodes than {nodes}, it holds one "
                f"of {name} with {other}",
                hint=hint,
            )
        return cls(other, Track.read(read_series(Path(folder) / SERIES)))


def extrapolated(nodes: tuple[int, int], values: tuple[float, float]) -> float:
    """The limit of no spacing of a value that converges with first order, from two runs.

    ``nodes`` per length: u(h) = u + c h. So the speed does in the plane, see docs/swimmers.md.
    """
    (n, m), (one, other) = nodes, values
    return (n * one - m * other) / (n - m)
