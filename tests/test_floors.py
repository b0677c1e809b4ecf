"""Levels while bands are sought: what coarse ones take, what fine ones ask for, what is born."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.floors import Floor, bands
from levelset.lookup import places
from levelset.profile import profile
from levelset.scratch import borrow, give_back
from levelset.shapes import Disk
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.wavelets import get_wavelet

PREDICT = np.array([float(w) for w in get_wavelet("4.4").predict])


def grids(ndim: int) -> tuple[Grid, Grid]:
    return Grid((16,) * ndim, 1 / 16), Grid((32,) * ndim, 1 / 32)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_coarse_level_takes_the_values_at_even_nodes(ndim):
    low, high = grids(ndim)
    nodes = np.sort(np.random.default_rng(2).choice(high.size, 200, replace=False))
    values = np.random.default_rng(3).uniform(1.0, 2.0, 200)
    coarse, fine = Floor(low), Floor(high, nodes, values)
    coarse.take(fine, np.inf, PREDICT)
    at = np.stack(np.unravel_index(nodes, high.shape), axis=1)
    even = (at % 2 == 0).all(axis=1)
    under = np.ravel_multi_index((at[even] // 2).T, low.shape)
    np.testing.assert_array_equal(np.sort(np.concatenate(coarse.nodes)), np.sort(under))
    np.testing.assert_array_equal(coarse.field[under], values[even])
    assert len(coarse.asked) == 0
    fine.close()
    coarse.close()


@pytest.mark.parametrize("ndim", [2, 3])
def test_born_nodes_interpolate_cubics_exactly_and_found_ones_keep_their_values(ndim):
    low, high = grids(ndim)
    every = np.arange(low.size)

    def cubic(at: np.ndarray) -> np.ndarray:
        """Monotone along each axis, so that no value is beyond those around it."""
        return np.asarray((at + 0.5 * at**2 + at**3) @ np.arange(1.0, 1 + ndim))

    coarse = Floor(low, every, cubic(places(low, every)))
    found = np.ravel_multi_index(([13],) * ndim, high.shape)
    fine = Floor(high, found, np.array([7.0]))
    inner = np.all([(p > 2) & (p < 12) for p in np.unravel_index(every, low.shape)], axis=0)
    nodes = coarse.bear(every[inner], fine, lambda new: coarse.interpolate(fine, PREDICT, new))
    assert len(nodes) == inner.sum() * 2**ndim
    assert (np.diff(nodes) > 0).all()
    known = np.isin(nodes, found)
    exact = cubic(places(high, nodes))
    np.testing.assert_allclose(fine.field[nodes[~known]], exact[~known], rtol=1e-13)
    assert fine.field[nodes[known]].tolist() == [7.0]
    fine.close()
    coarse.close()


def test_what_only_a_fine_level_sees_asks_to_stay():
    low, high = grids(2)
    every = np.arange(high.size)
    thread = np.abs(places(high, every)[:, 0] - 0.515625) - 0.012  # beside the coarse nodes
    coarse, fine = Floor(low), Floor(high, every, thread)
    coarse.take(fine, 0.1, PREDICT)
    asked = np.unravel_index(coarse.asked, low.shape)[0]
    assert set(asked) == {8}
    assert (coarse.field[np.concatenate(coarse.nodes)] > 0).all()
    fine.close()
    coarse.close()


def test_scratch_is_given_back_as_clean_as_it_was_taken():
    mesh = AdaptiveMesh(
        grid=Grid((64, 64), 1 / 64, boundary="periodic"), levels=2, tolerance=1e-3, block=8
    )
    shape = Disk(0.2, center=(0.5, 0.5))
    grid = mesh.level_grid(0)
    every = np.arange(grid.size)
    floors = [Floor(grid, every, profile(shape.distance(places(grid, every).T), 0.2))]
    floors += [Floor(mesh.level_grid(level)) for level in (1, 2)]
    found = bands(mesh, floors, 0.2, 4)
    assert [len(band.nodes) > 0 for band in found] == [True, True, True]
    for floor in floors:
        assert not floor.marks.any()
    marks = borrow("marks", (mesh.grid.size,), np.uint8)
    assert not marks.any()
    give_back("marks", marks)
