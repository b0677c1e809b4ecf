"""The step of a vortex flow on an adaptive mesh, which goes with the vorticity."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.mask import at_rest
from pmesh.bodies.pose import Pose
from pmesh.bodies.wall import indicator
from pmesh.spectral.corrections import AdaptiveSolver
from pmesh.vortex import ledger
from pmesh.vortex.constraint import Wall, first_node
from pmesh.vortex.domain import SIGNIFICANT
from pmesh.vortex.engine import EDGE, Engine, largest
from pmesh.vortex.loads import inertia_force
from pmesh.vortex.passage import Passage, foresee
from pmesh.vortex.recipe import checked_vorticity
from pmesh.vortex.skin import hull, skin, smoothed
from pmesh.vortex.state import AdaptiveState, FlowState
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.multires.adapt import adapt
from remesh.multires.blocks import Blocks, Places
from remesh.multires.boxed import added
from remesh.multires.diffusion import spread
from remesh.multires.landing import landing
from remesh.multires.lookup import sampled_at
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled
from remesh.multires.strain import gradient_norm
from remesh.multires.travel import carried
from remesh.multires.uniform import to_uniform
from remesh.multires.wavelets import get_wavelet
from remesh.paths import SCHEMES, moved

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]
ROOM = "a larger grid, fewer levels, or domain='fixed' to let it leave"
FAR = 12  # reach of the velocity's corrections past bodies, whose vorticity is as sharp as can be


class Moved(NamedTuple):
    """Vorticity on the blocks that it was carried to, and what left through unbounded ends."""

    blocks: Blocks
    vorticity: Array
    lost: float


class AdaptiveEngine(Engine[AdaptiveState]):
    """Steps of a vortex flow on an adaptive mesh: see `VortexFlow`."""

    kind = AdaptiveState

    def check(self, state: FlowState) -> None:
        """Refuse a state of another kind of mesh, or of another adaptive mesh."""
        super().check(state)
        assert isinstance(state, AdaptiveState)
        own, other = self.mesh, state.blocks.mesh
        if own != other:
            names = [part.name for part in fields(own)
                     if getattr(own, part.name) != getattr(other, part.name)]  # fmt: skip
            raise InputError(
                f"the state's mesh differs from the flow's in {', '.join(names)}",
                hint="the mesh that the run began with, or flow.start(...)",
            )

    @property
    def mesh(self) -> AdaptiveMesh:
        """The mesh as a recipe."""
        mesh = self.flow.grid
        assert isinstance(mesh, AdaptiveMesh)
        return mesh

    def start(self, vorticity: Array | Callable[[Array], Array] | None) -> AdaptiveState:
        """See `VortexFlow.start`."""
        flow, mesh = self.flow, self.mesh
        poses = tuple(body.start() for body in flow.bodies)
        blocks, values = sampled(_started(vorticity, flow), mesh, threads=flow.threads)
        if values.shape != blocks.shape:
            raise InputError(
                f"vorticity must be one field, the law gives {len(values)} components",
                hint="a function of points (2, ...) that gives (...)",
            )
        state = AdaptiveState(
            time=0.0, step=0, grid=mesh.grid, gradient=0.0, speed=0.0, poses=poses,
            impulse_force=(math.nan, math.nan), tolerance=mesh.tolerance,
            blocks=blocks, vorticity=values, busy=np.empty(0, bool),
        )  # fmt: skip
        values = values.astype(flow.dtype, copy=False)
        state = self._adapted(state, blocks, values, self._skin(poses))
        leaving = self._leaving(state)
        if leaving and flow.domain != "fixed":
            raise InputError(self._told(leaving), hint=ROOM)
        if flow.bodies:
            wall = self._wall(poses, poses, 0.0)
            velocity = self._cut(self.velocity(state), state.blocks, wall)
            created, held = self.launched(wall, velocity)
            state = replace(state, **held)
            values = self._with(state.vorticity, state.blocks, created, wall)
            state = self._adapted(state, state.blocks, values, self._skin(poses))
        return self._measured(state, self.velocity(state), state.blocks)

    def step(self, state: AdaptiveState, dt: float) -> AdaptiveState:
        """See `VortexFlow.step`."""
        flow = self.flow
        ahead = foresee(flow.bodies, state, flow.contact, dt)
        passage = None
        if flow.bodies:
            wall = self._wall(state.poses, ahead.poses, flow.viscosity * dt)
            passage = Passage.planned(state, wall, ahead, dt)
        half, lost = self._first_half(state, passage, dt)
        velocity = self._velocity(state.blocks, half)
        keep = self._skin(ahead.poses)
        went = self._carried(state, half, velocity, dt, keep)
        went = went._replace(lost=went.lost + lost)
        after = self._second_half(state, went, passage, dt)
        return self._measured(self._pushed(state, after, dt), velocity, state.blocks)

    def velocity(self, state: AdaptiveState) -> Array:
        """Velocity on the blocks, free stream included, (2, *blocks.shape) [L/T]."""
        return self._velocity(state.blocks, state.vorticity)

    def ledger(self, state: AdaptiveState) -> Mapping[str, float]:
        """Integrals of the vorticity, what left the mesh, and how many nodes it takes.

        The lifting keeps the moments: those of the coarsest level are those of all.
        """
        coarse, grid = self._coarsest(state)
        impulse = ledger.impulse(coarse, grid)
        return {
            "circulation": ledger.circulation(coarse, grid),
            "impulse_x": impulse[0],
            "impulse_y": impulse[1],
            "angular_moment": ledger.angular_moment(coarse, grid),
            "enstrophy": _enstrophy(state),
            "lost_circulation": state.lost_circulation,
            "active": float(state.blocks.active),
            "compression": state.blocks.compression,
            "blocks": float(state.blocks.size),
            "finest_level": float(state.blocks.finest),
            "tolerance": state.tolerance,
        }

    def fields(self, state: AdaptiveState) -> Mapping[str, Array]:
        """Vorticity and velocity on the blocks; with bodies their indicator too."""
        fields = {"vorticity": state.vorticity, "velocity": self.velocity(state)}
        if self.flow.bodies:
            points = state.blocks.points()
            distance = np.min(
                [b.distance(points, p) for b, p in zip(self.flow.bodies, state.poses, strict=True)],
                axis=0,
            )
            width = self.flow.penalisation.width * state.grid.spacing
            fields["chi"] = indicator(distance, width).astype(state.vorticity.dtype)
        return fields

    def _first_half(
        self, state: AdaptiveState, passage: Passage | None, dt: float
    ) -> tuple[Array, float]:
        """The vorticity after half of the spread and of the last known force; what left."""
        flow, half = self.flow, 0.5 * dt * self.flow.viscosity
        if passage is not None and passage.given is None:  # no force is known on the first step
            return state.vorticity, 0.0
        vorticity, lost = self._spread(state.vorticity, state.blocks, half)
        if passage is None or passage.given is None:
            return vorticity, lost
        created = passage.before.created(passage.given, half)
        created = created.astype(flow.dtype, copy=False)
        return self._with(vorticity, state.blocks, created, passage.before), lost

    def _carried(
        self,
        state: AdaptiveState,
        vorticity: Array,
        first: Array,
        dt: float,
        keep: Places | None,
    ) -> Moved:
        """The vorticity carried by the velocity that it induces, ``first`` at the start."""
        flow, blocks, busy = self.flow, state.blocks, state.busy
        scheme, slopes = SCHEMES[flow.time_scheme], [first]
        for row in scheme.rows:
            place = moved(None, slopes, row, dt)
            stage = self._remeshed(vorticity, place, blocks, busy)
            velocity = self._velocity(stage.blocks, stage.vorticity)
            slopes.append(
                sampled_at(velocity, stage.blocks, blocks, place, flow.kernel, threads=flow.threads)
            )
        place = moved(None, slopes, scheme.weights, dt)
        return self._remeshed(vorticity, place, blocks, busy, keep)

    def _remeshed(
        self,
        vorticity: Array,
        displacement: Array,
        blocks: Blocks,
        busy: NDArray[np.bool_],
        keep: Places | None = None,
    ) -> Moved:
        """Displaced particles remeshed level by level, on the blocks where they land."""
        target = landing(blocks, displacement, busy)
        if keep is not None:
            target = target.joined(self.mesh.levels, keep)
        found = carried(
            vorticity, displacement, blocks, target, self.flow.kernel, threads=self.flow.threads
        )
        return Moved(target, found.values, float(found.lost))

    def _second_half(
        self, state: AdaptiveState, went: Moved, passage: Passage | None, dt: float
    ) -> AdaptiveState:
        """The other half of the spread and the force that holds the bodies: the next state."""
        flow = self.flow
        tau = 0.5 * dt if passage is None else passage.tau
        vorticity, lost = self._spread(went.vorticity, went.blocks, flow.viscosity * tau)
        after = replace(
            state, time=state.time + dt, step=state.step + 1,
            lost_circulation=state.lost_circulation + went.lost + lost,
        )  # fmt: skip
        if passage is None:
            return self._adapted(after, went.blocks, vorticity, None)
        box = self._cut(self._velocity(went.blocks, vorticity), went.blocks, passage.after)
        held = passage.arrive(box, self.reference(state.speed, passage.after.poses))
        after = replace(
            after, constraint=held.constraint, loads=held.loads, poses=held.poses,
            earlier=held.earlier,
        )  # fmt: skip
        vorticity = self._with(vorticity, went.blocks, held.created, passage.after)
        return self._adapted(after, went.blocks, vorticity, self._skin(held.poses))

    def _pushed(self, before: AdaptiveState, after: AdaptiveState, dt: float) -> AdaptiveState:
        """The state with the force that its vorticity's impulse tells; refuses what leaves."""
        leaving = self._leaving(after)
        if leaving and self.flow.domain != "fixed":
            raise BlowUpError(self._told(leaving), hint=ROOM)
        if not self.flow.bodies:
            return after
        if leaving:
            return replace(after, impulse_force=(math.nan, math.nan))
        old, grid = self._coarsest(before)
        new, _ = self._coarsest(after)
        force = ledger.impulse_force((old, new), grid, dt, self.flow.freestream, (None, None))
        force += inertia_force(self.flow.bodies, before.poses, after.poses, dt)
        return replace(after, impulse_force=tuple(float(x) for x in force))

    def _measured(self, state: AdaptiveState, velocity: Array, blocks: Blocks) -> AdaptiveState:
        """The state with the gradient and speed of a velocity on some blocks."""
        gradient = gradient_norm(velocity, blocks, threads=self.flow.threads)
        if not math.isfinite(gradient):
            raise BlowUpError("the velocity is not finite", hint="a smaller deformation")
        return replace(state, gradient=gradient, speed=largest(velocity))

    def _adapted(
        self, state: AdaptiveState, blocks: Blocks, vorticity: Array, keep: Places | None
    ) -> AdaptiveState:
        """The state on the mesh that its vorticity asks for, finest where ``keep`` says."""
        always = None
        if keep is not None:
            always = [*[keep[:0]] * self.mesh.levels, keep]
        found = adapt(vorticity, blocks, always=always, threads=self.flow.threads)
        return replace(
            state, blocks=found.blocks, vorticity=found.fields, busy=found.busy,
            tolerance=found.tolerance,
        )  # fmt: skip

    def _velocity(self, blocks: Blocks, vorticity: Array) -> Array:
        """Velocity on some blocks, free stream included."""
        return self._hierarchy.velocity(vorticity, blocks, freestream=self.flow.freestream)

    @cached_property
    def _hierarchy(self) -> AdaptiveSolver:
        flow, mesh = self.flow, self.mesh
        most = mesh.block - len(get_wavelet(mesh.wavelet).predict)
        return AdaptiveSolver(
            mesh, order=flow.order, radius=flow.radius, threads=flow.threads,
            reach=min(FAR, most) if flow.bodies else None,
        )  # fmt: skip

    def _spread(self, vorticity: Array, blocks: Blocks, diffused: float) -> tuple[Array, float]:
        """The vorticity after it spread by ``diffused`` = nu t [L^2], and what left."""
        if diffused == 0:
            return vorticity, 0.0
        found = spread(vorticity, blocks, diffused, threads=self.flow.threads)
        return found.values, float(found.lost)

    def _wall(self, before: tuple[Pose, ...], after: tuple[Pose, ...], variance: float) -> Wall:
        """The bodies on the part of the finest mesh that holds what their force creates."""
        boxes = []
        for poses in dict.fromkeys((before, after)):
            wall = self.wall_on(self.mesh.grid, poses)
            wall.stay(fixed=True)
            boxes.append(wall.wide(variance))
        return self.wall_on(hull(boxes), before)

    def _cut(self, velocity: Array, blocks: Blocks, wall: Wall) -> Array:
        """The velocity on the mesh of a wall, without ripples from node to node."""
        box = tuple(
            range(first, first + n)
            for first, n in zip(first_node(self.mesh.grid, wall.grid), wall.grid.shape, strict=True)
        )
        return smoothed(to_uniform(velocity, blocks, region=box, outside="last"))

    def _with(self, vorticity: Array, blocks: Blocks, created: Array, wall: Wall) -> Array:
        """The vorticity and what a wall created on its mesh."""
        first = first_node(self.mesh.grid, wall.grid)
        return added(vorticity, blocks, created, first, threads=self.flow.threads)

    def _skin(self, poses: tuple[Pose, ...]) -> Places | None:
        """Places of the finest blocks at the walls."""
        bodies = self.flow.bodies
        if not bodies:
            return None
        return skin(bodies, at_rest(bodies, poses), self.mesh)

    def _coarsest(self, state: AdaptiveState) -> tuple[Array, Grid]:
        """The vorticity of the coarsest level, with the moments of all, on a grid."""
        return to_uniform(state.vorticity, state.blocks, 0), self.mesh.level_grid(0)

    def _told(self, leaving: list[int]) -> str:
        """What is wrong with vorticity at the ends of some axes."""
        return (
            f"vorticity has reached the end of the adaptive mesh along axis {leaving[0]}: it comes "
            f"within {EDGE} nodes of the coarsest level ({EDGE * self.mesh.spacing(0):.3g})"
        )

    def _leaving(self, state: AdaptiveState) -> list[int]:
        """Axes at whose unbounded ends vorticity is about to leave."""
        size = np.abs(self._coarsest(state)[0])
        floor = max(self.flow.negligible or SIGNIFICANT, state.tolerance) * float(
            np.abs(state.vorticity).max()
        )
        found = []
        for axis, wraps in enumerate(self.mesh.grid.periodic):
            ends = np.take(size, [*range(EDGE), *range(-EDGE, 0)], axis=axis)
            if not wraps and (ends > floor).any():
                found.append(axis)
        return found


def _started(vorticity: Array | Callable[[Array], Array] | None, flow: VortexFlow) -> Any:
    """What a flow starts from: an array or a law; none is zero everywhere."""
    if vorticity is None:
        return lambda points: np.zeros(points.shape[1:])
    if callable(vorticity):
        return vorticity
    return checked_vorticity(vorticity, flow.lattice, np.dtype(flow.dtype))


def _enstrophy(state: AdaptiveState) -> float:
    """int w^2 dV over the active nodes [L^2/T^2]."""
    mesh, blocks = state.blocks.mesh, state.blocks
    squares = np.where(blocks.leaves(), np.square(state.vorticity, dtype=np.float64), 0.0)
    sums = squares.sum(axis=tuple(range(1, mesh.ndim + 1)))
    cells = np.array([mesh.spacing(level) ** mesh.ndim for level in range(mesh.levels + 1)])
    return float(sums @ cells[blocks.levels])
