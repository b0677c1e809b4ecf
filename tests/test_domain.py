"""The mesh that makes room: on its lattice, before anything is cut, without changing the flow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmesh.vortex.domain import SIGNIFICANT, STRIDE, Shift, room
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

GRID = Grid((40, 48), 0.1, (0.3, -1.7))
ENDS = st.tuples(st.integers(-15, 40), st.integers(-15, 40))


def spot(grid: Grid, *places: tuple[int, int]) -> np.ndarray:
    values = np.zeros(grid.shape)
    for place in places:
        values[place] = 1.0
    return values


@given(before=ENDS, after=ENDS, front=st.sampled_from([(), (2,)]))
def test_a_shift_keeps_every_value_at_its_place(before, after, front):
    shift = Shift(before, after)
    grid = shift.grid(GRID)
    field = np.broadcast_to(GRID.points()[0] + 10 * GRID.points()[1], (*front, *GRID.shape))
    moved = shift.field(np.ascontiguousarray(field))
    assert moved.shape == (*front, *grid.shape)
    x, y = grid.points()
    old = (x > 0.29) & (x < 4.21) & (y > -1.71) & (y < 3.01)
    np.testing.assert_allclose(
        moved[..., old], np.broadcast_to((x + 10 * y)[old], (*front, old.sum())), atol=1e-12
    )
    assert (moved[..., ~old] == 0).all()


@given(before=ENDS, after=ENDS)
def test_growing_and_trimming_back_is_the_identity(before, after):
    grown = Shift(tuple(map(abs, before)), tuple(map(abs, after)))
    back = Shift(tuple(-abs(n) for n in before), tuple(-abs(n) for n in after))
    field = np.random.default_rng(1).standard_normal(GRID.shape)
    np.testing.assert_array_equal(back.field(grown.field(field)), field)
    assert back.grid(grown.grid(GRID)).shape == GRID.shape
    np.testing.assert_allclose(back.grid(grown.grid(GRID)).origin, GRID.origin, atol=1e-12)


def test_a_hundred_shifts_leave_the_origin_on_the_lattice():
    grid = Grid((40, 40), 0.1 / 3, (1 / 7, -1 / 7))
    for _ in range(50):
        grid = Shift((16, 0), (0, 16)).grid(grid)
        grid = Shift((0, 16), (-16, -16)).grid(grid)
    steps = (np.array(grid.origin) - (1 / 7, -1 / 7)) * 30
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-11)


@pytest.mark.parametrize("margin", [4, 10, 17])
def test_room_leaves_the_margin_at_every_unbounded_end(margin):
    field = spot(GRID, (2, 40), (30, 3))
    shift = room(field, GRID, margin, follow=False)
    live = np.argwhere(shift.field(field))
    shape = shift.grid(GRID).shape
    assert (live.min(axis=0) >= margin).all()
    assert (live.max(axis=0) < np.array(shape) - margin).all()
    assert all(n % STRIDE == 0 for n in (*shift.before, *shift.after))
    assert not room(shift.field(field), shift.grid(GRID), margin, follow=False)


def test_there_is_no_need_for_room_when_nothing_is_near():
    assert not room(spot(GRID, (20, 24)), GRID, 10, follow=False)
    assert not room(np.zeros(GRID.shape), GRID, 10, follow=True)
    faint = spot(GRID, (20, 24))
    faint[0, 0] = 0.5 * SIGNIFICANT
    assert not room(faint, GRID, 10, follow=False)


def test_a_periodic_axis_never_changes():
    grid = Grid((40, 48), 0.1, boundary=("periodic", "unbounded"))
    for follow in (False, True):
        shift = room(spot(grid, (0, 0)), grid, 10, follow=follow)
        assert (shift.before[0], shift.after[0]) == (0, 0)
        assert shift.before[1] > 0


def test_only_follow_lets_go_of_ends_at_rest():
    grid = Grid((200, 48), 0.1)
    field = spot(grid, (180, 24))
    assert not room(field, grid, 10, follow=False)
    shift = room(field, grid, 10, follow=True)
    assert shift.before[0] < -50
    assert shift.after == (0, 0)
    while shift:
        assert max(*shift.before, *shift.after) <= 0, "it does not flutter"
        field, grid = shift.field(field), shift.grid(grid)
        shift = room(field, grid, 10, follow=True)
    assert field.sum() == 1
    assert np.argwhere(field)[0, 0] >= 10


def test_a_mesh_in_space_goes_with_what_moves_by_single_strides():
    grid, place, sizes = Grid((48, 48, 48), 0.1), 24, []
    field = spot(grid, (24, 24, place))
    for _ in range(100):  # one node a step along z
        field = np.roll(field, 1, axis=2)
        shift = room(field, grid, 10, follow=True)
        assert set(np.abs((*shift.before, *shift.after))) <= {0, STRIDE}
        field, grid = shift.field(field), shift.grid(grid)
        sizes.append(grid.shape[2])
        live = int(np.argwhere(field)[0, 2])
        assert 10 <= live < grid.shape[2] - 10
    assert max(sizes) <= 48 + STRIDE
    assert field.sum() == 1


@pytest.mark.parametrize("negligible", [1e-3, 1e-7])
def test_what_is_negligible_is_said_by_the_flow(negligible):
    def law(points):
        far = np.exp(-((points[0] - 0.2) ** 2 + points[1] ** 2) / 0.01)
        return far + 1e-5 * np.exp(-((points[0] + 0.85) ** 2 + points[1] ** 2) / 0.01)

    flow = VortexFlow(grid=Grid((40, 40), 0.05, (-0.975, -0.975)), negligible=negligible)
    state = flow.step(flow.start(vorticity=law), 0.01)
    assert (state.grid.shape[0] > 40) is (negligible < 1e-5)


def test_the_mesh_covers_what_the_bodies_need():
    box = Grid((20, 30), 0.1, (0.3 - 0.5, -1.7 + 2.9))
    shift = Shift((-16, 0), (0, 0)).covering(GRID, box)
    grid = shift.grid(GRID)
    for axis in range(2):
        assert grid.axes()[axis][0] <= box.axes()[axis][0] + 1e-9
        assert grid.axes()[axis][-1] >= box.axes()[axis][-1] - 1e-9


# In a flow


def drifting(points: np.ndarray) -> np.ndarray:
    """A vortex of radius 1 that ends there, so that no tail is cut."""
    x, y = points
    return np.maximum(1 - x**2 - y**2, 0) ** 8


@pytest.mark.parametrize("domain", ["grow", "follow"])
@pytest.mark.parametrize("viscosity", [0.0, 2e-3])
def test_a_mesh_that_moves_gives_the_flow_of_a_large_fixed_one(domain, viscosity):
    h, options = 1 / 16, {"viscosity": viscosity, "freestream": (1.0, -0.5)}
    small = VortexFlow(grid=Grid((40, 40), h, (-1.25, -1.25)), domain=domain, **options)
    large = VortexFlow(grid=Grid((160, 120), h, (-3.25, -4.25)), domain="fixed", **options)
    moving, fixed = small.start(vorticity=drifting), large.start(vorticity=drifting)
    for _ in range(5):
        moving, fixed = small.step(moving, 0.6), large.step(fixed, 0.6)
        steps = (np.array(moving.grid.origin) + 1.25) / h
        np.testing.assert_array_equal(steps, np.round(steps))
    first = np.round((np.array(moving.grid.origin) - fixed.grid.origin) / h).astype(int)
    whole = np.zeros((400, 400))
    whole[100 : 100 + 160, 100 : 100 + 120] = fixed.vorticity
    i, j = 100 + first
    part = whole[i : i + moving.grid.shape[0], j : j + moving.grid.shape[1]]
    assert np.abs(moving.vorticity - part).max() < 1e-6 * part.max()
    assert abs(whole.sum() - part.sum()) < 1e-6 * part.sum()
    total = moving.vorticity.sum() * h**2 + moving.lost_circulation
    assert total == pytest.approx(small.ledger(small.start(vorticity=drifting))["circulation"])
    assert abs(moving.lost_circulation) < 1e-7
    if domain == "follow":
        assert moving.grid.size < 0.8 * fixed.grid.size


def test_the_mesh_grows_with_particles_that_are_not_remeshed():
    flow = VortexFlow(
        grid=Grid((40, 40), 1 / 16, (-1.25, -1.25)), freestream=(1.0, 0.0), remeshing="distorted",
        distortion=9.0,
    )  # fmt: skip
    state = flow.start(vorticity=lambda points: 1e-3 * drifting(points))
    total = flow.ledger(state)["circulation"]
    for _ in range(10):
        state = flow.step(state, 0.2)
    assert state.strengths is not None
    assert state.grid.shape[0] > 60
    assert flow.ledger(state)["circulation"] == pytest.approx(total, rel=1e-9)


def test_what_a_following_mesh_lets_go_of_is_counted():
    """A faint trail over a long axis, below what is made room for."""
    grid = Grid((200, 48), 1 / 16, (-10.0, -1.5))

    def trail(points: np.ndarray) -> np.ndarray:
        return drifting(points) + 0.5 * SIGNIFICANT * (np.hypot(points[1], points[0] + 9) < 0.5)

    flow = VortexFlow(grid=grid, domain="follow")
    state = flow.start(vorticity=trail)
    total = flow.ledger(state)["circulation"]
    end = flow.step(state, 0.1)
    assert end.grid.shape[0] < 150
    assert end.lost_circulation > 1e-7
    kept = flow.ledger(end)["circulation"] + end.lost_circulation
    assert kept == pytest.approx(total, rel=1e-13)
