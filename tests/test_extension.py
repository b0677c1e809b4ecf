"""Extended values are those of the closest point, constant along normals."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.closest import closest_points
from levelset.extension import extend, values_at
from levelset.shapes import Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid


def mesh(n, ndim):
    h = 3.1 / n
    return Grid((n,) * ndim, h, origin=(-1.55 + h / 2,) * ndim)


def ball(ndim):
    return Disk(1.0) if ndim == 2 else Sphere(1.0)


def law(places):
    """A smooth function of places (ndim, ...)."""
    return np.sin(2 * places[0]) + places[-1] ** 2 * places[0]


@pytest.mark.parametrize("ndim", [2, 3])
def test_values_are_those_of_the_foot_to_third_order_at_least(ndim):
    errors = []
    for n in (20, 40, 80):
        grid = mesh(n, ndim)
        x = grid.points()
        phi = ball(ndim).distance(x)
        near = np.abs(phi) < 4 * grid.spacing
        found = extend(law(x), phi, grid, width=5 * grid.spacing)
        foot = x / np.sqrt((x**2).sum(axis=0))
        errors.append(np.abs(found - law(foot))[near].max())
    assert np.log2(errors[1] / errors[2]) > 2.8, errors


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_band_is_enough(dtype, ndim):
    grid = mesh(24, ndim)
    phi = ball(ndim).distance(grid.points()).astype(dtype)
    values = law(grid.points()).astype(dtype)
    nodes = np.flatnonzero(np.abs(phi) < 4 * grid.spacing)
    whole = extend(values, phi, grid).reshape(-1)[nodes]
    unset = np.full(grid.size, np.nan, dtype)
    unset[nodes] = values.reshape(-1)[nodes]
    banded = extend(unset.reshape(grid.shape), phi, grid, nodes=nodes)
    short = extend(unset[nodes], phi.reshape(-1)[nodes], grid, nodes=nodes)
    assert banded.dtype == dtype
    np.testing.assert_array_equal(banded, short)
    band = Band(grid, nodes, phi.reshape(-1)[nodes])
    np.testing.assert_array_equal(extend(unset[nodes], band), short)
    np.testing.assert_allclose(banded, whole, atol=1e-5)


def test_vectors_keep_their_components():
    grid = mesh(24, 2)
    x = grid.points()
    phi = Disk(1.0).distance(x)
    both = extend(np.stack([law(x), x[1]]), phi, grid)
    np.testing.assert_array_equal(both[0], extend(law(x), phi, grid))
    np.testing.assert_array_equal(both[1], extend(x[1], phi, grid))
    assert both.shape == (2, *grid.shape)


def test_far_values_stay_and_zeros_are_values():
    grid = mesh(24, 2)
    phi = Disk(1.0).distance(grid.points())
    values = np.where(np.abs(phi) < 4 * grid.spacing, 0.0, 7.0)
    found = extend(values, phi, grid, width=grid.spacing)
    far = np.abs(phi) > 2 * grid.spacing
    np.testing.assert_array_equal(found[far], values[far])
    assert np.abs(found[np.abs(phi) < grid.spacing]).max() < 1e-12


def test_extending_twice_changes_nothing_but_round_off_of_the_interpolation():
    grid = mesh(48, 2)
    x = grid.points()
    phi = Disk(1.0).distance(x)
    once = extend(law(x), phi, grid)
    near = np.abs(phi) < 2 * grid.spacing
    np.testing.assert_allclose(extend(once, phi, grid)[near], once[near], atol=1e-3)


def test_points_beyond_reach_are_not_a_number():
    grid = mesh(24, 2)
    phi = Disk(0.5).distance(grid.points())
    corner = np.arange(4)  # a part of the band that the contour does not touch
    nodes = np.concatenate([corner, np.flatnonzero(np.abs(phi) < 4 * grid.spacing)])
    found = extend(np.ones(grid.shape), phi, grid, nodes=np.unique(nodes))
    assert np.isnan(found[:4]).all()
    np.testing.assert_allclose(found[4:], 1.0)
    assert len(closest_points(phi, grid, nodes=np.unique(nodes)).nodes) < len(found)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_values_at_points_are_those_of_cubics(dtype, ndim):
    grid = mesh(12, ndim)
    x = grid.points()
    values = (x[0] ** 3 - 2 * x[0] * x[-1] ** 2 + 1).astype(dtype)
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (40, ndim))
    exact = points[:, 0] ** 3 - 2 * points[:, 0] * points[:, -1] ** 2 + 1
    found = values_at(values, points, grid)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, exact, atol=1e-12 if dtype == np.float64 else 1e-5)
    nodes = np.flatnonzero(np.abs(x[0]) < 1.2)
    banded = values_at(values.reshape(-1)[nodes], points, grid, nodes=nodes)
    np.testing.assert_allclose(
        banded[np.abs(points[:, 0]) < 0.5], found[np.abs(points[:, 0]) < 0.5]
    )


def test_bad_input_is_refused():
    grid = mesh(24, 2)
    phi = Disk(0.5).distance(grid.points())
    with pytest.raises(InputError, match=r"values must end in \(24, 24\), got \(3,\)"):
        extend(np.ones(3), phi, grid)
    with pytest.raises(InputError, match="phi has no interface"):
        extend(phi, np.abs(phi) + 1, grid)
    with pytest.raises(InputError, match=r"points must be finite and of shape \(n, 2\)"):
        values_at(phi, np.ones((2, 5)), grid)
    with pytest.raises(InputError, match="values must have the grid's shape"):
        values_at(phi[1:], np.ones((5, 2)), grid)
