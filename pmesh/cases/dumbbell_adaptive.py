"""The collapsing dumbbell on an adaptive mesh: fine at the neck and the tips, coarse elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.active import active_nodes
from pmesh.cases.case import Case, Outcome
from pmesh.cases.dumbbell import MARGIN, STAGES, DumbbellCase, neck_of
from pmesh.cases.options import option
from pmesh.cases.style import REFERENCE, name_panels, styled
from pmesh.run.snapshots import Snapshots
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.cases.dumbbell_curve import Reference
    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series
    from pmesh.run.snapshots import Snapshot

Values = NDArray[np.float64]
BLOCK = 8  # nodes: the box is a whole number of them on the coarsest level
SHARE = 0.25  # of the nodes of a uniform mesh as fine everywhere: active nodes at most
LEVELS = ("#c8311b", "#e0a13a", "#2f8f5b", "#5b9bd5", "#a6a6a6", "#d3d3d3")  # the finest first


@dataclass(frozen=True, kw_only=True)
class DumbbellAdaptive(DumbbellCase):
    """Two balls joined by a bar shrink at their mean curvature; details decide where it is fine."""

    cells: int = option(128, "finest mesh cells per unit length")
    levels: int = option(3, "how often the finest mesh can be halved")
    tolerance: float = option(5e-3, "shift of the surface that is let go, in its own spacings")
    stretch: float = option(20.0, "time step over the explicit limit of the finest level in use")
    coarse: bool = option(True, "whether to run the uniform case with half the cells as well")

    title: ClassVar[str] = "Collapsing dumbbell, adaptive mesh"
    short: ClassVar[Mapping[str, Any]] = {
        "cells": 64,
        "levels": 2,
        "until": 0.01,
        "tolerance": 1e-2,
        "coarse": False,
        "every": 2e-3,
    }

    def __post_init__(self) -> None:
        """Refuse what is no mesh as well."""
        super().__post_init__()
        self.require(1 <= self.levels < len(LEVELS), "levels", f"from 1 to {len(LEVELS) - 1}")
        self.require(0 < self.tolerance < 0.25, "tolerance", "between 0 and 0.25")

    def mesh(self) -> AdaptiveMesh:
        """The mesh on a box with a node of all levels in its middle."""
        across = self.radius + MARGIN
        unit = BLOCK * 2 ** (self.levels - 1)
        h = 1.0 / self.cells
        half = [
            unit * math.ceil(self.cells * length / unit - 1e-9)
            for length in (0.5 * self.separation + across, across, across)
        ]
        grid = Grid([2 * n for n in half], h, [-n * h for n in half])
        return AdaptiveMesh(grid=grid, levels=self.levels, tolerance=self.tolerance, block=BLOCK)

    def build(self) -> tuple[Any, Any]:
        """The flow on the adaptive mesh, and the dumbbell's distance."""
        from levelset.curvature_flow import CurvatureFlow

        flow = CurvatureFlow(grid=self.mesh(), stretch=self.stretch)
        return flow, flow.start(self.shape)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the middle, pieces, symmetry and levels; snapshots of the last level but one.

        That level's nodes tell all: where the finest level is its nodes are the children of these.
        """
        shown = self.levels - 1
        return [*Case.watchers(self), Watch(shown), LevelSnapshots(self.every, shown)]

    def rougher(self) -> DumbbellCase:
        """The uniform case with half the cells."""
        known = {name: value for name, value in self.parameters().items()
                 if name not in ("levels", "tolerance", "stretch")}  # fmt: skip
        least = math.ceil(1.5 / self.bar)
        known |= {"cells": max(self.cells // 2, least), "coarse": False}
        return DumbbellCase(**known)

    @property
    def other(self) -> str:
        """What the uniform case is called."""
        return f"uniform, {self.rougher().cells} cells"

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """As of the uniform case; and how few nodes it took."""
        active = outcome.series["active"]
        most, mean = float(active.max()), float(active.mean())
        return [
            *super().metrics(outcome),
            Metric("active nodes, largest", most, kind="report"),
            Metric("active nodes, mean", mean, kind="report"),
            Metric("largest over those of a uniform mesh as fine", most / self._uniform(self.cells),
                   0.0, SHARE, kind="absolute"),
            Metric(f"largest over those of the {self.other}",
                   most / self._uniform(self.rougher().cells), kind="report"),
        ]  # fmt: skip

    def _uniform(self, cells: int) -> int:
        """Nodes of the uniform case."""
        return math.prod(2 * math.ceil(cells * half) + 1 for half in self._halves())

    def _halves(self) -> Sequence[float]:
        """Half the sides of the uniform case's box [L]."""
        across = self.radius + MARGIN
        return 0.5 * self.separation + across, across, across

    def _symmetry(self, largest: float) -> Metric:
        """Levels are refined in whole cells, which have no mirror images: not to round-off."""
        name, source = "asymmetry of the surface, in spacings", "the start is its own mirror image"
        return Metric(name, largest, 0.0, 0.05, "A", source, "absolute")

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """Surfaces; the active particles by their level; volume, neck and particles over time."""
        from matplotlib.figure import Figure

        known = self.reference()
        figure = Figure(figsize=(11.0, 7.1), layout="constrained")
        rows: Any = figure.subfigures(3, 1, height_ratios=(1.0, 0.98, 1.5))
        shots = outcome.stages([known.pinch * part for part in STAGES])
        shots = [*outcome.snapshots()[:1], *shots[1:]] if len(shots) > 1 else shots
        lit = rows[0].subplots(1, len(shots), squeeze=False)[0]
        cuts = rows[1].subplots(1, len(shots), squeeze=False)[0]
        panels = rows[2].subplots(1, 3)
        for above, below, shot in zip(lit, cuts, shots, strict=True):
            self._portrait(above, shot)
            self._particles(below, shot, known)
        self._legend(rows[1])
        self._volume(panels[0], outcome.series, known)
        self._middle(panels[1], outcome.series, known)
        self._active(panels[2], outcome.series, known)
        name_panels([*lit, *cuts, *panels])
        figure.suptitle(
            f"Dumbbell collapsing by its mean curvature: {self.cells} cells per unit length where "
            f"it is finest, {self.levels + 1} levels, tolerance {self.tolerance:g}",
            fontsize=11,
        )
        return figure

    def _particles(self, panel: Axes, shot: Snapshot, known: Reference) -> None:
        """The active particles in the middle plane, coloured by level, under the surface."""
        points, levels = particles(shot["level"], shot.grid, self.levels)
        for level in range(self.levels + 1):
            own = points[levels == level]
            size = 5.5 * 0.46**level
            x, y = own.T
            panel.scatter(x, y, s=size, color=self._colour(level), lw=0, rasterized=True)
        x, y, z = shot.grid.axes()
        cut = shot["phi"][:, :, len(z) // 2].T
        px, py = known.curve(shot.time).T
        for way, side in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            panel.plot(way * px, side * py, color=REFERENCE, lw=2.6, alpha=0.6)
        if cut.min() < 0:
            panel.contour(x, y, cut, levels=[0.0], colors=["black"], linewidths=0.7)
        panel.set_aspect("equal")
        panel.set(xlim=(x[0], -x[0]), ylim=(y[0], -y[0]), xticks=[], yticks=[])
        panel.set_title(f"{len(points)} particles in the middle plane")
        panel.grid(visible=False)

    def _colour(self, level: int) -> str:
        """The colour of a level."""
        return LEVELS[self.levels - level]

    def _legend(self, row: Any) -> None:
        """What the colours are."""
        from matplotlib.lines import Line2D

        marks: list[Any] = [
            Line2D([], [], ls="", marker="o", ms=4, color=self._colour(level),
                   label=f"h = 1/{self.cells // 2 ** (self.levels - level)}")
            for level in range(self.levels + 1)
        ]  # fmt: skip
        row.legend(handles=marks, loc="outside lower center", ncols=len(marks))

    def _active(self, panel: Axes, series: Series, known: Reference) -> None:
        """Active particles over time, level upon level; what uniform meshes have."""
        counts = [series[f"level_{level}"] / 1e3 for level in range(self.levels + 1)]
        panel.stackplot(
            series["time"],
            counts,
            colors=[self._colour(level) for level in range(self.levels + 1)],
            lw=0,
        )
        panel.axvline(known.pinch, color="black", lw=0.9, ls=(0, (4, 3)), label="pinch-off")
        panel.set(title="active particles, thousands", xlabel="time $t$", xlim=(0, None))
        panel.set_ylim(0, 1.15 * float(np.sum(counts, axis=0).max()))
        panel.legend()


class Watch:
    """Watcher: phi in the middle, the neck, pieces, asymmetry; active particles of each level."""

    def __init__(self, level: int) -> None:
        self.level = level  # on whose nodes it looks

    def __call__(self, moment: Moment) -> dict[str, float]:
        """The columns of a moment."""
        from scipy.ndimage import label

        flow, state = moment.flow, moment.state
        phi = flow.to_uniform(state, self.level)
        i, j, k = (n // 2 for n in phi.shape)
        line: Values = np.asarray(phi[i, j:, k], np.float64)
        columns = {
            "middle": float(phi[i, j, k]),
            "neck": neck_of(line, flow.mesh.spacing(self.level)),
            "pieces": float(label(phi < 0)[1]),
            "asymmetry": asymmetry(phi, flow.mesh.spacing(self.level)) / flow.mesh.grid.spacing,
        }
        return columns | {f"level_{n}": float(count) for n, count in enumerate(state.counts)}


class LevelSnapshots(Snapshots):
    """Snapshots of the fields on all nodes of one level."""

    def __init__(self, every: float, level: int) -> None:
        super().__init__(every, dtype="float32")
        self.level = level

    def __call__(self, moment: Moment) -> None:
        """Write a snapshot if it is time for one."""
        flow, state = moment.flow, moment.state
        told = SimpleNamespace(fields=lambda _: {
            "phi": flow.to_uniform(state, self.level), "level": flow.levels(state, self.level)
        })  # fmt: skip
        grid = flow.mesh.level_grid(self.level)
        at = SimpleNamespace(grid=grid, time=state.time, step=state.step)
        super().__call__(replace(moment, flow=told, state=at))


def asymmetry(phi: Values, near: float) -> float:
    """Largest change of phi [L] by a mirror image, where it is within ``near`` [L] of the surface.

    The box has one node more on the side of its first ones.
    """
    whole = phi[(slice(1, None),) * phi.ndim]
    close = np.abs(whole) < near
    return max(
        float(np.abs(whole - np.flip(whole, axis)).max(where=close, initial=0.0))
        for axis in range(phi.ndim)
    )


def particles(field: NDArray[Any], grid: Grid, finest: int) -> tuple[Values, NDArray[np.int64]]:
    """The active particles in the middle plane of a snapshot: places (n, 2), and their levels.

    ``field``: the level in use at the nodes of ``grid``, of the last level but one, ``finest - 1``.
    """
    cut = np.rint(field[:, :, field.shape[2] // 2]).astype(np.int64)
    nodes, known = active_nodes(cut, finest - 1)
    own = np.argwhere(cut == finest)
    children = [own + 0.5 * np.array(shift) for shift in np.ndindex(2, 2)]
    levels = np.concatenate([known, np.full(4 * len(own), finest)])
    places = np.array(grid.origin)[:2] + grid.spacing * np.concatenate([nodes, *children])
    return places, levels
