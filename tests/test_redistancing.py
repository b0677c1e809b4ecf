"""Redistancing: slope one, the contour stays, sides stay, and the cost follows the contour."""

import time

import numpy as np
import pytest

from levelset.band import Band
from levelset.redistancing import redistance, redistance_band
from remesh.errors import InputError
from remesh.grid import Grid


def _box(ndim, cells, **options):
    step = 2.0 / cells
    return Grid((cells,) * ndim, step, (-1.0 + 0.5 * step,) * ndim, **options)


def _ball(points):
    center = np.array([0.03, -0.05, 0.02][: len(points)]).reshape(-1, *(1,) * (points.ndim - 1))
    return np.sqrt(((points - center) ** 2).sum(axis=0)) - 0.5


def _torus(points):
    x, y, z = points
    return np.hypot(np.hypot(x, y) - 0.55, z) - 0.28


def _distorted(points, distance):
    """Slopes from 0.05 to 6, the same contour."""
    return (0.05 + ((points - 0.35) ** 2).sum(axis=0)) * distance


def _slope_error(values, grid, near):
    """Largest | |grad| - 1 | where ``near``, by fourth-order differences."""
    square = 0.0
    for axis in range(grid.ndim):
        one = np.roll(values, -1, axis) - np.roll(values, 1, axis)
        two = np.roll(values, -2, axis) - np.roll(values, 2, axis)
        square = square + ((8 * one - two) / (12 * grid.spacing)) ** 2
    return np.abs(np.sqrt(square) - 1)[near].max()


def _contour_points(phi, grid):
    """Roots along all mesh lines, on the quintic through six nodes: an interpolant not ours."""
    stencil = np.arange(-2, 4)
    found = []
    for axis in range(grid.ndim):
        lines = np.moveaxis(phi, axis, -1)
        places = np.argwhere((lines[..., 2:-3] < 0) != (lines[..., 3:-2] < 0))
        row, start = tuple(places[:, :-1].T), places[:, -1]
        taps = np.stack([lines[(*row, start + 2 + k)] for k in stencil])
        low, high = np.zeros(len(start)), np.ones(len(start))
        for _ in range(50):
            middle = 0.5 * (low + high)
            weights = [
                np.prod([(middle - j) / (k - j) for j in stencil if j != k], axis=0)
                for k in stencil
            ]
            same = ((np.array(weights) * taps).sum(axis=0) < 0) == (taps[2] < 0)
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        points = np.empty((grid.ndim, len(start)))
        points[axis] = start + 2 + low
        points[[k for k in range(grid.ndim) if k != axis]] = row
        origin = np.array(grid.origin)[:, None]
        found.append(origin + grid.spacing * points)
    return np.concatenate(found, axis=1)


@pytest.mark.parametrize(
    ("shape", "ndim", "cells"),
    [(_ball, 2, (48, 96, 192)), (_ball, 3, (40, 80)), (_torus, 3, (48, 96))],
)
def test_slope_one_and_distance_of_the_order_claimed(shape, ndim, cells):
    slopes, errors = [], []
    for n in cells:
        grid = _box(ndim, n)
        distance = shape(grid.points())
        h = grid.spacing
        found = redistance(_distorted(grid.points(), distance), grid, width=6 * h)
        slopes.append(_slope_error(found, grid, np.abs(distance) < 3 * h))
        errors.append(np.abs(found - distance)[np.abs(distance) < 5 * h].max())
    assert np.log2(slopes[-2] / slopes[-1]) > 2.6
    assert np.log2(errors[-2] / errors[-1]) > 3.6
    assert slopes[-1] < 1e-3


@pytest.mark.parametrize(
    ("shape", "ndim", "cells"), [(_ball, 2, 64), (_ball, 3, 48), (_torus, 3, 80)]
)
def test_ten_calls_move_the_contour_by_less_than_a_thousandth_of_a_cell(shape, ndim, cells):
    grid = _box(ndim, cells)
    h = grid.spacing
    distance = shape(grid.points())
    before = _distorted(grid.points(), distance)
    phi = before
    for _ in range(10):
        phi = redistance(phi, grid, width=4 * h)
    after = _contour_points(phi, grid)
    assert np.abs(shape(after)).max() < 1e-3 * h  # against the exact contour
    drift = np.abs(shape(after)).max() + np.abs(shape(_contour_points(before, grid))).max()
    assert drift < 1.2e-3 * h  # against where it was


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_distance_stays_what_it_is_in_both_precisions(ndim, dtype):
    grid = _box(ndim, 40)
    distance = _ball(grid.points()).astype(dtype)
    found = redistance(distance, grid, width=0.2)
    assert found.dtype == dtype
    near = np.abs(distance) < 0.2
    assert np.abs(found - distance)[near].max() < 3e-3 * grid.spacing
    np.testing.assert_array_equal(found[distance > 0.21], dtype(0.2))
    np.testing.assert_array_equal(found[distance < -0.21], dtype(-0.2))


@pytest.mark.parametrize("scale", [0.05, 20.0])
def test_slopes_of_any_size_give_the_same(scale):
    grid = _box(2, 48)
    distance = _ball(grid.points())
    np.testing.assert_allclose(
        redistance(scale * distance, grid), redistance(distance, grid), atol=1e-9
    )


def test_a_plane_is_exact_up_to_the_edges_and_periodic_axes_carry_on():
    grid = _box(3, 24)
    x, y, z = grid.points()
    plane = (x + 0.2) * 0.8 + y * 0.48 + z * 0.36
    near = np.abs(plane) < 0.3
    found = redistance(plane * 3, grid, width=0.35)
    np.testing.assert_allclose(found[near], plane[near], atol=1e-9)
    grid = _box(2, 32, boundary="periodic")
    x = grid.points()[0]
    strip = np.abs((x - 0.9 + 1) % 2 - 1) - 0.31  # across the edge
    np.testing.assert_allclose(redistance(strip, grid)[:3], strip[:3], atol=1e-9)


def _filament(thick):
    grid = Grid((64, 64), 1.0)
    x, y = grid.points() - 31.5
    distance = np.abs(x * np.cos(0.4) + y * np.sin(0.4)) - 0.5 * thick
    return grid, distance, np.hypot(x, y) < 20


@pytest.mark.parametrize("thick", [1.5, 2.0, 3.0])
def test_a_thin_filament_stays_where_it_is(thick):
    grid, distance, inner = _filament(thick)
    phi = redistance(distance * (3 + 0.01 * grid.points()[1]), grid)
    assert np.abs(phi - distance)[inner].max() < 0.03
    for _ in range(9):
        phi = redistance(phi, grid)
    assert np.abs(phi - distance)[inner].max() < 0.06
    np.testing.assert_array_equal(phi < 0, distance < 0)


@pytest.mark.parametrize("thick", [1.5, 2.0, 3.0])
def test_a_filament_that_is_strained_between_calls_keeps_its_thickness(thick):
    grid, distance, inner = _filament(thick)
    x, _ = grid.points()
    phi = distance
    for k in range(10):
        phi = redistance(phi * (1 + 0.1 * np.sin(x / 3 + k)), grid, width=6.0)
    near = inner & (np.abs(distance) < 0.7)  # a level off by e is a side moved by e
    assert abs((phi - distance)[near].mean()) < 0.02 * 0.5 * thick


@pytest.mark.parametrize("ndim", [2, 3])
def test_corners_do_not_wear_off_from_call_to_call(ndim):
    grid = Grid((32,) * ndim, 1.0)
    points = grid.points() - 15.5
    points[:2] = points[0] * 0.96 + points[1] * 0.28, points[1] * 0.96 - points[0] * 0.28
    beyond = np.abs(points) - 8.3
    outside = np.sqrt((np.maximum(beyond, 0) ** 2).sum(axis=0))
    distance = outside + np.minimum(beyond.max(axis=0), 0)
    once = phi = redistance(distance, grid, width=5.0)
    for _ in range(9):
        phi = redistance(phi, grid, width=5.0)
    near = np.abs(distance) < 1
    assert np.abs(phi - once)[near].mean() < 0.005
    assert np.abs(phi - distance)[near].mean() < 0.01


def test_a_slotted_disk_keeps_its_corners_and_its_sides():
    from levelset.shapes import SlottedDisk

    grid = Grid((100, 100), 1.0, (0.5, 0.5))
    distance = SlottedDisk(center=(50.0, 75.0)).distance(grid.points())
    phi = distance * (0.05 + ((grid.points() - 40) ** 2).sum(axis=0) / 500)
    found = redistance(phi, grid)
    error = np.abs(found - distance)
    assert error.max() < 0.4  # at the corners
    assert np.quantile(error, 0.9) < 0.05
    assert np.median(error) < 1e-4
    np.testing.assert_array_equal(found < 0, distance < 0)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_single_node_is_a_component_and_stays_one(ndim):
    grid = Grid((12,) * ndim, 0.1)
    phi = np.ones(grid.shape)
    phi[(5,) * ndim] = -1e-9
    for _ in range(5):
        phi = redistance(phi, grid)
        assert np.count_nonzero(phi < 0) == 1
        assert phi[(5,) * ndim] < 0
    corner = phi[(0,) * ndim]
    assert corner == pytest.approx(0.5 * np.sqrt(ndim), abs=0.1)


def test_a_contour_through_nodes_leaves_them_outside():
    grid = Grid((16, 16), 0.1)
    x, _ = grid.points()
    found = redistance(2 * (x - 0.5), grid)
    np.testing.assert_allclose(found, x - 0.5, atol=1e-12)
    np.testing.assert_array_equal(found < 0, 2 * (x - 0.5) < 0)


@pytest.mark.parametrize(("ndim", "cells"), [(2, 96), (3, 48)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_band_is_made_anew_wider_or_narrower(ndim, cells, dtype):
    grid = _box(ndim, cells)
    h = grid.spacing
    distance = _ball(grid.points())
    nodes = np.flatnonzero(np.abs(distance) < 3.5 * h)
    values = _distorted(grid.points(), distance).reshape(-1)[nodes].astype(dtype)
    for width in (2.5 * h, 7 * h):
        band = redistance_band(values, grid, nodes, width)
        assert isinstance(band, Band)
        assert band.values.dtype == dtype
        exact = distance.reshape(-1)[band.nodes]
        assert np.abs(band.values - exact).max() < 1.5e-3 * h
        assert set(band.nodes) >= set(np.flatnonzero(np.abs(distance) < width - 0.01 * h))
        assert np.abs(exact).max() < width + 0.01 * h


def test_a_band_can_go_on_from_itself():
    grid = _box(2, 64)
    h = grid.spacing
    distance = _ball(grid.points())
    band = Band(grid, np.flatnonzero(np.abs(distance) < 3 * h), distance[np.abs(distance) < 3 * h])
    for _ in range(10):
        again = redistance_band(band.values, grid, band.nodes, 3 * h)
        band = redistance_band(band, width=3 * h)
        np.testing.assert_array_equal(again.values, band.values)
    exact = distance.reshape(-1)[band.nodes]
    assert np.abs(band.values - exact).max() < 2e-3 * h


@pytest.mark.parametrize(("ndim", "cells"), [(2, (256, 1024)), (3, (48, 96))])
def test_the_cost_of_a_band_follows_the_contour(ndim, cells):
    spent = []
    for n in cells:
        grid = _box(ndim, n)
        distance = _ball(grid.points())
        nodes = np.flatnonzero(np.abs(distance) < 3.5 * grid.spacing)
        values = distance.reshape(-1)[nodes]
        best = np.inf
        for _ in range(4):
            start = time.process_time()
            redistance_band(values, grid, nodes, 3.5 * grid.spacing, threads=1)
            best = min(best, time.process_time() - start)
        spent.append(best)
    exponent = np.log(spent[1] / spent[0]) / np.log(cells[1] / cells[0])
    assert exponent < ndim - 1 + 0.4  # the box would be ndim; figures are in the benchmarks


def test_what_cannot_be_redistanced_is_refused():
    grid = Grid((8, 8), 0.5)
    x, _ = grid.points()
    phi, nodes = x - 1.7, np.arange(64)
    cases = [
        (lambda: redistance(phi + 9, grid), "no interface"),
        (lambda: redistance(-abs(phi) - 1, grid), "no interface"),
        (lambda: redistance(np.where(x > 2, np.inf, phi), grid), "finite"),
        (lambda: redistance(phi[1:], grid), "must have shape"),
        (lambda: redistance(phi, grid, width=-1.0), "positive length"),
        (lambda: redistance(phi, grid, method="magic"), "closest-point"),
        (lambda: redistance_band(phi, grid, nodes, np.nan), "positive length"),
        (lambda: redistance_band(phi, grid, nodes), "a band needs a width"),
        (lambda: redistance_band(phi + 0j, grid, nodes, 1.0), "real numbers"),
        (lambda: redistance(phi + 0j, grid), "real numbers"),
        (lambda: redistance_band(phi + 9, grid, nodes, 1.0), "no interface"),
    ]
    for call, told in cases:
        with pytest.raises(InputError, match=told):
            call()
