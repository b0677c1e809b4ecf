"""The state of a vortex flow: exactly what a restart needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.pose import Pose
from remesh.grid import Grid
from remesh.multires.blocks import Blocks

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class Load:
    """What the fluid did to one body, as a mean over the last step, per unit density.

    The inertia of the fluid in the body's place is counted: this is what an outer fluid does.
    """

    force: tuple[float, ...]  # from the momentum of the force that holds it [L^(ndim+1)/T^2]
    torque: tuple[float, ...]  # about its centre, 1 or 3 numbers [L^(ndim+2)/T^2]
    power: float  # that the body gives to the fluid [L^(ndim+2)/T^3]


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """The force that holds the bodies after a step, and how well it does."""

    grid: Grid  # of the box around the bodies
    force: Array  # on the fluid, mean over the last step, (ndim, *grid.shape) [L/T^2]
    change: Array  # of that force since the step before, moved along with the bodies
    slip: float  # |u - u_s| inside the bodies, root mean square [L/T]
    slip_max: float  # the same, largest where chi > 1/2 [L/T]
    residual: float  # of the law that holds them, relative to the reference speed
    iterations: int


@dataclass(frozen=True, kw_only=True)
class Wake:
    """What a wake that left its window goes on to do, see `Window`."""

    flux: float = 0.0  # of its momentum deficit [L^ndim/T]
    circulation: float = 0.0  # that left lately [L^2/T]
    way: tuple[float, ...] = ()  # downwind, a unit vector while the wind is steady


NO_WAKE = Wake()


@dataclass(frozen=True, kw_only=True)
class FlowState:
    """What a vortex flow knows at one instant, on any mesh. A value: a step makes a new one."""

    time: float  # [T]
    step: int  # steps taken since the start
    grid: Grid  # the mesh now, the finest one if it is adaptive
    vorticity: Array  # on the nodes or blocks; in space three components in front [1/T]
    gradient: float  # largest |grad u| seen by the last step [1/T]
    speed: float  # largest |u| seen by the last step [L/T]
    poses: tuple[Pose, ...] = ()  # one per body
    earlier: tuple[Pose, ...] = ()  # the poses a step before; none at the start
    constraint: Constraint | None = None  # None without bodies
    loads: tuple[Load, ...] = ()  # one per body
    impulse_force: tuple[float, ...] = ()  # on all bodies, from the vorticity's impulse; in space
    # their torque about the origin too
    lost_circulation: float | Array = 0.0  # that left through unbounded edges since the start
    # [L^2/T]; in space the vector int w dV [L^3/T]

    @property
    def size(self) -> int:
        """Nodes that a step moves."""
        return self.grid.size


@dataclass(frozen=True, kw_only=True)
class State(FlowState):
    """A vortex flow on a uniform mesh, which may grow with the vorticity."""

    strengths: Array | None = None  # at home, of particles that were not remeshed [1/T]
    displacement: Array | None = None  # of those particles from home, (ndim, *shape) [L]
    wake: Wake = NO_WAKE  # that left a window


@dataclass(frozen=True, kw_only=True)
class AdaptiveState(FlowState):
    """A vortex flow on the blocks of an adaptive mesh."""

    blocks: Blocks
    busy: NDArray[np.bool_]  # cells of 4^ndim nodes that the mesh must follow, see `adapt`
    tolerance: float  # that the mesh was adapted to, relative to the largest vorticity

    @property
    def size(self) -> int:
        """Nodes that a step moves."""
        return self.blocks.active
