"""Wavelet transforms of values on blocks: to coarser values and details, and back."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.blocks import Blocks
from remesh.multires.ghosts import check_values, layers, lifting_weights
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


class Coefficients(NamedTuple):
    """Wavelet coefficients on blocks, both of the shape of the values.

    ``smooth`` are the values of each level after the details of all finer levels were added to
    them; ``details`` those at the nodes that a level has more than the next coarser one, zero at
    its even nodes and on level 0.
    """

    smooth: Array
    details: Array


def forward(
    values: Array, blocks: Blocks, *, spill: bool = False, threads: int | None = None
) -> Coefficients:
    """Coarser values and details of values on blocks ``(n, ...)`` or ``(c, n, ...)``.

    Only values of active nodes are read. On each level a tensor product of lifting steps, finest
    level first; around the blocks of a level the field is what `ghosts.padded` tells. As it is,
    coarser values change under the level's blocks only, and `inverse` undoes it for any values.
    With ``spill`` those beside the blocks get their part of the details too: then the sums
    over the coarsest nodes of f x^a y^b z^c, a, b, c < N~, stay whatever details are
    dropped afterwards. Both are the same where details vanish within N + N~ - 2 nodes of a coarser
    neighbour. O(nodes); same bits for any number of threads.
    Source: Sweldens, SIAM J. Math. Anal. 29 (1998) 511; blocks as in Gillis & van Rees, SIAM J.
    Sci. Comput. 44 (2022) C367.
    """
    from remesh.multires import _pyramid

    values = check_values(values, blocks)
    result = Coefficients(values.copy(), np.empty_like(values))
    smooth, details = (layers(part, blocks) for part in result)
    details[:, blocks.of(0)] = 0
    work, count = np.empty_like(smooth), thread_count(threads)
    predict, update = lifting_weights(blocks, values.dtype)
    tables = _tables(blocks)
    for level in range(blocks.finest, 0, -1):
        first, last = blocks.starts[level : level + 2]
        args = (last - first, count, first)
        share(_pyramid.predict_blocks, *args, smooth, work, tables, predict, True)
        share(_pyramid.update, *args, work, tables, update, spill, smooth, details)
        if spill and update.size:
            below = blocks.starts[level - 1]
            share(
                _pyramid.spill, first - below, count, below, work, blocks.neighbours,
                blocks.children, update, smooth,
            )  # fmt: skip
    return result


def inverse(smooth: Array, details: Array, blocks: Blocks, *, threads: int | None = None) -> Array:
    """The values on all blocks from those of level 0 and the details: undoes `forward`.

    Of ``smooth`` only the values of level 0 are read. Without details a level is a subdivision
    of the coarser one. O(nodes); same bits for any number of threads.
    """
    result = check_values(smooth, blocks).copy()
    details = check_values(details, blocks)
    if details.shape != result.shape or details.dtype != result.dtype:
        raise InputError(
            f"smooth and details must agree, got {result.dtype} {result.shape} and "
            f"{details.dtype} {details.shape}",
            hint="both parts of what forward gives",
        )
    build(result, details, blocks, thread_count(threads))
    return result


def build(values: Array, details: Array, blocks: Blocks, threads: int) -> None:
    """Fill all levels of ``values`` but level 0, which is there."""
    from remesh.multires import _pyramid

    result, given = layers(values, blocks), layers(details, blocks)
    work = np.empty_like(result)
    predict, update = lifting_weights(blocks, result.dtype)
    tables = _tables(blocks)
    for level in range(1, blocks.finest + 1):
        first, last = blocks.starts[level : level + 2]
        args = (last - first, threads, first)
        share(_pyramid.undo_update, *args, result, given, tables, update, work)
        share(_pyramid.predict_blocks, *args, result, work, tables, predict, False)


def restricted(values: Array, blocks: Blocks, *, threads: int | None = None) -> Array:
    """Values on blocks with those under finer blocks made consistent: restrictions of the finer.

    Active nodes keep their bits. Keeps sums as `forward` does. O(nodes).
    """
    return forward(values, blocks, threads=threads).smooth


def _tables(blocks: Blocks) -> tuple[Any, ...]:
    return blocks.neighbours, blocks.coarser, blocks.sides
