"""Compression: error against tolerance, moments kept, what the value says about itself."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.compression import compress
from remesh.multires.transform import forward
from remesh.multires.wavelets import WAVELETS

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def unit(shape, boundary):
    return Grid(shape, 1 / shape[0], boundary=boundary)


def radius(grid, center=0.43):
    return np.sqrt(((grid.points() - center) ** 2).sum(axis=0))


def gaussian(grid):
    return np.exp(-((radius(grid) / 0.12) ** 2))


def wave(grid):
    return np.prod(np.cos(2 * np.pi * grid.points() + 0.3), axis=0)


def kink(grid):
    return np.abs(radius(grid) - 0.3)


def hat(grid):
    return np.maximum(0.25 - radius(grid), 0)


FIELDS = [gaussian, wave, kink, hat]
MESHES = [
    unit((128, 128), "periodic"),
    unit((130, 97), "unbounded"),
    unit((128, 80), ("periodic", "unbounded")),
    unit((32, 32, 32), "periodic"),
    unit((40, 33, 36), "unbounded"),
]
SIDES = ["2-D periodic", "2-D", "2-D mixed", "3-D periodic", "3-D"]


@pytest.mark.parametrize("grid", MESHES, ids=SIDES)
@pytest.mark.parametrize("make", FIELDS)
@pytest.mark.parametrize("name", list(WAVELETS))
def test_the_error_stays_below_ten_tolerances_over_five_decades(name, make, grid):
    field = make(grid)
    largest = np.abs(field).max()
    for tolerance in TOLERANCES:
        packed = compress(field, grid, tolerance=tolerance, wavelet=name)
        error = np.abs(packed.expand() - field).max()
        assert error == packed.error_bound
        assert error <= 10 * tolerance * largest
    assert packed.ratio >= 1


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
@pytest.mark.parametrize("make", [gaussian, kink])
def test_the_error_is_proportional_to_the_tolerance(make, boundary):
    grid = unit((256, 256), boundary)
    field = make(grid)
    errors = [compress(field, grid, tolerance=t).error_bound for t in TOLERANCES]
    slope = np.polyfit(np.log(TOLERANCES), np.log(errors), 1)[0]
    assert abs(slope - 1) <= 0.1


@pytest.mark.parametrize("make", [gaussian, hat])
def test_a_tolerance_is_relative(make):
    grid = MESHES[1]
    small = compress(make(grid) * 2.0**-20, grid, tolerance=1e-3)
    large = compress(make(grid), grid, tolerance=1e-3)
    np.testing.assert_array_equal(small.indices, large.indices)
    np.testing.assert_array_equal(small.values * 2.0**20, large.values)


@pytest.mark.parametrize("tolerance", [0.3, 1e-2, 1e-4])
@pytest.mark.parametrize("grid", MESHES, ids=SIDES)
@pytest.mark.parametrize("name", ["2.2", "4.2", "4.4", "6.2"])
def test_compression_keeps_the_moments_that_the_lifting_claims(name, grid, tolerance):
    field = gaussian(grid) + 0.3 * kink(grid)
    packed = compress(field, grid, tolerance=tolerance, wavelet=name)
    error = packed.expand() - field
    assert np.abs(error).max() > 1e-6
    assert len(packed.indices) < grid.size
    kept = [1 if wraps else packed.wavelet.moments for wraps in grid.periodic]
    for powers in np.ndindex(*kept):
        shape = np.prod([p**a for p, a in zip(grid.points(), powers, strict=True)], axis=0)
        assert abs((error * shape).sum()) <= 1e-12 * np.abs(field * shape).sum()


@pytest.mark.parametrize("shape", [(256, 256), (96, 96, 96)])
def test_on_periodic_axes_higher_moments_are_kept_away_from_the_seam(shape):
    grid = unit(shape, "periodic")
    field = np.maximum(0.1 - radius(grid, 0.5), 0)
    packed = compress(field, grid, tolerance=1e-2, wavelet="4.4", levels=2)
    error = packed.expand() - field
    assert np.abs(error).max() > 1e-4
    x = grid.points()
    for a, b in ((1, 0), (2, 0), (3, 3), (1, 2)):
        shape = x[0] ** a * x[1] ** b
        assert abs((error * shape).sum()) <= 1e-12 * np.abs(field * shape).sum()


def test_without_lifting_the_sum_is_not_kept():
    grid = MESHES[0]
    field = hat(grid)
    error = compress(field, grid, tolerance=1e-2, wavelet="4.0").expand() - field
    assert abs(error.sum()) > 1e-5 * field.sum()


def test_a_tighter_tolerance_keeps_more_and_finer_coefficients():
    grid = MESHES[0]
    packs = [compress(gaussian(grid), grid, tolerance=t) for t in TOLERANCES]
    ratios = [packed.ratio for packed in packs]
    assert ratios == sorted(ratios, reverse=True)
    assert ratios[2] > 20
    assert packs[0].counts()[-1] == 0
    for packed in packs:
        assert sum(packed.counts()) == packed.size == packed.indices.size
        assert packed.counts()[0] == (packed.levels == 0).sum() == 16
        assert packed.ratio == grid.size / packed.size


def test_kept_values_are_the_coefficients_at_their_nodes():
    grid = MESHES[4]
    field = kink(grid)
    packed = compress(field, grid, tolerance=1e-3)
    coefficients = forward(field, grid, "4.4")
    np.testing.assert_array_equal(packed.values, coefficients.ravel()[packed.indices])
    dropped = np.delete(coefficients.ravel(), packed.indices)
    assert np.abs(dropped).max() <= 1e-3 * np.abs(field).max()


def test_float32_stays_float32():
    grid = MESHES[1]
    field = gaussian(grid).astype(np.float32)
    packed = compress(field, grid, tolerance=1e-4)
    assert packed.values.dtype == packed.expand().dtype == np.float32
    assert packed.error_bound == np.abs(packed.expand() - field).max()
    assert packed.error_bound <= 1e-3


def test_components_may_each_have_their_scale():
    grid = MESHES[0]
    field = np.stack([gaussian(grid), 1e-3 * wave(grid)])
    one = compress(field, grid, tolerance=1e-2)
    each = compress(field, grid, tolerance=1e-2, scale=(1.0, 1e-3))
    assert one.expand().shape == field.shape
    assert np.abs(one.expand()[1] - field[1]).max() > 1e-4
    assert np.abs(each.expand()[1] - field[1]).max() <= 10 * 1e-5
    alone = compress(field[1], grid, tolerance=1e-2, scale=1e-3)
    np.testing.assert_array_equal(
        each.indices[each.indices >= grid.size] - grid.size, alone.indices
    )
    assert each.components == (2,)


def test_threads_do_not_change_a_bit():
    grid = MESHES[4]
    packs = [compress(kink(grid), grid, tolerance=1e-3, threads=n) for n in (1, 3)]
    np.testing.assert_array_equal(packs[0].indices, packs[1].indices)
    np.testing.assert_array_equal(packs[0].values, packs[1].values)
    np.testing.assert_array_equal(packs[0].expand(threads=1), packs[0].expand(threads=3))


def test_a_field_of_zeros_is_all_dropped_but_the_coarsest_values():
    grid = MESHES[1]
    packed = compress(np.zeros(grid.shape), grid, tolerance=1e-3)
    assert packed.error_bound == 0
    assert packed.counts()[1:] == (0,) * packed.depth


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tolerance": 0.0}, "tolerance must lie in"),
        ({"tolerance": 1.0}, "tolerance must lie in"),
        ({"tolerance": float("nan")}, "tolerance must lie in"),
        ({"scale": (1.0, 2.0)}, "scale must be one finite number or 1"),
        ({"scale": -1.0}, "scale must be positive"),
        ({"wavelet": "5.1"}, "unknown wavelet"),
        ({"levels": 20}, "levels must be"),
        ({"field": np.full((128, 128), np.nan)}, "field must be finite"),
        ({"field": np.zeros((3, 3))}, "field must have shape"),
    ],
)
def test_bad_input_is_refused(change, message):
    asked = {"field": gaussian(MESHES[0]), "grid": MESHES[0], "tolerance": 1e-3, **change}
    with pytest.raises(InputError, match=message):
        compress(asked.pop("field"), asked.pop("grid"), **asked)


def test_a_mesh_that_cannot_be_halved_is_refused():
    grid = Grid((33, 33), 0.1, boundary="periodic")
    with pytest.raises(InputError, match="cannot be halved"):
        compress(np.ones(grid.shape), grid, tolerance=1e-3)
