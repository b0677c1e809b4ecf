"""A cylinder towed in still fluid beside the same cylinder held in a free stream."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.shapes import Disk
from pmesh.cases.case import Outcome
from pmesh.cases.cylinder import Cylinder, Drag
from pmesh.cases.reference import cylinder_drag, cylinder_reynolds
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.wake import draw_vorticity
from pmesh.run.summary import Metric

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Values = NDArray[np.float64]
HELD = "held_"  # prefix of the columns of the cylinder in the free stream
SETTLED = 0.3  # T from which the two drags are compared: the start is the mesh's own
ALLOWED = 0.01  # part of the drag that the two may differ by
GALILEO = "Galileo's invariance"


def towed(time: float) -> tuple[float, float]:
    """Where the towed cylinder is [R]."""
    return -time, 0.0


def tow(_: float) -> tuple[float, float]:
    """How fast it is towed [U]."""
    return -1.0, 0.0


@dataclass(frozen=True, kw_only=True)
class MovingCylinder(Cylinder):
    """A cylinder is towed through fluid at rest; its drag is that of one held in a free stream.

    Both flows run side by side with the same steps. Lengths in radii and velocities in the
    cylinder's, so that time is T = U t / R.
    """

    title: ClassVar[str] = "Towed cylinder"
    source: ClassVar[str] = "the cylinder in a free stream, and " + Cylinder.source
    short: ClassVar[Mapping[str, Any]] = {"nodes": 64, "until": 1.0, "deformation": 0.5}

    def build(self) -> tuple[Any, Any]:
        """The towed cylinder and the held one, which start from the same mesh."""
        from pmesh.bodies.body import RigidBody
        from pmesh.bodies.motion import Prescribed
        from pmesh.cases.twins import Twins

        held = self.recipe()
        body = RigidBody(Disk(radius=1.0), motion=Prescribed(shift=towed, velocity=tow))
        moving = replace(held, freestream=(0.0, 0.0), bodies=(body,))
        flow = Twins(first=moving, second=held, prefix=HELD)
        return flow, flow.start()

    def held(self, outcome: Outcome) -> Drag:
        """Drag coefficients of the cylinder in the free stream."""
        named = {
            name.removeprefix(HELD): column
            for name, column in outcome.series.items()
            if name.startswith(HELD) or name in ("time", "dt")
        }
        return self.drag(replace(outcome, series=named))

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """The two drags apart; then all that the started cylinder is judged by, for the towed."""
        moving, held = self.drag(outcome), self.held(outcome)
        late = moving.time > SETTLED
        found = []
        if late.any():
            apart = float(np.abs(moving.momentum[late] / held.momentum[late] - 1.0).max())
            name = f"towed off held, {SETTLED} < T < {self.until:g}, largest"
            found.append(Metric(name, apart, 0.0, ALLOWED, "A", GALILEO, "absolute"))
            rms = float(np.sqrt(np.mean((moving.momentum / held.momentum - 1.0)[late] ** 2)))
            found.append(Metric("the same, rms", rms, kind="report"))
        lift = float(np.abs(outcome.series["body0_force_y"][1:]).max())
        found.append(Metric("lift, for the flow is symmetric", lift, 0.0, 1e-3, "A", "symmetry",
                            "absolute"))  # fmt: skip
        return [*found, *super().metrics(outcome)]

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Both drags over the published one, how far they are apart, and the towed wake."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.6, 6.4), layout="constrained")
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.15, 1.0)).ravel()
        left, right = top.subplots(1, 2, width_ratios=(1.5, 1.0))
        moving, held = self.drag(outcome), self.held(outcome)
        self._draw_both(left, moving, held)
        late = moving.time > 0.05
        off = 100 * (moving.momentum[late] / held.momentum[late] - 1.0)
        right.axhspan(-100 * ALLOWED, 100 * ALLOWED, color="#eeeeee")
        right.plot(moving.time[late], off, color=OURS, lw=1.0)
        right.set(xlim=(0, self.until), ylim=(-2.5, 2.5), xlabel="$T = U t / R$", ylabel="%")
        right.set_title("towed off held, the strip is what is allowed")
        wake = below.subplots()
        shot = outcome.snapshots()[-1]
        around = np.linspace(0, 2 * np.pi, 256, endpoint=False)
        circle = np.stack([np.cos(around), np.sin(around)], axis=1) + towed(shot.time)
        limit = 0.25 * self.reynolds**0.5
        draw_vorticity(wake, shot["vorticity"], shot.grid, limit, outlines=[circle])
        wake.set(xlim=(-shot.time - 1.5, -shot.time + 6.5), ylim=(-2.0, 2.0))
        wake.set(xlabel="$x / R$", ylabel="$y / R$")
        wake.set_title(f"vorticity at T = {shot.time:.3g}: the fluid is at rest far away")
        name_panels([left, right, wake])
        figure.suptitle(
            f"{self.title}, Re = {self.reynolds:g}: {2 / self.spacing:.0f} nodes per diameter",
            fontsize=11,
        )
        return figure

    def _draw_both(self, panel: Axes, moving: Drag, held: Drag) -> None:
        """Drag coefficients over time."""
        panel.plot(held.time, held.momentum, color=OTHERS[2], lw=3.0, label="held in a stream")
        panel.plot(moving.time, moving.momentum, color=OURS, lw=1.2, label="towed in still fluid")
        if self.reynolds in cylinder_reynolds():
            curve = cylinder_drag(self.reynolds)
            shown = curve.time <= self.until
            panel.plot(curve.time[shown], curve.value[shown], "o", color=REFERENCE, mfc="white",
                       label=curve.source)  # fmt: skip
        late = held.momentum[held.time > 0.1 * self.until]
        top = 1.6 * float(late.max()) if late.size else 2.0
        panel.set(xlim=(0, self.until), ylim=(0, top), xlabel="$T = U t / R$", ylabel="$C_D$")
        panel.set_title("drag coefficient")
        panel.legend(loc="best")
