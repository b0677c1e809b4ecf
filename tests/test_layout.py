"""How fields are laid out for compiled loops."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, even_bands, layout, precision, split, tables, wraps

PLANE = Grid((8, 9), 0.5, boundary=("periodic", "unbounded"))
SPACE = Grid((8, 9, 10), 0.5, boundary=("unbounded", "periodic", "periodic"))


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 1000, 12345])
def test_pieces_cover_the_work_and_are_few(count):
    size, pieces = split(count)
    assert pieces * size >= count > (pieces - 1) * size or count == pieces == 0
    assert pieces <= 64


@pytest.mark.parametrize("count", [0, 1, 2, 3, 64, 65, 1000])
def test_bands_are_one_or_an_even_number_that_fits(count):
    bands = even_bands(count)
    assert bands == 1 or (bands % 2 == 0 and bands <= min(count, 64))


@pytest.mark.parametrize("kind", ["f4", "f8", "i4", "?", "f2"])
def test_only_single_precision_stays_single(kind):
    assert precision(np.zeros(3, kind)) == (np.float32 if kind == "f4" else np.float64)


def test_a_plane_is_a_space_with_one_node_across():
    assert np.zeros(PLANE.shape).reshape(layout(PLANE)).shape == (1, 8, 1, 9)
    assert np.zeros((3, *SPACE.shape)).reshape(layout(SPACE)).shape == (3, 8, 9, 10)
    assert list(wraps(PLANE)) == [True, False, False]
    assert list(wraps(SPACE)) == [False, True, True]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_kernel_is_told_in_the_precision_of_the_field(dtype):
    for grid, across in ((PLANE, 1), (SPACE, 6)):
        scale, coeffs, taps, mid, _ = tables("M6'", grid, np.dtype(dtype))
        assert scale.dtype == coeffs.dtype == dtype
        assert scale[0] == 2.0
        assert (len(taps), len(mid)) == (6, across)


def test_a_field_of_another_mesh_is_refused():
    assert check_field(np.zeros((2, 8, 9)), PLANE).shape == (2, 8, 9)
    for shape in ((9, 8), (8,), (1, 1, 8, 9)):
        with pytest.raises(
            InputError, match=r"field must have shape \(8, 9\) or \(c, \*\(8, 9\)\)"
        ):
            check_field(np.zeros(shape), PLANE)
