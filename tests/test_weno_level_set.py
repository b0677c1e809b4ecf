"""The WENO oracle is what it claims: fifth order in space, third in time, of the right sense."""

from __future__ import annotations

import math

import numpy as np
import pytest
from weno_level_set import carried, padded

from levelset.laws import Rotation, SingleVortex, Uniform
from remesh.grid import Grid


def square(nodes: int) -> Grid:
    return Grid((nodes, nodes), 1.0 / nodes, boundary="periodic")


def wave(points: np.ndarray) -> np.ndarray:
    x, y = 2 * np.pi * points
    return np.sin(x) * np.cos(y) + 0.5 * np.cos(x + y)


@pytest.mark.parametrize("drift", [(1.0, 0.4), (-0.7, 1.0), (-1.0, -0.3)])
def test_a_smooth_field_is_carried_with_fifth_order(drift: tuple[float, float]) -> None:
    """With dt as h^(5/3), for the scheme is of third order in time."""
    errors = []
    for nodes in (20, 40, 80):
        grid = square(nodes)
        law = Uniform(velocity=drift)
        end = carried(wave(grid.points()), grid, law, 0.5, dt=0.4 * (20 / nodes) ** (5 / 3) / 20)
        back = grid.points() - 0.5 * np.array(drift)[:, None, None]
        errors.append(float(np.abs(end - wave(back)).mean()))
    assert math.log2(errors[1] / errors[2]) == pytest.approx(5.0, abs=0.3)


def test_a_step_is_of_third_order_in_time_and_looks_at_the_time() -> None:
    """A drift that depends on time only: with a fine mesh the error is that of the step."""
    grid = Grid((400, 8), 1 / 400, boundary="periodic")

    def swaying(time: float, positions: np.ndarray) -> np.ndarray:
        return np.stack([np.full(len(positions), math.cos(3 * time)), np.zeros(len(positions))], 1)

    x = grid.points()[0]
    exact = np.sin(2 * np.pi * (x - math.sin(3.0) / 3))
    errors = [
        float(np.abs(carried(np.sin(2 * np.pi * x), grid, swaying, 1.0, dt=dt) - exact).max())
        for dt in (1 / 256, 1 / 512)
    ]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(3.0, abs=0.2)


def test_a_turned_field_is_where_the_exact_rotation_takes_it() -> None:
    """Anticlockwise, by a third of a turn; in an unbounded box."""
    law = Rotation(center=(0.5, 0.5), rate=1.0)
    errors = []
    for nodes in (41, 81):
        grid = Grid((nodes, nodes), 1 / (nodes - 1))

        def bump(points: np.ndarray) -> np.ndarray:
            x, y = points.reshape(2, -1)
            return np.exp(-80 * (x - 0.65) ** 2 - 120 * (y - 0.5) ** 2)

        start = bump(grid.points()).reshape(grid.shape)
        places = law.flow(grid.points().reshape(2, -1).T, 2 * math.pi / 3, 0.0)
        end = carried(start, grid, law, 2 * math.pi / 3, courant=0.4)
        errors.append(float(np.abs(end - bump(places.T).reshape(grid.shape)).max()))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 8


def test_a_reversed_vortex_brings_a_smooth_field_back() -> None:
    grid = Grid((65, 65), 1 / 64)
    x, y = grid.points()
    phi = np.hypot(x - 0.5, y - 0.75) - 0.15
    end = carried(phi, grid, SingleVortex(period=1.0), 1.0)
    near = np.abs(phi) < 0.05
    assert np.abs(end - phi)[near].max() < 0.05 * grid.spacing


def test_a_kink_makes_no_new_extrema() -> None:
    grid = square(50)
    x, _ = grid.points()
    roof = np.abs(x - 0.5)
    end = carried(roof, grid, Uniform(velocity=(1.0, 0.0)), 1.0)
    assert end.min() > -1e-3
    assert end.max() < 0.5 + 1e-3


def test_a_straight_line_goes_on_beyond_an_edge() -> None:
    grid = Grid((9, 12), 0.1)
    x, y = grid.points()
    wide = Grid((15, 18), 0.1, (-0.3, -0.3))
    u, v = wide.points()
    assert padded(2 * x - y, (False, False)) == pytest.approx(2 * u - v)
    end = carried(2 * x - y, grid, Uniform(velocity=(0.3, 0.5)), 0.7)
    assert end == pytest.approx(2 * (x - 0.21) - (y - 0.35), abs=1e-12)
