"""Fields on a box of the finest nodes, given to the blocks of an adaptive mesh."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.transform import forward
from remesh.multires.wavelets import Wavelet, get_wavelet

Array = NDArray[np.floating[Any]]


def added(
    values: Array, blocks: Blocks, field: Array, first: Sequence[int], *, threads: int | None = None
) -> Array:
    """The values on the blocks and a field that is known on a box of finest nodes, zero around it.

    ``first``: the finest node at which the box begins. Each level gets the restriction of the
    field, so what the blocks do not resolve is let go by the lifting: the moments 0 to N~ - 1 stay.
    Cost: O(box). Refuses boxes that do not lie on the mesh.
    """
    mesh = blocks.mesh
    shape = tuple(field.shape)
    if len(shape) != mesh.ndim:
        raise InputError(
            f"the box must have {mesh.ndim} axes, got a field of shape {shape}",
            hint="one scalar field",
        )
    result = values.copy()
    level = mesh.levels
    for part, start in _restrictions(field, first, get_wavelet(mesh.wavelet), level, threads):
        own = blocks.of(level)
        if own.stop > own.start:
            index = _inside(blocks, own, level, part.shape, start)
            result[own] += np.pad(part, 1)[index]
        level -= 1
    return result


def _restrictions(
    field: Array, first: Sequence[int], wavelet: Wavelet, levels: int, threads: int | None
) -> Iterator[tuple[Array, NDArray[np.int64]]]:
    """The field on each level, finest first, and the node at which it begins."""
    start = np.asarray(first, np.int64)
    yield field, start
    margin = 2 * max(len(wavelet.update), len(wavelet.predict)) + 2
    for _ in range(levels):
        low = margin + start % 2
        high = margin + (np.array(field.shape) + low + margin) % 2
        padded = np.pad(field, list(zip(low, high, strict=True)))
        grid = Grid(padded.shape, 1.0, None, "periodic")
        forward(padded, grid, wavelet, 1, out=padded, threads=threads)
        field = np.ascontiguousarray(padded[(slice(None, None, 2),) * padded.ndim])
        start = (start - low) // 2
        yield field, start


def _inside(
    blocks: Blocks, own: slice, level: int, shape: Sequence[int], start: NDArray[np.int64]
) -> tuple[NDArray[np.int64], ...]:
    """Where the nodes of some blocks lie on a box that has one more node around it, of zeros."""
    mesh = blocks.mesh
    index = []
    for axis in range(mesh.ndim):
        nodes = blocks.places[own, axis, None] * mesh.block + np.arange(mesh.block) - start[axis]
        if mesh.grid.periodic[axis]:
            nodes %= mesh.counts(level)[axis] * mesh.block
        sides = [len(nodes), *(1,) * mesh.ndim]
        sides[1 + axis] = mesh.block
        index.append((np.clip(nodes, -1, shape[axis]) + 1).reshape(sides))
    return tuple(index)
