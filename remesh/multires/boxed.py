"""Fields on a box of the finest nodes, given to the blocks of an adaptive mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.adapt import details_on
from remesh.multires.blocks import Blocks
from remesh.multires.pyramid import build
from remesh.multires.transform import forward
from remesh.multires.wavelets import Wavelet, get_wavelet
from remesh.threads import thread_count

Array = NDArray[np.floating[Any]]


def added(
    values: Array, blocks: Blocks, field: Array, first: Sequence[int], *, threads: int | None = None
) -> Array:
    """The values on the blocks and a field that is known on a box of finest nodes, zero around it.

    ``first``: the finest node at which the box begins. Along periodic axes it goes round, also more
    than once. What the blocks cannot hold, details where
    there are none of their level and those that reach past the blocks of their level, is let go
    by the lifting: the moments 0 to N~ - 1 stay. Cost: O(box) + O(nodes). Refuses fields of other
    dimensions.
    """
    mesh, count = blocks.mesh, thread_count(threads)
    if field.ndim != mesh.ndim:
        raise InputError(
            f"the box must have {mesh.ndim} axes, got a field of shape {field.shape}",
            hint="one scalar field",
        )
    details = np.zeros(blocks.shape, values.dtype)
    start, part = np.asarray(first, np.int64), field
    for level in range(mesh.levels, 0, -1):
        part, start = _split(part, start, get_wavelet(mesh.wavelet), count)
        even = (slice(None, None, 2),) * part.ndim
        coarse = np.ascontiguousarray(part[even])
        part[even] = 0
        _give(part, start, blocks, level, details)
        part, start = coarse, start // 2
    result = np.empty(blocks.shape, values.dtype)
    _give(part, start, blocks, 0, result)
    build(result, details_on(details, blocks, blocks, count), blocks, count)
    return values + result


def _split(
    field: Array, start: NDArray[np.int64], wavelet: Wavelet, threads: int
) -> tuple[Array, NDArray[np.int64]]:
    """One level of the transform, coarse values at even nodes, and its first node."""
    margin = 2 * max(len(wavelet.update), len(wavelet.predict)) + 2
    low = margin + start % 2
    high = margin + (np.array(field.shape) + low + margin) % 2
    padded = np.pad(field, list(zip(low, high, strict=True)))
    grid = Grid(padded.shape, 1.0, None, "periodic")
    forward(padded, grid, wavelet, 1, out=padded, threads=threads)
    return padded, start - low


def _give(part: Array, start: NDArray[np.int64], blocks: Blocks, level: int, values: Array) -> None:
    """What a box holds to the blocks of a level; zero to those beside it."""
    own = blocks.of(level)
    if own.stop > own.start:
        part = _folded(part, blocks, level)
        values[own] = np.pad(part, 1)[_inside(blocks, own, level, part.shape, start)]


def _folded(part: Array, blocks: Blocks, level: int) -> Array:
    """A box no longer than the periods of a level: what goes round more than once is added up."""
    mesh = blocks.mesh
    for axis, wraps in enumerate(mesh.grid.periodic):
        period = mesh.counts(level)[axis] * mesh.block
        if wraps and part.shape[axis] > period:
            part = _wound(part, axis, period)
    return part


def _wound(part: Array, axis: int, period: int) -> Array:
    """Sum of the stretches of one period along an axis, the first one first."""
    stretches = np.moveaxis(part, axis, 0)
    result = stretches[:period].copy()
    for first in range(period, len(stretches), period):
        more = stretches[first : first + period]
        result[: len(more)] += more
    return np.moveaxis(result, 0, axis)


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
