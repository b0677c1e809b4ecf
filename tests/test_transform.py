"""Wavelet transforms in 2-D and 3-D: round trips, parity with matrices, threads, refusals."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.lines import split_line
from remesh.multires.transform import forward, inverse, max_levels, node_levels
from remesh.multires.wavelets import WAVELETS

NAMES = list(WAVELETS)
GRIDS = [
    Grid((32, 48), 0.1, boundary="periodic"),
    Grid((33, 50), 0.1),
    Grid((32, 21), 0.1, boundary=("periodic", "unbounded")),
    Grid((16, 24, 32), 0.1, boundary="periodic"),
    Grid((17, 20, 22), 0.1),
    Grid((14, 16, 13), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]
SIDES = ["2-D periodic", "2-D", "2-D mixed", "3-D periodic", "3-D", "3-D mixed"]


def random_field(grid, *components, dtype=np.float64):
    return np.random.default_rng(5).standard_normal((*components, *grid.shape)).astype(dtype)


def lifted(values, axis, split, rows):
    """One axis, one level, by matrices: NumPy's text of the compiled loops."""
    last = [split.nodes - 1] if split.coarse > (split.nodes + 1) // 2 else []
    kept = [*range(0, split.nodes, 2), *last]
    details = [i for i in range(split.nodes) if i not in kept]
    moved = np.moveaxis(values, axis, 0).copy()
    predict = split.predict.matrix(split.details, split.coarse)
    update = split.update.matrix(split.coarse, split.details)
    moved[details] -= np.tensordot(predict, moved[kept], 1)
    moved[kept] += np.tensordot(update, moved[details], 1)
    rows.append(kept)
    return np.moveaxis(moved, 0, axis)


def forward_by_matrices(field, grid, wavelet, levels):
    result = field.copy()
    nodes = [np.arange(n) for n in grid.shape]
    for level in range(levels):
        part = result[np.ix_(*nodes)]
        rows = []
        for axis, (n, wraps) in enumerate(zip(grid.shape, grid.periodic, strict=True)):
            split = split_line(WAVELETS[wavelet], n, wraps, levels)[level]
            part = lifted(part, axis, split, rows)
        result[np.ix_(*nodes)] = part
        nodes = [here[kept] for here, kept in zip(nodes, rows, strict=True)]
    return result


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
@pytest.mark.parametrize("grid", GRIDS, ids=SIDES)
@pytest.mark.parametrize("name", NAMES)
def test_inverse_undoes_forward(name, grid, dtype, tolerance):
    field = random_field(grid, 2, dtype=dtype)
    kept = field.copy()
    coefficients = forward(field, grid, name)
    assert coefficients.dtype == dtype
    assert coefficients.shape == field.shape
    assert max_levels(grid, name) >= 1
    back = inverse(coefficients, grid, name)
    np.testing.assert_array_equal(field, kept)
    assert np.abs(back - field).max() <= tolerance
    assert np.abs(coefficients - field).max() > 0.1


@pytest.mark.parametrize("grid", GRIDS, ids=SIDES)
@pytest.mark.parametrize("name", ["2.2", "4.0", "4.4", "6.2"])
def test_compiled_loops_do_what_the_matrices_say(name, grid):
    field = random_field(grid)
    levels = max_levels(grid, name)
    expected = forward_by_matrices(field, grid, name, levels)
    np.testing.assert_allclose(forward(field, grid, name), expected, atol=1e-13)


@pytest.mark.parametrize("grid", [GRIDS[1], GRIDS[4]], ids=["2-D", "3-D"])
@pytest.mark.parametrize("name", NAMES)
def test_polynomials_below_the_order_have_no_details(name, grid):
    degree = WAVELETS[name].order - 1
    x = grid.points()
    field = np.prod([(0.3 + p) ** degree for p in x], axis=0)
    levels = max_levels(grid, name)
    fine = node_levels(grid, levels) == levels
    scale = np.abs(field).max()
    assert np.abs(forward(field, grid, name)[fine]).max() <= 1e-12 * scale
    steeper = forward(field * (0.3 + x[0]), grid, name)
    assert np.abs(steeper[fine]).max() > 1e-9 * scale


@pytest.mark.parametrize("name", NAMES)
def test_details_of_a_smooth_field_shrink_with_the_order(name):
    largest = []
    for nodes in (64, 128):
        grid = Grid((nodes, nodes), 1 / nodes, boundary="periodic")
        x, y = grid.points()
        field = np.sin(2 * np.pi * x) * np.cos(2 * np.pi * y + 0.4)
        fine = node_levels(grid, 2) == 2
        largest.append(np.abs(forward(field, grid, name, 2)[fine]).max())
    order = np.log2(largest[0] / largest[1])
    assert abs(order - WAVELETS[name].order) <= 0.2


@pytest.mark.parametrize("grid", [GRIDS[2], GRIDS[5]], ids=["2-D", "3-D"])
def test_any_number_of_threads_gives_the_same_bits(grid):
    field = random_field(grid, 3)
    results = [forward(field, grid, "4.4", threads=n) for n in (1, 2, 5)]
    backs = [inverse(results[0], grid, "4.4", threads=n) for n in (1, 2, 5)]
    for result, back in zip(results, backs, strict=True):
        np.testing.assert_array_equal(result, results[0])
        np.testing.assert_array_equal(back, backs[0])


def test_components_are_transformed_each_on_its_own():
    grid = GRIDS[1]
    field = random_field(grid, 2)
    together = forward(field, grid, "4.2")
    for part, whole in zip(field, together, strict=True):
        np.testing.assert_array_equal(forward(part, grid, "4.2"), whole)


def test_transforms_work_in_place():
    grid = GRIDS[0]
    field = random_field(grid)
    coefficients = forward(field, grid)
    work = field.copy()
    assert forward(work, grid, out=work) is work
    np.testing.assert_array_equal(work, coefficients)
    assert inverse(work, grid, out=work) is work
    assert np.abs(work - field).max() <= 1e-12


def test_no_levels_leave_the_field_as_it_is():
    grid = GRIDS[1]
    field = random_field(grid)
    np.testing.assert_array_equal(forward(field, grid, levels=0), field)
    assert (node_levels(grid, 0) == 0).all()


def test_node_levels_count_from_the_coarsest_mesh():
    grid = Grid((16, 16), 1.0, boundary="periodic")
    levels = node_levels(grid, 2)
    assert (levels[::4, ::4] == 0).all()
    assert np.bincount(levels.ravel()).tolist() == [16, 48, 192]
    assert (levels[1::2] == 2).all()
    grid = Grid((16, 17), 1.0)
    levels = node_levels(grid, 1)
    assert (levels[-1, ::2] == 0).all()  # the last node of an axis with ends stays
    assert (levels == 0).sum() == 9 * 9


def test_a_single_detail_is_a_wavelet_around_its_node():
    grid = Grid((64, 64), 1.0, boundary="periodic")
    coefficients = np.zeros(grid.shape)
    coefficients[33, 32] = 1.0  # finest level, a detail along x
    wave = inverse(coefficients, grid, "4.4", 1)
    found = np.argwhere(np.abs(wave) > 1e-15)
    assert np.abs(found - [33, 32]).max(axis=0).tolist() == [6, 3]
    x, y = grid.points()
    assert abs(wave[33, 32]) > 0.5
    for a in range(4):
        assert abs(((x - 33) ** a * wave).sum()) <= 1e-11
        assert abs(((x - 33) ** a * (y - 32) * wave).sum()) <= 1e-11


def test_levels_that_the_mesh_does_not_allow_are_refused():
    field = np.zeros((32, 48))
    grid = GRIDS[0]
    assert max_levels(grid, "4.4") == 3
    with pytest.raises(InputError, match="from 0 to 3"):
        forward(field, grid, "4.4", 4)
    with pytest.raises(InputError, match="levels must be"):
        forward(field, grid, "4.4", 1.5)


def test_a_wrong_shape_or_a_wrong_out_is_refused():
    grid = GRIDS[0]
    with pytest.raises(InputError, match="field must have shape"):
        forward(np.zeros((3, 3)), grid)
    with pytest.raises(InputError, match="out must be"):
        inverse(np.zeros(grid.shape), grid, out=np.zeros(grid.shape, np.float32))
