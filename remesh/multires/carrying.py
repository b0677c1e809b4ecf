"""Values carried from one adaptive mesh to another as they are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.blocks import Blocks
from remesh.multires.ghosts import check_values, layers, lifting_weights
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


def transferred(
    values: Array, blocks: Blocks, other: Blocks, *, threads: int | None = None
) -> Array:
    """Values ``(n, ...)`` or ``(c, n, ...)`` on other blocks of the same mesh.

    Blocks that both have are copied bit for bit; new ones are subdivisions of the coarser ones
    under them, by the wavelet's prediction. Consistent where the values were and details vanish
    beside coarser neighbours. What only the old mesh resolves is let go: `adapt` does so with the
    moments kept. O(nodes). Refuses blocks of different meshes.
    """
    given = check_values(values, blocks)
    mesh = blocks.mesh
    same = replace(
        other.mesh, tolerance=mesh.tolerance, refinement=mesh.refinement,
        most_blocks=mesh.most_blocks,
    )  # fmt: skip
    if same != mesh:
        raise InputError(
            f"both must be blocks of one mesh, got {mesh} and {other.mesh}",
            hint="meshes may differ in tolerance, refinement and most_blocks only",
        )
    from remesh.multires import _carrying

    found = other.found_in(blocks)
    new = found < 0
    result = np.empty((*given.shape[: -len(blocks.shape)], *other.shape), given.dtype)
    parts, count = layers(result, other), thread_count(threads)
    parts[:, ~new] = layers(given, blocks)[:, found[~new]]
    tables = other.neighbours, other.coarser, other.sides
    predict = lifting_weights(other, result.dtype)[0]
    for level in range(1, other.finest + 1):
        first, last = other.starts[level : level + 2]
        if new[first:last].any():
            args = (last - first, count, first)
            share(_carrying.seed, *args, parts, tables, new)
            share(_carrying.grow, *args, parts, tables, new, predict)
    return result
