"""Scratch is given to one at a time, zero when new, and comes back as it was left."""

from __future__ import annotations

import numpy as np

from levelset.lookup import places, remeshed
from levelset.profile import profile
from levelset.scratch import borrow, give_back
from levelset.shapes import Disk
from remesh.grid import Grid


def test_new_scratch_is_zero_and_given_to_one_only():
    one, two = (borrow("test", (5, 3), np.float64) for _ in range(2))
    assert one is not two
    assert not one.any()
    one[0] = 1.0
    give_back("test", one)
    assert borrow("test", (5, 3), np.float64) is one


def test_scratch_of_another_shape_or_type_is_not_taken():
    give_back("test", np.ones((5, 3)))
    assert borrow("test", (3, 5), np.float64).shape == (3, 5)
    give_back("test", np.ones((5, 3)))
    assert borrow("test", (5, 3), np.uint8).dtype == np.uint8


def test_what_was_remeshed_before_leaves_no_trace():
    """The same band twice, another one on the same mesh in between: the same bits."""
    grid = Grid((81, 81), 0.05, (-2.0, -2.0))

    def carried(shape):
        distance = shape.distance(grid.points()).ravel()
        nodes = np.flatnonzero(np.abs(distance) < 0.6)
        moved = places(grid, nodes) + 0.013
        return remeshed(grid, nodes, moved, profile(distance[nodes], 0.4), "M6'", 0.4)

    first = carried(Disk(0.7))
    carried(Disk(1.1, center=(0.3, 0.1)))
    again = carried(Disk(0.7))
    np.testing.assert_array_equal(first.nodes, again.nodes)
    np.testing.assert_array_equal(first.values, again.values)
