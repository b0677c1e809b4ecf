"""Adaptation: blocks where fields have details, and the fields on them, moments kept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.blocks import Blocks, Places, keys_of, layout
from remesh.multires.ghosts import check_values, layers
from remesh.multires.mesh import BUFFER, CELL
from remesh.multires.pyramid import build, forward
from remesh.multires.wavelets import get_wavelet
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Cells = NDArray[np.float64]
AHEAD = 4  # nodes around a large detail that are made finer


class Adapted(NamedTuple):
    """Blocks that fit fields, the fields on them, and to what relative tolerance.

    ``busy`` tells of each cell of 4^ndim nodes, ``(n, *(block // 4,) * ndim)``, whether it holds
    details beyond the tolerance, or lies over coarser ones beyond the refinement threshold: what
    the mesh must follow when a flow carries it.
    """

    blocks: Blocks
    fields: Array
    tolerance: float
    busy: NDArray[np.bool_]


def adapt(
    fields: Array,
    blocks: Blocks,
    *,
    scale: float | Sequence[float] | None = None,
    always: Sequence[Places] | None = None,
    threads: int | None = None,
) -> Adapted:
    """Blocks where these fields ``(c, n, ...)`` or ``(n, ...)`` have details, and the fields there.

    A block stays or is made where a detail beyond ``tolerance * scale`` lies in it or within 8
    nodes of it, or where one beyond the refinement threshold of the next coarser level lies under
    it or within 4 nodes; where ``always`` asks for it (places of levels 0, 1, ...); and where
    the balance needs it. ``scale`` [unit of the fields] is one or one per field, by default
    their largest absolute value. Of ``most_blocks`` of the mesh too many, both thresholds
    are raised by the least common factor that does. Details of blocks that go, and those within
    N + N~ - 2 nodes of a coarser neighbour, are let go by the lifting: the sums over the
    coarsest nodes of f x^a y^b z^c, a, b, c < N~, stay (`pyramid.forward` with ``spill``) where
    nothing reaches the ends of the domain. O(nodes); same bits for any number of threads. Refuses
    fields that are not finite, and more blocks that are always kept than ``most_blocks``.
    Source: Rossinelli et al., J. Comput. Phys. 288 (2015) 1; Gillis & van Rees, SIAM J. Sci.
    Comput. 44 (2022) C367.
    """
    values = check_values(fields, blocks)
    count = thread_count(threads)
    scales = scales_of(values, blocks, scale, count)
    smooth, details = forward(values, blocks, spill=True, threads=count)
    cells = significance(details, blocks, scales, count)
    kept = np.empty(0, np.int64) if always is None else keys_of(blocks.mesh, always)
    target, factor = _target(blocks, cells, kept)
    low, high = (factor * threshold for threshold in blocks.mesh.thresholds)
    if np.array_equal(target.keys, blocks.keys):
        target = blocks
    rest = details_on(details, blocks, target, count)
    result = np.empty_like(rest)
    coarsest = blocks.of(0)
    layers(result, target)[:, coarsest] = layers(smooth, blocks)[:, coarsest]
    build(result, rest, target, count)
    found = significance(rest, target, scales, count)
    return Adapted(target, result, low, (found > low) | _ahead(found > high, target))


def scales_of(
    values: Array, blocks: Blocks, scale: float | Sequence[float] | None, threads: int
) -> NDArray[np.float64]:
    """What tolerances are relative to, one per component; zero for a field that is zero."""
    from remesh.multires import _adapt

    parts = layers(values, blocks)
    found = np.empty((len(parts), blocks.size), values.dtype)
    share(_adapt.largest, blocks.size, threads, parts, blocks.children, found)
    largest: NDArray[np.float64] = found.max(axis=1).astype(np.float64)
    if not np.isfinite(largest).all():
        raise InputError(
            "fields must be finite, they are not at some nodes", hint="np.isfinite(fields).all()"
        )
    if scale is not None:
        given = np.atleast_1d(np.asarray(scale, np.float64))
        if given.shape not in ((1,), (len(parts),)) or not (np.isfinite(given) & (given > 0)).all():
            raise InputError(
                f"scale must be one positive number or {len(parts)}, one per component, got "
                f"{scale}",
                hint="scale=None takes the largest absolute value of each field",
            )
        return np.repeat(given, len(parts) // given.size)
    return largest


def significance(
    details: Array, blocks: Blocks, scales: NDArray[np.float64], threads: int
) -> Cells:
    """Largest detail of each cell of 4^ndim nodes over all fields, relative to their scales."""
    from remesh.multires import _adapt

    mesh = blocks.mesh
    cells = np.empty((blocks.size, *(mesh.block // CELL,) * mesh.ndim))
    inverse = np.divide(1.0, scales, out=np.zeros_like(scales), where=scales > 0)
    share(
        _adapt.weigh, blocks.size, threads, layers(details, blocks), inverse,
        layers(cells, blocks)[0],
    )  # fmt: skip
    return cells


def asked_for(blocks: Blocks, cells: Cells, low: float, high: float) -> NDArray[np.int64]:
    """Keys of the blocks that these cells ask for with these thresholds, buffers included."""
    from remesh.multires import _adapt

    found: NDArray[np.int64] = _adapt.mark(
        layers(cells, blocks)[0], blocks.mesh.block, blocks.places, blocks.levels,
        layout(blocks.mesh), low, high, (BUFFER, AHEAD),
    )  # fmt: skip
    return found


def _target(blocks: Blocks, cells: Cells, kept: NDArray[np.int64]) -> tuple[Blocks, float]:
    """The blocks that the cells ask for, and by what factor the thresholds were raised."""
    mesh = blocks.mesh
    low, high = mesh.thresholds

    def raised(factor: float) -> Blocks:
        keys = asked_for(blocks, cells, factor * low, factor * high)
        return Blocks.of_keys(mesh, np.concatenate([keys, kept]))

    found = raised(1.0)
    most = mesh.most_blocks
    if most is None or found.size <= most:
        return found, 1.0
    least = Blocks.of_keys(mesh, kept)
    if least.size > most:
        raise InputError(
            f"the {least.size} blocks that are always kept are more than most_blocks {most}",
            hint="a larger most_blocks, or fewer levels",
        )
    factors = np.unique(np.concatenate([cells.ravel() / low, cells.ravel() / high]))
    factors = np.nextafter(factors[factors >= 1], np.inf)  # the product is no less than the cell
    below, fits = -1, len(factors) - 1
    while fits - below > 1:
        middle = (below + fits) // 2
        if raised(float(factors[middle])).size <= most:
            fits = middle
        else:
            below = middle
    return raised(float(factors[fits])), float(factors[fits])


def _ahead(large: NDArray[np.bool_], blocks: Blocks) -> NDArray[np.bool_]:
    """Which cells lie over coarser ones that are marked: there details may come next."""
    result = np.zeros_like(large)
    ndim, cells = blocks.mesh.ndim, large.shape[1]
    own = slice(blocks.starts[1], None)
    index: list[Any] = [blocks.coarser[own, 3**ndim // 2].reshape(-1, *(1,) * ndim)]
    for axis in range(ndim):
        half = blocks.places[own, axis, None] % 2 * (cells // 2) + np.arange(cells) // 2
        index.append(half.reshape(-1, *(cells if k == axis else 1 for k in range(ndim))))
    result[own] = large[tuple(index)]
    return result


def details_on(details: Array, blocks: Blocks, target: Blocks, threads: int) -> Array:
    """Details on other blocks, without those whose lifting steps reach past a level's blocks."""
    from remesh.multires import _adapt

    result = np.empty((*details.shape[: -len(blocks.shape)], *target.shape), details.dtype)
    wavelet = get_wavelet(blocks.mesh.wavelet)
    reach = max(len(wavelet.update) - 1, 0) + len(wavelet.predict) - 1
    share(
        _adapt.carry, target.size, threads, layers(details, blocks), target.found_in(blocks),
        target.neighbours, reach, layers(result, target),
    )  # fmt: skip
    return result
