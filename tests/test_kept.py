"""The adaptive mesh of a compressed field."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.compression import compress
from remesh.multires.kept import kept_blocks


def bump(grid):
    square = sum((x - 0.45) ** 2 for x in grid.points())
    return np.exp(-square / 0.04**2)


@pytest.mark.parametrize("shape", [(128, 128), (200, 131), (40, 64, 37)])
def test_every_kept_detail_lies_in_a_block_of_its_level(shape):
    grid = Grid(shape, 1 / max(shape))
    packed = compress(bump(grid), grid, tolerance=1e-3)
    blocks = kept_blocks(packed, block=8)
    mesh = blocks.mesh
    assert all(n >= m for n, m in zip(mesh.grid.shape, shape, strict=True))
    nodes = np.stack(np.unravel_index(packed.indices, shape), axis=-1)
    for level in range(1, mesh.levels + 1):
        own = nodes[packed.levels == level + packed.depth - mesh.levels]
        step = 2 ** (mesh.levels - level)
        assert (blocks.numbers_of(level, own // step // 8) >= 0).all()


def test_a_smooth_field_needs_fine_blocks_where_it_varies_only():
    grid = Grid((256, 256), 1 / 256)
    blocks = kept_blocks(compress(bump(grid), grid, tolerance=1e-3))
    assert blocks.active < 0.1 * grid.size
    finest = blocks.places[blocks.of(blocks.finest)]
    middle = (finest + 0.5) * blocks.mesh.block * blocks.mesh.spacing(blocks.finest)
    assert (np.linalg.norm(middle - 0.45, axis=1) < 0.3).all()


def test_lower_tolerances_only_add_blocks():
    grid = Grid((128, 128), 1 / 128)
    sizes = [kept_blocks(compress(bump(grid), grid, tolerance=t)).size
             for t in (1e-2, 1e-4, 1e-6)]  # fmt: skip
    assert sizes == sorted(sizes)


def test_a_field_that_was_not_split_is_refused():
    grid = Grid((16, 16), 1 / 16)
    packed = compress(bump(grid), grid, tolerance=1e-2, levels=0)
    with pytest.raises(InputError, match="not split into levels"):
        kept_blocks(packed)


def test_a_periodic_axis_stays_so_where_it_is_a_whole_number_of_blocks():
    grid = Grid((128, 120), 1 / 128, boundary="periodic")
    blocks = kept_blocks(compress(bump(grid), grid, tolerance=1e-3), block=8)
    assert blocks.mesh.grid.shape == (128, 128)
    assert blocks.mesh.grid.boundary == ("periodic", "unbounded")


def test_the_balance_crosses_a_seam():
    grid = Grid((128, 128), 1 / 128, boundary="periodic")
    x, y = grid.points()
    spike = np.exp(-((x + 1 / 256) ** 2 + (y - 0.5) ** 2) / 0.01**2)
    blocks = kept_blocks(compress(spike, grid, tolerance=1e-3), block=8)
    fine = blocks.places[blocks.of(blocks.finest)]
    beyond = (fine[fine[:, 0] == 0] - (1, 0)) // 2  # the coarser block on the other side
    assert len(beyond)
    assert (blocks.numbers_of(blocks.finest - 1, beyond) >= 0).all()
    assert (beyond[:, 0] == -1).all()
