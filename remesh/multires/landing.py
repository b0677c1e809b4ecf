"""Where the flow carries the blocks of an adaptive mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import BUFFER, CELL
from remesh.multires.particles import as_blocks, as_three, check_displacement, refuse_far

Array = NDArray[np.floating[Any]]


def landing(
    blocks: Blocks, displacement: Array, busy: NDArray[np.bool_], *, buffer: int = BUFFER
) -> Blocks:
    """The mesh that the flow carries along: as fine as now where busy particles land.

    ``displacement`` ``(ndim, *blocks.shape)`` [L] says how far the particle of each node goes, any
    length; ``busy`` ``(n, block / 4, ...)`` which cells of 4^ndim nodes hold details that must be
    followed. Blocks of a level are wanted wherever the moved particles of such a cell or nodes up
    to ``buffer`` around them lie; balance adds what it needs. ``most_blocks`` of the mesh does not
    count here: the next `adapt` brings the mesh back under it. Periodic axes wrap, beyond unbounded
    ends there is nothing. Cost: O(busy nodes). Refuses displacements of busy cells that are not
    finite.
    """
    from remesh.multires import _hashing, _landing

    mesh, ndim = blocks.mesh, blocks.mesh.ndim
    moves = as_blocks(check_displacement(displacement, blocks), blocks)
    cells = (blocks.size, *(mesh.block // CELL,) * ndim)
    marks = np.asarray(busy, bool)
    if marks.shape != cells:
        raise InputError(
            f"busy must have shape {cells}, one mark per {CELL}^{ndim} nodes, got {marks.shape}",
            hint="the marks that adapt gives with its blocks",
        )
    marks = marks.reshape(blocks.size, cells[1], -1 if ndim == 3 else 1, cells[1])
    wraps = as_three(mesh.grid.periodic, False)
    wanted = [np.empty((0, ndim), np.int64)]
    for level in range(1, blocks.finest + 1):
        own = blocks.of(level)
        counts = mesh.counts(level)
        bits = max(6, int(8 * (own.stop - own.start)).bit_length())
        found = -1
        while found == -1:
            keys = np.full(2**bits, _hashing.EMPTY, np.int64)
            found = _landing.touched(
                moves[:, own], marks[own], blocks.places[own], 1 / mesh.spacing(level),
                buffer, as_three(counts, 1), wraps, keys, bits,
            )  # fmt: skip
            bits += 2
        refuse_far(found == -2)
        places = np.unravel_index(keys[keys != _hashing.EMPTY], counts)
        wanted.append(np.stack(places, axis=-1).astype(np.int64))
    return Blocks.around(mesh, wanted)
