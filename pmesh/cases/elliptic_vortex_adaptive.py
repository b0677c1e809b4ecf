"""The elliptical vortex of Koumoutsakos (1997) on an adaptive mesh."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pmesh.cases.case import Outcome
from pmesh.cases.elliptic_vortex import EllipticVortexCase
from pmesh.cases.moments import vortex_moments
from pmesh.cases.options import option
from pmesh.cases.style import OURS
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.snapshots import Snapshot

AHEAD = 16.0  # tolerances from which details are resolved one level finer: by 2^4 they fall there
JUDGED = 1.0  # time at which few nodes are asked for; later filaments of the finest width fill all
COARSEST = 0.11  # spacing of the coarsest level at most [L]: its ends stay clear of the vortex
HALF = 1.4  # of the box, at least, as the uniform case has it
FULL = 1 / 256  # finest spacing [L] from which on few nodes are asked for
SHARE = 0.1  # of the nodes of the finest grid, at most


@dataclass(frozen=True, kw_only=True)
class EllipticVortexAdaptive(EllipticVortexCase):
    """An elliptical vortex sheds filaments; wavelets decide where the mesh is fine."""

    spacing: float = option(1 / 320, "finest mesh spacing", unit="L")
    levels: int = option(5, "how often the finest mesh can be halved")
    kernel: str = option("L6,4", "remeshing kernel")
    deformation: float = option(0.1, "largest dt * max|grad u|")
    tolerance: float = option(1e-4, "details below it are let go, relative to the vorticity")
    block: int = option(16, "nodes along the edge of a block: 16 or 32")

    title: ClassVar[str] = "Axisymmetrisation of an elliptical vortex, adaptive mesh"
    short: ClassVar[Mapping[str, Any]] = {
        "spacing": 1 / 80, "levels": 3, "tolerance": 1e-3, "until": 2.0, "every": 0.4,
    }  # fmt: skip

    def __post_init__(self) -> None:
        """Refuse what is no mesh."""
        super().__post_init__()
        self.require(0 < self.tolerance < 1, "tolerance", "between 0 and 1")
        self.require(self.block in (16, 32), "block", "16 or 32")
        most = math.floor(math.log2(COARSEST / self.spacing))
        self.require(1 <= self.levels <= most, "levels", f"from 1 to {most}", f"--levels {most}")

    def mesh(self) -> AdaptiveMesh:
        """The adaptive mesh, of whole blocks on all levels."""
        unit = self.block * 2**self.levels
        half = HALF + 2.0 * math.sqrt(4.0 * self.viscosity * self.until)
        nodes = unit * math.ceil(2.0 * half / self.spacing / unit)
        grid = Grid((nodes, nodes), self.spacing, (-0.5 * nodes * self.spacing,) * 2)
        return AdaptiveMesh(
            grid=grid, levels=self.levels, tolerance=self.tolerance, block=self.block,
            refinement=AHEAD * self.tolerance,
        )  # fmt: skip

    def recipe(self) -> Any:
        """None: the mesh follows the start, which has to be made first."""
        return None

    def build(self) -> tuple[Any, Any]:
        """The flow on an adaptive mesh, and the vortex at rest in it."""
        from pmesh.vortex.flow import VortexFlow

        flow = VortexFlow(
            grid=self.mesh(),
            viscosity=self.viscosity,
            kernel=self.kernel,
            deformation=self.deformation,
        )
        return flow, flow.start(vorticity=self.exact.vorticity)

    @property
    def drift(self) -> tuple[float, float]:
        """Allowed: what the mesh lets go of the circulation; of the second moments as elsewhere."""
        return self.tolerance, super().drift[1]

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the moments, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Forces, Ledger

        return [Forces(), Ledger(), watch_blocks, Snapshots(self.every, fields=["vorticity"])]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """What Euler flow keeps, how round the vortex became, and how few nodes it took."""
        series = outcome.series
        early = series["time"] <= JUDGED * (1 + 1e-9)
        share = 1.0 / float(np.min(series["compression"][early]))
        most = [float(np.max(series["active"][part])) for part in (early, slice(None))]
        return [
            *super().metrics(outcome),
            Metric(f"active nodes, largest for t <= {JUDGED:g}", most[0], kind="report"),
            share_metric(share, SHARE, full=self.spacing <= FULL),
            Metric("active nodes, largest", most[1], kind="report"),
        ]

    def _resolution(self, outcome: Outcome) -> str:
        most = float(np.max(outcome.series["active"]))
        finest = self.mesh().grid.size
        return (
            f"tolerance {self.tolerance:g}, h >= 1/{1 / self.spacing:.0f}, at most {most:,.0f} "
            f"active nodes (1/{finest / most:.0f} of the finest grid's)"
        )

    def _portrait(self, panel: Axes, shot: Snapshot) -> None:
        """Vorticity, and the mesh over it."""
        from pmesh.cases.mesh_picture import show_mesh
        from pmesh.run.amr import AdaptiveSnapshot

        super()._portrait(panel, shot)
        assert isinstance(shot, AdaptiveSnapshot)
        show_mesh(panel, shot.blocks, legend=False, width=0.5)
        panel.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05))

    def _kept(self, panel: Axes, outcome: Outcome) -> None:
        """Active nodes over time."""
        active = outcome.series["active"]
        panel.plot(outcome.series["time"], active, color=OURS)
        panel.set(title="active nodes", xlabel="time $t$", ylim=(0, 1.05 * float(active.max())))


def share_metric(share: float, allowed: float, *, full: bool) -> Metric:
    """Active nodes over those of the finest grid, judged at ``full`` resolution only."""
    name = "the same over the finest grid's"
    if not full:
        return Metric(name, share, kind="report")
    return Metric(name, share, 0.0, allowed, kind="absolute")


def watch_blocks(moment: Moment) -> dict[str, float]:
    """Watcher: second moments of the vorticity, from the coarsest level, and its extremes."""
    from remesh.multires.uniform import to_uniform

    state = moment.state
    coarse = to_uniform(state.vorticity, state.blocks, 0)
    columns = vortex_moments(coarse, state.blocks.mesh.level_grid(0))
    active = state.vorticity[state.blocks.leaves()]
    return columns | {"largest": float(active.max()), "smallest": float(active.min())}
