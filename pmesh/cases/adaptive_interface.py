"""What the reversed-flow cases on adaptive meshes share: particles of several levels, a study."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.transport import ParticleLevelSet
from pmesh.cases.active import active_nodes
from pmesh.cases.case import Outcome
from pmesh.cases.deformation import BACK, DEFORMED, KEPT, Reversed, ReversedCase
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE
from pmesh.run.summary import Metric
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pmesh.run.snapshots import Snapshot

BLOCK = 8  # nodes: the finest mesh is a whole number of them on the coarsest level
COLOURS = ("#d9d9d9", "#9ec9e2", "#3c93c2", "#0b559f", "#c8511b", "#5c1a0a")  # of the levels


class Run(NamedTuple):
    """What a run of the whole period took, and how far off it ended."""

    start: int  # active particles
    most: int
    end: int
    volume: float  # relative error
    error: float  # L1, of the interface [L]


@dataclass(frozen=True, kw_only=True)
class AdaptiveReversed(Reversed):
    """Base: a reversed case on particles of several spacings, as fine as a tolerance asks."""

    levels: int = option(4, "how often the finest mesh is halved")
    tolerance: float = option(0.01, "displacement of the interface over the band's half width")
    refinement: float = option(2.0, "threshold of refining over that of coarsening")
    study: bool = option(True, "whether to run with other tolerances and uniform meshes as well")

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.require(1 <= self.refinement < math.inf, "refinement", "at least 1")
        self.require(0 < self.tolerance < 1, "tolerance", "between 0 and 1")
        unit = self.unit
        near = f"--nodes {max(1, round(self.nodes / unit)) * unit}, or fewer --levels"
        what = f"a multiple of {unit} for {self.levels} halvings"
        self.require(self.nodes % unit == 0, "nodes", what, near)
        _ = self.mesh  # which refuses what else is none

    def check_band(self) -> None:
        """Refuse no levels, and a band too narrow for the kernel on the coarsest of them."""
        self.require(1 <= self.levels <= 20, "levels", "from 1 to 20")
        if self.width >= self.least:
            return
        ways = [f"--levels {fewer}" for fewer in range(self.levels - 1, 0, -1)
                if self.band * self.nodes >= self.least * 2**fewer][:1]  # fmt: skip
        needed = self.unit * math.ceil(self.least * 2**self.levels / self.band / self.unit)
        ways += [f"--nodes {needed}"] if needed <= 4 * self.nodes else []
        wide = math.ceil(1e4 * self.least * 2**self.levels / self.nodes) / 1e4
        ways += [f"--band {wide:g}"] if wide <= 0.5 else []
        raise InputError(
            f"band and levels must leave at least {self.least} coarsest cells to each side, got "
            f"{self.width:.3g}: {self.band:g} after {self.levels} halvings of 1/{self.nodes}",
            hint=" or ".join(ways) or "a wider --band and more --nodes",
        )

    @property
    def unit(self) -> int:
        """What the number of cells is a multiple of: blocks on the coarsest level."""
        return BLOCK * int(2**self.levels)

    @property
    def least(self) -> int:
        """Cells that the band has at least to each side: what the kernel reads."""
        return get_kernel(self.kernel).half_width

    @property
    def mesh(self) -> AdaptiveMesh:
        """The unit box, periodic, so that all levels have the same ends."""
        grid = Grid((self.nodes,) * self.law.ndim, self.spacing, boundary="periodic")
        return AdaptiveMesh(
            grid=grid, levels=self.levels, block=BLOCK, tolerance=self.tolerance,
            refinement=self.refinement * self.tolerance,
        )  # fmt: skip

    @property
    def width(self) -> float:
        """Half width of the band in cells of the coarsest level."""
        return self.band * self.nodes / float(2**self.levels)

    @property
    def parts(self) -> tuple[float, ...]:
        """Tolerances of the study over that of the run; those that are none are left out."""
        return (4.0, 0.25, 0.1)

    @abstractmethod
    def uniform(self, nodes: int) -> ReversedCase:
        """The same on a uniform mesh, with the same time step."""

    def build(self) -> tuple[Any, Any]:
        """Particles around the body's surface, in the unit box."""
        step = self.courant * self.spacing / self.law.max_speed(0.0)
        asked = math.ceil(step * self.law.max_gradient(0.0) / DEFORMED)
        flow = ParticleLevelSet(
            grid=self.mesh, velocity=self.law, kernel=self.kernel, width=self.width,
            remeshing=self.remeshing, substeps=self.substeps or asked, deformation=DEFORMED,
            largest_step=step,
        )  # fmt: skip
        return flow, flow.start(self.shape)

    def of_volume(self, outcome: Outcome, name: str, allowed: float) -> list[Metric]:
        """The volume at the start, where it is farthest off, and at the end."""
        exact, found = self.shape.volume, outcome.series["volume"]
        worst = float(found[np.abs(found - exact).argmax()])
        metrics = [
            Metric(f"{name} at t = 0", found[0], exact, 1e-3, "A", "closed form"),
            Metric(f"{name} where it is farthest off", worst, exact, allowed, "A", KEPT),
        ]
        if self.back(outcome):
            metrics.append(
                Metric(f"{name} back at the start", found[-1], exact, allowed, "A", BACK)
            )
        return metrics

    def of_particles(self, outcome: Outcome) -> list[Metric]:
        """Active particles at the start, at the most and at the end; what a uniform mesh has."""
        active, stored = outcome.series["active"], outcome.series["particles"]
        return [
            Metric("active particles at t = 0", active[0], kind="report"),
            Metric("active particles at the most", active.max(), kind="report"),
            Metric("active particles at the end", active[-1], kind="report"),
            Metric("particles of all levels at the most", stored.max(), kind="report"),
            Metric("least compression", outcome.series["compression"].min(), kind="report"),
            Metric("largest Courant number", self.courant, kind="report"),
        ]

    def of_error(self, outcome: Outcome) -> list[Metric]:
        """The L1 error of the interface over what the tolerance allows, and in finest cells."""
        if not self.back(outcome):
            return []
        own = self.error(outcome.flow, outcome.state)
        allowed = self.tolerance * self.band
        return [
            Metric("L1 interface error over tolerance times half width", own / allowed, 0.0, 2.0,
                   "A", BACK, "absolute"),
            Metric("L1 interface error in finest cells", own * self.nodes, kind="report"),
        ]  # fmt: skip

    def runs(self, outcome: Outcome) -> tuple[dict[float, Run], dict[int, Run]]:
        """Runs by tolerance, this one among them, and by nodes of a uniform mesh."""
        active, volume = outcome.series["active"], outcome.series["volume"][-1]
        off = float(volume / self.shape.volume - 1.0)
        error = self.error(outcome.flow, outcome.state)
        own = Run(int(active[0]), int(active.max()), int(active[-1]), off, error)
        if not self.study:
            return {self.tolerance: own}, {}
        case = replace(self, until=self.period, study=False)
        tolerances = [self.tolerance * part for part in self.parts]
        others = {key: _run_of(replace(case, tolerance=key)) for key in tolerances if key < 1}
        meshes = [self.nodes // part for part in (8, 4, 2)]
        return (
            dict(sorted({**others, self.tolerance: own}.items())),
            {
                nodes: _run_of(self.uniform(nodes))
                for nodes in meshes
                if self.band * nodes >= self.least
            },
        )


@lru_cache(maxsize=16)
def _run_of(case: Reversed) -> Run:
    """A case run to its end, without a directory."""
    from pmesh.run.loop import run

    sizes: list[int] = []
    flow, start = case.build()
    end = run(flow, start, until=case.until, watch=[lambda now: sizes.append(now.state.size)])
    off = flow.ledger(end)["volume"] / case.shape.volume - 1.0
    return Run(start.size, max(sizes), end.size, off, case.error(flow, end))


def active_particles(shot: Snapshot, levels: int) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Where the active particles of a snapshot are (n, ndim) [L], and their levels."""
    nodes, known = active_nodes(np.asarray(shot["level"]), levels)
    return np.array(shot.grid.origin) + shot.grid.spacing * nodes, known


def draw_counts(panel: Axes, outcome: Outcome, mark: int, label: str) -> None:
    """Active particles over time, beside a number of nodes."""
    series = outcome.series
    panel.semilogy(series["time"], series["particles"], color=OTHERS[2], lw=1.0, label="all levels")
    panel.semilogy(series["time"], series["active"], color=OURS, label="active")
    panel.axhline(mark, color=REFERENCE, lw=1.0, ls=(0, (4, 3)), label=label)
    panel.set(title="particles", xlabel="time $t$")
    panel.legend(loc="lower center", fontsize=7)


def draw_volume(panel: Axes, outcome: Outcome, exact: float, allowed: float, name: str) -> None:
    """Error of the volume over time."""
    series = outcome.series
    off = 100.0 * (series["volume"] / exact - 1.0)
    panel.axhspan(-100 * allowed, 100 * allowed, color=REFERENCE, alpha=0.12, lw=0,
                  label=f"within {100 * allowed:g} %")  # fmt: skip
    panel.plot(series["time"], off, color=OURS)
    top = max(130 * allowed, 1.1 * float(np.abs(off).max()))
    panel.set(title=f"error of the {name} [%]", xlabel="time $t$", ylim=(-top, top))
    panel.legend(loc="upper left", fontsize=7)


def draw_study(panel: Axes, adaptive: dict[float, Run], uniform: dict[int, Run], name: str) -> None:
    """Error of the volume after the period over particles at the start, the most and the end."""
    for runs, colour, label in ((adaptive, OURS, "adaptive"), (uniform, OTHERS[1], "uniform")):
        rows = sorted(runs.values())
        off = [100 * max(abs(row.volume), 1e-6) for row in rows]
        panel.loglog([row.start for row in rows], off, "o:", color=colour, mfc="white", lw=0.8,
                     label=f"{label}, start")  # fmt: skip
        panel.loglog([row.end for row in rows], off, "s--", color=colour, mfc="white", lw=0.8,
                     label=f"{label}, end")  # fmt: skip
        panel.loglog([row.most for row in rows], off, "o-", color=colour, label=f"{label}, most")
    panel.set(title=f"final error of the {name} [%]", xlabel="active particles")
    _make_room(panel, 0.6)
    panel.legend(loc="upper right", fontsize=5.5, ncols=2, handlelength=1.6, columnspacing=0.8)


def draw_errors(
    panel: Axes, adaptive: dict[float, Run], uniform: dict[int, Run], half_width: float
) -> None:
    """L1 errors of the interface by tolerance, and of uniform meshes as lines across."""
    tolerances = np.array(list(adaptive))
    panel.loglog(tolerances, [run.error for run in adaptive.values()], "o-", color=OURS,
                 label="adaptive")  # fmt: skip
    panel.loglog(tolerances, tolerances * half_width, color=OTHERS[0], lw=0.9, ls=(0, (4, 3)),
                 label="tolerance x half width")  # fmt: skip
    for nodes, run in uniform.items():
        panel.axhline(run.error, color=OTHERS[1], lw=0.8)
        panel.annotate(f"uniform, 1/{nodes}", (0.3, run.error), fontsize=7, color=OTHERS[1],
                       va="bottom", xycoords=("axes fraction", "data"))  # fmt: skip
    panel.set_xticks(tolerances, [f"{tolerance:g}" for tolerance in tolerances])
    panel.minorticks_off()
    panel.set(title="L1 error of the interface [L]", xlabel="tolerance")
    _make_room(panel, 0.5)
    panel.legend(loc="upper center", fontsize=6.5, ncols=2, columnspacing=0.8)


def _make_room(panel: Axes, share: float) -> None:
    """Leave room for a legend above logarithmic data: a share of their height."""
    low, high = panel.get_ylim()
    panel.set_ylim(low, high * (high / low) ** share)
