"""Vorticity in a given base flow: its linear evolution, or with its own velocity the whole one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from dataclasses import fields as parts_of
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.asked import AskedFields
from pmesh.vortex.domain import SIGNIFICANT
from pmesh.vortex.engine import SLAB
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.limits import ratio
from pmesh.vortex.schemes import Carriage
from pmesh.vortex.state import State
from pmesh.vortex.uniform import UniformEngine
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.limit import Limit, check_step, tightest
from remesh.stretching import Form

Array = NDArray[np.floating[Any]]
Rows = tuple[tuple[float, ...], ...]
Law = Callable[[Array], Array]


@dataclass(frozen=True, kw_only=True)
class PerturbedFlow:
    """Vorticity w in space that a given steady flow U carries and stretches.

    ``dw/dt + (U . grad) w = (w . grad) U + nu laplace(w)``, the linear evolution of a disturbance;
    with ``nonlinear`` its own velocity u is added to U, and w obeys the Navier-Stokes equations in
    that base flow. U must have no divergence and, for either to be the whole truth, no vorticity:
    ``(Omega . grad) u`` of a base vorticity Omega is left out. The step, its orders and what it
    keeps are those of `VortexFlow`; the energy in the ledger is that of u alone. The mean of U over
    the mesh carries and does not stretch, like a free stream.
    Refuses a plane grid, a base that is no 3 x 3 matrix without trace and no law of points, and
    periodic axes with a matrix.
    """

    grid: Grid  # the mesh at the start
    base: Rows | Law  # U: a matrix A, U = A x [1/T]; or a law of points (3, *shape) [L/T]
    nonlinear: bool = False  # whether w also moves itself
    viscosity: float = 0.0  # nu [L^2/T]
    deformation: float = 0.25  # largest dt * max|grad u|
    kernel: str | Kernel = "M6'"  # of remeshing and interpolation
    time_scheme: Literal["RK2", "RK3", "RK4"] = "RK2"
    domain: Literal["grow", "follow", "fixed"] = "grow"  # of the unbounded axes
    negligible: float | None = None  # of the largest vorticity, see `VortexFlow`
    order: int = 8  # of the Gaussian-regularised Poisson solve
    radius: float = 2.0  # of its regularisation, in spacings
    stretching: Form = "conservative"  # of vorticity, see `Carriage`
    projection: int = 0  # steps between projections onto solenoidal vorticity; 0: never
    cleaning: bool = True  # of divergence at each step, see `VortexFlow`
    diffusion: Literal["spectral", "compact"] | None = None  # None: compact
    largest_step: float = math.inf  # upper bound of dt [T]
    dtype: Literal["float64", "float32"] = "float64"
    threads: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot run."""
        if not isinstance(self.grid, Grid) or self.grid.ndim != 3:
            raise InputError(
                f"PerturbedFlow needs a uniform grid in 3 dimensions, got {self.grid!r}",
                hint="Grid((64, 64, 64), 1/16)",
            )
        if not callable(self.base):
            self._check_matrix()
        _ = self.alone

    def _check_matrix(self) -> None:
        """Refuse what is no matrix of a volume-preserving linear flow in free space."""
        hint = "base=((1, 0, 0), (0, -0.5, 0), (0, 0, -0.5))"
        matrix = np.asarray(self.base)
        if matrix.shape != (3, 3) or matrix.dtype.kind not in "fi" or not np.isfinite(matrix).all():
            raise InputError(
                f"base must be 3 rows of 3 numbers or a law of points, got {self.base!r}", hint=hint
            )
        if abs(np.trace(matrix)) > 1e-12 * float(np.abs(matrix).max()):
            raise InputError(
                f"the base flow must keep volumes, its trace is {np.trace(matrix):.3g}", hint=hint
            )
        if any(self.grid.periodic):
            raise InputError(
                f"a linear flow has no period, the grid has: {self.grid.boundary}",
                hint='boundary="unbounded"',
            )

    @cached_property
    def alone(self) -> VortexFlow:
        """The same vorticity without the base flow."""
        own = ("base", "nonlinear")
        names = [part.name for part in parts_of(self) if part.name not in own]
        return VortexFlow(**{name: getattr(self, name) for name in names})

    @cached_property
    def engine(self) -> _BaseEngine:
        """What steps it."""
        return _BaseEngine(self)

    def start(self, *, vorticity: Array | Law) -> State:
        """The state at time 0: ``vorticity`` on the nodes, or a law of points (3, *shape).

        Refuses a mesh for which the memory that is free does not suffice.
        """
        from pmesh.vortex.cost import refuse_without_room

        refuse_without_room(self)
        return self.engine.start(vorticity)

    def step(self, state: State, dt: float) -> State:
        """The state one step of dt [T] later; refuses a dt that is not positive and finite."""
        self.engine.check(state)
        return self.engine.step(state, check_step(dt))

    def limit(self, state: State) -> Limit:
        """The largest step [T]: "deformation" of the whole flow's gradient, or "largest_step"."""
        self.engine.check(state)
        rule = Limit(ratio(self.deformation, state.gradient), "deformation")
        return tightest(rule, Limit(self.largest_step, "largest_step"))

    def velocity(self, state: State) -> Array:
        """What carries the vorticity, on the nodes, (3, *grid.shape) [L/T]."""
        return self.engine.velocity(state)

    def ledger(self, state: State) -> Mapping[str, float]:
        """Integrals of the vorticity and of the velocity that it induces, and what left."""
        return self.engine.ledger(state)

    def forces(self, state: State) -> Mapping[str, float]:
        """None: there are no bodies."""
        self.engine.check(state)
        return {}

    def fields(self, state: State) -> Mapping[str, Array]:
        """Vorticity, and what carries it, on the nodes; computed when asked for."""
        return self.engine.fields(state)


class _Base(NamedTuple):
    """A base flow on the nodes of a mesh."""

    grid: Grid
    velocity: Array  # (3, *shape) [L/T]
    mean: tuple[float, ...]  # over the nodes [L/T]


class _BaseEngine(UniformEngine):
    """Steps of vorticity in a base flow on one uniform mesh."""

    def __init__(self, flow: PerturbedFlow) -> None:
        super().__init__(flow.alone)
        self.base, self.nonlinear = flow.base, flow.nonlinear
        self._known: _Base | None = None

    def fields(self, state: State) -> Mapping[str, Array]:
        """See `PerturbedFlow.fields`."""
        return AskedFields(
            {"vorticity": lambda: state.vorticity, "velocity": lambda: self.velocity(state)}
        )

    def velocity(self, state: State) -> Array:
        """See `PerturbedFlow.velocity`."""
        return self._induced(state.vorticity, state.grid, np.empty_like(state.vorticity))

    def _induced(self, vorticity: Array, grid: Grid, into: Array | None = None) -> Array:
        """The base flow and, if it is asked for, the velocity of the vorticity."""
        if into is None:
            into = self.buffers.take((3, *grid.shape), vorticity.dtype)
        if self.nonlinear:
            into = super()._induced(vorticity, grid, into)
            into += self._base(grid).velocity
        else:
            into[...] = self._base(grid).velocity
        return into

    def _carriage(self, grid: Grid) -> Carriage:
        """The same; what the base flow does on the mean carries and does not stretch."""
        return replace(super()._carriage(grid), drift=self._base(grid).mean)

    def _base(self, grid: Grid) -> _Base:
        """The base flow on the nodes of a mesh, kept for the next stage."""
        known = self._known
        if known is None or known.grid != grid:
            self._known = None  # makes room
            velocity = self._base_on(grid)
            means = velocity.mean(axis=(1, 2, 3), dtype=np.float64)
            known = self._known = _Base(grid, velocity, tuple(float(u) for u in means))
        return known

    def _base_on(self, grid: Grid) -> Array:
        if callable(self.base):
            given = np.asarray(self.base(grid.points()))
            if given.shape != (3, *grid.shape) or not np.isfinite(given).all():
                raise InputError(
                    f"the base flow must be finite, of shape {(3, *grid.shape)}, got {given.shape}",
                    hint="a function of points (3, *shape) that gives velocities of that shape",
                )
            return given.astype(self.flow.dtype)  # a copy: the law may keep its own
        axes = np.ix_(*grid.axes())
        found = np.empty((3, *grid.shape), self.flow.dtype)
        for part, row in zip(found, self.base, strict=True):
            part[...] = sum(a * x for a, x in zip(row, axes, strict=True))
        return found

    def _measured(self, state: State, velocity: Array) -> State:
        """The same; the speed is that of the vorticity: beside it a base flow has no bound."""
        measured = super()._measured(state, velocity)
        return replace(measured, speed=_largest_among(velocity, state.vorticity))


def _largest_among(velocity: Array, vorticity: Array) -> float:
    """Largest |u| over the nodes that hold vorticity; slab by slab, that it takes no memory."""
    floor = SIGNIFICANT * max(float(vorticity.max()), -float(vorticity.min()))
    thick, top = max(1, SLAB // velocity[0, 0].size), 0.0
    for low in range(0, velocity.shape[1], thick):
        slab, size = velocity[:, low : low + thick], np.abs(vorticity[:, low : low + thick])
        squares = np.einsum("i...,i...->...", slab, slab)
        top = max(top, float(squares.max(initial=0.0, where=size.max(axis=0) > floor)))
    return math.sqrt(top)
