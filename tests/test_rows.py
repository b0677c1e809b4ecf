"""What lies beyond a band is on the side of what is beside it."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.rows import filled, runs
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("shape", [(17, 23), (13, 14, 15)])
@pytest.mark.parametrize("kind", ["ball", "wall 0", "wall 1", "last wall"])
def test_a_band_is_filled_with_the_signs_of_the_whole(shape, kind, sign):
    grid = Grid(shape, 1.0)
    x = grid.points()
    if kind == "ball":
        phi = np.sqrt(((x - 6.3) ** 2).sum(axis=0)) - 5.2
    else:
        phi = x[{"wall 0": 0, "wall 1": 1, "last wall": -1}[kind]] - 6.4
    phi = sign * phi
    nodes = np.flatnonzero(np.abs(phi) < 1.6)
    values = phi.reshape(-1)[nodes]
    field = filled(nodes, values, grid, 3.0)
    np.testing.assert_array_equal(field < 0, phi < 0)
    np.testing.assert_array_equal(field.reshape(-1)[nodes], values)


def test_runs_are_all_nodes_beyond_the_band_once():
    grid = Grid((9, 8, 7), 1.0)
    phi = np.sqrt(((grid.points() - 3.6) ** 2).sum(axis=0)) - 2.4
    nodes = np.flatnonzero(np.abs(phi) < 1.2)
    found = np.zeros(grid.size, int)
    for row, first, stop, _ in zip(*runs(nodes, phi.reshape(-1)[nodes], grid), strict=True):
        found[row * 7 + first : row * 7 + stop] += 1
    found[nodes] += 1
    assert (found == 1).all()


def test_an_empty_band_has_no_inside():
    grid = Grid((5, 6), 1.0)
    assert (filled(np.zeros(0, np.int64), np.zeros(0), grid, 1.0) > 0).all()


def test_a_hole_in_the_band_is_refused():
    grid = Grid((5, 9), 1.0)
    values = grid.points()[1].reshape(-1) - 4.5
    nodes = np.flatnonzero(np.abs(values) > 1)
    with pytest.raises(InputError, match="the band has a hole"):
        runs(nodes, values[nodes], grid)
