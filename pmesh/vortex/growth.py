"""A mesh made ready for a step: room for the vorticity and the bodies wherever they go."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from pmesh.vortex import ledger
from pmesh.vortex.constraint import Wall
from pmesh.vortex.domain import room
from pmesh.vortex.state import State
from remesh.errors import BlowUpError
from remesh.kernels import get_kernel

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

FARTHEST = 64.0  # mesh lengths that nothing moves in one step of a sane run
SPREAD = 6.0  # standard deviations of the viscous spread of a step that room is made for


def with_room(
    state: State, flow: VortexFlow, walls: Iterable[Wall], dt: float, *, negligible: float
) -> State:
    """The state on a mesh with room for what a step of dt [T] does; the same if it has.

    ``walls``: the bodies before and after; vorticity below the part ``negligible`` of the
    largest is nothing to make room for. What a mesh lets go of is counted as lost. Refuses a step
    that would carry vorticity 64 mesh lengths.
    """
    reach = state.speed * dt + SPREAD * math.sqrt(2.0 * flow.viscosity * dt)
    if not reach < FARTHEST * max(state.grid.length):
        raise BlowUpError(
            f"a step of {dt:.3g} would carry vorticity {reach:.3g} far, "
            f"{reach / max(state.grid.length):.3g} times the mesh",
            hint="a smaller dt, or a smaller deformation",
        )
    margin = math.ceil(reach / state.grid.spacing) + get_kernel(flow.kernel).half_width + 2
    follow = flow.domain == "follow" and state.displacement is None
    shift = room(state.vorticity, state.grid, margin, follow=follow, negligible=negligible)
    if flow.window is not None:
        shift = flow.window.clipped(shift, state.grid, flow.bodies, state.poses)
    for wall in walls:
        shift = shift.covering(state.grid, wall.wide(flow.viscosity * dt))
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
