"""Fields on an adaptive mesh at places between its nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.kernels import Kernel, get_kernel
from remesh.layout import split
from remesh.multires.blocks import OUTSIDE, Blocks, layout
from remesh.multires.ghosts import check_values, padded
from remesh.multires.particles import (
    as_blocks,
    as_three,
    block_counts,
    check_displacement,
    first_places,
    inverse_spacings,
    refuse_far,
    tables,
)
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


def sampled_at(
    field: Array,
    blocks: Blocks,
    source: Blocks,
    displacement: Array,
    kernel: str | Kernel = "M6'",
    *,
    threads: int | None = None,
) -> Array:
    """A field on blocks at node + displacement of the nodes of ``source``.

    ``field`` ``([c,] *blocks.shape)``, ``displacement`` ``(ndim, *source.shape)`` [L]. Each place
    is looked up on its node's own level where ``blocks`` has it there, else on the next coarser one
    that it has; across a jump of levels the field is the wavelet's prediction. Beyond unbounded
    ends it keeps its last value, as `sample_nodes` does by default. Exact for polynomials of
    degree kernel.moments on one level; across jumps of a degree below the wavelet's order too.
    Cost: O(nodes); same bits for any number of threads. Refuses displacements that are not finite.
    """
    from remesh.multires import _lookup

    values = check_values(field, blocks)
    moves = check_displacement(displacement, source).astype(values.dtype, copy=False)
    if source.mesh != blocks.mesh:
        raise InputError("blocks and source must be of one mesh", hint="blocks of one AdaptiveMesh")
    found = get_kernel(kernel)
    mesh = blocks.mesh
    ghosts = padded(values, blocks, found.half_width, outside="last", threads=threads)
    edge = ghosts.shape[-1]
    ghosts = ghosts.reshape(-1, blocks.size, edge, edge if mesh.ndim == 3 else 1, edge)
    result: Array = np.empty((*values.shape[: -len(blocks.shape)], *source.shape), values.dtype)
    bad = np.zeros(source.size, np.int64)
    coeffs, taps, mid, terms, numbers = tables(found, mesh.ndim, values.dtype)
    parts = as_blocks(moves, source)
    size, pieces = split(source.size)
    share(
        _lookup.interpolate, pieces, thread_count(threads), size, ghosts,
        (blocks.neighbours == OUTSIDE).any(axis=1), *blocks.table, block_counts(mesh),
        layout(mesh)[2], source.levels, first_places(source), parts,
        inverse_spacings(source, values.dtype), numbers, np.array(parts.shape[2:]),
        as_three(mesh.grid.periodic, False), coeffs, taps, mid, terms, as_blocks(result, source),
        bad,
    )  # fmt: skip
    refuse_far(int(bad.sum()))
    return result
