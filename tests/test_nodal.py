"""Level sets reach the loops checked, and bands without a look at the rest of the mesh."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.nodal import axes, laid_out, on_mesh, refuse_empty, three
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


def test_a_band_comes_without_another_grid_or_nodes_and_a_field_with_one():
    band = Band(GRID, np.array([3, 8]), np.array([-1.0, 1.0]))
    for grid, nodes in ((Grid((6, 7), 2.0), None), (GRID, band.nodes)):
        with pytest.raises(InputError, match="a band has a grid and nodes of its own"):
            on_mesh(band, grid, nodes)
    assert on_mesh(band, GRID)[2] is band.nodes
    with pytest.raises(InputError, match="needs its grid"):
        laid_out(np.ones(GRID.shape))


@pytest.mark.parametrize("kind", [np.complex128, object, "U1"])
def test_what_is_no_real_number_is_refused(kind):
    phi = np.ones(GRID.shape).astype(kind)
    for nodes in (None, np.array([3, 8])):
        with pytest.raises(InputError, match="phi must be real numbers, got"):
            laid_out(phi, GRID, nodes)


def test_points_stand_in_the_loops_axes_in_node_units():
    plane = Grid((6, 7), 0.5, origin=(1.0, -1.0))
    np.testing.assert_allclose(three(plane, np.array([[2.0, 0.5]])), [[2.0, 0.0, 3.0]])
    assert axes(plane) == ((6, 1, 7), (False, False, False))
    space = Grid((6, 7, 8), 0.5, boundary=("unbounded", "periodic", "unbounded"))
    np.testing.assert_allclose(three(space, np.array([[2.0, 0.5, 1.0]])), [[4.0, 1.0, 2.0]])
    assert axes(space) == ((6, 7, 8), (False, True, False))
