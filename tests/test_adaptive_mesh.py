"""The adaptive mesh as a recipe: its levels, and what it refuses."""

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
    ],
)
def test_meshes_that_cannot_be_are_refused(changes, said):
    with pytest.raises(InputError, match=said):
        mesh(**changes)
