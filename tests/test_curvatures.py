"""Normals and curvatures are those of the level surfaces, to the orders stated."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.closest import closest_points
from levelset.curvatures import curvature, normal
from levelset.shapes import Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid

AXES = np.array([1.0, 0.7, 0.55])
CENTER = np.array([0.013, 0.021, 0.004])


def mesh(n, ndim, boundary="unbounded"):
    h = 3.1 / n
    return Grid((n,) * ndim, h, origin=(-1.55 + h / 2,) * ndim, boundary=boundary)


def seen(places):
    """Places (n, ndim) from the centre, and the half axes."""
    ndim = places.shape[1]
    return places - CENTER[:ndim], AXES[:ndim]


def ellipsoid(grid):
    """A function of no distance and no polynomial: its level surfaces are ellipsoids."""
    x, axes = seen(grid.points().reshape(grid.ndim, -1).T)
    return np.exp(0.7 * (((x / axes) ** 2).sum(axis=1) - 1.0)).reshape(grid.shape) - 1.0


def exact(places, kind):
    """Of the ellipsoid through each place: div n, or abc^-2 s^-6 (sum x^2/(as)^4)^-2."""
    x, axes = seen(places)
    slope, bend = 2 * x / axes**2, 2 / axes**2
    steep = (slope**2).sum(axis=1)
    if kind == "mean":
        return (steep * bend.sum() - (slope**2 * bend).sum(axis=1)) / steep**1.5
    square = ((x / axes) ** 2).sum(axis=1)
    return 1 / (axes.prod() ** 2 * square**3 * ((x**2 / axes**4).sum(axis=1) / square**2) ** 2)


def kinds(ndim):
    return ("mean",) if ndim == 2 else ("mean", "gaussian")


@pytest.mark.parametrize(("ndim", "counts"), [(2, (32, 64, 128)), (3, (20, 40, 80))])
def test_curvature_of_an_ellipsoid_is_of_order_four_at_nodes_and_on_the_contour(ndim, counts):
    for kind in kinds(ndim):
        errors = []
        for n in counts:
            grid = mesh(n, ndim)
            phi = ellipsoid(grid)
            nodes = np.flatnonzero(np.abs(phi) < 18 * grid.spacing)
            feet = closest_points(phi, grid, width=2 * grid.spacing)
            near = feet.nodes
            here = grid.points().reshape(ndim, -1).T[near]
            at_nodes = curvature(phi, grid, kind=kind).reshape(-1)[near]
            on_contour = np.full(grid.size, np.nan)
            on_contour[nodes] = curvature(phi, grid, kind=kind, at="contour", nodes=nodes)
            errors.append(
                (
                    np.abs(at_nodes - exact(here, kind)).max(),
                    np.abs(on_contour[near] - exact(feet.points, kind)).max(),
                )
            )
        orders = np.log2(np.array(errors[1]) / errors[2])
        assert (orders > 3.3).all(), (kind, orders, errors)


@pytest.mark.parametrize(("shape", "counts"), [(Disk(1.0), (32, 64)), (Sphere(1.0), (24, 48))])
def test_curvature_of_a_ball_is_of_order_two_at_least_in_a_narrow_band(shape, counts):
    for kind in kinds(shape.ndim):
        errors = []
        for n in counts:
            grid = mesh(n, shape.ndim)
            phi = shape.distance(grid.points())
            nodes = np.flatnonzero(np.abs(phi) < 5 * grid.spacing)
            near = np.abs(phi.reshape(-1)[nodes]) < 2 * grid.spacing
            known = np.full(grid.shape, np.nan)
            known.reshape(-1)[nodes] = phi.reshape(-1)[nodes]
            found = curvature(known, grid, kind=kind, at="contour", nodes=nodes)[near]
            right = 1.0 if kind == "gaussian" else shape.ndim - 1.0
            errors.append(np.abs(found - right).max())
        assert np.log2(errors[0] / errors[1]) > 1.9, (kind, errors)
        assert errors[1] < 4e-3


@pytest.mark.parametrize("ndim", [2, 3])
def test_curvature_at_a_node_is_that_of_the_level_surface_through_it(ndim):
    grid = mesh(64, ndim) if ndim == 2 else mesh(40, ndim)
    phi = (Disk(1.0) if ndim == 2 else Sphere(1.0)).distance(grid.points())
    near = np.abs(phi) < 3 * grid.spacing
    radius = 1.0 + phi[near]
    assert curvature(phi, grid)[near] == pytest.approx((ndim - 1) / radius, rel=2e-3)
    on_contour = curvature(phi, grid, at="contour")[near]
    assert on_contour == pytest.approx(np.full(radius.shape, ndim - 1.0), rel=2e-3)


def test_holes_curve_the_other_way_and_saddles_have_negative_gaussian_curvature():
    grid = mesh(40, 3)
    x, y, z = grid.points()
    phi = np.hypot(np.hypot(x, y) - 1.0, z) - 0.4
    inner = (np.abs(phi) < grid.spacing) & (np.hypot(x, y) < 0.9)
    assert (curvature(phi, grid, kind="gaussian")[inner] < 0).all()
    ball = Sphere(1.0).distance(grid.points())
    near = np.abs(ball) < 2 * grid.spacing
    np.testing.assert_allclose(curvature(-ball, grid)[near], -curvature(ball, grid)[near])
    assert (curvature(ball, grid)[near] > 0).all()


@pytest.mark.parametrize("ndim", [2, 3])
def test_curvature_does_not_depend_on_the_slope_of_phi(ndim):
    grid = mesh(24, ndim)
    phi = ellipsoid(grid)
    np.testing.assert_allclose(curvature(1e-3 * phi, grid), curvature(phi, grid), rtol=1e-9)
    np.testing.assert_allclose(normal(1e-3 * phi, grid), normal(phi, grid), atol=1e-12)


@pytest.mark.parametrize("ndim", [2, 3])
def test_normals_are_unit_outward_and_of_order_four(ndim):
    errors = []
    for n in (24, 48):
        grid = mesh(n, ndim)
        phi = ellipsoid(grid)
        near = np.abs(phi) < 0.3
        x = grid.points() - CENTER[:ndim].reshape(-1, *(1,) * ndim)
        right = x / AXES[:ndim].reshape(-1, *(1,) * ndim) ** 2
        right /= np.linalg.norm(right, axis=0)
        errors.append(np.abs(normal(phi, grid) - right)[:, near].max())
    assert np.log2(errors[0] / errors[1]) > 3.7
    np.testing.assert_allclose(np.linalg.norm(normal(phi, grid)[:, near], axis=0), 1.0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_band_has_the_same_values_where_its_neighbours_are_in_it(dtype, ndim):
    grid = mesh(24, ndim)
    phi = Disk(1.0) if ndim == 2 else Sphere(1.0)
    phi = phi.distance(grid.points()).astype(dtype)
    nodes = np.flatnonzero(np.abs(phi) < 5 * grid.spacing)
    deep = np.abs(phi.reshape(-1)[nodes]) < grid.spacing
    mean, dense = curvature(phi, grid, nodes=nodes), curvature(phi, grid)
    assert mean.dtype == dense.dtype == normal(phi, grid).dtype == dtype
    np.testing.assert_array_equal(mean[deep], dense.reshape(-1)[nodes][deep])
    banded = normal(phi.reshape(-1)[nodes], grid, nodes=nodes)
    assert banded.shape == (ndim, len(nodes))
    band = Band(grid, nodes, phi.reshape(-1)[nodes])
    np.testing.assert_array_equal(normal(band), banded)
    np.testing.assert_array_equal(curvature(band), mean)
    on_contour = curvature(phi, grid, nodes=nodes, at="contour")
    np.testing.assert_array_equal(curvature(band, at="contour"), on_contour)
    whole = normal(phi, grid).reshape(ndim, -1)[:, nodes]
    np.testing.assert_array_equal(banded[:, deep], whole[:, deep])


@pytest.mark.parametrize("ndim", [2, 3])
def test_periodic_axes_have_no_seam(ndim):
    grid = mesh(24, ndim, "periodic")
    phi = (Disk(1.0) if ndim == 2 else Sphere(1.0)).distance(grid.points())
    near = np.abs(phi) < 2 * grid.spacing
    moved = np.roll(phi, (13, 5, 11)[:ndim], range(ndim))
    back = np.roll(curvature(moved, grid), tuple(-s for s in (13, 5, 11)[:ndim]), range(ndim))
    np.testing.assert_array_equal(back[near], curvature(phi, grid)[near])


def test_threads_change_no_bit():
    grid = mesh(20, 3)
    phi = ellipsoid(grid)
    one, two = (curvature(phi, grid, at="contour", threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(normal(phi, grid, threads=1), normal(phi, grid, threads=2))


def test_flat_places_have_no_direction():
    grid = Grid((8, 8), 1.0)
    assert np.isnan(curvature(np.ones(grid.shape), grid)).all()
    assert (normal(np.ones(grid.shape), grid) == 0).all()


def test_bad_input_is_refused():
    grid = Grid((8, 9), 0.5)
    phi = grid.points()[0] - 1.1
    with pytest.raises(InputError, match="a line has no Gaussian curvature"):
        curvature(phi, grid, kind="gaussian")
    with pytest.raises(InputError, match="kind must be"):
        curvature(phi, grid, kind="total")
    with pytest.raises(InputError, match=r"phi must have shape \(8, 9\)"):
        normal(phi.T, grid)
    with pytest.raises(InputError, match="phi must be finite"):
        curvature(phi * np.inf, grid)
    with pytest.raises(InputError, match="phi has no interface"):
        curvature(phi + 9, grid, at="contour")
