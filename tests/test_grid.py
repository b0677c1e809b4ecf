"""Laws of the uniform mesh."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid


def test_nodes_sit_at_origin_plus_whole_spacings():
    grid = Grid((5, 6, 7), 0.25, origin=(1, -1, 0))
    assert grid.points().shape == (3, 5, 6, 7)
    np.testing.assert_allclose(grid.points()[:, 2, 3, 4], (1.5, -0.25, 1.0))
    for axis, values in enumerate(grid.axes()):
        assert len(values) == grid.shape[axis]


def test_a_periodic_axis_is_one_spacing_longer_than_its_nodes_span():
    grid = Grid((8, 8), 0.5, boundary=("periodic", "unbounded"))
    assert grid.length == (4.0, 3.5)
    assert grid.periodic == (True, False)


def test_sizes_and_volumes_follow_the_dimension():
    assert (Grid((4, 5), 0.5).ndim, Grid((4, 5), 0.5).size) == (2, 20)
    assert Grid((4, 5), 0.5).cell_volume == 0.25
    assert Grid((4, 5, 6), 0.5).cell_volume == 0.125


def test_equal_grids_are_equal_and_usable_as_keys():
    assert Grid([4, 5], 0.5) == Grid((4, 5), 0.5, origin=(0, 0), boundary="unbounded")
    assert len({Grid((4, 5), 0.5), Grid((4, 5), 0.5)}) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shape": (8,)}, "2 or 3 axes"),
        ({"shape": (8, 3)}, "at least 4 nodes"),
        ({"shape": (8, 8.5)}, "whole numbers"),
        ({"spacing": 0.0}, "positive length"),
        ({"spacing": float("nan")}, "positive length"),
        ({"origin": (0.0,)}, "2 finite numbers"),
        ({"boundary": "wall"}, "'periodic' or 'unbounded'"),
        ({"boundary": ("periodic",)}, "'periodic' or 'unbounded'"),
    ],
)
def test_unusable_meshes_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        Grid(**({"shape": (8, 8), "spacing": 0.5} | arguments))
