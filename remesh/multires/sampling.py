"""Adaptive representations of fields: of laws of points, and of fields on the finest mesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.layout import check_field, precision
from remesh.multires.adapt import adapt, asked_for, scales_of, significance
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.pyramid import forward
from remesh.multires.uniform import on_blocks
from remesh.threads import thread_count

Array = NDArray[np.floating[Any]]
Law = Callable[[NDArray[np.float64]], NDArray[Any]]


def sampled(
    field: Law | Array,
    mesh: AdaptiveMesh,
    *,
    scale: float | Sequence[float] | None = None,
    least: int = 2,
    threads: int | None = None,
) -> tuple[Blocks, Array]:
    """Blocks that resolve a field to the mesh's tolerance, and its values on them.

    ``field`` is an array on ``mesh.grid``, or ``(c, *shape)``, or a law: points
    ``(ndim, ...)`` [L] to values ``(...)`` or ``(c, ...)``. A law is evaluated on all blocks up to
    level ``least``, then on finer ones wherever details are beyond the tolerance: what lies
    between the nodes of level ``least`` may be missed. `to_uniform` of the values differs from the
    field by less than 10 times tolerance * scale; an array keeps its sums as in `adapt`. With
    ``most_blocks`` of the mesh the result has no more, to a tolerance that `adapt` raised and that
    is not told here; while a law's blocks are sought there may be more.
    O(nodes of the array), or O(nodes of the result) evaluations.
    """
    count = thread_count(threads)
    if callable(field):
        blocks, values = _refined(field, mesh, scale, least, count)
    else:
        given = check_field(field, mesh.grid)
        blocks = Blocks.uniform(mesh, mesh.levels)
        values = on_blocks(given.astype(precision(given), copy=False), blocks)
    found = adapt(values, blocks, scale=scale, threads=count)
    return found.blocks, found.fields


def _refined(
    law: Law, mesh: AdaptiveMesh, scale: float | Sequence[float] | None, least: int, threads: int
) -> tuple[Blocks, Array]:
    """Blocks with a law's values, finer ones made until nothing asks for more."""
    if isinstance(least, bool) or int(least) != least or least < 1:
        raise InputError(f"least must be a whole number >= 1, got {least}", hint="least=2")
    low = mesh.thresholds[0]
    blocks = Blocks.uniform(mesh, min(int(least), mesh.levels))
    while True:
        values = _evaluated(law, blocks)
        details = forward(values, blocks, threads=threads).details
        scales = scales_of(values, blocks, scale, threads)
        cells = significance(details, blocks, scales, threads)
        keys = np.concatenate([blocks.keys, asked_for(blocks, cells, low, low)])
        finer = Blocks.of_keys(mesh, keys)
        if finer.size == blocks.size:
            return blocks, values
        blocks = finer


def _evaluated(law: Law, blocks: Blocks) -> Array:
    """A law at the nodes of blocks."""
    values = np.asarray(law(blocks.points()))
    shape = blocks.shape
    if values.shape[-len(shape) :] != shape or values.ndim not in (len(shape), len(shape) + 1):
        raise InputError(
            f"the law must give values (...) or (c, ...) for points (ndim, ...), got "
            f"{values.shape} for {(blocks.mesh.ndim, *shape)}",
            hint="lambda x: np.exp(-(x**2).sum(axis=0))",
        )
    return np.ascontiguousarray(values, precision(values))
