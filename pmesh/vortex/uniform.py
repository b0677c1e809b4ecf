"""The step of a vortex flow on a uniform mesh, which grows and follows where it is asked to."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.mask import at_rest
from pmesh.bodies.pose import Pose
from pmesh.vortex import ledger
from pmesh.vortex.asked import AskedFields
from pmesh.vortex.buffers import Buffers
from pmesh.vortex.columns import plane_columns, space_columns
from pmesh.vortex.constraint import Wall
from pmesh.vortex.domain import PROJECTED, SIGNIFICANT, room
from pmesh.vortex.engine import EDGE, Engine, largest
from pmesh.vortex.growth import with_room
from pmesh.vortex.loads import inertia_force, inertia_torque
from pmesh.vortex.outer import Outer, swelling_flow
from pmesh.vortex.passage import Passage, foresee
from pmesh.vortex.recipe import check_solenoidal, checked_vorticity
from pmesh.vortex.schemes import Carriage, Carried
from pmesh.vortex.state import State
from pmesh.vortex.window import let_go
from remesh.cleaning import clean_divergence
from remesh.errors import BlowUpError
from remesh.grid import Grid
from remesh.particles import distortion
from remesh.paths import SCHEMES
from remesh.spreading import spread_nodes
from remesh.stencils import max_gradient_norm

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]


class UniformEngine(Engine[State]):
    """Steps of a vortex flow on one uniform mesh: see `VortexFlow`."""

    kind = State

    def __init__(self, flow: VortexFlow) -> None:
        super().__init__(flow)
        self.buffers = Buffers()
        self.negligible = flow.negligible or (PROJECTED if flow.projection else SIGNIFICANT)
        self.compact = (flow.diffusion or ("compact" if flow.grid.ndim == 3 else "")) == "compact"

    def start(self, vorticity: Array | Callable[[Array], Array] | None) -> State:
        """See `VortexFlow.start`."""
        values = checked_vorticity(vorticity, self.flow.lattice, np.dtype(self.flow.dtype))
        ndim = self.flow.lattice.ndim
        if ndim == 3 and self.flow.projection:
            values = self.solver(self.flow.lattice).solenoidal(values, out=values)
        elif ndim == 3:
            check_solenoidal(values, self.flow.lattice, self.flow.threads)
        state = State(
            time=0.0, step=0, grid=self.flow.lattice, vorticity=values, gradient=0.0, speed=0.0,
            impulse_force=(math.nan,) * (2 if ndim == 2 else 6),
            lost_circulation=0.0 if ndim == 2 else np.zeros(3),
        )  # fmt: skip
        if self.flow.bodies:
            poses = tuple(body.start() for body in self.flow.bodies)
            state = self._roomy(replace(state, poses=poses), 0.0, poses)
            wall = self.wall(state)
            created, held = self.launched(wall, self.velocity(state))
            state = replace(state, vorticity=state.vorticity + created, **held)
        return self._measured(state, self.velocity(state))

    def step(self, state: State, dt: float) -> State:
        """See `VortexFlow.step`."""
        ahead = foresee(self.flow.bodies, state, self.flow.contact, dt)
        state = self._roomy(state, dt, ahead.poses)
        passage = Passage.planned(state, self.wall(state), ahead, dt) if self.flow.bodies else None
        outer = self._outer(state, passage)
        half, velocity = self._first_half(state, passage, outer[0], dt)
        measured = self._measured(state, velocity)
        carriage = self._carriage(state.grid)
        displacement = carriage.carry(
            _particles(half), velocity, self._inducer(state.grid, outer), dt
        )
        moved = Carried(_particles(half).strengths, displacement)
        after = self._second_half(half, moved, passage, outer[1], dt)
        if after.displacement is not displacement:
            self.buffers.give(displacement)
        if half.vorticity is not state.vorticity:
            self.buffers.give(half.vorticity)
        after = self._pushed(state, after, outer, dt)
        return replace(after, gradient=measured.gradient, speed=measured.speed)

    def velocity(self, state: State) -> Array:
        """Velocity on the nodes, free stream included, shape (ndim, *grid.shape) [L/T]."""
        solver = self.solver(state.grid)
        velocity = solver.velocity(state.vorticity, freestream=self.flow.freestream)
        return _added(velocity, self._outer(state, None)[0])

    def ledger(self, state: State) -> Mapping[str, float]:
        """Integrals of the vorticity, and what left the mesh."""
        if state.grid.ndim == 2:
            return plane_columns(state)
        return space_columns(
            state, self.solver(state.grid), self.buffers,
            viscosity=self.flow.viscosity, threads=self.flow.threads,
        )  # fmt: skip

    def fields(self, state: State) -> Mapping[str, Array]:
        """Vorticity and velocity on the nodes; with bodies their indicator too: when asked for."""
        laws = {"vorticity": lambda: state.vorticity, "velocity": lambda: self.velocity(state)}
        if self.flow.bodies:
            laws["chi"] = lambda: self._indicator(state)
        return AskedFields(laws)

    def _indicator(self, state: State) -> Array:
        """Where the bodies are, on the nodes."""
        wall = self.wall(state)
        chi = np.zeros(state.grid.shape, state.vorticity.dtype)
        window = wall.window(wall.near)
        chi[window.mesh] = wall.mask().chi[window.box]
        return chi

    def _first_half(
        self, state: State, passage: Passage | None, outer: Array | None, dt: float
    ) -> tuple[State, Array]:
        """Half of the spread and of the last known force: the state, and its velocity."""
        spread = 0.5 * dt * self.flow.viscosity
        vorticity = state.vorticity
        if passage is not None and passage.given is not None:
            vorticity = self._spread(vorticity, state.grid, spread, self._like(vorticity))
            vorticity += passage.before.created(passage.given, spread)
            velocity = self._induced(vorticity, state.grid)
        elif passage is None and spread > 0:
            vorticity, velocity = self._spread_and_induced(
                vorticity, state.grid, spread, self._like(vorticity)
            )
        else:
            velocity = self._induced(vorticity, state.grid)
        particles = self._carriage(state.grid).told(_particles(state), state.vorticity, vorticity)
        lost = 0.0
        if vorticity is not state.vorticity and not all(state.grid.periodic):
            lost = ledger.circulation(state.vorticity, state.grid)
            lost = lost - ledger.circulation(vorticity, state.grid)
        half = replace(
            state,
            vorticity=vorticity,
            strengths=None if state.strengths is None else particles.strengths,
            lost_circulation=state.lost_circulation + lost,
        )
        return half, _added(velocity, outer)

    def _second_half(
        self, state: State, moved: Carried, passage: Passage | None, outer: Array | None, dt: float
    ) -> State:
        """The other half of the spread and the force that holds the bodies: the next state."""
        grid, carriage = state.grid, self._carriage(state.grid)
        mesh, dropped = carriage.on_mesh(
            moved, self._like(moved.strengths), time=dt
        )  # the state keeps it
        gone = carriage.on_mesh(_particles(state)).dropped if state.displacement is not None else 0
        after = replace(state, time=state.time + dt, step=state.step + 1)
        before = None if all(grid.periodic) else ledger.circulation(mesh, grid)
        into = mesh if self.flow.remeshing == "always" else np.empty_like(mesh)
        vorticity = mesh
        if passage is None:
            spread = 0.5 * dt * self.flow.viscosity
            vorticity = self._spread(mesh, grid, spread, into) if spread > 0 else mesh
        else:
            vorticity, velocity = self._spread_and_induced(
                mesh, grid, self.flow.viscosity * passage.tau, into, passage.after.rows
            )
            speed = self.reference(state.speed, passage.after.poses)
            held = passage.arrive(_added(velocity, outer), speed)
            self.buffers.give(velocity)
            vorticity += held.created
            after = replace(
                after, constraint=held.constraint, loads=held.loads, poses=held.poses,
                earlier=held.earlier,
            )  # fmt: skip
        if grid.ndim == 3:
            vorticity = self._solenoidal(vorticity, after, into)
        lost = dropped - gone
        if before is not None:
            lost = lost + before - ledger.circulation(vorticity, grid)
        lost = state.lost_circulation + lost
        after = replace(after, lost_circulation=lost if grid.ndim == 3 else float(lost))
        return self._remeshed(after, moved, mesh, vorticity)

    def _solenoidal(self, vorticity: Array, state: State, into: Array) -> Array:
        """The vorticity projected or cleaned of divergence, where the flow asks for that.

        ``into``: the array that it is in, or one to leave it as it is.
        """
        if self.flow.projection and state.step % self.flow.projection == 0:
            return self.solver(state.grid).solenoidal(vorticity, out=into)
        if not self.flow.cleaning:
            return vorticity
        if vorticity is not into:
            into[...] = vorticity
        scratch = self._like(into)
        clean_divergence(into, state.grid, scratch=scratch[0], threads=self.flow.threads)
        self.buffers.give(scratch)
        return into

    def _remeshed(self, state: State, moved: Carried, mesh: Array, vorticity: Array) -> State:
        """The state with its particles back on nodes, or where they are if still in good order."""
        state = replace(state, vorticity=vorticity, strengths=None, displacement=None)
        if self.flow.remeshing == "always" or moved.displacement is None:
            return state
        live = np.abs(moved.strengths) > SIGNIFICANT * np.abs(moved.strengths).max()
        if state.grid.ndim == 3:
            live = live.any(axis=0)
        if distortion(moved.displacement, state.grid, where=live) > self.flow.distortion:
            return state
        told = self._carriage(state.grid).told(moved, mesh, vorticity)
        return replace(state, strengths=told.strengths, displacement=told.displacement)

    def _pushed(self, before: State, after: State, outer: Outer, dt: float) -> State:
        """The state with the force that its vorticity's impulse tells; a window lets wake go."""
        if not self.flow.bodies:
            return after
        full = after.vorticity
        if self.flow.window is not None:
            after = let_go(self.flow.window, after, self.flow.bodies, self.wind(after.poses), dt)
        elif self.flow.domain == "fixed" and room(
            full, after.grid, EDGE, follow=False, negligible=self.negligible
        ):
            return replace(after, impulse_force=(math.nan,) * len(after.impulse_force))
        force = ledger.impulse_force(
            (before.vorticity, full), after.grid, dt, self.flow.freestream, outer
        )
        force += _inertia_rate(self.flow.bodies, before.poses, after.poses, dt)
        return replace(after, impulse_force=tuple(float(x) for x in force))

    def _outer(self, state: State, passage: Passage | None) -> Outer:
        """Velocity that no vorticity induces, now and after the step, beside the free stream."""
        first = self._outer_at(state, state.poses)
        if passage is None or at_rest(self.flow.bodies, state.poses) == at_rest(
            self.flow.bodies, passage.after.poses
        ):
            return first, first
        return first, self._outer_at(state, passage.after.poses)

    def _outer_at(self, state: State, poses: tuple[Pose, ...]) -> Array | None:
        """The same with the bodies at these poses; None if there is none."""
        total = None
        if not all(body.solenoidal for body in self.flow.bodies):
            total = swelling_flow(self.wall_on(state.grid, poses), self.solver(state.grid))
        if self.flow.window is not None:
            lee = self.flow.window.beyond(state.grid, self.flow.bodies, poses, state.wake)
            total = total if lee is None else lee if total is None else total + lee
        return None if total is None else total.astype(self.flow.dtype, copy=False)

    def _roomy(self, state: State, dt: float, ahead: tuple[Pose, ...]) -> State:
        """The state on a mesh with room for what the step does, bodies at its end included."""
        places = dict.fromkeys((state.poses, ahead))
        walls = [self.wall_on(state.grid, poses) for poses in places if poses]
        for wall in walls:
            wall.stay(fixed=self.flow.domain == "fixed")
        if self.flow.domain == "fixed":
            return state
        return with_room(state, self.flow, walls, dt, negligible=self.negligible)

    def _measured(self, state: State, velocity: Array) -> State:
        """The state with the gradient and speed of this velocity."""
        gradient = max_gradient_norm(velocity, state.grid, threads=self.flow.threads)
        if not math.isfinite(gradient):
            raise BlowUpError("the velocity is not finite", hint="a smaller deformation")
        return replace(state, gradient=gradient, speed=largest(velocity))

    def _inducer(self, grid: Grid, outer: Outer) -> Callable[[Array, float], Array]:
        """The law from vorticity on the nodes, and the part of the step gone by, to velocity.

        In space the velocity takes the place of the vorticity.
        """

        def velocity(vorticity: Array, part: float) -> Array:
            into = vorticity if grid.ndim == 3 else None
            induced = self._induced(vorticity, grid, into)
            if into is None:
                self.buffers.give(vorticity)
            return _added(induced, _between(outer, part))

        return velocity

    def _carriage(self, grid: Grid) -> Carriage:
        """How particles go on a mesh."""
        flow = self.flow
        return Carriage(
            grid=grid, kernel=flow.kernel, scheme=SCHEMES[flow.time_scheme],
            stretching=flow.stretching, threads=flow.threads, buffers=self.buffers,
            scratch=self.solver(grid).lent, drift=flow.freestream,
        )  # fmt: skip

    def _like(self, array: Array) -> Array:
        return self.buffers.take(array.shape, array.dtype)

    def _induced(self, vorticity: Array, grid: Grid, into: Array | None = None) -> Array:
        """Velocity of a vorticity field and the free stream."""
        if into is None:
            into = self.buffers.take((grid.ndim, *grid.shape), vorticity.dtype)
        return self.solver(grid).velocity(vorticity, freestream=self.flow.freestream, out=into)

    def _spread(self, vorticity: Array, grid: Grid, amount: float, into: Array) -> Array:
        """The vorticity after it spread by ``amount`` = nu t [L^2]."""
        if self.compact:
            return spread_nodes(vorticity, grid, amount, out=into, threads=self.flow.threads)
        return self.solver(grid).diffuse(vorticity, amount, out=into)

    def _spread_and_induced(
        self,
        vorticity: Array,
        grid: Grid,
        amount: float,
        into: Array,
        rows: tuple[int, int] | None = None,
    ) -> tuple[Array, Array]:
        """The same, and the velocity of what it became; ``rows``: where that is wanted."""
        if grid.ndim == 3:  # one after the other takes less memory
            field = self._spread(vorticity, grid, amount, into)
            return field, self._induced(field, grid)
        speed = self.buffers.take((grid.ndim, *grid.shape), vorticity.dtype)
        if rows is not None:
            speed.fill(0)
        return self.solver(grid).diffuse_and_velocity(
            vorticity, amount, out=(into, speed), freestream=self.flow.freestream, rows=rows
        )

    def wall(self, state: State) -> Wall:
        """The bodies on the mesh of a state."""
        return self.wall_on(state.grid, state.poses)


def _particles(state: State) -> Carried:
    """The state's vorticity as particles, on their nodes unless they were not remeshed."""
    strengths = state.vorticity if state.strengths is None else state.strengths
    return Carried(strengths, state.displacement)


def _inertia_rate(
    bodies: tuple[Body, ...], before: tuple[Pose, ...], after: tuple[Pose, ...], dt: float
) -> Array:
    """Rate of momentum, in space of angular momentum too, of fluid that would move with bodies."""
    force = inertia_force(bodies, before, after, dt)
    if len(force) == 2:
        return force
    return np.concatenate([force, inertia_torque(bodies, before, after, dt)])


def _added(velocity: Array, outer: Array | None) -> Array:
    """A velocity and another, if there is one."""
    if outer is not None:
        velocity += outer
    return velocity


def _between(outer: Outer, part: float) -> Array | None:
    """The outer velocity at a part of the step."""
    first, last = outer
    if first is None or last is None:
        return first
    return first if first is last else (1.0 - part) * first + part * last
