"""What recipes of surfaces are given."""

import numpy as np
import pytest

from levelset.given import check_grid, level_set, precision_asked
from levelset.shapes import Disk
from remesh.errors import InputError
from remesh.grid import Grid


def test_a_shape_gives_its_distance_and_an_array_itself():
    grid = Grid((9, 9), 0.5, (-2.0, -2.0))
    distance = Disk(1.0).distance(grid.points())
    np.testing.assert_array_equal(level_set(Disk(1.0), grid), distance)
    np.testing.assert_array_equal(level_set(3 * distance, grid), 3 * distance)


def test_what_is_no_surface_is_refused():
    grid = Grid((9, 9), 0.5, (-2.0, -2.0))
    for wrong in ("a", None, np.full(grid.shape, 1j)):
        with pytest.raises(InputError, match="a shape or numbers"):
            level_set(wrong, grid)
    with pytest.raises(InputError, match="must have shape"):
        level_set(np.zeros((3, 3)), grid)
    with pytest.raises(InputError, match="must be finite"):
        level_set(np.full(grid.shape, np.nan), grid)


def test_the_precision_is_the_one_asked_for_else_that_of_the_values():
    for asked in ("float32", np.float32, np.dtype(np.float32)):
        assert precision_asked(asked, np.zeros(3)) == np.float32
    assert precision_asked(None, np.zeros(3, np.float32)) == np.float32
    assert precision_asked(None, np.zeros(3, int)) == np.float64
    for wrong in ("a", "int32", complex, 3):
        with pytest.raises(InputError, match="dtype must be"):
            precision_asked(wrong, np.zeros(3))


def test_what_is_no_grid_is_refused():
    check_grid(Grid((4, 4), 1.0))
    for wrong in (None, "a", (4, 4)):
        with pytest.raises(InputError, match="grid must be a Grid"):
            check_grid(wrong)
