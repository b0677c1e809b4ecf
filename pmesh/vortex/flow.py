"""Incompressible plane flow carried by remeshed vortex particles, past penalised bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.contact import ContactLaw
from pmesh.bodies.forcing import DirectForcing
from pmesh.bodies.mask import Mask, at_rest
from pmesh.bodies.penalise import Penalisation
from pmesh.bodies.pose import Pose
from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex import ledger
from pmesh.vortex.constraint import Wall
from pmesh.vortex.domain import SIGNIFICANT, room
from pmesh.vortex.limits import body_limits, ratio
from pmesh.vortex.loads import inertia_force, load_columns
from pmesh.vortex.outer import Outer, swelling_flow
from pmesh.vortex.passage import Passage, foresee
from pmesh.vortex.recipe import checked_vorticity, validate
from pmesh.vortex.routes import route_names, routes
from pmesh.vortex.schemes import Carried, carry, on_mesh
from pmesh.vortex.solvers import solver_for
from pmesh.vortex.state import Load, State
from pmesh.vortex.window import Window, let_go
from remesh.errors import BlowUpError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.limit import Limit, check_step, tightest
from remesh.nodes import sample_nodes
from remesh.particles import distortion
from remesh.paths import SCHEMES
from remesh.stencils import max_gradient_norm

Array = NDArray[np.floating[Any]]

DEFAULT = Penalisation()
TOUCH = ContactLaw()
EDGE = 3  # nodes from the edge of a fixed mesh within which vorticity is about to leave it
LEE = 0.1  # of the largest speed: bodies are held to that where they feel less wind
FARTHEST = 64.0  # mesh lengths that nothing moves in one step of a sane run


@dataclass(frozen=True, kw_only=True)
class VortexFlow:
    """Incompressible flow in a plane, carried by remeshed vortex particles.

    Each step: half of the viscous spread and of the bodies' force, particles carried by the
    velocity they induce and remeshed, the other half (Strang). Second order in dt, third with
    "RK3" where nothing spreads; of the kernel's order in the spacing when dt follows it. The
    spread is exact, so it never limits dt. Bodies are held implicitly, by penalisation or direct
    forcing, iterated on its slip residual; free ones move with what the fluid does to them in the
    same solve, and never overlap: first order in dt; in the spacing the drag is of order 1.2, by
    direct forcing of order 2. Circulation and what was counted at unbounded edges stay one sum to
    round-off, as does the linear impulse without bodies; "distorted" particles that feel viscosity
    keep them to 1e-6, and to 0.4 % of what leaves. Refuses a 3-D grid, a negative viscosity, bodies
    that do not fit or overlap; a body that leaves a fixed mesh is a BlowUpError.
    """

    grid: Grid  # the mesh at the start
    viscosity: float = 0.0  # nu [L^2/T]
    freestream: tuple[float, ...] = (0.0, 0.0)  # [L/T]
    bodies: tuple[Body, ...] = ()
    deformation: float = 0.25  # largest dt * max|grad u|
    kernel: str | Kernel = "M6'"  # of remeshing and interpolation
    time_scheme: Literal["RK2", "RK3", "RK4"] = "RK2"
    remeshing: Literal["always", "distorted"] = "always"
    distortion: float = 0.1  # largest strain of the particles' lattice, for "distorted"
    domain: Literal["grow", "follow", "fixed"] = "grow"  # of the unbounded axes
    order: int = 8  # of the Gaussian-regularised Poisson solve
    radius: float = 2.0  # of its regularisation, in spacings
    window: Window | None = None  # around the bodies, in body lengths, out of which wakes may leave
    penalisation: Penalisation | DirectForcing = DEFAULT
    contact: ContactLaw = TOUCH  # between bodies of which one at least is free
    largest_step: float = math.inf  # upper bound of dt [T]
    dtype: Literal["float64", "float32"] = "float64"
    threads: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot run."""
        validate(self)

    def start(self, *, vorticity: Array | Callable[[Array], Array] | None = None) -> State:
        """The state at time 0: ``vorticity`` on the nodes, or a law of points (2, *shape), or none.

        With bodies the start is impulsive: the slip of the given flow becomes a vortex sheet, and
        the impulse that this takes (the added mass) is not part of any later force.
        """
        values = checked_vorticity(vorticity, self.grid, np.dtype(self.dtype))
        state = State(
            time=0.0, step=0, grid=self.grid, vorticity=values, gradient=0.0, speed=0.0,
            impulse_force=(math.nan, math.nan),
        )  # fmt: skip
        if self.bodies:
            poses = tuple(body.start() for body in self.bodies)
            state = self._roomy(replace(state, poses=poses), 0.0, poses)
            wall, velocity = self._wall(state), self.velocity(state)
            imposed, created = wall.start(velocity, self._reference(_largest(velocity), poses))
            nothing = np.zeros_like(imposed.impulse)
            unknown = Load(force=(math.nan,) * self.grid.ndim, torque=math.nan, power=math.nan)
            state = replace(
                state,
                vorticity=state.vorticity + created,
                constraint=wall.held(imposed, nothing, nothing),
                loads=(unknown,) * len(poses),
            )
        return self._measured(state, self.velocity(state))

    def step(self, state: State, dt: float) -> State:
        """The state one step of dt [T] later; refuses a dt that is not positive and finite."""
        dt = check_step(dt)
        ahead = foresee(self.bodies, state, self.contact, dt)
        state = self._roomy(state, dt, ahead.poses)
        passage = Passage.planned(state, self._wall(state), ahead, dt) if self.bodies else None
        outer = self._outer(state, passage)
        half, velocity = self._first_half(state, passage, outer[0], dt)
        displacement = carry(
            _particles(half), velocity, self._inducer(state.grid, outer), state.grid, dt,
            SCHEMES[self.time_scheme], self.kernel, self.threads,
        )  # fmt: skip
        moved = Carried(_particles(half).strengths, displacement)
        after = self._second_half(half, moved, passage, outer[1], dt)
        return self._measured(self._pushed(state, after, outer, dt), velocity)

    def limit(self, state: State) -> Limit:
        """The largest step [T] that this state allows, and the rule that sets it.

        "deformation": dt * max|grad u| <= ``deformation``, from the last step's velocity; "body":
        no particle passes more than a tenth of the thinnest body; "diffusion": the viscous spread
        stays below a tenth of it; "motion": a law of motion or a body's period is resolved, a
        falling body drops less than a quarter of a spacing from rest, a spring swings less than
        half a radian; "largest_step": the user's own bound.
        """
        limits = [Limit(ratio(self.deformation, state.gradient), "deformation")]
        limits += body_limits(self.bodies, state, self.viscosity)
        limits.append(Limit(self.largest_step, "largest_step"))
        return tightest(*limits)

    def velocity(self, state: State) -> Array:
        """Velocity on the nodes, free stream included, shape (2, *grid.shape) [L/T]."""
        solver = self._solver(state.grid)
        velocity = solver.velocity(state.vorticity, freestream=self.freestream)
        return _added(velocity, self._outer(state, None)[0])

    def ledger(self, state: State) -> Mapping[str, float]:
        """Integrals of the vorticity, and what left the mesh."""
        impulse = ledger.impulse(state.vorticity, state.grid)
        return {
            "circulation": ledger.circulation(state.vorticity, state.grid),
            "impulse_x": impulse[0],
            "impulse_y": impulse[1],
            "angular_moment": ledger.angular_moment(state.vorticity, state.grid),
            "enstrophy": ledger.enstrophy(state.vorticity, state.grid),
            "lost_circulation": state.lost_circulation,
            "nodes": float(state.grid.size),
        }

    def forces(self, state: State) -> Mapping[str, float]:
        """Forces on the bodies per unit density [L^3/T^2], means over the last step, and the slip.

        ``bodyN_force``, ``_torque`` (about its centre), ``_power`` (that it gives to the fluid):
        from the momentum of the force that holds it; ``impulse_force``: on all bodies, from the
        rate of the vorticity's impulse, which the curl of the force changes by that momentum
        and everything else must leave alone. It is NaN across a periodic axis, and while vorticity
        leaves a fixed mesh; all are NaN at the start. ``slip``: velocity left in the bodies, root
        mean square; ``slip_residual``: how far it is from the law that holds them. What moves
        tells its place too: ``bodyN_x, _y, _angle`` and their rates ``_u, _v, _spin``.
        """
        if state.constraint is None:
            return {}
        columns = load_columns(self.bodies, state.loads, state.poses)
        for axis, value in zip("xy", state.impulse_force, strict=True):
            columns[f"impulse_force_{axis}"] = value
        held = state.constraint
        columns |= {"slip": held.slip, "slip_max": held.slip_max, "slip_residual": held.residual}
        return columns | {"slip_iterations": float(held.iterations)}

    def routes(self, before: State, after: State) -> Mapping[str, float]:
        """Forces and torques over the step between two states by two more routes: see `routes`."""
        return routes(self, before, after)

    @property
    def route_names(self) -> list[str]:
        """The columns of ``routes``."""
        return route_names(len(self.bodies))

    def mask(self, grid: Grid, poses: tuple[Pose, ...]) -> Mask:
        """Where the bodies are imposed at these poses, on a box of the lattice of a mesh."""
        return self._wall_on(grid, poses).mask()

    def fields(self, state: State) -> Mapping[str, Array]:
        """Vorticity and velocity on the nodes; with bodies their indicator too."""
        fields = {"vorticity": state.vorticity, "velocity": self.velocity(state)}
        if self.bodies:
            wall = self._wall(state)
            chi = np.zeros(state.grid.shape, state.vorticity.dtype)
            window = wall.window(wall.near)
            chi[window.mesh] = wall.mask().chi[window.box]
            fields["chi"] = chi
        return fields

    def _first_half(
        self, state: State, passage: Passage | None, outer: Array | None, dt: float
    ) -> tuple[State, Array]:
        """Half of the spread and of the last known force: the state, and its velocity."""
        spread, solver = 0.5 * dt * self.viscosity, self._solver(state.grid)
        vorticity = state.vorticity
        if passage is not None and passage.given is not None:
            vorticity = solver.diffuse(vorticity, spread)
            vorticity += passage.before.created(passage.given, spread)
            velocity = solver.velocity(vorticity, freestream=self.freestream)
        elif passage is None and spread > 0:
            vorticity, velocity = solver.diffuse_and_velocity(
                vorticity, spread, freestream=self.freestream
            )
        else:
            velocity = solver.velocity(vorticity, freestream=self.freestream)
        particles = self._told(_particles(state), state.vorticity, vorticity, state.grid)
        half = replace(
            state,
            vorticity=vorticity,
            strengths=None if state.strengths is None else particles.strengths,
            lost_circulation=state.lost_circulation
            + ledger.cut(state.vorticity, vorticity, state.grid),
        )
        return half, _added(velocity, outer)

    def _second_half(
        self, state: State, moved: Carried, passage: Passage | None, outer: Array | None, dt: float
    ) -> State:
        """The other half of the spread and the force that holds the bodies: the next state."""
        grid, solver = state.grid, self._solver(state.grid)
        mesh, dropped = on_mesh(moved, grid, self.kernel, self.threads)
        gone = on_mesh(_particles(state), grid, self.kernel, self.threads).dropped
        after = replace(state, time=state.time + dt, step=state.step + 1)
        if passage is None:
            spread = 0.5 * dt * self.viscosity
            vorticity = solver.diffuse(mesh, spread) if spread > 0 else mesh
        else:
            vorticity, velocity = solver.diffuse_and_velocity(
                mesh,
                self.viscosity * passage.tau,
                freestream=self.freestream,
                rows=passage.after.rows,
            )
            speed = self._reference(state.speed, passage.after.poses)
            held = passage.arrive(_added(velocity, outer), speed)
            vorticity += held.created
            after = replace(
                after, constraint=held.constraint, loads=held.loads, poses=held.poses,
                earlier=held.earlier,
            )  # fmt: skip
        lost = float(dropped - gone) + ledger.cut(mesh, vorticity, grid)
        after = replace(after, lost_circulation=state.lost_circulation + lost)
        return self._remeshed(after, moved, mesh, vorticity)

    def _remeshed(self, state: State, moved: Carried, mesh: Array, vorticity: Array) -> State:
        """The state with its particles back on nodes, or where they are if still in good order."""
        state = replace(state, vorticity=vorticity, strengths=None, displacement=None)
        if self.remeshing == "always" or moved.displacement is None:
            return state
        live = np.abs(moved.strengths) > SIGNIFICANT * np.abs(moved.strengths).max()
        if distortion(moved.displacement, state.grid, where=live) > self.distortion:
            return state
        told = self._told(moved, mesh, vorticity, state.grid)
        return replace(state, strengths=told.strengths, displacement=told.displacement)

    def _told(self, particles: Carried, before: Array, after: Array, grid: Grid) -> Carried:
        """The particles after the vorticity on the mesh changed."""
        if particles.displacement is None or after is before:
            return particles
        change = sample_nodes(
            after - before, particles.displacement, grid, self.kernel, outside="zero",
            threads=self.threads,
        )  # fmt: skip
        return Carried(particles.strengths + change, particles.displacement)

    def _pushed(self, before: State, after: State, outer: Outer, dt: float) -> State:
        """The state with the force that its vorticity's impulse tells; a window lets wake go."""
        if not self.bodies:
            return after
        full = after.vorticity
        if self.window is not None:
            after = let_go(self.window, after, self.bodies, self._wind(after.poses), dt)
        elif self.domain == "fixed" and room(full, after.grid, EDGE, follow=False):
            return replace(after, impulse_force=(math.nan, math.nan))
        force = ledger.impulse_force(
            (before.vorticity, full), after.grid, dt, self.freestream, outer
        )
        force += inertia_force(self.bodies, before.poses, after.poses, dt)
        return replace(after, impulse_force=tuple(float(x) for x in force))

    def _wind(self, poses: tuple[Pose, ...]) -> Array:
        """The stream that the bodies feel on the whole [L/T]."""
        return np.asarray(self.freestream - np.mean([pose.velocity for pose in poses], axis=0))

    def _outer(self, state: State, passage: Passage | None) -> Outer:
        """Velocity that no vorticity induces, now and after the step, beside the free stream."""
        first = self._outer_at(state, state.poses)
        if passage is None or at_rest(self.bodies, state.poses) == at_rest(
            self.bodies, passage.after.poses
        ):
            return first, first
        return first, self._outer_at(state, passage.after.poses)

    def _outer_at(self, state: State, poses: tuple[Pose, ...]) -> Array | None:
        """The same with the bodies at these poses; None if there is none."""
        total = None
        if not all(body.solenoidal for body in self.bodies):
            total = swelling_flow(self._wall_on(state.grid, poses), self._solver(state.grid))
        if self.window is not None:
            lee = self.window.beyond(state.grid, self.bodies, poses, state.wake)
            total = total if lee is None else lee if total is None else total + lee
        return None if total is None else total.astype(self.dtype, copy=False)

    def _roomy(self, state: State, dt: float, ahead: tuple[Pose, ...]) -> State:
        """The state on a mesh with room for what the step does, bodies at its end included."""
        spread = self.viscosity * dt
        walls = [
            self._wall_on(state.grid, poses)
            for poses in dict.fromkeys((state.poses, ahead))
            if poses
        ]
        for wall in walls:
            wall.stay(fixed=self.domain == "fixed")
        if self.domain == "fixed":
            return state
        reach = state.speed * dt + 6.0 * math.sqrt(2.0 * self.viscosity * dt)
        if not reach < FARTHEST * max(state.grid.length):
            raise BlowUpError(
                f"a step of {dt:.3g} would carry vorticity {reach:.3g} far, "
                f"{reach / max(state.grid.length):.3g} times the mesh",
                hint="a smaller dt, or a smaller deformation",
            )
        margin = math.ceil(reach / state.grid.spacing) + get_kernel(self.kernel).half_width + 2
        moving = state.displacement is not None
        shift = room(
            state.vorticity, state.grid, margin, follow=self.domain == "follow" and not moving
        )
        if self.window is not None:
            shift = self.window.clipped(shift, state.grid, self.bodies, state.poses)
        for wall in walls:
            shift = shift.covering(state.grid, wall.wide(spread))
        if not shift:
            return state
        vorticity = shift.field(state.vorticity)
        grid = shift.grid(state.grid)
        before = ledger.circulation(state.vorticity, state.grid)
        return replace(
            state,
            grid=grid,
            vorticity=vorticity,
            strengths=None if state.strengths is None else shift.field(state.strengths),
            displacement=None if state.displacement is None else shift.field(state.displacement),
            lost_circulation=state.lost_circulation + before - ledger.circulation(vorticity, grid),
        )

    def _measured(self, state: State, velocity: Array) -> State:
        """The state with the gradient and speed of this velocity."""
        gradient = max_gradient_norm(velocity, state.grid, threads=self.threads)
        if not math.isfinite(gradient):
            raise BlowUpError("the velocity is not finite", hint="a smaller deformation")
        return replace(state, gradient=gradient, speed=_largest(velocity))

    def _inducer(self, grid: Grid, outer: Outer) -> Callable[[Array, float], Array]:
        """The law from vorticity on the nodes, and the part of the step gone by, to velocity."""
        solver = self._solver(grid)

        def velocity(vorticity: Array, part: float) -> Array:
            induced = solver.velocity(vorticity, freestream=self.freestream)
            return _added(induced, _between(outer, part))

        return velocity

    def _wall(self, state: State) -> Wall:
        return self._wall_on(state.grid, state.poses)

    def _wall_on(self, grid: Grid, poses: tuple[Pose, ...]) -> Wall:
        return Wall(
            bodies=self.bodies, poses=poses, grid=grid, viscosity=self.viscosity,
            settings=self.penalisation, order=self.order, radius=self.radius, solver=self._solver,
        )  # fmt: skip

    def _solver(self, grid: Grid) -> VelocitySolver:
        return solver_for(
            grid, order=self.order, radius=self.radius, dtype=self.dtype, threads=self.threads
        )

    def _reference(self, speed: float, poses: tuple[Pose, ...]) -> float:
        """The speed that a slip is compared with: the largest of the wind, a tenth of the flow's
        largest (bodies that go with the stream feel no wind) and that of viscosity on the bodies.
        """
        size = max(body.length for body in self.bodies)
        return max(float(np.hypot(*self._wind(poses))), LEE * speed, self.viscosity / size)


def _particles(state: State) -> Carried:
    """The state's vorticity as particles, on their nodes unless they were not remeshed."""
    strengths = state.vorticity if state.strengths is None else state.strengths
    return Carried(strengths, state.displacement)


def _largest(velocity: Array) -> float:
    """Largest |u| over the nodes."""
    return math.sqrt(float(np.einsum("i...,i...->...", velocity, velocity).max()))


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
