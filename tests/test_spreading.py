"""Laws of what spreads on a uniform mesh."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.spreading import plan, spread_nodes, stencil

GRIDS = [
    Grid((14, 150), 0.1, boundary=("periodic", "unbounded")),
    Grid((9, 5, 12), 0.1, boundary="periodic"),
    Grid((10, 8, 7), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]


def numpy_spread(field, grid, diffused):
    """The same law in NumPy: a circulant or cut matrix along each axis."""
    reach, steps = plan(diffused / grid.spacing**2, 12)
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
    np.testing.assert_allclose(found.field, expected, atol=tolerance * np.abs(field).max() * 3)
    went = (field - expected).reshape(2, -1).sum(axis=1) * grid.cell_volume
    scale = np.abs(field).sum() * grid.cell_volume
    np.testing.assert_allclose(found.lost, went, atol=tolerance * scale)
    again = spread_nodes(given, grid, diffused, out=given, threads=2)
    assert again.field is given
    assert np.array_equal(given, found.field)
    assert np.array_equal(again.lost, found.lost)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_gaussian_widens_as_it_must_to_eighth_order(ndim):
    errors = []
    for n in (24, 48):
        grid = Grid((n,) * ndim, 1 / n, boundary="unbounded")
        start, diffused = 0.08, 0.5 / n**2
        width = np.sqrt(start**2 + 2 * diffused)
        square = ((grid.points() - 0.5) ** 2).sum(axis=0)
        found = spread_nodes(np.exp(-square / 2 / start**2), grid, diffused).field
        exact = np.exp(-square / 2 / width**2) * (start / width) ** ndim
        errors.append(np.abs(found - exact).max())
    assert errors[1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 7.5


def test_nothing_spreads_in_no_time_and_nothing_is_lost_from_a_closed_box():
    grid = GRIDS[1]
    field = np.random.default_rng(1).normal(size=grid.shape)
    assert np.array_equal(spread_nodes(field, grid, 0.0).field, field)
    found = spread_nodes(field, grid, 0.01)
    assert found.lost == 0
    assert found.field.sum() == pytest.approx(field.sum(), abs=1e-12)


def test_what_has_no_meaning_is_refused():
    grid = GRIDS[1]
    field = np.zeros(grid.shape)
    for diffused in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="diffused must be finite"):
            spread_nodes(field, grid, diffused)
    with pytest.raises(InputError, match="field must have shape"):
        spread_nodes(field[1:], grid, 0.1)
    with pytest.raises(InputError, match="out must be a contiguous"):
        spread_nodes(field, grid, 0.1, out=np.zeros(grid.shape, np.float32))
    room = np.zeros((10, 5, 12))
    with pytest.raises(InputError, match="overlaps"):
        spread_nodes(room[:-1], grid, 0.1, out=room[1:])
