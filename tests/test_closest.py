"""Closest points of a contour: where they are, for smooth and kinked ones, in the box and band."""

import numpy as np
import pytest

from levelset.band import Band
from levelset.closest import closest_points
from remesh.errors import InputError
from remesh.grid import Grid


def _ball(ndim, cells, radius=0.5, center=(0.03, -0.05, 0.02), **options):
    """A grid over [-1, 1], the distance to a ball's surface, and a phi of other slopes."""
    step = 2.0 / cells
    grid = Grid((cells,) * ndim, step, (-1.0 + 0.5 * step,) * ndim, **options)
    points = grid.points()
    middle = np.array(center[:ndim]).reshape(-1, *(1,) * ndim)
    distance = np.sqrt(((points - middle) ** 2).sum(axis=0)) - radius
    return grid, distance, (0.1 + ((points - 0.3) ** 2).sum(axis=0)) * distance


@pytest.mark.parametrize(("ndim", "cells"), [(2, 64), (3, 64)])
def test_feet_of_a_ball_are_straight_below_their_nodes(ndim, cells):
    grid, distance, phi = _ball(ndim, cells)
    h = grid.spacing
    found = closest_points(phi, grid, width=4 * h)
    center = np.array([0.03, -0.05, 0.02][:ndim])
    seen = grid.points().reshape(ndim, -1).T[found.nodes] - center
    feet = center + 0.5 * seen / np.linalg.norm(seen, axis=1)[:, None]
    assert np.abs(found.points - feet).max() < 0.004 * h
    assert np.abs(found.distance - distance.reshape(-1)[found.nodes]).max() < 5e-4 * h
    np.testing.assert_array_equal(found.nodes, np.sort(found.nodes))
    assert set(found.nodes) >= set(np.flatnonzero(np.abs(distance) < 3.99 * h))


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_points_are_as_far_as_the_distance_says(ndim):
    grid, _, phi = _ball(ndim, 24)
    found = closest_points(phi, grid)
    nodes = grid.points().reshape(ndim, -1).T[found.nodes]
    away = np.linalg.norm(found.points - nodes, axis=1)
    np.testing.assert_allclose(np.abs(found.distance), away, atol=1e-9 * grid.spacing)
    assert len(found.nodes) == grid.size


def test_points_converge_in_third_order_along_the_contour():
    errors = []
    for cells in (128, 256):
        grid, _, phi = _ball(2, cells)
        found = closest_points(phi, grid, width=0.1)
        center = np.array([0.03, -0.05])
        seen = grid.points().reshape(2, -1).T[found.nodes] - center
        feet = center + 0.5 * seen / np.linalg.norm(seen, axis=1)[:, None]
        errors.append(np.abs(found.points - feet).max())
    assert np.log2(errors[0] / errors[1]) > 2.7


@pytest.mark.parametrize(("ndim", "cells"), [(2, 64), (3, 32)])
@pytest.mark.parametrize("short", [True, False])
def test_a_band_gives_what_the_box_gives_and_never_reads_other_nodes(ndim, cells, short):
    grid, distance, phi = _ball(ndim, cells)
    h = grid.spacing
    nodes = np.flatnonzero(np.abs(distance) < 3.5 * h)
    elsewhere = np.full(grid.shape, np.nan)
    elsewhere.reshape(-1)[nodes] = phi.reshape(-1)[nodes]
    values = phi.reshape(-1)[nodes] if short else elsewhere
    whole = closest_points(phi, grid, width=6 * h)
    band = closest_points(values, grid, nodes=nodes, width=6 * h)
    np.testing.assert_array_equal(band.nodes, whole.nodes)
    near = np.abs(band.distance) < 3 * h
    np.testing.assert_array_equal(band.distance[near], whole.distance[near])
    assert np.abs(band.distance - whole.distance).max() < 1e-3 * h


def test_without_a_width_a_band_is_answered_at_its_own_nodes():
    grid, distance, phi = _ball(2, 48)
    nodes = np.flatnonzero(np.abs(distance) < 3.5 * grid.spacing)
    found = closest_points(phi.reshape(-1)[nodes], grid, nodes=nodes)
    np.testing.assert_array_equal(found.nodes, nodes)
    again = closest_points(Band(grid, nodes, phi.reshape(-1)[nodes]))
    np.testing.assert_array_equal(again.points, found.points)


@pytest.mark.parametrize("ndim", [2, 3])
def test_threads_do_not_change_a_bit(ndim):
    grid, _, phi = _ball(ndim, 32)
    one = closest_points(phi, grid, width=0.3, threads=1)
    two = closest_points(phi, grid, width=0.3, threads=2)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("ndim", [2, 3])
def test_periodic_axes_carry_on(ndim):
    grid, _, _ = _ball(ndim, 32, boundary="periodic")
    center = np.array([0.95, -0.98, 0.4][:ndim]).reshape(-1, *(1,) * ndim)
    seen = (grid.points() - center + 1) % 2 - 1
    distance = np.sqrt((seen**2).sum(axis=0)) - 0.5
    found = closest_points(distance * (2 + seen[0]), grid, width=0.25)
    exact = distance.reshape(-1)[found.nodes]
    assert np.abs(found.distance - exact).max() < 0.005 * grid.spacing
    away = found.points - grid.points().reshape(ndim, -1).T[found.nodes]
    assert np.abs(away).max() < 0.26  # beside its node, even past the edge


def test_the_nearer_of_two_contours_is_taken():
    grid = Grid((64, 64), 1 / 64)
    x, y = grid.points()
    distance = np.minimum(np.hypot(x - 0.3, y - 0.5), np.hypot(x - 0.72, y - 0.5) - 0.02) - 0.15
    phi = distance * (0.2 + 3 * x)
    found = closest_points(phi, grid)
    error = np.abs(found.distance - distance.reshape(-1)[found.nodes]) / grid.spacing
    assert error.max() < 0.02  # at the ridge between them too: the feet are exact, the ridge is not
    assert np.quantile(error, 0.99) < 2e-3


def test_any_signs_are_survived():
    rng = np.random.default_rng(5)
    mixed = ("periodic", "unbounded", "unbounded")
    for shape, boundary in (((40, 31), "periodic"), ((14, 15, 16), mixed)):
        grid = Grid(shape, 0.1, boundary=boundary)
        phi = rng.normal(size=shape)
        found = closest_points(phi, grid)
        np.testing.assert_array_equal(found.distance < 0, phi.reshape(-1)[found.nodes] < 0)
        assert len(found.nodes) == grid.size
        assert np.isfinite(found.points).all()


def test_what_cannot_be_answered_is_refused():
    grid = Grid((8, 8), 0.5)
    x, _ = grid.points()
    phi, nodes = x - 1.7, np.arange(64)
    cases = [
        (lambda: closest_points(phi + 9, grid), "no interface"),
        (lambda: closest_points(phi[:4], grid), "must have shape"),
        (lambda: closest_points(np.where(x > 2, np.nan, phi), grid), "finite"),
        (lambda: closest_points(phi, grid, width=0.0), "positive length"),
        (lambda: closest_points(phi, grid, width="far"), "must be a number"),
        (lambda: closest_points(phi, grid, nodes=nodes[::-1]), "ascend"),
        (lambda: closest_points(phi, grid, nodes=nodes + 1), "ascend"),
        (lambda: closest_points(phi, grid, nodes=nodes * 1.0), "flat indices"),
        (lambda: closest_points(phi[:3], grid, nodes=nodes), "must have shape"),
        (lambda: closest_points(phi, grid, nodes=nodes[:0]), "no interface"),
    ]
    for call, told in cases:
        with pytest.raises(InputError, match=told):
            call()
