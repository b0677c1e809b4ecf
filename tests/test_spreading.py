"""How node values spread on a uniform mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.spreading import plan, spread_nodes, stencil


def bump(grid: Grid, width: float, spread: float = 0.0) -> np.ndarray:
    """A Gaussian after the heat equation's time: exact."""
    square = width**2 + 4.0 * spread
    radius = sum(x**2 for x in grid.points())
    return (width**2 / square) ** (grid.ndim / 2) * np.exp(-radius / square)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("boundary", ["unbounded", "periodic"])
@pytest.mark.parametrize("part", [0.05, 0.5, 1.0, 3.0])
def test_a_gaussian_spreads_exactly_in_time(ndim, boundary, part):
    grid = Grid((60,) * ndim, 0.1, (-3.0,) * ndim, boundary)
    spread = part * grid.spacing**2
    found = spread_nodes(bump(grid, 0.5), grid, spread)
    np.testing.assert_allclose(found, bump(grid, 0.5, spread), atol=2e-7)


def test_the_smallest_spread_is_of_order_eight_in_the_spacing():
    errors = []
    for n in (20, 40):
        grid = Grid((n, n, 16), 4.0 / n, (-2.0, -2.0, 0.0), ("periodic", "periodic", "periodic"))
        flat = np.exp(-sum(x**2 for x in grid.points()[:2]) / 0.25)
        found = spread_nodes(flat, grid, 0.002)
        exact = 0.25 / 0.258 * np.exp(-sum(x**2 for x in grid.points()[:2]) / 0.258)
        errors.append(np.abs(found - exact).max())
    assert 7.0 < math.log2(errors[0] / errors[1]) < 9.0


@pytest.mark.parametrize("shape", [(24, 20), (12, 14, 16)])
def test_the_sum_and_the_first_moments_stay(shape):
    grid = Grid(shape, 0.1)
    rng = np.random.default_rng(3)
    field = np.zeros((2, *shape))
    inner = (slice(None), *(slice(5, -5),) * len(shape))
    field[inner] = rng.standard_normal(field[inner].shape)
    found = spread_nodes(field, grid, 0.3 * grid.spacing**2)
    for lever in (1.0, *grid.points()):
        axes = tuple(range(1, grid.ndim + 1))
        np.testing.assert_allclose((found * lever).sum(axes), (field * lever).sum(axes), atol=1e-12)


def test_what_spreads_beyond_an_unbounded_edge_is_cut_and_wraps_on_a_periodic_axis():
    for boundary, kept in (("unbounded", False), ("periodic", True)):
        grid = Grid((16, 16), 1.0, None, boundary)
        field = np.zeros(grid.shape)
        field[0, 0] = 1.0
        found = spread_nodes(field, grid, 0.5)
        assert bool(found[-1, -1]) is kept
        assert bool(abs(found.sum() - 1.0) < 1e-13) is kept


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_in_place_and_with_threads_the_bits_are_the_same(dtype):
    grid = Grid((12, 20, 18), 0.1, None, ("periodic", "unbounded", "unbounded"))
    field = np.random.default_rng(1).standard_normal((3, *grid.shape)).astype(dtype)
    known = spread_nodes(field, grid, 0.02, threads=1)
    assert known.dtype == dtype
    np.testing.assert_array_equal(spread_nodes(field, grid, 0.02, threads=3), known)
    spread_nodes(field, grid, 0.02, out=field)
    np.testing.assert_array_equal(field, known)


def test_no_spread_is_a_copy():
    grid = Grid((12, 12), 0.1)
    field = bump(grid, 0.3)
    found = spread_nodes(field, grid, 0.0)
    assert found is not field
    np.testing.assert_array_equal(found, field)


def test_no_wave_grows():
    grid = Grid((32, 32), 1.0, None, "periodic")
    noise = np.random.default_rng(2).standard_normal(grid.shape)
    for spread in (0.01, 0.59, 1.3, 2.0, 7.0):
        before, after = (np.abs(np.fft.fft2(f)) for f in (noise, spread_nodes(noise, grid, spread)))
        assert (after <= before * (1 + 1e-12) + 1e-12).all()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"diffused": -1.0}, "diffused must be finite and >= 0"),
        ({"diffused": math.nan}, "diffused must be finite"),
        ({"field": np.zeros((5, 5))}, "field must have shape"),
        ({"out": np.zeros((12, 12), np.float32)}, "out must be a contiguous float64"),
    ],
)
def test_what_cannot_spread_is_refused(change, text):
    grid = Grid((12, 12), 0.1)
    given = {"field": np.zeros(grid.shape), "diffused": 0.1, "out": None} | change
    with pytest.raises(InputError, match=text):
        spread_nodes(given["field"], grid, given["diffused"], out=given["out"])


def test_an_output_beside_the_field_is_refused():
    room = np.zeros((13, 12))
    with pytest.raises(InputError, match="overlaps"):
        spread_nodes(room[:-1], Grid((12, 12), 0.1), 0.1, out=room[1:])


GRIDS = [
    Grid((14, 150), 0.1, boundary=("periodic", "unbounded")),
    Grid((9, 5, 12), 0.1, boundary="periodic"),
    Grid((10, 8, 7), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]


def numpy_spread(field, grid, diffused):
    """The same law in NumPy: a circulant or cut matrix along each axis."""
    reach, steps = plan(diffused / grid.spacing**2, 12)
    reach = max(reach, 4)
    weights = stencil(diffused / steps / grid.spacing**2, reach)
    for _ in range(steps):
        for axis, (n, wraps) in enumerate(zip(grid.shape, grid.periodic, strict=True)):
            matrix = np.zeros((n, n))
            for shift in range(-reach, reach + 1):
                for i in range(n):
                    if wraps or 0 <= i + shift < n:
                        matrix[i, (i + shift) % n] += weights[abs(shift)]
            along = field.ndim - grid.ndim + axis
            field = np.moveaxis(np.tensordot(matrix, field, axes=(1, along)), 0, along)
    return field


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("part", [0.3, 1.9, 4.5])
@pytest.mark.parametrize("grid", GRIDS)
def test_spreading_equals_its_numpy_text_in_place_or_not(grid, part, dtype):
    field = np.random.default_rng(0).normal(size=(2, *grid.shape))
    diffused = part * grid.spacing**2
    expected = numpy_spread(field, grid, diffused)
    given = field.astype(dtype)
    found = spread_nodes(given, grid, diffused, threads=1)
    tolerance = 1e-13 if dtype is np.float64 else 2e-6
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(field).max() * 3)
    again = spread_nodes(given, grid, diffused, out=given, threads=2)
    assert again is given
    assert np.array_equal(given, found)
