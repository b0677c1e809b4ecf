"""Virtual surgery: a burr and a blade cut an organ that breathes, on particles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.surgery import SWITCH, Operation, bore, swept_volume
from pmesh.run.summary import Metric
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher
    from pmesh.run.series import Series

Values = NDArray[np.floating[Any]]
LIVER, PIECE, WASTE, TOOL = "#a8503f", "#d98850", "#e0b4a8", "#9aa4ae"
SWEPT = "the tools' swept region in the body, by quadrature of exact shapes"
BORE = "pi r^2 d + 2/3 pi r^3: a ball driven to a depth d into a block"
ALLOWED = 0.01
BOUNDS = ((-0.86, -0.4, -0.55), (0.92, 0.4, 0.70))  # of the pictures [L]
SECTION = -0.08  # y of the section that is shown [L]
TIMES = 5  # at which the reference is known, at most


@dataclass(frozen=True, kw_only=True)
class CuttingCase(Case):
    """A burr scoops a groove, a blade cuts a lobe off; the organ breathes under the tools."""

    until: float = option(1.0, "end of the operation", unit="T")
    cells: int = option(56, "mesh cells per unit length; the blade is 0.08 thick")
    burr: float = option(0.13, "radius of the burr", unit="L")
    breathing: float = option(0.06, "how far the body moves up and down", unit="L")
    largest_step: float = option(0.025, "time step; any gives the same cut", unit="T")
    every: float = option(0.05, "time between snapshots", unit="T")

    title: ClassVar[str] = "Cutting an organ"
    source: ClassVar[str] = "virtual cutting of a liver on particles, Hieber & Koumoutsakos"
    short: ClassVar[Mapping[str, Any]] = {"cells": 28, "largest_step": 0.125, "every": 0.5}

    def __post_init__(self) -> None:
        """Refuse meshes that do not see the blade, and a burr larger than the organ."""
        super().__post_init__()
        self.positive("cells", "burr", "largest_step", "every")
        self.require(self.cells >= 28, "cells", "at least 28")
        self.require(self.burr * self.cells >= 2.0, "burr", "at least two spacings")
        self.require(self.burr <= 0.3, "burr", "at most 0.3")
        self.require(0.0 <= self.breathing <= 0.3, "breathing", "between 0 and 0.3")

    @property
    def operation(self) -> Operation:
        """The organ and the tools."""
        return Operation(self.burr, self.breathing)

    def build(self) -> tuple[Any, Any]:
        """The organ on particles, in a box that holds it, and the tools."""
        from levelset.cutting import Cutting
        from levelset.transport import ParticleLevelSet

        h, (low, high) = 1.0 / self.cells, self.operation.organ.bounds()
        first = [math.floor(x / h) - 10 for x in low]
        high = (*high[:2], high[2] + self.breathing)
        shape = [math.ceil(x / h) + 11 - a for x, a in zip(high, first, strict=True)]
        grid = Grid(tuple(shape), h, tuple(h * a for a in first))
        carrier = ParticleLevelSet(grid=grid, velocity=self.operation.motion, remeshing="distorted")
        recipe = Cutting(
            carrier=carrier, tools=self.operation.tools, largest_step=self.largest_step
        )
        return recipe, recipe.start(self.operation.organ)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, and snapshots of the level set."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Ledger

        return [Ledger(), Snapshots(self.every, dtype="float32")]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Volume removed beside the volume swept; what is left; pieces; a cut in closed form."""
        series = outcome.series
        removed, end = float(series["removed"][-1]), float(series["time"][-1])
        whole, left = float(series["volume"][0]), float(series["volume"][-1])
        found = []
        swept = float(self.removed(np.array([end]))[0])
        if swept > 1e-3:
            found.append(Metric("volume removed", removed, swept, ALLOWED, "A-num", SWEPT))
        bored, exact = bore(self.burr, self.cells)
        found.append(Metric("removed by a ball in a block", bored, exact, ALLOWED, "A", BORE))
        off = (whole - left - removed) / whole
        found.append(Metric("volume lost otherwise, of the whole", off, 0.0, 1e-3, "A",
                            "what is not cut stays", "absolute"))  # fmt: skip
        pieces = float(series["pieces"][-1])
        if end >= 1.0:
            found.append(Metric("pieces", pieces, 2.0, 0.0, "A", "the blade goes through",
                                "absolute"))  # fmt: skip
        found.append(Metric("remeshings", float(series["remeshings"][-1]), 0.0, 0.0, "A",
                            "rigid motion", "absolute"))  # fmt: skip
        found.append(Metric("particles at the end", series["particles"][-1], kind="report"))
        return found

    def removed(self, times: Values) -> Values:
        """The volume that the tools have swept in the organ at some times [L^3]: exact shapes."""
        return np.array([swept_volume(self.operation, float(time)) for time in times])

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The organ at up to four times, the account of its volume, and the cuts in a section."""
        from matplotlib.figure import Figure

        end = outcome.state.time
        figure = Figure(figsize=(11.0, 6.1), layout="constrained")
        rows: Any = figure.subfigures(2, 1, height_ratios=(1.2, 1.0))
        shots = outcome.stages([0.2 * end, 0.5 * end, 0.75 * end, end])
        stages = rows[0].subplots(1, len(shots), squeeze=False)[0]
        for panel, shot in zip(stages, shots, strict=True):
            self._portrait(panel, shot)
        panels = rows[1].subplots(1, 3, width_ratios=(1.0, 1.0, 1.15))
        steps = outcome.series["time"][1:]
        count = min(TIMES, max(1, len(steps) // 4))  # one costs as much as some steps
        chosen = np.linspace(len(steps) - 1, 0, count, endpoint=False)[::-1]
        times = steps[chosen.round().astype(int)]
        swept = self.removed(times)
        self._account(panels[0], outcome.series, times, swept)
        self._error(panels[1], outcome.series, times, swept)
        self._section(panels[2], shots[-1])
        name_panels([*stages, *panels])
        figure.suptitle(
            f"An organ of {outcome.series['particles'][0] / 1000:.0f} thousand particles under a "
            f"burr and a blade, {self.cells} cells per unit length",
            fontsize=11,
        )
        return figure

    def _portrait(self, panel: Axes, shot: Any) -> None:
        """What is left, lit; what was removed, as a shade; the tools."""
        from pmesh.cases.surfaces import Layer, render, show_surface

        layers = []
        for phi, colour in zip(_parts(shot["level_set"]), (LIVER, PIECE, PIECE), strict=False):
            layers.append(Layer(surface=(phi, shot.grid), colour=colour))
        waste = self.operation.section(shot.time, shot.grid.points())[1]
        waste += 0.4 * shot.grid.spacing  # off the walls of the cut
        if (waste < 0).any():
            layers.append(Layer(surface=(waste, shot.grid), colour=WASTE, opacity=0.35))
        tool = self.operation.tools[0] if shot.time <= SWITCH else self.operation.tools[1]
        layers.append(Layer(surface=_drawn(tool.at(shot.time)), colour=TOOL))
        picture = render(*layers, bounds=BOUNDS, view=(-64.0, 30.0), size=(700, 620))
        show_surface(panel, picture, title=f"$t$ = {shot.time:g}")

    def _account(self, panel: Axes, series: Series, times: Values, swept: Values) -> None:
        """What is left and what was removed add up to the whole."""
        time, left, removed = series["time"], series["volume"], series["removed"]
        panel.stackplot(time, left, removed, colors=(LIVER, WASTE))
        panel.plot(times, left[0] - swept, "o", color="white", mec=REFERENCE, mew=1.3,
                   label="whole less swept, exact shapes")  # fmt: skip
        panel.axhline(left[0], color="black", lw=0.9, ls=":")
        bottom = float(f"{0.8 * left[-1]:.2g}")
        panel.set(title=f"where the volume is, from {bottom:g} up", xlabel="time $t$",
                  xlim=(0, time[-1]), ylim=(bottom, 1.06 * left[0]))  # fmt: skip
        panel.text(0.04 * time[-1], 0.92 * left[-1], "left", color="white")
        panel.text(0.97 * time[-1], 0.5 * (left[0] + left[-1]), "removed", ha="right", va="center")
        panel.legend(loc="lower right", labelcolor="white")

    def _error(self, panel: Axes, series: Series, times: Values, swept: Values) -> None:
        """Removed beside swept, and the balance of the account, in parts of the whole."""
        time, left, removed = series["time"], series["volume"], series["removed"]
        lost = np.abs(left[0] - left - removed) / left[0]
        off = np.abs(np.interp(times, time, removed) - swept) / np.maximum(swept, 1e-30)
        seen = swept > 1e-3
        panel.semilogy(times[seen], off[seen], "o-", color=OURS, label="removed off swept")
        panel.semilogy(time, np.maximum(lost, 1e-16), color=OTHERS[1],
                       label="lost otherwise, of the whole")  # fmt: skip
        panel.axhline(ALLOWED, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)), label="allowed")
        panel.set(title="errors", xlabel="time $t$", xlim=(0, time[-1]), ylim=(1e-9, 1.0))
        panel.legend(loc="lower right")

    def _section(self, panel: Axes, shot: Any) -> None:
        """A plane through both cuts at the end: ours over the exact shapes."""
        x, y, z = shot.grid.axes()
        row = int(np.abs(y - SECTION).argmin())
        places = np.stack(np.meshgrid(x, y[row], z, indexing="ij"))
        exact = self.operation.section(shot.time, places)[0][:, 0]
        ours = shot["level_set"][:, row].astype(np.float64)
        panel.contourf(x, z, ours.T, levels=[-1e9, 0.0], colors=[LIVER], alpha=0.25)
        panel.contour(x, z, exact.T, levels=[0.0], colors=[REFERENCE], linewidths=3.0, alpha=0.5)
        panel.contour(x, z, ours.T, levels=[0.0], colors=[OURS], linewidths=0.9)
        panel.plot([], [], color=OURS, lw=0.9, label="ours")
        panel.plot([], [], color=REFERENCE, lw=3.0, alpha=0.5, label="exact shapes")
        panel.set_aspect("equal")
        panel.set(title=f"section $y$ = {y[row]:.2f}", xlabel="$x$", ylim=(None, z[-1] + 0.2))
        panel.legend(loc="upper right", ncols=2)


def _parts(level_set: NDArray[Any]) -> list[Values]:
    """A level set for each connected piece, largest first; specks left out."""
    from scipy import ndimage

    phi = level_set.astype(np.float64)
    label, count = ndimage.label(phi < 0)
    sizes = np.bincount(label.ravel())[1:]
    order = [k for k in np.argsort(-sizes) if sizes[k] > 20]
    if len(order) < 2:
        return [phi] * count
    parts = []
    for k in order:
        near = ndimage.binary_dilation(label == k + 1, iterations=2, structure=np.ones((3, 3, 3)))
        near &= (label == k + 1) | (label == 0)
        parts.append(np.where(near, phi, np.abs(phi)))
    return parts


def _drawn(shape: Shape) -> tuple[Values, Grid]:
    """A shape on a mesh of its own, sixteen cells through it."""
    low, high = shape.bounds()
    h = 0.02
    count = [math.ceil((b - a) / h) + 5 for a, b in zip(low, high, strict=True)]
    grid = Grid(tuple(count), h, tuple(x - 2 * h for x in low))
    return shape.distance(grid.points()), grid
