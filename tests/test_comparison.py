"""Lines of markers and particles with and without remeshing: the measures between them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.laws import Rotation
from levelset.shapes import Disk
from levelset.transport import ParticleLevelSet
from pmesh.cases.comparison import (
    Both,
    Comparison,
    inside,
    largest_gap,
    polygon_area,
    polygon_length,
)
from pmesh.run.loop import run
from remesh.grid import Grid


def circle(radius: float, count: int, center=(0.0, 0.0)) -> np.ndarray:
    turn = 2 * math.pi * np.arange(count) / count
    return np.array(center) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def test_a_square_has_its_area_and_length():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]) + 5.0
    assert polygon_area(square) == pytest.approx(4.0)
    assert polygon_area(square[::-1]) == pytest.approx(-4.0)
    assert polygon_length(square) == pytest.approx(8.0)


@pytest.mark.parametrize("count", [5, 4000])
def test_nodes_are_inside_a_convex_line_on_the_left_of_all_its_edges(count):
    line = circle(0.41, count, (0.5, 0.52))
    grid = Grid((37, 41), 1 / 40, (0.03, 0.01))
    points = grid.points()
    ahead = np.roll(line, -1, axis=0) - line
    away = points[:, None] - line.T[:, :, None, None]
    left = ahead[:, 0, None, None] * away[1] - ahead[:, 1, None, None] * away[0] > 0
    np.testing.assert_array_equal(inside(line, grid), left.all(axis=0))


def test_holes_of_a_folded_line_and_parts_beyond_the_mesh_are_seen():
    """A spiral band: nodes whose distance from its middle line is below half its width."""
    turn = np.linspace(0.5, 3.5 * math.pi, 4000)
    ray = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    middle = 0.05 * turn[:, None] * ray
    line = np.concatenate([middle - 0.03 * ray, (middle + 0.03 * ray)[::-1]])
    grid = Grid((61, 61), 0.02, (-0.5, -0.6))  # the end leaves the box
    x, y = grid.points()
    radius, angle = np.hypot(x, y), np.arctan2(y, x) % (2 * math.pi)
    exact = np.zeros(grid.shape, bool)
    for k in range(3):
        whole = angle + 2 * math.pi * k
        exact |= (np.abs(radius - 0.05 * whole) < 0.03) & (whole > 0.5) & (whole < 3.5 * math.pi)
    assert (inside(line, grid) != exact).mean() < 2e-3


def start(remeshing: str = "distorted"):
    grid = Grid((41, 41), 1 / 40)
    flow = ParticleLevelSet(
        grid=grid, velocity=Rotation(center=(0.5, 0.5), rate=1.0), remeshing=remeshing
    )
    disk = Disk(0.2, center=(0.5, 0.6))
    never = ParticleLevelSet(grid=grid, velocity=flow.velocity, remeshing="never")
    both = Both(
        time=0.0, step=0, without=never.start(disk), remeshed=flow.start(disk),
        markers=circle(0.2, 500, (0.5, 0.6)),
    )  # fmt: skip
    return Comparison(without=never, remeshed=flow, dt=0.05), both


def test_all_three_go_the_same_way():
    flow, state = start("always")
    end = run(flow, state, until=0.5)
    assert end.step == 10
    assert end.without.time == end.remeshed.time == pytest.approx(0.5)
    exact = flow.without.velocity.flow(state.markers, 0.0, 0.5)
    assert end.markers == pytest.approx(exact, abs=1e-7)
    middle = exact.mean(axis=0)
    for each in (end.without, end.remeshed):
        inner = each.positions[each.values < 0]
        assert inner.mean(axis=0) == pytest.approx(middle, abs=5e-3)
    found = flow.ledger(end)
    assert found["marker_area"] == pytest.approx(polygon_area(state.markers))
    assert found["remeshings"] == 10
    assert end.size == found["particles_without"] + found["particles_with"]


def test_neighbours_stay_a_spacing_apart_in_rigid_motion_and_part_in_a_shear():
    flow, state = start()
    end = run(flow, state, until=0.5)
    assert largest_gap(state.without) == pytest.approx(1.0)
    assert largest_gap(end.without) == pytest.approx(1.0, abs=1e-6)
    sheared = replace(state.without, positions=state.without.positions @ [[1.0, 0.0], [2.0, 1.0]])
    assert largest_gap(sheared) == pytest.approx(math.sqrt(5.0))
