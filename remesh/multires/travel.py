"""Particles of an adaptive mesh on their way: remeshed level by level where they land."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.kernels import Kernel, get_kernel
from remesh.layout import split
from remesh.multires.blocks import ABSENT, OUTSIDE, Blocks, layout
from remesh.multires.ghosts import check_values, prediction
from remesh.multires.leaving import at_ends, coarsest_sums, matter
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
from remesh.multires.pyramid import restricted
from remesh.multires.wavelets import get_wavelet
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
ENDS = 2  # layers of particles along the end of a region that tell where it ends once moved
ROOM = 100  # nodes that a block's particles may reach together, per particle


class Carried(NamedTuple):
    """Values on the target's blocks, and the strength [Q] that left through unbounded ends."""

    values: Array
    lost: Array


def carried(
    values: Array,
    displacement: Array,
    blocks: Blocks,
    target: Blocks,
    kernel: str | Kernel = "M6'",
    *,
    threads: int | None = None,
) -> Carried:
    """Move the particles of all levels and remesh each level on the blocks of ``target``.

    ``values`` ``([c,] *blocks.shape)`` [Q/L^ndim], consistent as `pyramid.restricted` leaves them;
    ``displacement`` ``(ndim, *blocks.shape)`` [L], any number of cells. Level by level the nodes
    of a block are particles that give their strength to the nodes of their level. Where a moved
    region of a level ends, and where the target goes on beyond it, values are the subdivision of
    the coarser level, right to what its details there are, below the tolerance of the mesh; so
    are the sums then. On one uniform level this is `advect_nodes` and keeps the kernel's moments.
    ``lost`` has shape ``()`` or ``(c,)``: what the coarsest level's particles put beyond unbounded
    ends; where finer blocks that touch or reach an end hold more than the tolerance, what the
    coarsest level's sum fell by, so that both together stay. Cost: O(blocks). Same bits for any
    number of threads. Refuses displacements that are not finite, and those that tear the particles
    of a block apart.
    Source: level-by-level remeshing as in Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5
    (2006) 980.
    """
    given = check_values(values, blocks)
    moves = check_displacement(displacement, blocks).astype(given.dtype, copy=False)
    if target.mesh != blocks.mesh:
        raise InputError("blocks and target must be of one mesh", hint="landing(blocks, ...)")
    way = _Way(moves, blocks, target, get_kernel(kernel), thread_count(threads))
    parts = as_blocks(given, blocks)
    result: Array = np.empty((*given.shape[: -len(blocks.shape)], *target.shape), given.dtype)
    lost = np.zeros(len(parts))
    marked = way.incomplete()
    for part, (source, out) in enumerate(zip(parts, as_blocks(result, target), strict=True)):
        lost[part] = way.remesh(source, out)
        way.fill(marked, out)
    kept = restricted(result, target, threads=threads)
    refined = matter(given, blocks, at_ends(blocks) | way.leave())
    refined |= matter(kept, target, at_ends(target))
    if refined.any():
        lost = np.where(refined, coarsest_sums(given, blocks) - coarsest_sums(kept, target), lost)
    volume = blocks.mesh.spacing(0) ** blocks.mesh.ndim
    return Carried(kept, volume * lost.reshape(result.shape[: -len(target.shape)]))


class _Way:
    """Where the particles land: the tile of each block, and which tiles reach which target."""

    def __init__(
        self, moves: Array, blocks: Blocks, target: Blocks, kernel: Kernel, threads: int
    ) -> None:
        from remesh.multires import _travel

        mesh = blocks.mesh
        self.blocks, self.target, self.threads = blocks, target, threads
        self.moves = as_blocks(moves, blocks)
        self.wraps = as_three(mesh.grid.periodic, False)
        self.inverse = inverse_spacings(blocks, moves.dtype)
        self.tables = tables(kernel, mesh.ndim, moves.dtype)
        self.edges = np.array(self.moves.shape[2:])
        reached = np.where(self.edges > 1, kernel.width, 1)
        self.shifts = np.empty((blocks.size, 3), np.int64)
        high = np.empty((blocks.size, 3), np.int64)
        bad = np.zeros(blocks.size, bool)
        self.share(
            _travel.reach, blocks, self.moves, self.inverse, self.tables[4], self.shifts, high, bad
        )
        refuse_far(int(bad.any()))
        self.sizes = high - self.shifts + reached
        room = float(self.sizes.astype(np.float64).prod(axis=1).sum())
        if room > ROOM * blocks.size * self.edges.prod():
            raise InputError(
                "displacement tears neighbouring particles apart: together those of a block reach "
                f"{room / blocks.size:.3g} nodes on average",
                hint="a smaller time step: dt * max|grad u| below 1",
            )
        self.offsets = np.concatenate([[0], np.cumsum(self.sizes.prod(axis=1))])
        self.low = (
            first_places(blocks) * self.edges + self.shifts - (reached // 2 - 1) * (reached > 1)
        )
        self.counts = block_counts(mesh)
        self.heads, self.pairs = self.meetings()

    def share(self, work: Any, blocks: Blocks, *arguments: Any) -> None:
        """Do the work on all blocks, in pieces."""
        size, pieces = split(blocks.size)
        share(work, pieces, self.threads, size, *arguments)

    def meetings(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The tiles that reach each target, ``pairs[heads[t]:heads[t + 1]]``."""
        from remesh.multires import _travel

        target = self.target
        offsets = layout(target.mesh)[2]
        heads = np.zeros(target.size + 1, np.int64)
        pairs = np.empty((0, 4), np.int64)
        for _ in range(2):
            _travel.meetings(
                self.low, self.sizes, self.blocks.levels, self.edges, self.counts, offsets,
                self.wraps, *target.table, heads, pairs,
            )  # fmt: skip
            if pairs.size:
                break
            np.cumsum(heads, out=heads)
            pairs = np.empty((heads[-1], 4), np.int64)
        heads[1:] = heads[:-1]
        heads[0] = 0
        return heads, pairs

    def remesh(self, source: Array, out: Array) -> float:
        """One component remeshed on each level; returns the sum that left the coarsest one."""
        from remesh.multires import _travel

        tiles = np.empty(self.offsets[-1], source.dtype)
        coeffs, taps, mid, terms, numbers = self.tables
        self.share(
            _travel.scatter, self.blocks, source, self.moves, self.inverse, numbers, coeffs, taps,
            mid, terms, self.shifts, self.sizes, self.offsets, tiles,
        )  # fmt: skip
        self.share(
            _travel.collect, self.target, self.heads, self.pairs, self.sizes, self.offsets, tiles,
            out,
        )  # fmt: skip
        coarse, nodes = self.blocks.of(0), self.counts[0] * self.edges
        tables = (self.low[coarse], self.sizes[coarse], self.offsets)
        return float(_travel.beyond(*tables, tiles, nodes, self.wraps))

    def leave(self) -> NDArray[np.bool_]:
        """Which blocks' particles reach beyond unbounded ends."""
        nodes = (self.counts * self.edges)[self.blocks.levels]
        over = (self.low < 0) | (self.low + self.sizes > nodes)
        return np.asarray((over & ~self.wraps).any(axis=1))

    def incomplete(self) -> NDArray[np.bool_]:
        """Which nodes of the target are to be predicted from the coarser level."""
        from remesh.multires import _rim

        blocks, target = self.blocks, self.target
        ends = (blocks.neighbours == ABSENT).any(axis=1)
        sources = np.zeros(blocks.size, bool)
        _rim.concerned(self.heads, self.pairs, ends, sources)
        tiles = np.empty(self.offsets[-1] if sources.any() else 0, np.uint8)
        if sources.any():
            self.share(
                _rim.mark, blocks, sources, blocks.neighbours, ABSENT, ENDS, self.moves,
                self.inverse, len(self.tables[1]), self.shifts, self.sizes, self.offsets, tiles,
            )  # fmt: skip
        wavelet = get_wavelet(blocks.mesh.wavelet)
        depth = min(len(wavelet.predict) + len(wavelet.update) - 2, blocks.mesh.block)
        whole = np.diff(blocks.starts) == self.counts.prod(axis=1)
        mask = np.zeros((target.size, *self.edges), bool)
        self.share(
            _rim.incomplete, target, whole, target.levels, self.heads, self.pairs, ends,
            target.neighbours, ABSENT, depth, self.sizes, self.offsets, tiles, mask,
        )  # fmt: skip
        return mask

    def fill(self, marked: NDArray[np.bool_], out: Array) -> None:
        """Predict the marked nodes from the next coarser level, level by level."""
        from remesh.multires import _rim

        target = self.target
        weights = prediction(target, None, out.dtype)
        for level in range(1, target.finest + 1):
            own = target.of(level)
            size, pieces = split(own.stop - own.start)
            share(
                _rim.fill, pieces, self.threads, size, own.start, own.stop, marked, target.places,
                target.coarser, OUTSIDE, weights, out,
            )  # fmt: skip
