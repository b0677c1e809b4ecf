"""Laws of the surface gradient and the Laplace-Beltrami operator."""

import numpy as np
import pytest

from levelset.surface_operators import laplace_beltrami, surface_gradient
from remesh.errors import InputError
from remesh.grid import Grid


def ball(cells, ndim=3, dtype=np.float64):
    grid = Grid((cells + 1,) * ndim, 3 / cells, (-1.5,) * ndim)
    points = grid.points().astype(dtype)
    return grid, points, np.sqrt((points**2).sum(axis=0))


def near(radius, grid, cells):
    return np.flatnonzero(np.abs(radius - 1).ravel() < cells * grid.spacing)


@pytest.mark.parametrize("ndim", [2, 3])
def test_laplace_beltrami_of_a_circle_and_a_sphere_has_order_four_for_any_phi(ndim):
    errors = []
    for cells in (48, 96):
        grid, points, radius = ball(cells, ndim)
        nodes = near(radius, grid, 5)
        seen = near(radius, grid, cells / 48)  # as wide on both meshes
        angle = np.arctan2(points[1], points[0])
        if ndim == 2:
            values = np.exp(np.sin(angle))
            exact = values * (np.cos(angle) ** 2 - np.sin(angle)) / radius.clip(0.1) ** 2
        else:
            mode = points[0] * points[1] * points[2] / radius.clip(0.1) ** 3
            values, exact = mode, -12 * mode / radius.clip(0.1) ** 2
        phi = np.exp(radius) - np.e  # same level surfaces, slopes far from one
        found = np.full(grid.size, np.nan)
        found[nodes] = laplace_beltrami(values, phi, grid, nodes=nodes)
        errors.append(np.abs(found - exact.ravel())[seen].max())
    assert errors[1] < 1e-3
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 4.0, atol=0.4)


def test_a_value_that_is_linear_in_space_is_an_eigenfunction_with_minus_two_over_r_squared():
    grid, (x, y, z), radius = ball(24)
    nodes = near(radius, grid, 2)
    values = 2 * x - y + 0.5 * z
    found = laplace_beltrami(values, radius**2 - 1, grid, nodes=nodes)
    expected = -2 * (values / radius.clip(0.1) ** 2).ravel()[nodes]
    np.testing.assert_allclose(found, expected, atol=1e-10)  # exact: all differences are


def test_the_laplacian_of_what_is_constant_along_normals_is_that_along_the_surface():
    grid, points, radius = ball(64)
    nodes = near(radius, grid, 0.6)
    values = points[0] * points[2] / radius.clip(0.1) ** 2
    found = laplace_beltrami(values, radius - 1, grid, nodes=near(radius, grid, 4))
    kept = np.isin(near(radius, grid, 4), nodes)
    expected = (-6 * values / radius.clip(0.1) ** 2).ravel()[nodes]
    np.testing.assert_allclose(found[kept], expected, atol=2e-4)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_surface_gradient_is_tangential_and_keeps_the_precision(dtype):
    grid, points, radius = ball(32, dtype=dtype)
    nodes = near(radius, grid, 3)
    x, y, z = points
    found = surface_gradient(x * y + z, radius**2 - 1, grid, nodes=nodes)
    assert found.dtype == dtype
    normal = (points / radius.clip(0.1)).reshape(3, -1)[:, nodes]
    full = np.stack([y, x, np.ones_like(x)]).reshape(3, -1)[:, nodes]
    tight = 1e-5 if dtype == np.float32 else 1e-12
    np.testing.assert_allclose((found * normal).sum(axis=0), 0, atol=10 * tight)
    expected = full - normal * (full * normal).sum(axis=0)
    np.testing.assert_allclose(found, expected, atol=10 * tight)


def test_nodes_that_are_not_named_are_never_read():
    grid, (x, y, z), radius = ball(24)
    nodes = near(radius, grid, 4)
    outside = np.ones(grid.size, bool)
    outside[nodes] = False
    laws = []
    for junk in (0.0, np.nan):
        phi, values = radius - 1, x * y + z
        phi.reshape(-1)[outside] = junk
        values.reshape(-1)[outside] = junk
        laws.append(laplace_beltrami(values, phi, grid, nodes=nodes))
        laws.append(surface_gradient(values, phi, grid, nodes=nodes))
    np.testing.assert_array_equal(laws[0], laws[2])
    np.testing.assert_array_equal(laws[1], laws[3])


@pytest.mark.parametrize("law", [laplace_beltrami, surface_gradient])
def test_a_band_may_be_given_by_the_values_of_its_nodes(law):
    for ndim in (2, 3):
        grid, points, radius = ball(24, ndim)
        nodes = near(radius, grid, 4)
        values = points[0] * points[1]
        whole = law(values, radius - 1, grid, nodes=nodes)
        short = law(values.ravel()[nodes], (radius - 1).ravel()[nodes], grid, nodes=nodes)
        np.testing.assert_array_equal(short, whole)


def test_the_whole_mesh_and_a_band_agree_inside_the_band():
    grid, (x, y, _z), radius = ball(24)
    nodes = near(radius, grid, 5)
    inner = near(radius, grid, 1)
    whole = laplace_beltrami(x * x * y, radius - 1, grid).ravel()[inner]
    part = laplace_beltrami(x * x * y, radius - 1, grid, nodes=nodes)[np.isin(nodes, inner)]
    np.testing.assert_allclose(part, whole, rtol=0, atol=1e-20)


def test_a_plane_across_periodic_axes_knows_no_edge():
    grid = Grid((32, 16, 32), 1 / 32, (0.0, 0.0, -0.5), ("periodic", "periodic", "unbounded"))
    x, y, z = grid.points()
    wave = np.sin(2 * np.pi * x) * np.cos(4 * np.pi * y)
    found = laplace_beltrami(wave, z - 0.01, grid)
    np.testing.assert_allclose(found, -20 * np.pi**2 * wave, atol=1.2)
    np.testing.assert_allclose(found, -np.roll(found, 16, axis=0), atol=1e-9)


def test_threads_do_not_change_a_bit():
    grid, (x, y, _), radius = ball(16)
    one = laplace_beltrami(x * y, radius - 1.0, grid, threads=1)
    np.testing.assert_array_equal(one, laplace_beltrami(x * y, radius - 1.0, grid, threads=2))


def test_where_phi_is_flat_there_is_no_surface():
    grid = Grid((8, 8), 0.1)
    x, _ = grid.points()
    flat = np.ones(grid.shape)
    assert np.isnan(laplace_beltrami(x, flat, grid)).all()
    np.testing.assert_allclose(surface_gradient(x, flat, grid)[0], 1.0)


def test_what_does_not_fit_the_grid_is_refused():
    grid = Grid((8, 8), 0.1)
    good = np.zeros(grid.shape)
    with pytest.raises(InputError, match="values must have shape"):
        laplace_beltrami(np.zeros((8, 7)), good, grid)
    with pytest.raises(InputError, match="phi must have shape"):
        surface_gradient(good, np.zeros(8), grid)
    holed = np.where(np.arange(64).reshape(8, 8) == 9, np.nan, 1.0)
    for law in (laplace_beltrami, surface_gradient):
        for nodes in (None, np.arange(20)):
            with pytest.raises(InputError, match="phi must be finite"):
                law(good, holed, grid, nodes=nodes)
            with pytest.raises(InputError, match="values must be finite"):
                law(holed, good, grid, nodes=nodes)
    for nodes in ([3, 2], [0, 64], [-1, 2], [0.5, 1.0]):
        with pytest.raises(InputError, match="nodes must"):
            laplace_beltrami(good, good, grid, nodes=np.array(nodes))
