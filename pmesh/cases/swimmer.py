"""The self-propelled anguilliform swimmer of Kern & Koumoutsakos (2006), in the plane."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from pmesh.cases.case import Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.swimming import (
    COUNTED,
    KERN,
    VISCOSITY,
    WAVES,
    Stages,
    Swimming,
    draw_wake,
    draw_ways,
)
from pmesh.cases.track import Track, disagreement, efficiency
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.bodies.motion import Motion
    from pmesh.run.protocols import Watcher

PUBLISHED = 0.54  # [L/T], of Carling's swimmer at this viscosity, +-0.04
FINE = 256  # nodes per length from which it is judged; a box sees too little of a coarser wake
SETTLED = 6.0  # periods before those that are counted as steady
HELD = {  # the titles of figures
    "free": "Self-propelled swimmer",
    "tethered": "Swimmer held along x",
    "fixed": "Swimmer held in place",
}


@dataclass(frozen=True, kw_only=True)
class SwimmerCase(Swimming):
    """A swimmer starts from rest and goes where the fluid lets it: its speed and its wake.

    Lengths in body lengths L, times in periods T of the wave.
    """

    heading: float = option(0.0, "turned by; at 0 it swims towards -x", unit="degrees")
    mirrored: bool = option(False, "bends to the other side: half a period later in its wave")
    tether: Literal["free", "tethered", "fixed"] = option(
        "free", "what holds it: nothing, its way along x, or all of it"
    )
    routes: int = option(5, "steps between forces from the momentum through a box")

    title: ClassVar[str] = "Swimmer"
    source: ClassVar[str] = KERN
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 112, "until": 1.5}

    def __post_init__(self) -> None:
        """Refuse a tether across its way."""
        super().__post_init__()
        self.require(self.routes >= 1, "routes", "a number of steps")
        along = self.tether != "tethered" or self.heading % 180 == 0
        self.require(along, "heading", "along x for a tethered swimmer", "--heading 0")

    @property
    def known(self) -> bool:
        """Whether the speed of this swimmer is published."""
        return self.gait == "carling" and self.viscosity == VISCOSITY and self.tether == "free"

    def motion(self) -> Motion:
        """How it is held."""
        from pmesh.bodies.motion import Fixed, Free

        if self.tether == "fixed":
            return Fixed()
        return Free(density=1.0, locked=("x",) if self.tether == "tethered" else ())

    def recipe(self) -> Any:
        """The flow around the swimmer; its mesh grows with the wake."""
        phase = 0.5 if self.mirrored else 0.0
        heading = math.radians(self.heading)
        body = self.swimmer(phase=phase, heading=heading, motion=self.motion())
        return self.flow((body,))

    def build(self) -> tuple[Any, Any]:
        """The swimmer at rest, in fluid at rest."""
        flow = self.recipe()
        return flow, flow.start()

    def watchers(self) -> Sequence[Watcher]:
        """Forces, also from a control volume, the ledger and snapshots."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Forces, Ledger

        return [Forces(routes=self.routes), Ledger(), Snapshots(self.every, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed beside the published one, what swimming costs, momenta, the slip."""
        track = Track.read(outcome.series)
        body = outcome.flow.bodies[0]
        free = self.tether == "free"
        return [
            *self._swimming(track, body.measure.volume),
            *(self.deformation_metrics(outcome, track) if free else []),
            *self._balance(outcome, track),
            *self.slip_metrics(outcome, track),
        ]

    def _swimming(self, track: Track, mass: float) -> list[Metric]:
        """Speed, lateral velocity, power and efficiency over the counted periods."""
        first, last = self.counted
        work = float(track.integral(track.power, first, last)) / (last - first)
        pull = track.integral(track.force, first, last) / (last - first)
        pulls = [
            Metric(f"mean force along {axis}, L^3/T^2", float(value), kind="report")
            for axis, value in zip("xy", pull, strict=True)
        ]
        if self.tether == "fixed":
            return [Metric("power, L^4/T^3", work, kind="report"), *pulls]
        direction, speed = track.way(first, last)
        if self.tether == "tethered":
            direction = np.array([1.0, 0.0])
        found = [
            self._speed(f"mean speed, t = {first:g} to {last:g}", speed),
            Metric(
                "lateral velocity, amplitude", track.lateral(first, last, direction), kind="report"
            ),
            Metric("power, L^4/T^3", work, kind="report"),
        ]
        if self.tether == "tethered":
            return [*found[1:], pulls[0]]
        return [*found, Metric("efficiency", efficiency(mass, speed, work), kind="report")]

    def _speed(self, name: str, speed: float) -> Metric:
        """The speed beside the published one where that is meant, judged on a fine mesh."""
        if not self.known or self.until < SETTLED + COUNTED:
            return Metric(name, speed, kind="report")
        kind: Literal["relative", "report"] = "relative" if self.nodes >= FINE else "report"
        return Metric(name, speed, PUBLISHED, 0.1, "C", KERN, kind)

    def _balance(self, outcome: Outcome, track: Track) -> list[Metric]:
        """Momentum that body and fluid gained together over the last period."""
        if self.tether != "free" or self.until < 1.0:
            return []
        last = self.until - 1.0, self.until
        found = self.balance_metrics(outcome, track, 0.01)
        passed = np.stack([outcome.series[f"body0_flux_force_{axis}"] for axis in "xy"], axis=1)
        apart = disagreement(track, passed, *last)
        if apart is not None:
            name = "body's momentum and what passed a box, over a period"
            kind: Literal["absolute", "report"] = "absolute" if self.nodes >= FINE else "report"
            found.append(Metric(name, apart, 0.0, 0.01, kind=kind))
        return found

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Velocities over the published speed and the way, or forces and power; the wake."""
        from matplotlib.figure import Figure

        track = Track.read(outcome.series)
        stages = Stages.of(outcome, [0.25 * self.until, 0.5 * self.until, self.until])
        figure = Figure(figsize=(9.6, 2.8 + stages.height), layout="constrained")
        ratios = (2.8, stages.height)
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=ratios).ravel()
        left, right = top.subplots(1, 2, width_ratios=(1.6, 1.0))
        if self.tether == "fixed":
            self._draw_loads(left, right, track)
        else:
            self._draw_speeds(left, track)
            draw_ways(right, [track])
        fields = draw_wake(below, stages, [(outcome.flow.bodies[0], track)])
        name_panels([left, right, *fields])
        figure.suptitle(
            rf"{HELD[self.tether]}, {WAVES[self.gait]}, $L^2/\nu T$ = {1 / self.viscosity:.0f}: "
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
        if self.known:
            panel.axhline(PUBLISHED, color=REFERENCE, ls="--", lw=1.2, label=KERN)
            panel.axhspan(0.9 * PUBLISHED, 1.1 * PUBLISHED, color=REFERENCE, alpha=0.12, lw=0)
        panel.set(xlim=(0, self.until), xlabel="$t / T$", ylabel="velocity $[L/T]$")
        panel.set_title("velocity of the centre of mass")
        panel.legend(loc="best")

    def _draw_loads(self, panel: Axes, other: Axes, track: Track) -> None:
        """Forces of the fluid and the power it takes, means over the steps at their middles."""
        first, last = self.counted
        middle = (track.time - 0.5 * track.dt)[1:]
        for axis, colour, force in zip("xy", (OURS, OTHERS[0]), track.force[1:].T, strict=True):
            panel.plot(middle, force, color=colour, lw=1.2, label=f"along {axis}")
        other.plot(middle, track.power[1:], color=OURS, lw=1.2)
        late = track.within(max(first, 0.02 * last), last)
        for one, values in ((panel, track.force[late]), (other, track.power[late])):
            room = 0.1 * float(np.ptp(values)) or 1.0
            one.set(ylim=(float(values.min()) - room, float(values.max()) + room))
            one.set(xlim=(0, self.until), xlabel="$t / T$")
        panel.set(ylabel="force $[L^3/T^2]$", title="force of the fluid")
        other.set(ylabel="power $[L^4/T^3]$", title="power given to the fluid")
        panel.legend(loc="best")
