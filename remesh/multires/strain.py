"""How fast a velocity on an adaptive mesh deforms what it carries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.layout import split
from remesh.multires.blocks import Blocks
from remesh.multires.ghosts import padded
from remesh.multires.particles import (
    as_blocks,
    as_three,
    block_counts,
    first_places,
    inverse_spacings,
)
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


def gradient_norm(velocity: Array, blocks: Blocks, *, threads: int | None = None) -> float:
    """Largest over the active nodes of the row-sum norm max_i sum_j |du_i/dx_j| [1/T].

    ``velocity`` ``(ndim, *blocks.shape)`` [L/T]. Fourth-order differences with the spacing of each
    level, one-sided of first order at the last node before an unbounded end and of second order
    next to it. Not a number if the velocity is not one at some active node. O(nodes); same bits for
    any number of threads.
    """
    from remesh.multires import _strain

    if np.shape(velocity) != (blocks.mesh.ndim, *blocks.shape):
        raise InputError(
            f"a velocity must have shape {(blocks.mesh.ndim, *blocks.shape)}, "
            f"got {np.shape(velocity)}",
            hint="one component per axis",
        )
    ghosts = padded(velocity, blocks, _strain.GHOSTS, outside="last", threads=threads)
    edge = ghosts.shape[-1]
    ghosts = ghosts.reshape(-1, blocks.size, edge, edge if blocks.mesh.ndim == 3 else 1, edge)
    factors = inverse_spacings(blocks, ghosts.dtype) / ghosts.dtype.type(12)
    result = np.zeros(blocks.size, ghosts.dtype)
    size, pieces = split(blocks.size)
    share(
        _strain.largest, pieces, thread_count(threads), size, ghosts, factors,
        as_blocks(blocks.leaves(), blocks)[0], first_places(blocks), block_counts(blocks.mesh),
        blocks.levels, as_three(blocks.mesh.grid.periodic, False), result,
    )  # fmt: skip
    return float(result.max())
