"""A flow that carries an interface with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.interface import Interface
from levelset.sampled import Sampled
from levelset.shape import Shape
from levelset.transport import ParticleLevelSet
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.flowmap import VelocityHistory
from pmesh.vortex.state import State
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.limit import Limit, check_step, tightest
from remesh.transfer import m2p

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class Carriage:
    """A flow and the interface in it at one instant. A value: a step makes a new one."""

    time: float  # [T]
    step: int  # steps taken since the start
    grid: Grid  # of the interface
    flow: State
    interface: Interface

    @property
    def size(self) -> int:
        """Nodes of the flow and particles of the interface that a step moves."""
        return self.flow.size + self.interface.size


@dataclass(frozen=True, kw_only=True)
class Carrier:
    """An interface that goes with a flow, and does not act on it.

    In each step the flow goes ahead; the interface's particles follow in its velocity, which is
    straight in time between the step's ends and interpolated in space: second order in dt, of the
    kernel's order in the flow's spacing. The interface has a mesh of its own, that of the flow's
    start if none is given. ``options`` are those of `levelset.ParticleLevelSet`, all but its grid
    and velocity; ``remeshing`` is every step by default, and one that only turns needs none:

        dye = Carrier(flow=flow, grid=fine, options={"remeshing": "distorted", "kernel": "M8'"})
        state = pmesh.run(dye, dye.start(Disk(0.2), vorticity=vorticity), until=2.0)
        body = dye.shape(state)

    A body in the flow carries an interface inside it as it moves itself. Refuses a 3-D flow, and an
    interface that leaves the flow's mesh, where no velocity is known. Cost: that of the flow, of a
    velocity solve at both ends of a step, and of the interface.
    """

    flow: VortexFlow
    grid: Grid | None = None  # of the interface
    options: Mapping[str, Any] = field(default_factory=dict)  # of the interface, as above

    def __post_init__(self) -> None:
        """Refuse what is not a flow or a grid, and options that no interface has."""
        if not isinstance(self.flow, VortexFlow):
            raise InputError(f"flow must be a VortexFlow, got {self.flow!r}",
                             hint="Carrier(flow=VortexFlow(grid=grid))")  # fmt: skip
        if not isinstance(self.flow.grid, Grid):
            raise InputError(
                "an interface goes with a flow on a uniform grid, this one is adaptive",
                hint="VortexFlow(grid=remesh.Grid((256, 256), 1 / 64))",
            )
        if self.grid is not None and not isinstance(self.grid, Grid):
            raise InputError(f"grid of the interface must be a Grid, got {self.grid!r}",
                             hint="grid=remesh.Grid((128, 128), 1 / 64)")  # fmt: skip
        if self.grid is not None and self.grid.ndim != self.flow.lattice.ndim:
            raise InputError(
                f"the interface's grid has {self.grid.ndim} dimensions, the flow's "
                f"{self.flow.lattice.ndim}", hint="grids of one dimension",
            )  # fmt: skip
        if not isinstance(self.options, Mapping):
            raise InputError(f"options of the interface must be a dict, got {self.options!r}",
                             hint="options={'remeshing': 'distorted'}")  # fmt: skip
        given = sorted({"grid", "velocity"} & set(self.options))
        if given:
            raise InputError(
                f"options may not hold {given}: the flow is the velocity",
                hint="Carrier(flow=..., grid=..., options={'remeshing': 'distorted'})",
            )
        try:
            self._level_set(_rest)
        except TypeError as error:
            raise InputError(
                f"options of the interface: {error}", hint="those of levelset.ParticleLevelSet"
            ) from error

    def start(
        self,
        shape: Shape | Array,
        *,
        vorticity: Array | Callable[[Array], Array] | None = None,
    ) -> Carriage:
        """The flow at time 0, as `VortexFlow.start` takes it, with an interface around a shape.

        ``shape``: a shape, or a level set on the interface's grid.
        """
        flow = self.flow.start(vorticity=vorticity)
        interface = self._level_set(self._velocity(flow)).start(shape)
        return Carriage(time=0.0, step=0, grid=interface.grid, flow=flow, interface=interface)

    def step(self, state: Carriage, dt: float) -> Carriage:
        """The flow and the interface one step of dt [T] later."""
        dt = check_step(dt)
        before = replace(state.flow, time=state.time)
        after = self.flow.step(before, dt)
        level_set = self._level_set(self._velocity(before, after))
        interface = level_set.step(replace(state.interface, time=state.time), dt)
        return replace(state, time=after.time, step=state.step + 1, flow=after, interface=interface)

    def limit(self, state: Carriage) -> Limit:
        """The smaller of both limits; the interface's rule is called "interface"."""
        own = self.level_set.limit(state.interface)
        return tightest(self.flow.limit(state.flow), Limit(own.dt, "interface"))

    def ledger(self, state: Carriage) -> Mapping[str, float]:
        """The flow's ledger, and the interface's as ``interface_volume`` and so on."""
        own = self.level_set.ledger(state.interface)
        return {
            **self.flow.ledger(state.flow),
            **{f"interface_{name}": value for name, value in own.items()},
        }

    def band(self, state: Carriage) -> Band:
        """The level set on the nodes near the interface: see `ParticleLevelSet.band`."""
        return self.level_set.band(state.interface)

    def distance(self, state: Carriage) -> Band:
        """The signed distance [L] on the nodes near the interface."""
        return self.level_set.distance(state.interface)

    def shape(self, state: Carriage) -> Sampled:
        """The interface as a shape: a body for a flow, something to measure."""
        return self.level_set.shape(state.interface)

    def forces(self, state: Carriage) -> Mapping[str, float]:
        """Those of the flow on its bodies."""
        return self.flow.forces(state.flow)

    def routes(self, before: Carriage, after: Carriage) -> Mapping[str, float]:
        """Those of the flow: see `VortexFlow.routes`."""
        return self.flow.routes(before.flow, after.flow)

    @property
    def route_names(self) -> list[str]:
        """The columns of ``routes``."""
        return self.flow.route_names

    def fields(self, state: Carriage) -> Mapping[str, Array]:
        """The level set, and the flow's fields at the nodes of the interface's grid."""
        found = dict(self.level_set.fields(state.interface))
        fields = self.flow.fields(state.flow)
        if state.flow.grid == state.grid:
            return {**found, **fields}
        nodes = state.grid.points().reshape(state.grid.ndim, -1).T
        for name, values in fields.items():
            here = m2p(values, nodes, state.flow.grid, self.flow.kernel, outside="drop")
            found[name] = np.ascontiguousarray(here.T).reshape(
                *values.shape[:-2], *state.grid.shape
            )
        return found

    @cached_property
    def level_set(self) -> ParticleLevelSet:
        """The recipe of the interface, in a fluid at rest: to measure what a state holds."""
        return self._level_set(_rest)

    def _level_set(self, velocity: Callable[[float, Array], Array]) -> ParticleLevelSet:
        grid = self.flow.lattice if self.grid is None else self.grid
        return ParticleLevelSet(grid=grid, velocity=velocity, **self.options)

    def _velocity(self, *states: State) -> Callable[[float, Array], Array]:
        """The flow's velocity between some states; always the same for one."""
        frames = [_Frame(s.time, s.grid, self.flow.velocity(s)) for s in states]
        if len(frames) == 1:
            frames.append(replace(frames[0], time=frames[0].time + 1.0))
        history = VelocityHistory(frames, kernel=self.flow.kernel, threads=self.flow.threads)

        def velocity(time: float, positions: Array) -> Array:
            _refuse_outside(positions, frames)
            return history(time, positions)

        return velocity


@dataclass(frozen=True)
class _Frame:
    """A velocity on a grid at a time."""

    time: float
    grid: Grid
    velocity: Array

    def __getitem__(self, name: str) -> Array:
        """The field of this name."""
        return self.velocity


def _rest(time: float, positions: Array) -> Array:
    """No velocity."""
    return np.zeros_like(positions)


def _refuse_outside(positions: Array, frames: list[_Frame]) -> None:
    """Refuse places beyond an unbounded edge of the flow's mesh."""
    for frame in frames:
        grid = frame.grid
        for axis in range(grid.ndim):
            low = grid.origin[axis]
            away = (positions[:, axis] < low) | (positions[:, axis] > low + grid.length[axis])
            if not grid.periodic[axis] and away.any():
                raise InputError(
                    f"the interface has left the flow's mesh: {int(away.sum())} particles beyond "
                    f"its ends along axis {axis} at t = {frame.time:.4g}",
                    hint="a larger grid for the flow, or one of domain='fixed'",
                )
