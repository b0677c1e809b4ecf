"""Laws of the finite differences."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import (
    curl,
    derivative,
    divergence,
    divergence_ratio,
    gradient,
    laplacian,
    max_gradient_norm,
)  # fmt: skip

ORDERS = (2, 4, 6)
GRIDS = [
    Grid((12, 15), 0.1, boundary="unbounded"),
    Grid((12, 15), 0.1, boundary=("periodic", "unbounded")),
    Grid((9, 10, 11), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("degree", [1, 2])
def test_one_sided_and_central_differences_are_exact_for_polynomials(order, degree):
    grid = Grid((14, 15), 0.25, origin=(-1.0, 0.5))
    x, y = grid.points()
    power = order + degree - 1
    found = derivative(x**power + y, grid, 0, degree=degree, order=order)
    factor = power if degree == 1 else power * (power - 1)
    np.testing.assert_allclose(found, factor * x ** (power - degree), atol=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
def test_measured_order_is_the_claimed_order(order, boundary):
    errors = []
    for n in (32, 64):
        grid = Grid((n, n), 2 * np.pi / n, boundary=boundary)
        x, y = grid.points()
        f = np.sin(x) * np.cos(y)
        exact = [np.cos(x) * np.cos(y), -np.sin(x) * np.sin(y)]
        first = np.abs(gradient(f, grid, order=order) - exact).max()
        second = np.abs(laplacian(f, grid, order=order) + 2 * f).max()
        errors.append((first, second))
    orders = np.log2(np.array(errors[0]) / errors[1])
    np.testing.assert_allclose(orders, order, atol=0.2 if boundary == "periodic" else 0.35)


def test_curl_of_a_counter_clockwise_rotation_is_positive_two():
    grid = Grid((10, 12), 0.5, origin=(-2.0, -3.0))
    x, y = grid.points()
    np.testing.assert_allclose(curl(np.stack([-y, x]), grid), 2.0, atol=1e-12)
    np.testing.assert_allclose(curl(-(x**2 + y**2) / 2, grid), [-y, x], atol=1e-12)


def test_curl_in_three_dimensions_follows_the_right_hand():
    grid = Grid((8, 9, 10), 0.5, origin=(-2.0, -2.0, -2.0))
    x, y, z = grid.points()
    zero = np.zeros_like(x)
    for axis, turn in enumerate(([zero, -z, y], [z, zero, -x], [-y, x, zero])):
        expected = np.zeros((3, *grid.shape))
        expected[axis] = 2
        np.testing.assert_allclose(curl(np.stack(turn), grid), expected, atol=1e-12)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("order", ORDERS)
def test_divergence_of_a_curl_vanishes(grid, order):
    rng = np.random.default_rng(1)
    shape = grid.shape if grid.ndim == 2 else (3, *grid.shape)
    u = curl(rng.normal(size=shape), grid, order=order)
    assert np.abs(divergence(u, grid, order=order)).max() < 1e-9 * np.abs(u).max() / grid.spacing


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_precision_stays(dtype):
    grid = GRIDS[0]
    f = np.ones(grid.shape, dtype)
    assert gradient(f, grid).dtype == laplacian(f, grid).dtype == curl(f, grid).dtype == dtype


def test_zero_edges_see_the_field_go_on_as_zero():
    grid = Grid((12, 12), 1.0)
    f = np.random.default_rng(2).normal(size=grid.shape)
    wide = Grid((20, 20), 1.0, origin=(-4, -4))
    g = np.zeros(wide.shape)
    g[4:-4, 4:-4] = f
    for order in ORDERS:
        inner = gradient(g, wide, order=order)[:, 4:-4, 4:-4]
        np.testing.assert_allclose(gradient(f, grid, order=order, edge="zero"), inner, atol=1e-14)
        summed = laplacian(f, grid, order=order, edge="zero")
        np.testing.assert_allclose(summed, laplacian(g, wide, order=order)[4:-4, 4:-4], atol=1e-14)


def row_sum_norm(u, grid):
    """The same law in NumPy, second order with first-order edges."""
    total = np.zeros((grid.ndim, *grid.shape))
    for axis in range(grid.ndim):
        if grid.periodic[axis]:
            d = np.roll(u, -1, axis + 1) - np.roll(u, 1, axis + 1)
            total += np.abs(d) / (2 * grid.spacing)
        else:
            total += np.abs(np.gradient(u, grid.spacing, axis=axis + 1))
    return total.max()


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_largest_gradient_equals_its_numpy_text(grid, dtype):
    rng = np.random.default_rng(3)
    u = rng.normal(size=(grid.ndim, *grid.shape))
    for edge in range(2 * grid.ndim + 1):
        v = u.copy()
        if edge < 2 * grid.ndim:  # the largest difference sits at this edge
            place = [slice(None)] * (grid.ndim + 1)
            place[1 + edge // 2] = -(edge % 2)
            v[tuple(place)] *= 20
        expected = row_sum_norm(v, grid)
        found = max_gradient_norm(v.astype(dtype), grid)
        assert found == pytest.approx(expected, rel=1e-12 if dtype is np.float64 else 1e-5)


def test_largest_gradient_of_exact_flows():
    grid = Grid((16, 20), 0.5, origin=(-3, -4))
    x, y = grid.points()
    assert max_gradient_norm(np.stack([-y, x]), grid) == pytest.approx(1.0, rel=1e-12)
    assert max_gradient_norm(np.stack([3 * y, 0 * x]), grid) == pytest.approx(3.0, rel=1e-12)


def test_largest_gradient_shows_what_is_not_a_number():
    grid = Grid((16, 20), 0.5)
    u = np.zeros((2, 16, 20))
    u[1, 7, 9] = np.nan
    assert np.isnan(max_gradient_norm(u, grid))


def test_largest_gradient_has_the_same_bits_for_any_thread_count():
    grid = Grid((67, 20), 0.5)
    u = np.random.default_rng(4).normal(size=(2, 67, 20))
    assert len({max_gradient_norm(u, grid, threads=n) for n in (1, 2, 3)}) == 1


def test_unusable_requests_are_refused():
    grid = GRIDS[0]
    with pytest.raises(InputError, match="order must be"):
        gradient(np.zeros(grid.shape), grid, order=3)
    with pytest.raises(InputError, match="end in the grid's shape"):
        gradient(np.zeros((3, 4)), grid)
    with pytest.raises(InputError, match="vector field"):
        divergence(np.zeros(grid.shape), grid)
    with pytest.raises(InputError, match="edge must be"):
        laplacian(np.zeros(grid.shape), grid, edge="reflect")
    with pytest.raises(InputError, match="read 7 nodes"):
        gradient(np.zeros((6, 8)), Grid((6, 8), 1.0), order=6)


def test_the_divergence_ratio_is_zero_for_a_curl_and_known_for_a_gradient():
    grid = Grid((24, 24, 24), 2 * np.pi / 24, None, "periodic")
    x, y, z = grid.points()
    assert divergence_ratio(np.stack([np.sin(y), np.sin(z), np.sin(x)]), grid) < 1e-14
    assert divergence_ratio(np.stack([np.cos(x), 0 * y, 0 * z]), grid) == pytest.approx(1.0)
    both = np.stack([np.cos(x), np.sin(z), 0 * z])
    assert divergence_ratio(both, grid) == pytest.approx(np.sqrt(0.5))
    assert divergence_ratio(np.ones((3, *grid.shape)), grid) < 1e-12


def test_the_divergence_ratio_looks_only_where_its_stencil_lies_on_the_mesh():
    grid = Grid((16, 18, 20), 0.1)
    x, y, z = grid.points()
    field = np.stack([x**2, y * z, x])  # div = 2 x + z
    inner = (slice(3, -3),) * 3
    gradients = (4 * x**2 + z**2 + y**2 + 1)[inner]
    known = np.sqrt((((2 * x + z) ** 2)[inner]).sum() / gradients.sum())
    found = [divergence_ratio(field, grid, threads=n) for n in (1, 3)]
    assert found[0] == pytest.approx(known, rel=1e-10)
    assert found[0] == found[1]
    edges = field.copy()
    edges[:, 0], edges[:, :, :, -1] = 0.0, 0.0
    assert divergence_ratio(edges[:, 1:, :, :-1], Grid((15, 18, 19), 0.1)) > 0
    with pytest.raises(InputError, match="the grid is plane"):
        divergence_ratio(np.zeros((2, 8, 8)), Grid((8, 8), 0.1))
