"""A band of nodes: its values on the mesh, and the sides beyond it."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.shapes import Disk, Torus
from remesh.grid import Grid

PLANE = Grid((41, 37), 0.1, (-2.0, -1.8))
SPACE = Grid((30, 32, 21), 0.1, (-1.5, -1.6, -1.0))
CASES = [
    (PLANE, Disk(1.1) - Disk(0.5, center=(0.2, 0.1))),
    (PLANE, Disk(0.3, center=(-1.0, 0.0)) | Disk(0.4, center=(1.0, 0.9))),
    (SPACE, Torus(0.9, 0.35)),
]


@pytest.mark.parametrize(("grid", "shape"), CASES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_what_lies_beyond_a_band_gets_the_side_it_is_on(grid, shape, dtype):
    phi = shape.distance(grid.points()).astype(dtype)
    nodes = np.flatnonzero(np.abs(phi.ravel()) < 0.25)
    band = Band(grid, nodes, phi.ravel()[nodes])
    filled = band.filled(7.0)
    near = np.abs(phi) < 0.25
    np.testing.assert_array_equal(filled[near], phi[near])
    np.testing.assert_array_equal(filled[~near], np.where(phi[~near] < 0, -7.0, 7.0))
    assert filled.dtype == dtype


def test_on_the_grid_a_band_is_zero_where_nothing_is_known():
    band = Band(PLANE, np.array([0, 5]), np.array([1.5, -2.0]))
    field = band.on_grid()
    assert field.shape == PLANE.shape
    assert field[0, 0] == 1.5
    assert np.count_nonzero(field) == 2
