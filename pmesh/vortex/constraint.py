"""The bodies of a flow over a step: where the penalisation acts, and the vorticity it creates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.penalise import Imposed, Mask, Penalisation, box_around, mask_of, penalise
from pmesh.bodies.wall import start_offset, wall_offset
from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.state import Constraint, Load
from remesh.grid import Grid
from remesh.stencils import curl

Array = NDArray[np.floating[Any]]
SPREAD = 8.0  # a wide box reaches this many standard deviations of the viscous spread further
START_RATE = 1e3  # lambda tau of an impulsive start
SHEET = 0.1  # its vortex sheet lies this part of a spacing outside the wall: on Stokes's first
# problem the drag is then right from a layer of sqrt(nu t) = 0.6 h on; at 0 it is 2 % too large


class Window(NamedTuple):
    """The part of a box that lies on the mesh: its slices on the mesh and on the box."""

    mesh: tuple[slice, ...]
    box: tuple[slice, ...]


@dataclass(frozen=True, kw_only=True)
class Wall:
    """The bodies on a mesh at one time, and how they are held."""

    bodies: tuple[Body, ...]
    grid: Grid  # the mesh
    time: float
    viscosity: float
    settings: Penalisation
    order: int  # of the velocity solve that the wall feels
    radius: float
    solver: Callable[[Grid], VelocitySolver]

    @property
    def near(self) -> Grid:
        """The box that holds the indicator."""
        reach = self.settings.width * self.grid.spacing
        return box_around(self.bodies, self.grid, self.time, reach)

    def wide(self, spread: float) -> Grid:
        """The box that holds what the force creates after it spread by ``spread`` [L^2]."""
        reach = self.settings.width * self.grid.spacing + SPREAD * math.sqrt(2 * spread)
        return box_around(self.bodies, self.grid, self.time, reach)

    def mask(self, *, impulsive: bool = False) -> Mask:
        """The indicator, drawn in so that the flow sees the wall at distance zero."""
        settings, h = self.settings, self.grid.spacing
        if impulsive:
            offset = start_offset(settings.width, START_RATE, self.order, self.radius) - SHEET
        else:
            offset = wall_offset(settings.width, settings.strength, self.order, self.radius)
        time = self.time if any(body.moving for body in self.bodies) else 0.0
        return mask_of(self.bodies, self.near, time, settings.width * h, offset * h)

    def start(self, velocity: Array, speed: float) -> tuple[Imposed, Array]:
        """Stop the slip of a given velocity [L/T] at once: the impulse, and its vorticity."""
        box = self.window(self.near)
        given = _cut(velocity, box, self.near)
        imposed = penalise(
            given, self.mask(impulsive=True), self.solver(self.near), rate=START_RATE, spread=0.0,
            speed=speed, settings=self.settings,
        )  # fmt: skip
        return imposed, self.created(imposed.impulse, 0.0)

    def impose(self, velocity: Array, tau: float, speed: float, guess: Array | None) -> Imposed:
        """Hold the bodies over a time tau [T]; ``velocity`` on the mesh without the force."""
        spread = self.viscosity * tau
        rate = self.settings.strength * spread / self.grid.spacing**2
        return penalise(
            _cut(velocity, self.window(self.near), self.near), self.mask(), self.solver(self.near),
            rate=rate, spread=spread, speed=speed, settings=self.settings, guess=guess,
        )  # fmt: skip

    def created(self, impulse: Array, spread: float) -> Array:
        """Vorticity on the mesh [1/T] from an impulse density on the near box, spread by phi1."""
        wide, near = self.wide(spread), self.near
        front = _steps(wide, near)
        widened = np.zeros((len(impulse), *wide.shape), impulse.dtype)
        inner = tuple(slice(a, a + n) for a, n in zip(front, near.shape, strict=True))
        widened[(slice(None), *inner)] = impulse
        vorticity = curl(widened, wide, order=4, edge="zero")
        if spread > 0:
            vorticity = self.solver(wide).smoothed(vorticity, spread, "phi1")
        result = np.zeros(self.grid.shape, impulse.dtype)
        window = self.window(wide)
        result[window.mesh] = vorticity[window.box]
        return result

    def window(self, box: Grid) -> Window:
        """Where a box of this mesh's lattice lies on the mesh."""
        mesh, inside = [], []
        for first, n, nodes in zip(_steps(self.grid, box), box.shape, self.grid.shape, strict=True):
            low, high = max(first, 0), min(first + n, nodes)
            mesh.append(slice(low, high))
            inside.append(slice(low - first, high - first))
        return Window(tuple(mesh), tuple(inside))

    def report(self, imposed: Imposed, force: Array) -> tuple[Constraint, tuple[Load, ...]]:
        """The penalisation's outcome and the load on each body, for ``force`` on the fluid."""
        mask = self.mask()
        slip = np.sqrt(np.sum((imposed.velocity - mask.velocity) ** 2, axis=0))
        held = Constraint(
            grid=mask.grid,
            force=force,
            slip=float(np.sqrt(np.sum(mask.chi * slip**2) / np.sum(mask.chi))),
            slip_max=float(slip[mask.chi > 0.5].max()),
            residual=imposed.residual,
            iterations=imposed.iterations,
        )
        loads = []
        for number in range(len(self.bodies)):
            own = force[:, mask.owner == number]
            loads.append(tuple(-own.sum(axis=1, dtype=np.float64) * self.grid.cell_volume))
        return held, tuple(Load(force=tuple(float(x) for x in load)) for load in loads)


def _steps(grid: Grid, box: Grid) -> tuple[int, ...]:
    """Nodes from the grid's origin to the box's."""
    return tuple(
        round((b - a) / grid.spacing) for a, b in zip(grid.origin, box.origin, strict=True)
    )


def _cut(field: Array, window: Window, box: Grid) -> Array:
    """The part of a field on a box; zero where the box sticks out of the mesh."""
    result = np.zeros((len(field), *box.shape), field.dtype)
    result[(slice(None), *window.box)] = field[(slice(None), *window.mesh)]
    return result
