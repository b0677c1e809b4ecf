"""Nodes of an adaptive mesh as particles: how their arrays are laid out, and what is refused."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.particles import (
    block_counts,
    check_displacement,
    inverse_spacings,
)

MESHES = [
    AdaptiveMesh(grid=Grid((64, 128), 0.1), levels=2, block=8),
    AdaptiveMesh(grid=Grid((32, 64, 64), 0.1), levels=1, block=16),
]
meshes = pytest.mark.parametrize("mesh", MESHES, ids=["2-D", "3-D"])


@meshes
def test_counts_are_those_of_the_blocks_of_complete_levels(mesh):
    first = Blocks.uniform(mesh, mesh.levels)
    assert block_counts(mesh).prod(axis=1).tolist() == np.diff(first.starts).tolist()


def test_in_a_plane_the_middle_axis_has_one_block():
    assert block_counts(MESHES[0]).tolist() == [[2, 1, 4], [4, 1, 8], [8, 1, 16]]
    assert block_counts(MESHES[1]).tolist() == [[1, 2, 2], [2, 4, 4]]


@meshes
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_inverse_spacings_are_those_of_the_levels(mesh, dtype):
    blocks = Blocks.uniform(mesh, mesh.levels)
    found = inverse_spacings(blocks, np.dtype(dtype))
    assert found.dtype == dtype
    exact = [1 / mesh.spacing(level) for level in blocks.levels]
    np.testing.assert_allclose(found, exact, rtol=np.finfo(dtype).eps)


@meshes
def test_displacements_that_are_not_real_or_of_another_shape_are_refused(mesh):
    blocks = Blocks.uniform(mesh)
    with pytest.raises(InputError, match="must be real numbers, got complex128"):
        check_displacement(np.zeros((mesh.ndim, *blocks.shape), complex), blocks)
    with pytest.raises(InputError, match="displacement must have shape"):
        check_displacement(np.zeros(blocks.shape), blocks)
