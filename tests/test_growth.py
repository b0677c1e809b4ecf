"""The mesh made ready for a step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.growth import FARTHEST, with_room
from remesh.errors import BlowUpError
from remesh.grid import Grid

H = 0.125


def off_centre(ndim: int) -> VortexFlow:
    """A flow on a box of two units a side."""
    return VortexFlow(grid=Grid((16,) * ndim, H, (-1.0,) * ndim), viscosity=1e-3)


def blob(points: np.ndarray) -> np.ndarray:
    """A smooth vortex near the lower end of the first axis; in space a line through it."""
    radius = np.sum((points - np.array([-0.5, *[0.0] * (len(points) - 1)]).reshape(-1, *[1] * len(
        points))) ** 2, axis=0)  # fmt: skip
    values = np.exp(-radius / 0.2**2)
    if len(points) == 2:
        return values
    zero = np.zeros_like(values)
    x, y = points[0] + 0.5, points[1]
    return np.stack([-y * values, x * values, zero])  # a ring: curl of a vector along z


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_mesh_grows_to_where_the_vorticity_is_and_keeps_every_value(ndim):
    flow = off_centre(ndim)
    state = flow.start(vorticity=blob)
    grown = with_room(replace(state, speed=4.0), flow, [], 0.1, negligible=1e-6)
    assert grown.grid.size > state.grid.size
    first = np.round((np.array(state.grid.origin) - grown.grid.origin) / H).astype(int)
    box = (..., *(slice(a, a + n) for a, n in zip(first, state.grid.shape, strict=True)))
    np.testing.assert_array_equal(grown.vorticity[box], state.vorticity)
    assert np.count_nonzero(grown.vorticity) == np.count_nonzero(state.vorticity)
    np.testing.assert_allclose(grown.lost_circulation, 0.0, atol=1e-15)


def test_what_left_its_nodes_goes_along():
    flow = off_centre(2)
    state = flow.start(vorticity=blob)
    moved = np.full((2, 16, 16), 0.01)
    state = replace(state, strengths=2 * state.vorticity, displacement=moved)
    grown = with_room(state, flow, [], 1.0, negligible=1e-6)
    assert grown.strengths.shape == grown.vorticity.shape == grown.displacement.shape[1:]
    assert grown.strengths.sum() == pytest.approx(2 * state.vorticity.sum())
    assert grown.displacement.sum() == pytest.approx(moved.sum())


def test_a_mesh_with_room_is_left_as_it_is():
    flow = VortexFlow(grid=Grid((48, 48), H, (-3.5, -3.0)), viscosity=1e-3)
    state = flow.start(vorticity=blob)
    assert with_room(state, flow, [], 1e-3, negligible=1e-6) is state


def test_a_step_that_would_leave_sight_is_refused():
    flow = off_centre(2)
    state = replace(flow.start(vorticity=blob), speed=1.0)
    with pytest.raises(BlowUpError, match="times the mesh"):
        with_room(state, flow, [], 2.0 * FARTHEST, negligible=1e-6)
    with pytest.raises(BlowUpError, match="times the mesh"):
        with_room(replace(state, speed=np.nan), flow, [], 0.1, negligible=1e-6)
