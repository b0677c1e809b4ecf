"""The active parts of an adaptive mesh as boxes."""

import numpy as np
import pytest

from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.boxes import leaf_boxes
from remesh.multires.mesh import AdaptiveMesh

PLANE = AdaptiveMesh(grid=Grid((128, 96), 0.5, (-3.0, 2.0), "periodic"), levels=2, block=8)
SPACE = AdaptiveMesh(grid=Grid((64, 32, 64), 0.25), levels=2, block=8)


def some_blocks(mesh, seed=0):
    rng = np.random.default_rng(seed)
    wanted = [np.empty((0, mesh.ndim), np.int64)] * 2
    finest = rng.integers(0, mesh.counts(2), (3, mesh.ndim))
    return Blocks.around(mesh, [*wanted, finest])


@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_boxes_tile_the_domain_once_and_hold_the_active_nodes(mesh):
    blocks = some_blocks(mesh)
    boxes = leaf_boxes(blocks)
    volume = np.prod(boxes.high - boxes.low, axis=1)
    assert volume.sum() == pytest.approx(mesh.grid.size * mesh.grid.cell_volume)
    nodes = volume / np.array([mesh.spacing(int(level)) for level in boxes.level]) ** mesh.ndim
    assert nodes.sum() == pytest.approx(blocks.active)
    points = np.random.default_rng(1).uniform(boxes.low.min(0), boxes.high.max(0), (300, mesh.ndim))
    inside = (points[:, None] >= boxes.low) & (points[:, None] < boxes.high)
    assert (inside.all(axis=-1).sum(axis=1) == 1).all()


@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_every_active_node_lies_in_a_box_of_its_level(mesh):
    blocks = some_blocks(mesh)
    boxes, leaves, points = leaf_boxes(blocks), blocks.leaves(), blocks.points()
    for level in range(blocks.finest + 1):
        own = blocks.of(level)
        nodes = points[:, own][:, leaves[own]].T + 1e-9
        low, high = (part[boxes.level == level] for part in (boxes.low, boxes.high))
        inside = (nodes[:, None] >= low) & (nodes[:, None] < high)
        assert (inside.all(axis=-1).sum(axis=1) == 1).all()


def test_a_block_with_nothing_over_it_is_one_box():
    boxes = leaf_boxes(Blocks.uniform(PLANE, 0))
    assert len(boxes.level) == 4 * 3
    np.testing.assert_allclose(boxes.high - boxes.low, 8 * PLANE.spacing(0))
    assert leaf_boxes(Blocks.uniform(PLANE, 2)).level.min() == 2
