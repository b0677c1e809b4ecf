"""The bodies of a flow over a step: where their force acts, and the vorticity it creates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.forced_wall import calibrated, sheet_retraction
from pmesh.bodies.forcing import DirectForcing, force
from pmesh.bodies.hold import Freedom, Held, Imposed
from pmesh.bodies.markers import markers_of
from pmesh.bodies.mask import MARGIN, Mask, box_around, deformation_on, mask_of, moves
from pmesh.bodies.motion import Free
from pmesh.bodies.penalise import Penalisation, penalise
from pmesh.bodies.pose import Pose
from pmesh.bodies.wall import Law, start_offset, wall_law
from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.state import Constraint
from remesh.errors import BlowUpError
from remesh.grid import Grid
from remesh.stencils import curl
from remesh.transfer import p2m

Array = NDArray[np.floating[Any]]
SPREAD = 8.0  # a wide box reaches this many standard deviations of the viscous spread further
START_RATE = 1e3  # lambda tau of an impulsive start
SHEET = 0.1  # its vortex sheet lies this part of a spacing outside the wall: on Stokes's first
# problem the drag is then right from a layer of sqrt(nu t) = 0.6 h on; at 0 it is 2 % too large
CARRIER = "M6'"  # kernel that carries a force along with its body
FAINT = 1e-3  # indicator below which a carried force says nothing


class Overlap(NamedTuple):
    """The part of a box that lies on the mesh: its slices on the mesh and on the box."""

    mesh: tuple[slice, ...]
    box: tuple[slice, ...]


@dataclass(frozen=True, kw_only=True)
class Wall:
    """The bodies on a mesh at one time, and how they are held."""

    bodies: tuple[Body, ...]
    poses: tuple[Pose, ...]
    grid: Grid  # the mesh
    viscosity: float
    settings: Penalisation | DirectForcing
    order: int  # of the velocity solve that the wall feels
    radius: float
    solver: Callable[[Grid], VelocitySolver]

    def at(self, poses: tuple[Pose, ...]) -> Wall:
        """The same bodies elsewhere."""
        return replace(self, poses=poses)

    @cached_property
    def near(self) -> Grid:
        """The box that holds the indicator."""
        reach = self.settings.width * self.grid.spacing
        return box_around(self.bodies, self.poses, self.grid, reach)

    def wide(self, spread: float) -> Grid:
        """The box that holds what the force creates after it spread by ``spread`` [L^2]."""
        reach = self.settings.width * self.grid.spacing + SPREAD * math.sqrt(2 * spread)
        return box_around(self.bodies, self.poses, self.grid, reach)

    def stay(self, *, fixed: bool) -> None:
        """Refuse bodies that crossed the end of a periodic axis, or left a mesh that is fixed."""
        reach = (self.settings.width + MARGIN) * self.grid.spacing
        for number, (body, pose) in enumerate(zip(self.bodies, self.poses, strict=True)):
            for axis, wraps in enumerate(self.grid.periodic):
                low, high = (corner[axis] for corner in body.bounds(pose))
                start, span = self.grid.origin[axis], self.grid.length[axis]
                if wraps and high - low > span - 2 * self.grid.spacing:
                    continue  # from end to end: a wall
                room = reach if fixed and not wraps else 0.0
                if (wraps or fixed) and (low < start + room or high > start + span - room):
                    raise BlowUpError(
                        f"body {number} reaches from {low:.4g} to {high:.4g} along axis {axis} at "
                        f"t = {pose.time:.4g}, out of the mesh from {start:.4g} to "
                        f"{start + span:.4g}",
                        hint="a larger grid"
                        + ("" if wraps else ', or domain="follow"')
                        + ", or a shorter run",
                    )

    def mask(self, *, impulsive: bool = False) -> Mask:
        """The indicator, drawn in so that the flow sees the wall at distance zero."""
        settings, h = self.settings, self.grid.spacing
        sharp = isinstance(settings, Penalisation) and settings.sharp
        return mask_of(
            self.bodies, self.poses, self.near, settings.width * h,
            self.offset(impulsive=impulsive) * h, sharp,
        )  # fmt: skip

    def offset(self, *, impulsive: bool = False) -> float:
        """How far the middle of the indicator, or the first marker, lies inside, in spacings."""
        settings, velocity = self.settings, (self.order, self.radius)
        if isinstance(settings, DirectForcing):
            if impulsive:
                return sheet_retraction(START_RATE, *velocity) - SHEET
            return calibrated(settings.strength, *velocity).retraction
        if impulsive:
            return start_offset(settings.width, START_RATE, *velocity, sharp=settings.sharp) - SHEET
        return self.law(settings).offset

    def law(self, settings: Penalisation) -> Law:
        """Where a penalised wall acts and what it feels."""
        return wall_law(
            settings.width, settings.strength, self.order, self.radius, sharp=settings.sharp
        )

    def fastest(self) -> float:
        """Largest known speed of the bodies' matter [L/T]."""
        mask = self.mask()
        return float(np.sqrt(np.max(np.sum(mask.velocity**2, axis=0) * (mask.chi > 0))))

    def start(self, velocity: Array, speed: float) -> tuple[Imposed, Array]:
        """Stop the slip of a given velocity [L/T] at once: the impulse, and its vorticity."""
        mask = self.launched(self.mask(impulsive=True))
        imposed = self._imposed(velocity, mask, START_RATE, 0.0, speed, impulsive=True)
        return imposed, self.created(imposed.impulse, 0.0)

    def launched(self, mask: Mask) -> Mask:
        """The mask with the velocity that free bodies have."""
        points, velocity = mask.grid.points(), mask.velocity
        for number, (body, pose) in enumerate(zip(self.bodies, self.poses, strict=True)):
            if isinstance(body.motion, Free):
                velocity = velocity + np.where(mask.owner == number, pose.rigid(points), 0.0)
        return mask._replace(velocity=velocity)

    def impose(
        self,
        velocity: Array,
        tau: float,
        speed: float,
        guess: Array | None,
        freedom: Freedom | None = None,
    ) -> Imposed:
        """Hold the bodies over a time tau [T]; ``velocity`` on the mesh without the force."""
        spread = self.viscosity * tau
        rate = self.settings.strength * spread / self.grid.spacing**2
        return self._imposed(velocity, self.mask(), rate, spread, speed, guess, freedom)

    def _imposed(
        self,
        velocity: Array,
        mask: Mask,
        rate: float,
        spread: float,
        speed: float,
        guess: Array | None = None,
        freedom: Freedom | None = None,
        *,
        impulsive: bool = False,
    ) -> Imposed:
        """What penalisation or direct forcing does on the near box."""
        settings, given, solver = self.settings, self.cut(velocity), self.solver(mask.grid)
        held = Held(mask=mask, solver=solver, rate=rate, spread=spread, freedom=freedom)
        if isinstance(settings, Penalisation):
            held = replace(held, blur=0.0 if impulsive else self.law(settings).blur)
            return penalise(given, held, speed=speed, settings=settings, guess=guess)
        depth = self.offset(impulsive=impulsive) * self.grid.spacing
        markers = markers_of(self.bodies, self.poses, self.grid, settings.spacing, depth)
        wall = calibrated(settings.strength, self.order, self.radius)
        held = replace(held, blur=0.0 if impulsive else -wall.sharpening)
        return force(given, markers, held, speed=speed, settings=settings, guess=guess)

    def carried(self, before: Wall, force: Array) -> Array:
        """A force density on the near box of an earlier wall, moved along with the bodies."""
        if not any(moves(body) for body in self.bodies):
            return force
        mask, near = before.mask(), self.near
        points, dt = mask.grid.points(), self.poses[0].time - before.poses[0].time
        inside = mask.chi > 0
        places = np.empty((int(inside.sum()), self.grid.ndim))
        owner = mask.owner[inside]
        for number, (body, old, new) in enumerate(
            zip(self.bodies, before.poses, self.poses, strict=True)
        ):
            own = owner == number
            here = points[:, inside][:, own]
            change = deformation_on(body, old, mask.grid)
            there = here if change is None else here + dt * change[:, inside][:, own]
            places[own] = new.placed(old.seen(there)).T
        parts = [
            p2m(places, component[inside] * self.grid.cell_volume, near, kernel=CARRIER)
            for component in force
        ]
        return np.stack(parts).astype(force.dtype, copy=False)

    def guess(self, force: Array) -> Array:
        """A carried force where the indicator can hold it."""
        if not any(moves(body) for body in self.bodies):
            return force
        chi = self.mask().chi
        return np.asarray(force * (chi / (chi + FAINT)), force.dtype)

    def created(self, impulse: Array, spread: float) -> Array:
        """Vorticity on the mesh [1/T] from an impulse density on the near box, spread by phi1.

        Of the mesh's shape in the plane, (3, *shape) in space.
        """
        wide, near = self.wide(spread), self.near
        widened = np.zeros((len(impulse), *wide.shape), impulse.dtype)
        part = window_on(wide, near)
        widened[(slice(None), *part.mesh)] = impulse[(slice(None), *part.box)]
        vorticity = curl(widened, wide, order=4, edge="zero")
        if spread > 0:
            vorticity = self.solver(wide).smoothed(vorticity, spread, "phi1")
        window = self.window(wide)
        if vorticity.ndim == self.grid.ndim:
            result = np.zeros(self.grid.shape, impulse.dtype)
            result[window.mesh] = vorticity[window.box]
            return result
        result = np.zeros((len(vorticity), *self.grid.shape), impulse.dtype)
        result[(slice(None), *window.mesh)] = vorticity[(slice(None), *window.box)]
        return result

    def window(self, box: Grid) -> Overlap:
        """Where a box of this mesh's lattice lies on the mesh."""
        return window_on(self.grid, box)

    @property
    def rows(self) -> tuple[int, int]:
        """Nodes of the mesh's first axis between which the near box lies."""
        along = self.window(self.near).mesh[0]
        return along.start, along.stop

    def cut(self, field: Array) -> Array:
        """The part of a field on the near box; zero where the box sticks out of the mesh."""
        near = self.near
        window = self.window(near)
        result = np.zeros((len(field), *near.shape), field.dtype)
        result[(slice(None), *window.box)] = field[(slice(None), *window.mesh)]
        return result

    def held(self, imposed: Imposed, force: Array, change: Array) -> Constraint:
        """The outcome of a step with the mean ``force`` on the fluid."""
        mask = self.mask()
        slip = np.sqrt(np.sum(imposed.slip**2, axis=0))  # weighed by sqrt(chi)
        core = mask.chi > 0.5
        return Constraint(
            grid=mask.grid,
            force=force,
            change=change,
            slip=float(np.sqrt(np.sum(slip**2) / np.sum(mask.chi))),
            slip_max=float((slip[core] / mask.root[core]).max()),
            residual=imposed.residual,
            iterations=imposed.iterations,
        )


def window_on(grid: Grid, box: Grid) -> Overlap:
    """Where a box lies on a mesh of the same lattice."""
    mesh, inside = [], []
    for first, n, nodes in zip(first_node(grid, box), box.shape, grid.shape, strict=True):
        low, high = max(first, 0), min(first + n, nodes)
        mesh.append(slice(low, high))
        inside.append(slice(low - first, high - first))
    return Overlap(tuple(mesh), tuple(inside))


def first_node(grid: Grid, box: Grid) -> tuple[int, ...]:
    """The node of a grid at which a box of its lattice begins."""
    return tuple(
        round((b - a) / grid.spacing) for a, b in zip(grid.origin, box.origin, strict=True)
    )
