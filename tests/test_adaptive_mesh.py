"""The adaptive mesh as a recipe: its levels, and what it refuses."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

GRID = Grid((128, 64), 0.5, origin=(1.0, -2.0), boundary=("periodic", "unbounded"))


def mesh(**changes):
    return AdaptiveMesh(**({"grid": GRID, "levels": 2, "block": 8} | changes))


def test_the_finest_level_is_the_grid():
    assert mesh().level_grid(2) == GRID


def test_each_level_is_twice_as_coarse_as_the_next_and_keeps_the_domain():
    for level in (0, 1):
        coarse, fine = mesh().level_grid(level), mesh().level_grid(level + 1)
        assert coarse.spacing == 2 * fine.spacing == mesh().spacing(level)
        assert tuple(2 * n for n in coarse.shape) == fine.shape
        assert (coarse.origin, coarse.boundary) == (fine.origin, fine.boundary)


def test_counts_are_blocks_along_each_axis():
    assert [mesh().counts(level) for level in range(3)] == [(4, 2), (8, 4), (16, 8)]
    assert mesh().ndim == 2


def test_details_are_refined_at_four_times_the_tolerance_unless_told():
    assert mesh(tolerance=1e-2).thresholds == (1e-2, 4e-2)
    assert mesh(tolerance=1e-2, refinement=2e-2).thresholds == (1e-2, 2e-2)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"tolerance": 0.0}, "tolerance must lie in"),
        ({"tolerance": 1.0}, "tolerance must lie in"),
        ({"tolerance": "fine"}, "tolerance"),
        ({"tolerance": 1e-2, "refinement": 5e-3}, "must not lie below the tolerance"),
        ({"refinement": float("nan")}, "must not lie below the tolerance"),
        ({"block": 12}, "block must be one of"),
        ({"levels": 0}, "levels must be a whole number"),
        ({"levels": 1.5}, "levels must be a whole number"),
        ({"levels": 4}, "need multiples of 128"),
        ({"wavelet": "3.3"}, "unknown wavelet"),
        ({"most_blocks": 7}, "most_blocks must be at least 8"),
        ({"most_blocks": 100.5}, "most_blocks must be a whole number"),
        ({"most_blocks": "9"}, "most_blocks must be a number, got '9'"),
        ({"levels": True}, "levels must be a whole number"),
        ({"levels": float("nan")}, "levels must be a whole number"),
        ({"levels": float("inf")}, "levels must be a whole number"),
        ({"levels": None}, "levels must be a number, got None"),
        ({"block": [16]}, "block must be a number"),
        ({"grid": (64, 64)}, r"grid must be a Grid, the finest, got \(64, 64\)"),
    ],
)
def test_meshes_that_cannot_be_are_refused(changes, said):
    with pytest.raises(InputError, match=said):
        mesh(**changes)


def test_whole_numbers_of_other_types_are_held_as_int():
    found = mesh(levels=2.0, block=np.float64(8), most_blocks=np.int32(20))
    assert found == mesh(most_blocks=20)
    assert [type(n) for n in (found.levels, found.block, found.most_blocks)] == [int] * 3


def test_a_level_is_one_of_the_mesh_and_the_finest_if_none_is_asked_for():
    assert [mesh().checked_level(level) for level in (None, 0, 1.0)] == [2, 0, 1]
    for level in (-1, 3, 0.5, float("nan"), "fine", True):
        with pytest.raises(InputError, match="level must be a"):
            mesh().checked_level(level)
