"""The cell list: every particle in one cell, and all that are near a point in reach of its own."""

from __future__ import annotations

import numpy as np
import pytest

from remesh.cells import CellList, check_points
from remesh.errors import InputError


@pytest.mark.parametrize("ndim", [2, 3])
def test_every_particle_is_in_one_cell_and_its_near_ones_are_within_reach(ndim):
    places = np.random.default_rng(3).uniform(-2.0, 5.0, (300, ndim))
    reach = 0.9
    cells = CellList(places, reach)
    assert sorted(cells.order) == list(range(300))
    assert cells.starts[-1] == 300
    np.testing.assert_array_equal(cells.places[:, :ndim], places[cells.order])
    home = np.floor((cells.places - cells.origin) / cells.width).astype(int)
    apart = np.linalg.norm(cells.places[:, None] - cells.places[None], axis=-1)
    away = np.abs(home[:, None] - home[None]).max(axis=-1)
    assert (away[apart < reach] <= cells.reach).all()


def test_a_wide_cloud_of_few_particles_keeps_the_number_of_cells_bounded():
    cells = CellList(np.array([[0.0, 0.0], [1e9, 1e9]]), 1e-3)
    assert cells.starts.size < 3 << 21
    assert cells.reach == 1


@pytest.mark.parametrize(
    ("given", "match"),
    [
        (np.zeros((2, 5)), "positions must have shape"),
        (np.array([[0.0, np.inf]]), "positions must be finite"),
    ],
)
def test_points_that_make_no_sense_are_refused(given, match):
    with pytest.raises(InputError, match=match):
        check_points(given, "positions")
