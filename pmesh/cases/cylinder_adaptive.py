"""The impulsively started cylinder on an adaptive mesh, up to Re = 9500."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from levelset.shapes import Disk
from pmesh.cases.case import Outcome
from pmesh.cases.cylinder import Cylinder
from pmesh.cases.elliptic_vortex_adaptive import share_metric
from pmesh.cases.options import option
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pmesh.run.snapshots import Snapshot

NODES = {550.0: 112, 3000.0: 272, 9500.0: 512}  # per diameter
BOX = ((-4.0, 12.0), (-4.0, 4.0))  # that the coarsest level covers, at least [R]
FULL = 256  # nodes per diameter from which on few nodes are asked for
SHARE = 0.04  # of the nodes of the finest grid, at most
CLEAR = 0.4  # coarsest spacing at most [R]: its nodes at the ends must stay clear of vorticity
ROOT = 32  # nodes of the coarsest level across the box, at least


@dataclass(frozen=True, kw_only=True)
class CylinderAdaptive(Cylinder):
    """A cylinder is set in motion at once; wavelets decide where the mesh is fine.

    As fine at the wall as ``nodes`` says, coarse where nothing happens: Re = 9500 in a box of 16 by
    8 radii. Lengths in radii and velocities in the free stream's, so that time is T = U t / R.
    """

    nodes: int | None = option(
        None, "finest mesh nodes per diameter; 112, 272, 512 at Re = 550, 3000, 9500 if not given"
    )
    tolerance: float = option(
        1e-6, "slip residual of the penalisation; the mesh has --mesh-tolerance", unit="U"
    )
    mesh_tolerance: float = option(
        1e-4, "details below it are let go, relative to the largest vorticity"
    )
    levels: int | None = option(
        None, "how often the finest mesh can be halved; fitting if not given"
    )

    title: ClassVar[str] = "Impulsively started cylinder, adaptive mesh"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 48, "until": 0.6, "mesh_tolerance": 1e-3}

    def __post_init__(self) -> None:
        """Refuse what is outside the case."""
        super().__post_init__()
        self.require(0 < self.mesh_tolerance < 1, "mesh_tolerance", "between 0 and 1")
        most = math.floor(math.log2(CLEAR / self.spacing))
        held = self.levels is None or 1 <= self.levels <= most
        self.require(held, "levels", f"from 1 to {most}", f"--levels {most}")

    @property
    def spacing(self) -> float:
        """Finest mesh spacing [R]."""
        return 2.0 / (
            self.nodes or NODES.get(self.reynolds) or 16 * round(0.33 * math.sqrt(self.reynolds))
        )

    def mesh(self) -> AdaptiveMesh:
        """The adaptive mesh: a box much larger than the wake, in whole blocks on all levels."""
        sides = [high - low for low, high in BOX]
        levels = self.levels or max(1, math.floor(math.log2(min(sides) / self.spacing / ROOT)))
        unit = 16 * 2**levels
        shape = tuple(unit * math.ceil(side / self.spacing / unit) for side in sides)
        first = round(BOX[0][0] / self.spacing), -shape[1] // 2  # the wake in the middle
        origin = tuple((0.5 + n) * self.spacing for n in first)
        grid = Grid(shape, self.spacing, origin)
        return AdaptiveMesh(grid=grid, levels=levels, tolerance=self.mesh_tolerance)

    def build(self) -> tuple[Any, Any]:
        """The flow on an adaptive mesh."""
        from pmesh.bodies.body import RigidBody
        from pmesh.bodies.penalise import Penalisation
        from pmesh.vortex.flow import VortexFlow

        flow = VortexFlow(
            grid=self.mesh(),
            viscosity=self.viscosity,
            freestream=(1.0, 0.0),
            bodies=(RigidBody(Disk(radius=1.0)),),
            deformation=self.deformation,
            kernel=self.kernel,
            penalisation=Penalisation(
                strength=self.strength, width=self.width, tolerance=self.tolerance
            ),
        )
        return flow, flow.start()

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Drag beside the published curve and the short-time law; how few nodes it took."""
        series = outcome.series
        share = 1.0 / float(np.min(series["compression"]))
        most = float(np.max(series["active"]))
        return [
            *super().metrics(outcome),
            Metric("active nodes, largest", most, kind="report"),
            share_metric(share, SHARE, full=2.0 / self.spacing >= FULL),
        ]

    def _draw_fields(self, panels: Sequence[Axes], shots: Sequence[Snapshot]) -> None:
        """Vorticity to one scale, and the mesh over the last."""
        from pmesh.cases.mesh_picture import show_mesh
        from pmesh.run.amr import AdaptiveSnapshot

        super()._draw_fields(panels, shots)
        panel, shot = panels[-1], shots[-1]
        assert isinstance(shot, AdaptiveSnapshot)
        around = panel.get_xlim(), panel.get_ylim()
        show_mesh(panel, shot.blocks, legend=False, width=0.4)
        panel.set(xlim=around[0], ylim=around[1])
