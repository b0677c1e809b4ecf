"""Zalesak's slotted disk, turned by about 800 particles without remeshing, or with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.slotted import SlottedDisk
from pmesh.cases.case import Outcome
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.zalesak import BOX, PERIOD, Zalesak, in_turns, show_errors

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from levelset.interface import Interface
    from levelset.laws import Rotation

Values = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ZalesakDisk(Zalesak):
    """A disk with a slot turns about the middle of a box: about 800 particles keep it exactly."""

    title: ClassVar[str] = "Zalesak's disk"
    source: ClassVar[str] = "Zalesak, J. Comput. Phys. 31 (1979) 335"
    short: ClassVar[Mapping[str, Any]] = {"until": PERIOD / 4}

    @property
    def shape(self) -> SlottedDisk:
        """Radius 15, the slot 5 wide and 25 deep."""
        return SlottedDisk(center=(0.5 * BOX, 0.75 * BOX))

    @property
    def law(self) -> Rotation:
        """About the middle of the box, anticlockwise."""
        from levelset.laws import Rotation

        return Rotation(center=(0.5 * BOX, 0.5 * BOX), rate=2.0 * math.pi / PERIOD)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The turn; the particles; ours over the exact disk; errors over the turns."""
        from matplotlib.figure import Figure

        from levelset.surface import contours

        first, last = self.build()[1], outcome.state
        lines = {
            name: contours(*self.field(state, 8))
            for name, state in (("start", first), ("end", last))
        }
        figure = Figure(figsize=(12.0, 7.0), layout="constrained")
        halves: Any = figure.subfigures(2, 1, height_ratios=(2.1, 1.0))
        turn, dots, whole = halves[0].subplots(1, 3)
        errors = halves[1].subplots()
        self._turn(turn, outcome)
        self._particles(dots, last, lines["end"])
        self._overlay(whole, lines, last.time)
        show_errors(errors, outcome.series, self.spacing)
        errors.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        name_panels([turn, dots, whole, errors])
        how = "without remeshing" if not last.remeshings else f"{last.remeshings} times remeshed"
        halves[0].suptitle(
            f"Zalesak's disk, {self.nodes} x {self.nodes} cells: {in_turns(last.time)} of "
            f"{self.steps} steps, {how}",
            fontsize=11,
        )
        return figure

    def _turn(self, panel: Axes, outcome: Outcome) -> None:
        """The level set's contour at some times of the last turn."""
        shots = outcome.snapshots()
        latest = [shot for shot in shots if shot.time > shots[-1].time - PERIOD + 1e-6][-4:]
        for shot in latest:
            x, y = shot.grid.axes()
            phi = shot["level_set"].T
            colour = OURS if shot is latest[-1] else "#9dbfe0"
            panel.contourf(x, y, phi, levels=[-1e9, 0.0], colors=[colour], alpha=0.25)
            panel.contour(x, y, phi, levels=[0.0], colors=[colour], linewidths=1.0)
        around = np.linspace(0, 2 * math.pi, 181)
        half, arm = 0.5 * BOX, 0.25 * BOX
        panel.plot(
            half + arm * np.cos(around), half + arm * np.sin(around), color="#b5b5b5", lw=0.7
        )
        panel.plot([half], [half], "+", color="#707070", ms=7)
        panel.set(xlim=(0, BOX), ylim=(0, BOX), title="the last turn, anticlockwise")
        panel.set_aspect("equal")

    def _particles(self, panel: Axes, state: Interface, lines: list[Values]) -> None:
        """All particles, coloured by what they carry, and the interface that they rebuild."""
        x, y = state.positions.T
        dots = panel.scatter(x, y, c=state.values, s=7, cmap="RdBu_r", edgecolors="none", zorder=2)
        top = float(np.abs(state.values).max())
        dots.set_clim(-top, top)
        for line in lines:
            now = self.law.flow(line, 0.0, state.time)
            panel.plot(*now.T, color="black", lw=1.1, zorder=3)
        bar = panel.figure.colorbar(
            dots, ax=panel, shrink=0.8, pad=0.02, aspect=30, location="bottom"
        )
        bar.set_label(r"level set $\phi_p$ that each carries")
        panel.set(title=f"{state.size} particles at the end")
        self._frame(panel, state.time)
        panel.grid(False)

    def _overlay(self, panel: Axes, lines: Mapping[str, list[Values]], time: float) -> None:
        """Start, end and the exact disk over each other, and the slot's corner close up."""
        from levelset.contour import contour

        exact = contour(self.shape, cells=900)
        (x, y), half = self.shape.center, 0.5 * self.shape.width
        end = y + self.shape.depth - self.shape.radius
        close = panel.inset_axes((x - 12.5, y - 6.5, 9.0, 9.0), transform=panel.transData)
        close.set(xlim=(x - half - 0.3, x - half + 0.9), ylim=(end - 0.9, end + 0.3))
        for axes, thick in ((panel, 1.0), (close, 1.3)):
            for line in exact:
                ring = np.concatenate([line, line[:1]])
                axes.plot(*ring.T, color=REFERENCE, lw=3.2 * thick, alpha=0.4, label="exact")
            for k, (name, colour, style) in enumerate(
                (("start", OTHERS[0], "-"), ("end", OURS, (0, (4, 3))))
            ):
                told = "start" if name == "start" else f"after {in_turns(time)}"
                for line in lines[name]:
                    axes.plot(*line.T, color=colour, ls=style, lw=1.5 - 0.3 * k, label=told)
            axes.set_aspect("equal")
        panel.indicate_inset_zoom(close, edgecolor="#707070")
        close.set_xticks([])
        close.set_yticks([])
        for side in ("top", "right"):
            close.spines[side].set_visible(True)
        self._frame(panel, 0.0)
        panel.set(title="turned back, over the exact disk")
        handles, labels = panel.get_legend_handles_labels()
        known = dict(zip(labels, handles, strict=True))
        panel.legend(
            known.values(), known.keys(), loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=3
        )

    def _frame(self, panel: Axes, time: float) -> None:
        """The disk where it is at this time and a margin, to scale."""
        center = np.array([self.shape.center])
        (x, y), half = self.law.flow(center, 0.0, time)[0], 1.2 * self.shape.radius
        panel.set(xlim=(x - half, x + half), ylim=(y - half, y + half))
        panel.set_aspect("equal")
