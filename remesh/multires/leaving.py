"""What leaves an adaptive mesh through unbounded ends, as the sums of its coarsest level tell."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.multires.blocks import OUTSIDE, Blocks
from remesh.multires.particles import as_blocks

Array = NDArray[np.floating[Any]]
ALL = (1, 2, 3, 4)  # axes of the blocks and of their nodes in the loops' layout


def coarsest_sums(values: Array, blocks: Blocks) -> NDArray[np.float64]:
    """Sums of each component (c,) over the coarsest level, in double precision."""
    coarse = as_blocks(values, blocks)[:, blocks.of(0)]
    sums: NDArray[np.float64] = coarse.sum(axis=ALL, dtype=np.float64)
    return sums


def at_ends(blocks: Blocks) -> NDArray[np.bool_]:
    """Which blocks touch an unbounded end."""
    found: NDArray[np.bool_] = (blocks.neighbours == OUTSIDE).any(axis=1)
    return found


def matter(values: Array, blocks: Blocks, some: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which components (c,) are beyond the tolerance on those of some blocks that are refined.

    The mesh's tolerance, relative to the largest absolute value of the component.
    """
    parts, finer = as_blocks(values, blocks), some & (blocks.levels > 0)
    if not finer.any():
        return np.zeros(len(parts), bool)
    floor = blocks.mesh.tolerance * np.abs(parts).max(axis=ALL)
    return np.asarray(np.abs(parts[:, finer]).max(axis=ALL) > floor)
