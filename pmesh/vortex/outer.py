"""Velocity that no vorticity induces: the room that bending bodies make and take."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.mask import at_rest, swelling
from pmesh.bodies.pose import Pose
from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.constraint import Wall, window_on
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Outer = tuple[Array | None, Array | None]  # before and after a step


def swelling_flow(wall: Wall, solver: VelocitySolver) -> Array:
    """Potential velocity grad(phi) on the mesh [L/T], laplace(phi) = divergence of the bodies.

    With it a deformation that is not solenoidal can be held by a solenoidal force.
    """
    return _swelling_flow(
        wall.bodies, at_rest(wall.bodies, wall.poses), wall.grid, wall.near,
        wall.settings.width, solver,
    )  # fmt: skip


@lru_cache(maxsize=3)
def _swelling_flow(
    bodies: tuple[Body, ...],
    places: tuple[Pose, ...],
    grid: Grid,
    near: Grid,
    width: float,
    solver: VelocitySolver,
) -> Array:
    source = swelling(bodies, places, near, width * grid.spacing)
    assert source is not None  # a body deforms
    window = window_on(grid, near)
    spread = np.zeros(grid.shape, solver.dtype)
    spread[window.mesh] = source[window.box]
    flow = solver.potential_flow(spread)
    flow.flags.writeable = False
    return flow
