"""Adaptive meshes for tests: boxes of finer and finer blocks around a place."""

import numpy as np

from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh


def recipe(nodes, ndim=2, levels=2, boundary="periodic", block=16, **more):
    """A mesh over the unit box."""
    grid = Grid((nodes,) * ndim, 1 / nodes, boundary=boundary)
    return AdaptiveMesh(grid=grid, levels=levels, block=block, **more)


def nested(mesh, center, radius):
    """Blocks within ``radius`` of a place on the finest level, twice as far on each coarser one."""
    wanted = [np.empty((0, mesh.ndim), int)]
    for level in range(1, mesh.levels + 1):
        edge = mesh.spacing(level) * mesh.block
        reach = radius * 2 ** (mesh.levels - level)
        low = np.maximum(np.floor((np.array(center) - reach) / edge), 0).astype(int)
        high = np.minimum((np.array(center) + reach) // edge + 1, mesh.counts(level)).astype(int)
        axes = [np.arange(a, b) for a, b in zip(low, high, strict=True)]
        wanted.append(np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, mesh.ndim))
    return Blocks.around(mesh, wanted)


def dense(values, blocks, level):
    """Scalar values of a complete level on its uniform grid."""
    mesh = blocks.mesh
    result = np.empty(mesh.level_grid(level).shape, values.dtype)
    for number in range(blocks.starts[level], blocks.starts[level + 1]):
        start = blocks.places[number] * mesh.block
        result[tuple(slice(s, s + mesh.block) for s in start)] = values[number]
    return result


def at_nodes(uniform, blocks, level):
    """What a field on the finest uniform grid holds at the nodes of a level's blocks."""
    mesh = blocks.mesh
    step = 2 ** (mesh.levels - level)
    local = np.indices((mesh.block,) * mesh.ndim)
    start = blocks.places[blocks.of(level)].T.reshape(mesh.ndim, -1, *(1,) * mesh.ndim)
    return uniform[tuple(step * (mesh.block * start + local[:, None]))]


def cells(marks, blocks):
    """Marks of nodes, told for cells of 4 nodes along each axis."""
    parts = (blocks.mesh.block // 4, 4) * blocks.mesh.ndim
    within = tuple(range(2, 2 * blocks.mesh.ndim + 1, 2))
    return marks.reshape(blocks.size, *parts).any(axis=within)
