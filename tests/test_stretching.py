"""Laws of vortex stretching on nodes."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import derivative
from remesh.stretching import stretched

FORMS = ("conservative", "classical")
GRIDS = [
    Grid((9, 11, 21), 0.1, boundary="periodic"),
    Grid((10, 8, 17), 0.1, boundary="unbounded"),
    Grid((9, 10, 7), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]


def numpy_stretched(w, d, grid, form):
    """The same law in NumPy, for strengths that are zero near unbounded edges."""
    if form == "conservative":
        return w + sum(derivative(w[j] * d, grid, j, order=6, edge="zero") for j in range(3))
    return w + sum(w[j] * derivative(d, grid, j, order=6, edge="zero") for j in range(3))


def inner(grid, depth):
    """One where a node is so deep inside the unbounded axes, else zero."""
    mask = np.zeros(grid.shape)
    mask[tuple(slice(None) if wraps else slice(depth, -depth) for wraps in grid.periodic)] = 1
    return mask


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("grid", GRIDS)
def test_stretching_equals_its_numpy_text(grid, form, dtype):
    rng = np.random.default_rng(0)
    w = rng.normal(size=(3, *grid.shape)) * inner(grid, 3)
    w[:, 2:5] = 0
    d = 0.02 * rng.normal(size=w.shape)
    found = stretched(w.astype(dtype), d.astype(dtype), grid, form, threads=1)
    assert found.dtype == dtype
    tolerance = 1e-13 if dtype is np.float64 else 3e-6
    np.testing.assert_allclose(found, numpy_stretched(w, d, grid, form), atol=tolerance * 4)


@pytest.mark.parametrize("grid", GRIDS)
def test_the_conservative_form_keeps_the_sum(grid):
    rng = np.random.default_rng(1)
    w = rng.normal(size=(3, *grid.shape)) * inner(grid, 3)
    d = 0.02 * rng.normal(size=w.shape)
    found = stretched(w, d, grid)
    np.testing.assert_allclose(found.sum(axis=(1, 2, 3)), w.sum(axis=(1, 2, 3)), atol=1e-11)
    assert np.abs(stretched(w, d, grid, "classical").sum(axis=(1, 2, 3)) - w.sum((1, 2, 3))).max()


@pytest.mark.parametrize("form", FORMS)
def test_a_linear_displacement_is_exact_and_has_the_right_hand(form):
    """In a rotation about z by a small angle, strengths along x turn towards y."""
    grid = GRIDS[1]
    turn = np.array([[0, -0.1, 0], [0.1, 0, 0], [0, 0, 0]])
    strain = np.array([[0.1, 0.03, 0.2], [-0.2, 0.05, 0.4], [0.3, -0.7, -0.15]])
    for rates in (turn, strain):
        d = np.tensordot(rates, grid.points(), 1)
        w = np.ones((3, *grid.shape)) * np.array([1.0, 0.5, -2.0]).reshape(3, 1, 1, 1)
        found = stretched(w, d, grid, form)[:, 3:-3, 3:-3, 3:-3]
        expected = (w + np.tensordot(rates, w, 1))[:, 3:-3, 3:-3, 3:-3]
        np.testing.assert_allclose(found, expected, atol=1e-12)
    x = np.zeros_like(w)
    x[0] = 1
    assert (stretched(x, np.tensordot(turn, grid.points(), 1), grid, form)[1, 4, 4, 4]) > 0.09


@pytest.mark.parametrize("form", FORMS)
def test_stretching_is_of_sixth_order(form):
    errors = []
    for n in (24, 48):
        grid = Grid((n, n, n), 2 * np.pi / n, boundary="periodic")
        x, y, z = grid.points()
        w = np.stack([np.sin(y), np.sin(z), np.sin(x)])  # without divergence
        d = np.stack([np.sin(x + z), np.cos(y), np.sin(z) * np.cos(y)])
        zero = 0 * x
        slopes = [
            [np.cos(x + z), zero, np.cos(x + z)],
            [zero, -np.sin(y), zero],
            [zero, -np.sin(z) * np.sin(y), np.cos(z) * np.cos(y)],
        ]
        exact = w + np.stack([sum(w[j] * row[j] for j in range(3)) for row in slopes])
        errors.append(np.abs(stretched(w, d, grid, form) - exact).max())
    assert abs(np.log2(errors[0] / errors[1]) - 6) < 0.2


@pytest.mark.parametrize("form", FORMS)
def test_any_thread_count_gives_the_same_bits(form):
    grid = GRIDS[0]
    w, d = np.random.default_rng(2).normal(size=(2, 3, *grid.shape))
    one, two = (stretched(w, d, grid, form, threads=n) for n in (1, 2))
    assert np.array_equal(one, two)


def test_what_has_no_meaning_is_refused():
    plane, grid = Grid((12, 12), 0.1), GRIDS[1]
    w = np.zeros((3, *grid.shape))
    with pytest.raises(InputError, match="vectors in space"):
        stretched(np.zeros((2, 12, 12)), np.zeros((2, 12, 12)), plane)
    with pytest.raises(InputError, match="strengths must have shape"):
        stretched(w[0], w, grid)
    with pytest.raises(InputError, match="form must be"):
        stretched(w, w, grid, "transposed")
    with pytest.raises(InputError, match="shares memory"):
        stretched(w, w, grid, out=w)
    with pytest.raises(InputError, match="contiguous"):
        stretched(w, w, grid, out=np.zeros((3, 4, 4, 4)))
