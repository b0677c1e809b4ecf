"""Level sets reach the loops checked, and bands without a look at the rest of the mesh."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.nodal import laid_out, on_mesh, refuse_empty
from remesh.errors import InputError
from remesh.grid import Grid

GRID = Grid((6, 7), 1.0)


def test_known_zeros_are_told_from_unset_nodes():
    phi = np.full(GRID.shape, np.nan)
    nodes = np.array([3, 8, 20])
    phi.reshape(-1)[nodes] = (-1.0, 0.0, 2.0)
    laid = laid_out(phi, GRID, nodes)
    assert np.flatnonzero(laid.flat).tolist() == nodes.tolist()
    assert laid.known == pytest.approx([-1.0, 0.0, 2.0], abs=1e-20)
    assert laid.gaps
    assert not laid_out(np.ones(GRID.shape), GRID).gaps


def test_a_band_brings_its_own_grid():
    band = Band(GRID, np.array([3, 8]), np.array([-1.0, 1.0]))
    values, grid, nodes = on_mesh(band, None)
    assert grid is GRID
    np.testing.assert_array_equal(laid_out(values, grid, nodes).known, band.values)


def test_one_sign_is_told():
    with pytest.raises(InputError, match="it is nowhere negative"):
        refuse_empty(laid_out(np.ones(GRID.shape), GRID))
    with pytest.raises(InputError, match="it is negative"):
        refuse_empty(laid_out(-np.ones(GRID.shape), GRID))
    with pytest.raises(InputError, match="it is on no nodes"):
        refuse_empty(laid_out(np.ones(GRID.shape), GRID, np.zeros(0, np.int64)))
