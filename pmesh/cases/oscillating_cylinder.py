"""A cylinder that oscillates along a line in fluid at rest, as Dütsch et al. measured in 1998."""

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
from pmesh.cases.reference import read_table
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.wake import draw_vorticity
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher
    from pmesh.run.snapshots import Snapshot

Values = NDArray[np.float64]
DUETSCH = "Dütsch, Durst, Becker & Lienhart 1998"
COEFFICIENTS = (2.09, 1.45)  # of drag and of added mass at Re = 100, KC = 5, grade C
KNOWN = (100.0, 5.0)  # Re, KC
SHOTS = 12  # per period: on the phases of the profiles, 180, 210 and 330 degrees
PHASES = (180, 210, 330)
ACROSS = np.linspace(-1.05, 1.05, 211)  # [D]
PROFILE = 0.12  # rms of the measured velocity about ours, over U_max: allowed


class Morison(NamedTuple):
    """A force as ``-Cd |U| U / 2 - Cm (pi/4) dU/dt``, over rho U_max^2 D."""

    drag: float
    added_mass: float


class Profile(NamedTuple):
    """Velocity along x over y at one phase and place, as measured and as ours."""

    phase: int  # [degrees]
    x: float  # [D]
    y: Values  # [D]
    measured: Values  # [U_max]
    ours: Values  # [U_max]
    line: Values  # ours along ACROSS, NaN in the cylinder


@dataclass(frozen=True, kw_only=True)
class OscillatingCylinder(Case):
    """A cylinder oscillates in fluid at rest: force and velocity profiles beside Dütsch et al.

    Lengths in diameters and velocities in the largest of the cylinder, so that its period is KC.
    It moves as ``x = -A sin(2 pi t / KC)``, ``A = KC / (2 pi)``.
    """

    until: float = option(30.0, "end of the run; the period is KC", unit="D/U")
    reynolds: float = option(100.0, "Reynolds number U_max D / nu, from 10 to 500")
    keulegan: float = option(5.0, "Keulegan-Carpenter number U_max T / D, from 0.5 to 20")
    nodes: int = option(32, "mesh nodes per diameter")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    tolerance: float = option(1e-5, "slip residual of the penalisation", unit="U")

    title: ClassVar[str] = "Oscillating cylinder"
    source: ClassVar[str] = DUETSCH
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 24, "until": 15.0, "deformation": 0.5}

    def __post_init__(self) -> None:
        """Refuse what is outside the case, and a body of too few nodes."""
        super().__post_init__()
        self.require(10 <= self.reynolds <= 500, "reynolds", "between 10 and 500")
        self.require(0.5 <= self.keulegan <= 20, "keulegan", "between 0.5 and 20")
        self.require(self.nodes >= 16, "nodes", "at least 16 per diameter")
        self.positive("deformation", "tolerance")
        whole = self.until >= self.keulegan
        self.require(whole, "until", f"at least one period, {self.keulegan:g}")

    @property
    def amplitude(self) -> float:
        """Of the motion [D]."""
        return self.keulegan / (2.0 * math.pi)

    @property
    def rate(self) -> float:
        """Angular frequency [U/D]."""
        return 2.0 * math.pi / self.keulegan

    @property
    def cycles(self) -> int:
        """Whole periods that the run holds."""
        return math.floor(self.until / self.keulegan + 1e-9)

    def place(self, time: float) -> tuple[float, float]:
        """Of the cylinder's centre [D]."""
        return -self.amplitude * math.sin(self.rate * time), 0.0

    def speed(self, time: float) -> tuple[float, float]:
        """Of the cylinder [U_max]."""
        return -math.cos(self.rate * time), 0.0

    def recipe(self) -> Any:
        """The flow on a box that just holds the cylinder; it follows the wake."""
        from pmesh.bodies.body import RigidBody
        from pmesh.bodies.motion import Prescribed
        from pmesh.bodies.penalise import Penalisation
        from pmesh.vortex.flow import VortexFlow

        h = 1.0 / self.nodes
        cells = 8 * math.ceil(0.7 / h / 8)
        motion = Prescribed(shift=self.place, velocity=self.speed, scale=1.0 / self.rate)
        return VortexFlow(
            grid=Grid((2 * cells,) * 2, h, ((0.5 - cells) * h,) * 2),
            viscosity=1.0 / self.reynolds,
            bodies=(RigidBody(Disk(radius=0.5), motion=motion),),
            deformation=self.deformation,
            domain="follow",
            penalisation=Penalisation(tolerance=self.tolerance),
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the start of the motion in it."""
        flow = self.recipe()
        return flow, flow.start()

    def watchers(self) -> Sequence[Watcher]:
        """Forces, the ledger, and twelve snapshots of the last period."""
        from pmesh.run.protocols import Moment
        from pmesh.run.snapshots import Snapshots

        after = (self.cycles - 1) * self.keulegan

        class Late(Snapshots):
            def __call__(self, moment: Moment) -> None:
                if moment.time > after - 0.5 * self.every:
                    super().__call__(moment)

        return [*super().watchers(), Late(self.keulegan / SHOTS, dtype="float32")]

    def morison(self, outcome: Outcome, cycle: int | None = None) -> tuple[Morison, Morison]:
        """Coefficients of a cycle (the last if not given): by Fourier means, by least squares."""
        number = self.cycles if cycle is None else cycle
        series, period = outcome.series, self.keulegan
        inside = (series["time"] > (number - 1 + 1e-9) * period) & (
            series["time"] < (number + 1e-9) * period
        )
        dt, force = (np.asarray(series[c][inside]) for c in ("dt", "body0_force_x"))
        phase = self.rate * (series["time"][inside] - 0.5 * dt)
        speed, gain = -np.cos(phase), self.rate * np.sin(phase)
        laws = np.stack([-0.5 * np.abs(speed) * speed, -0.25 * math.pi * gain])
        tests = np.stack([speed, gain])
        drag, added = (tests * dt @ force) / np.sum(tests * dt * laws, axis=1)
        least = np.linalg.solve((laws * dt) @ laws.T, (laws * dt) @ force)
        return Morison(float(drag), float(added)), Morison(*map(float, least))

    def profiles(self, outcome: Outcome) -> list[Profile]:
        """Ours at the measured places of the last whole period; none but at Re = 100, KC = 5."""
        from remesh.transfer import m2p

        if (self.reynolds, self.keulegan) != KNOWN:
            return []
        shots, found = outcome.snapshots(), []
        table = np.array(
            [[float(row[name]) for name in ("phase", "x", "y", "u")] for row in measured()]
        )
        for phase in PHASES:
            shot = self._shot(shots, phase)
            center = self.place(shot.time)[0]
            for x in np.unique(table[:, 1]):
                rows = table[(table[:, 0] == phase) & (table[:, 1] == x)]
                y = np.concatenate([rows[:, 2], ACROSS])
                places = np.stack([np.full_like(y, x), y], axis=1)
                ours = m2p(shot["velocity"], places, shot.grid, outside="drop")[:, 0]
                here, line = np.split(np.asarray(ours, np.float64), [len(rows)])
                line = np.where(np.hypot(x - center, ACROSS) > 0.5, line, np.nan)
                found.append(Profile(phase, float(x), rows[:, 2], rows[:, 3], here, line))
        return found

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Morison's coefficients, velocity profiles, force routes, lift and slip."""
        fourier, least = self.morison(outcome)
        judged = (self.reynolds, self.keulegan) == KNOWN
        found = []
        names = ("drag coefficient Cd", "added-mass coefficient Cm")
        for name, value, other, known in zip(names, fourier, least, COEFFICIENTS, strict=True):
            if judged:
                found.append(Metric(name, value, known, 0.04, "C", DUETSCH))
            else:
                found.append(Metric(name, value, kind="report"))
            found.append(Metric(f"{name}, by least squares", other, kind="report"))
        if self.cycles > 1:
            before = self.morison(outcome, self.cycles - 1)[0]
            change = abs(fourier.drag / before.drag - 1.0)
            found.append(Metric("change of Cd since the cycle before", change, kind="report"))
        for phase in PHASES if judged else ():
            off = [p.ours - p.measured for p in self.profiles(outcome) if p.phase == phase]
            rms = float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
            name = f"velocity off the measured, rms, phase {phase}"
            found.append(Metric(name, rms, 0.0, PROFILE, "B", DUETSCH, "absolute"))
        return found + self._routes(outcome)

    def _routes(self, outcome: Outcome) -> list[Metric]:
        """What the run says of itself."""
        series = outcome.series
        late = series["time"] > (self.cycles - 1) * self.keulegan
        momentum, impulse = series["body0_force_x"][late], series["impulse_force_x"][late]
        apart = float(np.abs(impulse - momentum).max() / np.abs(momentum).max())
        lift = float(np.abs(series["body0_force_y"][late]).max())
        slip = float(series["slip"][late].max())
        return [
            Metric("force routes apart", apart, 0.0, 0.01, "A", "one force", "absolute"),
            Metric("lift, for the flow is symmetric", lift, 0.0, 0.01, "A", "symmetry", "absolute"),
            Metric("slip, rms", slip, kind="report"),
        ]

    def _shot(self, shots: Sequence[Snapshot], phase: float) -> Snapshot:
        """The snapshot at a phase [degrees] of the last whole period."""
        time = (self.cycles - 1 + phase / 360.0) * self.keulegan
        return min(shots, key=lambda shot: abs(shot.time - time))

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The force over two cycles, the vorticity, and the measured velocity profiles."""
        from matplotlib.figure import Figure

        profiles = self.profiles(outcome)
        figure = Figure(figsize=(9.6, 6.6 if profiles else 3.6), layout="constrained")
        parts = figure.subfigures(2 if profiles else 1, 1, squeeze=False).ravel()
        force, field = parts[0].subplots(1, 2, width_ratios=(1.15, 1.0))
        self._draw_force(force, outcome)
        self._draw_field(field, outcome)
        panels = [force, field]
        if profiles:
            below = parts[1].subplots(1, len(PHASES), sharey=True)
            for panel, phase in zip(below, PHASES, strict=True):
                _draw_profiles(panel, [p for p in profiles if p.phase == phase])
                panel.set_title(f"velocity along x, phase {phase}°")
            below[0].set_ylabel("$y / D$")
            below[0].legend(loc="upper right", fontsize=7)
            panels += list(below)
        name_panels(panels)
        figure.suptitle(
            f"{self.title}, Re = {self.reynolds:g}, KC = {self.keulegan:g}: "
            f"{self.nodes} nodes per diameter",
            fontsize=11,
        )
        return figure

    def _draw_force(self, panel: Axes, outcome: Outcome) -> None:
        """The force coefficient of the last two cycles, and Morison's with published numbers."""
        series = outcome.series
        time = (series["time"] - 0.5 * series["dt"]) / self.keulegan
        late = (time > max(self.cycles - 2, 0.05)) & (time < self.cycles)
        routes = (("body0_force_x", "ours, penalisation momentum", OURS, "-"),
                  ("impulse_force_x", "ours, vorticity impulse", OTHERS[1], ":"))  # fmt: skip
        for column, label, colour, line in routes:
            panel.plot(time[late], 2 * series[column][late], line, color=colour, label=label)
        if (self.reynolds, self.keulegan) == KNOWN:
            phase = 2 * math.pi * time[late]
            speed, gain = -np.cos(phase), self.rate * np.sin(phase)
            drag, added = COEFFICIENTS
            law = -drag * np.abs(speed) * speed - 0.5 * math.pi * added * gain
            label = f"Morison's, $C_d$ = {drag}, $C_m$ = {added}"
            panel.plot(time[late], law, "--", color=REFERENCE, lw=1.2, label=label)
        panel.set(xlabel="$t / T$", ylabel="$2 F_x / (\\rho U^2 D)$", title="force along x")
        most = 2 * float(np.abs(series["body0_force_x"][late]).max())
        panel.set(ylim=(-1.3 * most, 2.0 * most))  # room for the legend
        panel.legend(loc="upper center", fontsize=7.5)

    def _draw_field(self, panel: Axes, outcome: Outcome) -> None:
        """Vorticity at the end of the last whole period."""
        shot = self._shot(outcome.snapshots(), 360.0)
        around = np.linspace(0, 2 * math.pi, 128, endpoint=False)
        circle = self.place(shot.time) + 0.5 * np.stack([np.cos(around), np.sin(around)], axis=1)
        limit = 0.4 * math.sqrt(self.reynolds)
        draw_vorticity(panel, shot["vorticity"], shot.grid, limit, outlines=[circle])
        wide = self.amplitude + 1.6
        panel.set(xlim=(-wide, wide), ylim=(-0.8 * wide, 0.8 * wide), xlabel="$x / D$")
        panel.set(ylabel="$y / D$", title="vorticity, phase 0°")


def measured() -> list[dict[str, str]]:
    """The measured velocity: rows of phase [degrees], x, y [D] and u [U_max]."""
    return read_table("oscillating_cylinder.csv")


def _draw_profiles(panel: Axes, profiles: Sequence[Profile]) -> None:
    """Profiles of one phase, a colour for each place."""
    colours = (OURS, REFERENCE, *OTHERS[:2])
    for profile, colour in zip(profiles, colours, strict=True):
        panel.plot(profile.measured, profile.y, "o", color=colour, mfc="none", ms=3.5)
        panel.plot(profile.line, ACROSS, color=colour, lw=1.2, label=f"$x$ = {profile.x:g} $D$")
    panel.set(xlim=(-1.2, 1.4), ylim=(-1.1, 1.1), xlabel="$u / U$ (rings: measured)")
