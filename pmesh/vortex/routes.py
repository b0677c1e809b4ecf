"""Forces on bodies by routes that do not ask what holds them: from the flow around them alone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body, matter_velocity
from pmesh.bodies.control_volume import box_of, momentum_balance
from pmesh.bodies.pose import Pose
from pmesh.bodies.traction import has_room, traction
from pmesh.vortex.constraint import window_on
from pmesh.vortex.loads import inertia_force, spin_gained
from pmesh.vortex.state import State
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]
Pair = tuple[Array, Array]
POINTS = 0.5  # spacings between points of an outline
ROUTES = ("flux", "surface")
LOADS = ("force_x", "force_y", "torque")
Columns = dict[str, float]


def routes(flow: VortexFlow, before: State, after: State) -> Columns:
    """Force and torque on every body, mean over the step between two states.

    ``bodyN_flux_*``: from the momentum that passes a box around it; ``bodyN_surface_*``: from
    pressure and shear on it; ``bodyN_routes_apart``: how far the forces are from each other and
    from the momentum of the force that holds it, at most. NaN where there is no room to look.
    Costs two velocity solves, and for each body a box and an outline.
    """
    grid = after.grid
    earlier = replace(before, grid=grid, vorticity=_onto(before.vorticity, before.grid, grid))
    fields = ((earlier.vorticity, after.vorticity), (flow.velocity(earlier), flow.velocity(after)))
    columns: Columns = {}
    for number, body in enumerate(flow.bodies):
        name = f"body{number}"
        poses = before.poses[number], after.poses[number]
        others = [
            other.bounds(state.poses[n])
            for n, other in enumerate(flow.bodies)
            for state in (before, after)
            if n != number
        ]
        known = (
            _flux(body, poses, others, fields, grid, flow.viscosity),
            _surface(body, poses, fields, grid, flow.viscosity),
        )
        loads = [np.asarray(after.loads[number].force)]
        for route, values in zip(ROUTES, known, strict=True):
            parts = (f"{name}_{route}_{part}" for part in LOADS)
            columns |= dict(zip(parts, values, strict=True))
            loads.append(np.array(values[:2]))
        columns[f"{name}_routes_apart"] = max(
            float(np.hypot(*(a - b))) for i, a in enumerate(loads) for b in loads[:i]
        )
    return columns


def check_routes(flow: VortexFlow) -> None:
    """Refuse flows whose routes are not known: in space, and on adaptive meshes."""
    if flow.lattice.ndim == 3:
        raise InputError(
            "control volumes and traction are laws of the plane, the flow is in space",
            hint="pmesh.Forces() without routes: it has two of them",
        )
    if isinstance(flow.grid, AdaptiveMesh):
        raise InputError(
            "control volumes and traction need a uniform grid, the mesh is adaptive",
            hint="pmesh.Forces() without routes, or a Grid",
        )


def route_names(bodies: int) -> list[str]:
    """The columns of `routes`."""
    return [
        f"body{number}_{name}"
        for number in range(bodies)
        for name in (*(f"{a}_{b}" for a in ROUTES for b in LOADS), "routes_apart")
    ]


def _flux(
    body: Body,
    poses: tuple[Pose, Pose],
    others: list[Any],
    fields: tuple[Pair, Pair],
    grid: Grid,
    viscosity: float,
) -> tuple[float, float, float]:
    """Force and torque from a control volume."""
    vorticity, velocity = fields
    box = box_of(body.bounds(poses[0]), body.bounds(poses[1]), others, grid)
    if box is None:
        return (math.nan,) * 3
    dt = poses[1].time - poses[0].time
    found = momentum_balance(
        velocity, vorticity, grid, box, dt=dt, viscosity=viscosity, center=_middle(poses)
    )
    force = np.asarray(found.force) + inertia_force((body,), poses[:1], poses[1:], dt)
    spun = float(spin_gained(body, *poses)[0]) / dt
    return float(force[0]), float(force[1]), float(found.torque + spun)


def _surface(
    body: Body,
    poses: tuple[Pose, Pose],
    fields: tuple[Pair, Pair],
    grid: Grid,
    viscosity: float,
) -> tuple[float, float, float]:
    """Force and torque from pressure and shear on all outlines."""
    vorticity, velocity = fields
    outlines = [body.outlines(pose, POINTS * grid.spacing) for pose in poses]
    lines = list(zip(*outlines, strict=True))
    if not all(has_room(line, grid) for line in lines):
        return (math.nan,) * 3
    total = np.zeros(3)
    for line in lines:
        found = traction(
            line, velocity, vorticity, grid, dt=poses[1].time - poses[0].time,
            viscosity=viscosity, center=_middle(poses),
            moving=(
                matter_velocity(body, line[0].T, poses[0]).T,
                matter_velocity(body, line[1].T, poses[1]).T,
            ),
        )  # fmt: skip
        total += (*found.force, found.torque)
    return float(total[0]), float(total[1]), float(total[2])


def _middle(poses: tuple[Pose, Pose]) -> tuple[float, ...]:
    return tuple(0.5 * (a + b) for a, b in zip(poses[0].center, poses[1].center, strict=True))


def _onto(field: Array, grid: Grid, other: Grid) -> Array:
    """A field on another mesh of the same lattice, zero where it was not."""
    result = np.zeros(other.shape, field.dtype)
    window = window_on(other, grid)
    result[window.mesh] = field[window.box]
    return result
