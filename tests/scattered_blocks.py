"""Adaptive meshes for tests: a few blocks anywhere, with all kinds of neighbours, and fields."""

import numpy as np

from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh

SIDES = {
    "2-D": (2, "unbounded"),
    "2-D periodic": (2, "periodic"),
    "3-D mixed": (3, ("periodic", "unbounded", "periodic")),
    "3-D": (3, "unbounded"),
}


def scattered(side, seed=0, block=8, number=2, **more):
    """Blocks around random ones of each level."""
    ndim, boundary = SIDES[side]
    levels = 3 if ndim == 2 else 2
    grid = Grid(((256, 128) if ndim == 2 else (64, 64, 96)), 0.01, boundary=boundary)
    if block == 16 and ndim == 3:
        levels, grid = 1, Grid((64, 64, 96), 0.01, boundary=boundary)
    mesh = AdaptiveMesh(grid=grid, levels=levels, block=block, **more)
    rng = np.random.default_rng(seed)
    some = [rng.integers(0, mesh.counts(lv), (number, ndim)) for lv in range(1, levels + 1)]
    return Blocks.around(mesh, [np.empty((0, ndim), np.int64), *some])


def noise(blocks, *components, dtype=np.float64, seed=0):
    """Random values on the nodes of blocks."""
    field = np.random.default_rng(seed).standard_normal((*components, *blocks.shape))
    return field.astype(dtype)


def cube(ndim, edge, block=8, **more):
    """A cube of finer blocks, so many along its edge, in the middle of a large unbounded mesh."""
    grid = Grid((12 * block,) * ndim, 0.01)
    mesh = AdaptiveMesh(grid=grid, levels=1, block=block, **more)
    along = np.arange(6 - edge // 2, 6 - edge // 2 + edge)
    places = np.stack(np.meshgrid(*[along] * ndim, indexing="ij"), -1).reshape(-1, ndim)
    return Blocks.around(mesh, [np.empty((0, ndim), np.int64), places])
