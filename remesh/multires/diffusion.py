"""How values on an adaptive mesh spread: the heat equation's solution, each level on its own."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.layout import split
from remesh.multires.blocks import Blocks
from remesh.multires.ghosts import check_values, padded
from remesh.multires.leaving import at_ends, coarsest_sums, matter
from remesh.multires.particles import as_blocks
from remesh.multires.pyramid import restricted
from remesh.multires.wavelets import get_wavelet
from remesh.spreading import plan, stencil
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


class Spread(NamedTuple):
    """Values after they spread, and the strength [Q] that left through unbounded ends."""

    values: Array
    lost: Array


def spread(values: Array, blocks: Blocks, diffused: float, *, threads: int | None = None) -> Spread:
    """Values after the heat equation's time t, ``diffused`` = nu t [L^2].

    ``values`` ``([c,] *blocks.shape)`` [Q/L^ndim], consistent. On each level, along each axis, the
    stencil of half width w that has the moments 0 to 2w + 1 of the heat kernel, a Gaussian of
    variance 2 nu t: of order 2w (4 up to nu t = 0.4 finest spacings^2, 8 up to 0.6, 16 up to 1.3,
    24 up to 2.0), one step without error in time, no wave grows. More takes equal substeps of all
    levels. Keeps the sums on one level; across jumps of levels to the details dropped there.
    ``lost`` ``()`` or ``(c,)``: what the coarsest level's stencil takes beyond unbounded ends;
    where finer blocks at an end hold more than the tolerance, what the coarsest level's sum fell
    by, so that both together stay. O(nodes) per substep; same bits for any number of threads.
    Refuses ``diffused`` that is negative or not finite.
    """
    given = check_values(values, blocks)
    mesh = blocks.mesh
    if not (math.isfinite(diffused) and diffused >= 0):
        raise InputError(
            f"diffused must be finite and >= 0, got {diffused}", hint="viscosity * dt [L^2]"
        )
    volume = mesh.spacing(0) ** mesh.ndim
    before = coarsest_sums(given, blocks)
    lost = np.zeros_like(before)
    shape = given.shape[: -len(blocks.shape)]
    if diffused == 0:
        return Spread(given.copy(), lost.reshape(shape))
    most = mesh.block - len(get_wavelet(mesh.wavelet).predict)
    spacings = [mesh.spacing(level) for level in range(blocks.finest + 1)]
    reach, steps = plan(diffused / spacings[-1] ** 2, most)
    weights = np.array([stencil(diffused / steps / h**2, reach) for h in spacings], given.dtype)
    ends = at_ends(blocks)
    for _ in range(steps):
        refined = matter(given, blocks, ends)
        spreading = _convolved(given, blocks, weights, threads)
        given = restricted(spreading, blocks, threads=threads)
        after = coarsest_sums(given, blocks)
        if not all(mesh.grid.periodic):
            told = np.where(refined, after, coarsest_sums(spreading, blocks))
            lost += volume * (before - told)
        before = after
    return Spread(given, lost.reshape(shape))


def _convolved(values: Array, blocks: Blocks, weights: Array, threads: int | None) -> Array:
    """Each level's stencil applied along all axes."""
    from remesh.multires import _diffusion

    width = weights.shape[1] - 1
    result = np.empty_like(values)
    ghosts = padded(values, blocks, width, threads=threads)
    edge = ghosts.shape[-1]
    deep = blocks.mesh.ndim == 3
    parts = ghosts.reshape(-1, blocks.size, edge, edge if deep else 1, edge)
    size, pieces = split(blocks.size)
    for source, out in zip(parts, as_blocks(result, blocks), strict=True):
        share(
            _diffusion.convolve, pieces, thread_count(threads), size, source, width, blocks.levels,
            weights, out,
        )  # fmt: skip
    return result
