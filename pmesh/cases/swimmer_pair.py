"""Two swimmers in tandem: what the wake of one does to the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, name_panels, styled
from pmesh.cases.swimming import WAVES, Stages, Swimming, draw_wake, draw_ways
from pmesh.cases.track import Track
from pmesh.cases.twins import Twins
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.bodies.body import Body
    from pmesh.run.protocols import Watcher

Values = NDArray[np.float64]
ALONE = "alone_"  # of the columns of the swimmer that has no other behind it
NAMES = ("leader", "follower", "alone")
COLOURS = (OURS, OTHERS[0], OTHERS[2])
CLOSEST = 0.05  # [L] from the tail of one to the nose of the other, at the start


@dataclass(frozen=True, kw_only=True)
class SwimmerPair(Swimming):
    """Two swimmers alike, one behind the other: their speeds beside that of one alone.

    Lengths in body lengths L, times in periods T of the wave.
    """

    distance: float = option(0.25, "from the leader's tail to the follower's nose", unit="L")
    offset: float = option(0.0, "of the follower, to the side", unit="L")
    phase: float = option(
        0.0, "how much later the follower's wave comes than the leader's", unit="T"
    )
    alone: bool = option(True, "swims the leader alone too, beside it")

    title: ClassVar[str] = "Two swimmers in tandem"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 104, "until": 1.0}

    def __post_init__(self) -> None:
        """Refuse swimmers that lie in each other."""
        super().__post_init__()
        apart = self.distance >= CLOSEST or abs(self.offset) >= 0.5
        self.require(apart, "distance", f"at least {CLOSEST:g} lengths, or the offset half of one")

    def build(self) -> tuple[Any, Any]:
        """Both at rest, in fluid at rest; and the leader in a fluid of its own."""
        leader = self.swimmer()
        place = (1.0 + self.distance, self.offset)
        pair = self.flow((leader, self.swimmer(position=place, phase=self.phase)))
        if not self.alone:
            return pair, pair.start()
        flow = Twins(first=pair, second=self.flow((leader,)), prefix=ALONE)
        return flow, flow.start()

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger and snapshots of the pair."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, dtype="float32")]

    def tracks(self, outcome: Outcome) -> dict[str, Track]:
        """The swimmers by name: leader, follower, and alone if it swam."""
        found = [Track.read(outcome.series, body) for body in (0, 1)]
        if self.alone:
            found.append(Track.read(outcome.series, 0, ALONE))
        return dict(zip(NAMES, found, strict=False))

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed and power of each over the counted periods; how the distance changed; the slip."""
        first, last = self.counted
        tracks = self.tracks(outcome)
        speeds = {name: track.way(first, last)[1] for name, track in tracks.items()}
        works = {
            name: float(track.integral(track.power, first, last)) / (last - first)
            for name, track in tracks.items()
        }
        found = [
            Metric(f"mean speed, {name}, t = {first:g} to {last:g}", speed, kind="report")
            for name, speed in speeds.items()
        ]
        found += [Metric(f"power, {name}, L^4/T^3", work, kind="report")
                  for name, work in works.items()]  # fmt: skip
        if self.alone:
            found += [
                Metric(f"{what}, {name} over alone", told[name] / told["alone"], kind="report")
                for what, told in (("speed", speeds), ("power", works))
                for name in NAMES[:2]
            ]
        apart = tracks["follower"].place - tracks["leader"].place
        change = float(np.hypot(*apart[-1]) - np.hypot(*apart[0]))
        found.append(Metric("distance of the centres, change", change, kind="report"))
        residual = float(np.nanmax(outcome.series["slip_residual"][1:]))
        found.append(
            Metric("slip residual, largest", residual, 0.0, self.tolerance, kind="absolute")
        )
        return found

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Forward velocities, the ways, and the wake at three times."""
        from matplotlib.figure import Figure

        tracks = self.tracks(outcome)
        stages = Stages.of(outcome, [0.25 * self.until, 0.5 * self.until, self.until])
        figure = Figure(figsize=(9.6, 2.8 + stages.height), layout="constrained")
        ratios = (2.8, stages.height)
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=ratios).ravel()
        speeds, way = top.subplots(1, 2, width_ratios=(1.6, 1.0))
        self._draw_speeds(speeds, tracks)
        draw_ways(way, [tracks["leader"], tracks["follower"]])
        bodies: Sequence[Body] = (outcome.flow.first if self.alone else outcome.flow).bodies
        swimmers = list(zip(bodies, [tracks["leader"], tracks["follower"]], strict=True))
        fields = draw_wake(below, stages, swimmers)
        name_panels([speeds, way, *fields])
        figure.suptitle(
            f"{self.title}, {WAVES[self.gait]}, {self.distance:g} L apart, follower's phase "
            f"{self.phase:g} T: {self.nodes} nodes per length",
            fontsize=11,
        )
        return figure

    def _draw_speeds(self, panel: Axes, tracks: Mapping[str, Track]) -> None:
        """Velocity towards -x of all."""
        for (name, track), colour in zip(tracks.items(), COLOURS, strict=False):
            style = "--" if name == "alone" else "-"
            panel.plot(track.time, -track.velocity[:, 0], style, color=colour, label=name)
        panel.set(xlim=(0, self.until), xlabel="$t / T$", ylabel="velocity $[L/T]$")
        panel.set_title("velocity along $-x$")
        panel.legend(loc="best")
