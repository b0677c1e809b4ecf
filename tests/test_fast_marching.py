"""Fast marching from scikit-fmm: distances, axes, width, sides, and what is refused."""

import sys

import numpy as np
import pytest

from levelset.fast_marching import fast_marching
from levelset.redistancing import redistance
from remesh.errors import InputError
from remesh.grid import Grid

pytest.importorskip("skfmm")


def _disk(cells, boundary="unbounded", center=0.5):
    grid = Grid((cells, cells), 1 / cells, boundary=boundary)
    seen = grid.points() - center
    if boundary == "periodic":
        seen = (seen + 0.5) % 1 - 0.5
    return grid, np.hypot(*seen) - 0.3


@pytest.mark.parametrize("cells", [40, 80, 160])
def test_distances_of_a_disk_are_right_to_a_part_of_the_spacing(cells):
    grid, distance = _disk(cells)
    found = fast_marching(distance * (1.5 + distance), grid, width=0.15)
    near = np.abs(distance) < 0.12
    assert np.abs(found - distance)[near].max() < 0.3 * grid.spacing


def test_periodic_axes_carry_on():
    grid, distance = _disk(48, "periodic", center=0.02)
    found = fast_marching(2 * distance, grid)
    assert np.abs(found - distance)[np.abs(distance) < 0.15].max() < 0.3 * grid.spacing


def test_beyond_the_width_distances_are_the_width():
    grid, distance = _disk(48)
    found = fast_marching(distance, grid, width=0.1)
    np.testing.assert_array_equal(found[distance > 0.12], 0.1)
    np.testing.assert_array_equal(found[distance < -0.12], -0.1)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_sides_and_precision_stay(ndim, dtype):
    grid = Grid((12,) * ndim, 0.1)
    phi = np.random.default_rng(0).normal(size=grid.shape).astype(dtype)
    found = redistance(phi, grid, method="fast-marching")
    assert found.dtype == dtype
    np.testing.assert_array_equal(found < 0, phi < 0)


def test_what_cannot_be_marched_is_refused():
    grid, distance = _disk(16)
    with pytest.raises(InputError, match="no interface"):
        fast_marching(distance + 2, grid)
    with pytest.raises(InputError, match="finite"):
        fast_marching(distance * np.inf, grid)
    with pytest.raises(InputError, match="order must be"):
        fast_marching(distance, grid, order=3)


def test_a_missing_library_is_told_with_what_to_install(monkeypatch):
    grid, distance = _disk(16)
    monkeypatch.setitem(sys.modules, "skfmm", None)
    with pytest.raises(InputError, match=r"pip install \"pmesh-flow\[fmm\]\""):
        fast_marching(distance, grid)
