"""What steps a vortex flow on its kind of mesh, and how all of them hold bodies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.pose import Pose
from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.constraint import Wall
from pmesh.vortex.solvers import solver_for
from pmesh.vortex.state import FlowState, Load
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]
S = TypeVar("S", bound=FlowState)

EDGE = 3  # nodes from the edge of a fixed mesh within which vorticity is about to leave it
SLAB = 65_536  # nodes squared in one go
LEE = 0.1  # of the largest speed: bodies are held to that where they feel less wind


class Engine(ABC, Generic[S]):
    """The start and the step of a vortex flow, and what can be read from its states."""

    kind: ClassVar[type[FlowState]]  # of its states

    def __init__(self, flow: VortexFlow) -> None:
        self.flow = flow

    def check(self, state: FlowState) -> None:
        """Refuse a state of another kind of mesh."""
        if not isinstance(state, self.kind):
            raise InputError(
                f"the flow steps a {self.kind.__name__}, got a {type(state).__name__}",
                hint="the mesh that the state was made on, or flow.start(...)",
            )
        given = state.vorticity.dtype
        if given != self.flow.dtype:
            raise InputError(
                f"the flow computes in {self.flow.dtype}, the state is in {given}",
                hint=f'dtype="{given}", or flow.start(...)',
            )

    @abstractmethod
    def start(self, vorticity: Array | Callable[[Array], Array] | None) -> S:
        """See `VortexFlow.start`."""

    @abstractmethod
    def step(self, state: S, dt: float) -> S:
        """See `VortexFlow.step`; dt has been checked."""

    @abstractmethod
    def velocity(self, state: S) -> Array:
        """Velocity on the nodes, free stream included [L/T]."""

    @abstractmethod
    def ledger(self, state: S) -> Mapping[str, float]:
        """Integrals of the vorticity, and what the mesh holds."""

    @abstractmethod
    def fields(self, state: S) -> Mapping[str, Array]:
        """Fields by name."""

    def wall_on(self, grid: Grid, poses: tuple[Pose, ...]) -> Wall:
        """The bodies at these poses on a mesh."""
        flow = self.flow
        return Wall(
            bodies=flow.bodies, poses=poses, grid=grid, viscosity=flow.viscosity,
            settings=flow.penalisation, order=flow.order, radius=flow.radius, solver=self.solver,
        )  # fmt: skip

    def solver(self, grid: Grid) -> VelocitySolver:
        """The velocity solver of a uniform mesh."""
        flow = self.flow
        return solver_for(
            grid, order=flow.order, radius=flow.radius, dtype=flow.dtype, threads=flow.threads
        )

    def launched(self, wall: Wall, velocity: Array) -> tuple[Array, dict[str, Any]]:
        """Bodies set in motion at once: the vorticity of their sheet, and what a state keeps.

        ``velocity``: of the flow without them, on the wall's mesh [L/T].
        """
        speed = self.reference(largest(velocity), wall.poses)
        imposed, created = wall.start(velocity, speed)
        nothing = np.zeros_like(imposed.impulse)
        turns = 1 if wall.grid.ndim == 2 else 3
        unknown = Load(
            force=(math.nan,) * wall.grid.ndim, torque=(math.nan,) * turns, power=math.nan
        )
        return created, {
            "constraint": wall.held(imposed, nothing, nothing),
            "loads": (unknown,) * len(wall.poses),
        }

    def wind(self, poses: tuple[Pose, ...]) -> Array:
        """The stream that the bodies feel on the whole [L/T]."""
        return np.asarray(self.flow.freestream - np.mean([pose.velocity for pose in poses], axis=0))

    def reference(self, speed: float, poses: tuple[Pose, ...]) -> float:
        """The speed that a slip is compared with: the largest of the wind, a tenth of the flow's
        largest (bodies that go with the stream feel no wind) and that of viscosity on the bodies.
        """
        size = max(body.length for body in self.flow.bodies)
        return max(float(np.linalg.norm(self.wind(poses))), LEE * speed, self.flow.viscosity / size)


def largest(velocity: Array) -> float:
    """Largest |u| over the nodes; slab by slab, that squares take no memory."""
    thick = max(1, SLAB // max(1, velocity[0, 0].size))
    slabs = (velocity[:, low : low + thick] for low in range(0, velocity.shape[1], thick))
    squares = [np.einsum("i...,i...->...", slab, slab).max() for slab in slabs]
    return math.sqrt(float(np.max(squares)))
