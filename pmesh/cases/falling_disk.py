"""A disk let go in fluid at rest: it falls, or rises if it is light, to its terminal speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.shapes import Disk
from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.unsteady_stokes import Release, released
from pmesh.cases.wake import draw_vorticity
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher

Values = NDArray[np.float64]
RADIUS = 0.5
DRAGS = {  # drag coefficients of a cylinder in a steady stream, grade B
    20.0: (2.091, "cylinder in a stream at Re = 20, as quoted by Basilisk's tests"),
    40.0: (1.565, "cylinder in a stream at Re = 40, as quoted by Basilisk's tests"),
}
EARLY = (0.1, 0.4)  # times between which unsteady Stokes flow is compared [D/U]
STOKES = "unsteady Stokes flow, exact"


class Fall(NamedTuple):
    """The motion of the disk, along gravity for a heavy one and against it for a light one."""

    time: Values  # ends of the steps [D/U]
    dt: Values
    speed: Values  # at the ends [U]
    acceleration: Values  # means over the steps
    force: Values  # of the fluid against the motion, means over the steps [rho U^2 D]


@dataclass(frozen=True, kw_only=True)
class FallingDisk(Case):
    """A free disk sets off with its added mass and reaches the speed that its drag allows.

    Lengths in diameters. Gravity is chosen such that with the drag of a cylinder in a stream at
    this Reynolds number the terminal speed is 1.
    """

    until: float = option(25.0, "end of the run", unit="D/U")
    density: float = option(2.0, "density of the disk over the fluid's; below 1 it rises")
    reynolds: float = option(40.0, "Reynolds number of the terminal speed: 20 or 40")
    nodes: int = option(32, "mesh nodes per diameter")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    largest_step: float = option(0.02, "largest time step", unit="D/U")
    wake: float = option(12.0, "how far behind the disk the wake is kept", unit="D")
    every: float = option(1.0, "time between snapshots", unit="D/U")

    title: ClassVar[str] = "Falling disk"
    source: ClassVar[str] = STOKES + "; drag of a cylinder in a stream"
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 24, "until": 2.0, "every": 0.5}

    def __post_init__(self) -> None:
        """Refuse what is outside the case."""
        super().__post_init__()
        self.positive("density", "deformation", "largest_step", "every")
        self.require(self.density <= 100, "density", "at most 100")
        self.require(abs(self.density - 1) >= 0.01, "density", "not that of the fluid")
        self.require(self.reynolds in DRAGS, "reynolds", "20 or 40, where the drag is known")
        self.require(self.nodes >= 16, "nodes", "at least 16 per diameter")
        self.require(self.wake >= 4, "wake", "at least 4")

    @property
    def way(self) -> float:
        """The direction of the motion along y: down for a heavy disk, up for a light one."""
        return -1.0 if self.density > 1 else 1.0

    @property
    def pull(self) -> float:
        """Weight and buoyancy over the mass of the fluid displaced [U^2/D]."""
        return 2.0 * DRAGS[self.reynolds][0] / math.pi

    @property
    def gravity(self) -> tuple[float, float]:
        """[U^2/D]; always down."""
        return 0.0, -self.pull / abs(self.density - 1.0)

    def recipe(self) -> Any:
        """The flow on a box that just holds the disk; a window travels with it."""
        from pmesh.bodies.body import RigidBody
        from pmesh.bodies.motion import Free
        from pmesh.vortex.flow import VortexFlow
        from pmesh.vortex.window import Window

        h = 1.0 / self.nodes
        cells = 8 * math.ceil(0.7 / h / 8)
        front, behind = 3.0, self.wake
        below, above = (front, behind) if self.way < 0 else (behind, front)
        motion = Free(density=self.density, gravity=self.gravity)
        return VortexFlow(
            grid=Grid((2 * cells,) * 2, h, ((0.5 - cells) * h,) * 2),
            viscosity=1.0 / self.reynolds,
            bodies=(RigidBody(Disk(radius=RADIUS), motion=motion),),
            deformation=self.deformation,
            largest_step=self.largest_step,
            domain="follow",
            window=Window(lower=(3.0, below), upper=(3.0, above)),
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the disk at rest in it."""
        flow = self.recipe()
        return flow, flow.start()

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, dtype="float32")]

    def fall(self, outcome: Outcome) -> Fall:
        """The motion of a run."""
        series = {name: np.asarray(column) for name, column in outcome.series.items()}
        speed, dt = self.way * series["body0_v"], series["dt"][1:]
        return Fall(
            time=series["time"][1:],
            dt=dt,
            speed=speed[1:],
            acceleration=np.diff(speed) / dt,
            force=-self.way * series["body0_force_y"][1:],
        )

    def slow(self, time: Values) -> Release:
        """The exact motion before inertia of the flow counts."""
        return released(
            time, density=self.density, pull=self.pull, viscosity=1 / self.reynolds, radius=RADIUS
        )

    def added_mass(self, fall: Fall) -> float:
        """The force less its viscous part over the acceleration, early on; 1 for a cylinder."""
        middle = fall.time - 0.5 * fall.dt
        early = (middle > EARLY[0]) & (middle < EARLY[1])
        area = math.pi * RADIUS**2
        left = fall.force[early] / area - self.slow(middle[early]).friction
        return float(np.sum(left * fall.dt[early]) / np.sum((fall.acceleration * fall.dt)[early]))

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Added mass and the first motion; terminal speed; symmetry; balance and routes."""
        fall = self.fall(outcome)
        found = []
        early = (fall.time > EARLY[0]) & (fall.time < EARLY[1])
        if fall.time[-1] >= EARLY[1]:
            added = self.added_mass(fall)
            found.append(Metric("added mass over pi rho R^2", added, 1.0, 0.02, "A", STOKES))
            off = float(np.abs(fall.speed / self.slow(fall.time).speed - 1.0)[early].max())
            name = f"speed off unsteady Stokes flow, {EARLY[0]} < t < {EARLY[1]}"
            found.append(Metric(name, off, 0.0, 0.02, "A", STOKES, "absolute"))
        if self.until >= 15:
            last = fall.time > 0.9 * fall.time[-1]
            speed = float(np.sum((fall.speed * fall.dt)[last]) / np.sum(fall.dt[last]))
            source = DRAGS[self.reynolds][1]
            found.append(Metric("terminal speed", speed, 1.0, 0.04, "B", source))
            drag = float(np.sum((fall.force * fall.dt)[last]) / np.sum(fall.dt[last]))
            found.append(Metric("drag coefficient there", 2 * drag / speed**2, kind="report"))
            gain = float(fall.speed[last][-1] - fall.speed[last][0])
            found.append(Metric("its change over the last tenth", gain, kind="report"))
        return found + self._itself(outcome, fall)

    def _itself(self, outcome: Outcome, fall: Fall) -> list[Metric]:
        """What the run says of itself: symmetry, Newton's law, force routes, slip."""
        series = outcome.series
        aside = float(np.abs(series["body0_u"]).max())
        spin = float(np.abs(series["body0_spin"]).max())
        area = math.pi * RADIUS**2
        newton = self.density * area * fall.acceleration - (area * self.pull - fall.force)
        impulse = -self.way * series["impulse_force_y"][1:]
        scale = area * self.pull
        apart = float(np.abs(impulse - fall.force).max()) / scale
        return [
            Metric("speed aside", aside, 0.0, 1e-3, "A", "symmetry", "absolute"),
            Metric("spin", spin, 0.0, 1e-3, "A", "symmetry", "absolute"),
            Metric("off Newton's law, over the weight", float(np.abs(newton).max()) / scale, 0.0,
                   1e-6, "A", "Newton", "absolute"),
            Metric("force routes apart, over the weight", apart, 0.0, 0.01, "A", "one force",
                   "absolute"),
            Metric("slip, rms", float(series["slip"][1:].max()), kind="report"),
        ]  # fmt: skip

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The speed, its first moments beside the exact law, and the wake."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 4.8), layout="constrained")
        speed, early, wake = figure.subplots(1, 3, width_ratios=(1.2, 1.2, 0.8))
        fall = self.fall(outcome)
        speed.plot(fall.time, fall.speed, color=OURS, label="ours")
        speed.axhline(1.0, color=REFERENCE, ls="--", lw=1.2, label="drag of a cylinder in a stream")
        speed.set(xlim=(0, self.until), ylim=(0, 1.3), xlabel="$t$", ylabel="speed")
        speed.set_title("to the terminal speed")
        speed.legend(loc="best")
        self._draw_early(early, fall)
        shot = outcome.snapshots()[-1]
        around = np.linspace(0, 2 * math.pi, 128, endpoint=False)
        center = np.array([outcome.series[f"body0_{a}"][-1] for a in "xy"])
        circle = center + RADIUS * np.stack([np.cos(around), np.sin(around)], axis=1)
        limit = 0.3 * math.sqrt(self.reynolds)
        draw_vorticity(wake, shot["vorticity"], shot.grid, limit, outlines=[circle])
        long = min(1.5 + abs(center[1]), 7.0)
        low, high = sorted((center[1] + 1.5 * self.way, center[1] - long * self.way))
        wake.set(xlim=(-1.7, 1.7), ylim=(low, high), xlabel="$x$", ylabel="$y$")
        wake.set_title(f"vorticity, t = {shot.time:.3g}")
        name_panels([speed, early, wake])
        figure.suptitle(
            f"{self.title}, density ratio {self.density:g}, Re = {self.reynolds:g}: "
            f"{self.nodes} nodes per diameter",
            fontsize=11,
        )
        return figure

    def _draw_early(self, panel: Axes, fall: Fall) -> None:
        """Acceleration over the first moments, over that in vacuum of the fluid."""
        time = np.linspace(0.002, 1.0, 200)
        without = self.pull / (self.density + 1.0)
        exact = self.slow(time)
        middle = fall.time - 0.5 * fall.dt
        first = middle < 1.0
        panel.axhline(without, color=OTHERS[2], lw=1.0, ls=":", label="added mass only")
        panel.plot(time, exact.acceleration, "--", color=REFERENCE, label=STOKES)
        panel.plot(middle[first], fall.acceleration[first], color=OURS, label="ours")
        panel.axvspan(*EARLY, color="#eeeeee")
        panel.set(xlim=(0, 1), ylim=(0, 1.25 * without), xlabel="$t$", ylabel="acceleration")
        panel.set_title("the first moments")
        panel.legend(loc="lower left")
