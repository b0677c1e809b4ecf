"""Drops of one node are seen, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.redistancing import redistance, redistance_band
from levelset.shapes import Disk
from levelset.specks import specks
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.mark.parametrize("boundary", ["unbounded", "periodic"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_drop_of_one_node_is_seen_in_the_box_and_in_a_band(ndim, boundary):
    grid = Grid((16,) * ndim, 0.5, boundary=boundary)
    for place in ((0,) * ndim, (15,) * ndim, (8,) * ndim):
        phi = np.sqrt(((grid.points() - 3.1) ** 2).sum(axis=0)) - 1.2
        if place == (8,) * ndim:
            phi += 2.0
        phi[place] = -1e-3
        drop = np.ravel_multi_index(place, grid.shape)
        assert specks(phi, grid).tolist() == [drop]
        nodes = np.flatnonzero(np.abs(phi) < 1.6)
        assert specks(Band(grid, nodes, phi.reshape(-1)[nodes])).tolist() == [drop]


def test_neighbours_across_a_seam_are_neighbours_only_if_the_axis_is_periodic():
    phi = np.ones((5, 6))
    phi[0, 2] = phi[4, 2] = -0.1
    assert len(specks(phi, Grid((5, 6), 1.0))) == 2
    assert len(specks(phi, Grid((5, 6), 1.0, boundary="periodic"))) == 0


def test_thin_shapes_and_deep_nodes_are_no_drops():
    grid = Grid((20, 20), 1.0)
    phi = np.abs(grid.points()[0] - 9.1) - 0.3  # a sheet of one node
    assert len(specks(phi, grid)) == 0
    phi = np.ones(grid.shape)
    phi[4, 5] = -0.7
    assert len(specks(phi, grid)) == 0
    assert len(specks(phi, grid, depth=1.0)) == 1


def test_raising_a_vanished_drop_lets_redistancing_forget_it():
    grid = Grid((32, 32), 1.0)
    phi = Disk(6.0, center=(12.2, 15.1)).distance(grid.points())
    exact = redistance(phi, grid)
    phi[27, 27] = -1e-9
    assert redistance(phi, grid)[27, 27] < 0  # for ever
    phi.reshape(-1)[specks(phi, grid)] = 1e-9
    nodes = np.flatnonzero(np.abs(phi) < 4.0)
    nodes = nodes[nodes != 27 * 32 + 27]
    band = redistance_band(phi, grid, nodes, 3.0)
    np.testing.assert_allclose(band.values, exact.reshape(-1)[band.nodes], atol=1e-9)
    assert len(specks(band)) == 0


def test_what_is_not_finite_is_refused():
    with pytest.raises(InputError, match="phi must be finite"):
        specks(np.full((5, 6), np.nan), Grid((5, 6), 1.0))
