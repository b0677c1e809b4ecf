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
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from pmesh.run.protocols import Moment, Watcher

HALF = 1.4  # of the box, at least, as the uniform case has it
SHARE = 0.1  # of the nodes of the finest grid, at most


@dataclass(frozen=True, kw_only=True)
class EllipticVortexAdaptive(EllipticVortexCase):
    """An elliptical vortex sheds filaments; wavelets decide where the mesh is fine."""

    spacing: float = option(1 / 320, "finest mesh spacing", unit="L")
    levels: int = option(5, "how often the finest mesh can be halved")
    tolerance: float = option(1e-4, "details below it are let go, relative to the vorticity")
    block: int = option(16, "nodes along the edge of a block: 8, 16 or 32")

    title: ClassVar[str] = "Axisymmetrisation of an elliptical vortex, adaptive mesh"
    short: ClassVar[Mapping[str, Any]] = {
        "spacing": 1 / 80, "levels": 3, "tolerance": 1e-3, "until": 2.0, "every": 0.4,
    }  # fmt: skip

    def mesh(self) -> AdaptiveMesh:
        """The adaptive mesh, of whole blocks on all levels."""
        unit = self.block * 2**self.levels
        half = HALF + 2.0 * math.sqrt(4.0 * self.viscosity * self.until)
        nodes = unit * math.ceil(2.0 * half / self.spacing / unit)
        grid = Grid((nodes, nodes), self.spacing, (-0.5 * nodes * self.spacing,) * 2)
        return AdaptiveMesh(
            grid=grid, levels=self.levels, tolerance=self.tolerance, block=self.block
        )

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

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the moments, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Forces, Ledger

        return [Forces(), Ledger(), watch_blocks, Snapshots(self.every, fields=["vorticity"])]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """What Euler flow keeps, how round the vortex became, and how few nodes it took."""
        series = outcome.series
        share = 1.0 / float(np.min(series["compression"]))
        most = float(np.max(series["active"]))
        return [
            *super().metrics(outcome),
            Metric("active nodes, largest", most, kind="report"),
            Metric("the same over the finest grid's", share, 0.0, SHARE, kind="absolute"),
        ]


def watch_blocks(moment: Moment) -> dict[str, float]:
    """Watcher: second moments of the vorticity, from the coarsest level, and its extremes."""
    from remesh.multires.uniform import to_uniform

    state = moment.state
    coarse = to_uniform(state.vorticity, state.blocks, 0)
    columns = vortex_moments(coarse, state.blocks.mesh.level_grid(0))
    active = state.vorticity[state.blocks.leaves()]
    return columns | {"largest": float(active.max()), "smallest": float(active.min())}
