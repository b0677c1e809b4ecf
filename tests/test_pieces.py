"""Pieces: counted on a band as on the whole mesh."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from levelset.band import Band
from levelset.pieces import pieces
from levelset.shapes import Box, Disk, Sphere
from remesh.grid import Grid


def banded(phi: np.ndarray, grid: Grid, width: float = 3.0) -> Band:
    nodes = np.flatnonzero(np.abs(phi.ravel()) < width * grid.spacing)
    return Band(grid, nodes, phi.ravel()[nodes])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("ndim", [2, 3])
def test_balls_strewn_at_random_are_labelled_as_on_the_whole_mesh(ndim: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid((60, 55, 50)[:ndim], 0.02)
    ball = Disk if ndim == 2 else Sphere
    phi = np.min(
        [
            ball(r, center=tuple(c)).distance(grid.points())
            for c, r in zip(rng.uniform(0.1, 1, (9, ndim)), rng.uniform(0.05, 0.2, 9), strict=True)
        ],
        axis=0,
    )
    label, count = ndimage.label(phi < 0)
    found = pieces(banded(phi, grid))
    assert len(found) == count
    assert found.tolist() == sorted(np.bincount(label.ravel())[1:].tolist(), reverse=True)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_ball_across_a_periodic_seam_is_one_piece(axis: int) -> None:
    grid = Grid((32, 32, 32), 1 / 32, boundary="periodic")
    x = grid.points()
    x[axis] = np.mod(x[axis] + 0.5, 1.0) - 0.5
    center = [0.5, 0.5, 0.5]
    center[axis] = 0.0
    phi = Sphere(0.3, center=tuple(center)).distance(x)
    assert len(pieces(banded(phi, grid))) == 1
    walls = Grid((32, 32, 32), 1 / 32)
    assert len(pieces(banded(phi, walls))) == 2


def test_a_slab_thinner_than_the_band_and_nothing_at_all() -> None:
    grid = Grid((40, 40), 0.05, (-1.0, -1.0))
    slab = Box((1.0, 0.22)).distance(grid.points())
    assert pieces(banded(slab, grid)).tolist() == [int((slab < 0).sum())]
    far = Disk(0.2, center=(9.0, 9.0)).distance(grid.points())
    assert len(pieces(banded(far, grid))) == 0
