"""The adaptive mesh of a compressed field: blocks where coefficients were kept."""

from __future__ import annotations

from typing import Any

import numpy as np

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.compression import Compressed
from remesh.multires.mesh import SIZES, AdaptiveMesh


def kept_blocks(compressed: Compressed, *, block: int | None = None) -> Blocks:
    """Blocks of ``block`` nodes under all details that were kept, level by level.

    Their mesh begins where the field's does and reaches as far or farther: to whole blocks of its
    coarsest level. A periodic axis stays so, and the balance crosses its seam, where it is a whole
    number of these; one that was lengthened is unbounded. ``block``: by default the largest of 8,
    16 and 32 of which 64 fit along the shortest axis, or 8. O(coefficients).
    """
    grid, depth = compressed.grid, compressed.depth
    if depth < 1:
        raise InputError("the field was not split into levels", hint="compress(..., levels=None)")
    shortest = min(grid.shape)
    size = max((b for b in SIZES if 64 * b <= shortest), default=8) if block is None else block
    levels = int(np.clip(np.log2(max(shortest / size, 1.0)), 1, depth))
    unit = size * 2**levels
    shape = [-(-n // unit) * unit for n in grid.shape]
    ends = zip(grid.boundary, shape, grid.shape, strict=True)
    boundary: Any = [end if n == given else "unbounded" for end, n, given in ends]
    mesh = AdaptiveMesh(
        grid=Grid(shape, grid.spacing, grid.origin, boundary),
        levels=levels,
        tolerance=compressed.tolerance,
        wavelet=compressed.wavelet,
        block=size,
    )
    nodes = np.stack(np.unravel_index(compressed.indices % grid.size, grid.shape), axis=-1)
    wanted = [np.empty((0, grid.ndim), np.int64)]
    for level in range(1, levels + 1):
        own = nodes[compressed.levels == level + depth - levels]
        places = (own >> (levels - level)) // size
        wanted.append(np.unique(places, axis=0))
    return Blocks.around(mesh, wanted)
