"""Velocity on an adaptive mesh: a solve on the coarsest level, local corrections on finer ones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.spectral.checks import check_field
from pmesh.spectral.coarsest import CoarsestSolver
from pmesh.spectral.taps import POINTS, correction_taps
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.ghosts import layers, midpoint_weights
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.uniform import by_blocks, to_uniform
from remesh.multires.wavelets import Wavelet, get_wavelet
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
REACHES = (6, 8, 10, 12)  # nodes
LEAST = 16  # nodes along the edge of a block
MOMENTS = 2  # that the restriction keeps: with fewer the corrections reach farther than any cut
LANES = 16  # blocks corrected together
MARGIN = POINTS // 2  # nodes around the coarsest level


class AdaptiveSolver:
    """Velocity of vorticity on the blocks of an adaptive mesh, again and again.

    u_0 = K_0 * w on the coarsest level, then u_l = P u_{l-1} + D_l w_l on every block: P
    interpolates through 6 nodes along each axis and D = K_l - P K_{l-1} R is short-ranged, as the
    lifted restriction R keeps moments. K is the free-space kernel matched to the scaling functions
    of the wavelet, on the finest level to those of ``order``, so that there smooth vorticity is
    solved to that order; with a ``radius`` [finest nodes] the Gaussian-regularised kernel of that
    order, as on uniform meshes, so that what the mesh barely resolves is the same on both.
    ``reach`` cuts D off [nodes], by default as far as the mesh's tolerance allows. Where vorticity
    is as sharp as a level can hold, the cut costs about 4e-4 of the largest velocity at 8 nodes,
    4e-5 at 10 and 4e-6 at 12, in 3-D five times that; less where it is smooth. Wavelets that keep
    two moments ("4.2", "6.2") are cut less well: 2e-5 at 12 nodes. The last line of nodes before an
    upper unbounded end is extrapolated by half a coarser cell: vorticity that ends less than about
    8 nodes of a level before it is felt there. Vorticity within 6 nodes of the coarsest level
    of an end loses what its restriction carries past it.
    O(nodes), same bits for any number of threads. Refuses blocks of fewer nodes than 16, whose
    ghosts do not reach far enough, and wavelets that keep fewer than two moments, see `check_mesh`.
    Source: local corrections after Anderson, J. Comput. Phys. 62 (1986) 111.
    """

    def __init__(
        self,
        mesh: AdaptiveMesh,
        *,
        order: int = 8,
        radius: float | None = None,
        reach: int | None = None,
        threads: int | None = None,
    ) -> None:
        check_mesh(mesh)
        wavelet = get_wavelet(mesh.wavelet)
        most = mesh.block - len(wavelet.predict)
        if reach is None:
            reach = min(_reach(mesh), most)
        if reach not in REACHES or reach > most:
            raise InputError(
                f"the reach must be one of {REACHES} and at most {most} for blocks of "
                f"{mesh.block} nodes and wavelet {wavelet.name!r}, got {reach}",
                hint="reach=None takes what the tolerance asks for",
            )
        self.mesh, self.order, self.radius, self.reach = mesh, order, radius, reach
        self.threads = thread_count(threads)
        self._wavelet = wavelet

    def velocity(
        self, vorticity: Array, blocks: Blocks, *, freestream: Sequence[float] | None = None
    ) -> Array:
        """Velocity ``(ndim, *blocks.shape)`` [L/T] plus the free stream, best values on all levels.

        ``vorticity``: ``blocks.shape`` in 2-D, ``(3, *blocks.shape)`` in 3-D [1/T], float32 or
        float64. Refuses other shapes, and blocks of another mesh.
        """
        from pmesh.spectral import _corrections

        if blocks.mesh != self.mesh:
            raise InputError(
                "the blocks must be those of the solver's mesh", hint="AdaptiveSolver(blocks.mesh)"
            )
        ndim, threads = self.mesh.ndim, self.threads
        dtype = np.dtype(np.float32 if np.asarray(vorticity).dtype == np.float32 else np.float64)
        components = () if ndim == 2 else (3,)
        values = check_field(vorticity, (*components, *blocks.shape), dtype, "vorticity")
        values = np.ascontiguousarray(values)
        result = np.empty((ndim, *blocks.shape), dtype)
        coarsest = self._on_coarsest(values, blocks, freestream)
        result[:, blocks.of(0)] = by_blocks(coarsest[(slice(None), *self._inner)], self.mesh, 0)
        if blocks.finest == 0:
            return result
        sources, speed = layers(values, blocks), layers(result, blocks)
        tables = blocks.neighbours, blocks.coarser, blocks.sides
        self._correct(sources, blocks, speed)
        points = midpoint_weights(POINTS).astype(dtype)
        whole = coarsest.reshape(ndim, -1, *coarsest.shape[-2:])
        start, stop = blocks.starts[1:3]
        args = (start, speed, whole, MARGIN, blocks.places, points)
        share(_corrections.descend_first, stop - start, threads, *args)
        for level in range(2, blocks.finest + 1):
            start, stop = blocks.starts[level : level + 2]
            share(_corrections.descend, stop - start, threads, start, speed, *tables, points)
        for level in range(blocks.finest, 0, -1):
            start, stop = blocks.starts[level : level + 2]
            share(_corrections.inject, stop - start, threads, start, speed, *tables[1:])
        return result

    @cached_property
    def _inner(self) -> tuple[slice, ...]:
        """The coarsest level within its margin."""
        return (slice(MARGIN, -MARGIN),) * self.mesh.ndim

    def _on_coarsest(
        self, values: Array, blocks: Blocks, freestream: Sequence[float] | None
    ) -> Array:
        """The velocity of level 0 as on a uniform mesh, with a margin around it."""
        field, periodic = to_uniform(values, blocks, 0), self.mesh.grid.periodic
        margins = [(0, 0) if p else (MARGIN, MARGIN) for p in periodic]
        source = np.pad(field, [(0, 0)] * (field.ndim - self.mesh.ndim) + margins)
        speed = self._coarsest[values.dtype.char].velocity(source, freestream)
        if not any(periodic):
            return speed
        around = [(0, 0), *((MARGIN, MARGIN) if p else (0, 0) for p in periodic)]
        return np.pad(speed, around, mode="wrap")

    @cached_property
    def _coarsest(self) -> _Solvers:
        return _Solvers(self)

    def _correct(self, sources: Array, blocks: Blocks, out: Array) -> None:
        """D_l w_l on all blocks but the coarsest."""
        from pmesh.spectral import _corrections

        ndim, mesh = self.mesh.ndim, self.mesh
        dtype = sources.dtype
        last = blocks.starts[mesh.levels]
        groups = [_groups(blocks.starts[1], last), _groups(last, blocks.size)]
        which = np.repeat((0, 1), [len(some) for some in groups])
        tables, extents = _tables(
            self._wavelet, self.order, self.radius, ndim, self.reach, dtype.char
        )
        predict = np.array([float(w) for w in self._wavelet.predict], dtype)
        law = _corrections.correct_plane if ndim == 2 else _corrections.correct_space
        share(
            law, which.size, self.threads, np.concatenate(groups), sources,
            blocks.neighbours, blocks.coarser, blocks.sides, predict, tables, extents, which,
            blocks.spacings.astype(dtype), np.finfo(dtype).tiny / np.finfo(dtype).eps, out,
        )  # fmt: skip


def check_mesh(mesh: AdaptiveMesh) -> None:
    """Refuse meshes on which corrections are not local enough to be cut."""
    wavelet = get_wavelet(mesh.wavelet)
    if wavelet.moments < MOMENTS:
        raise InputError(
            f"local corrections of the velocity need a wavelet that keeps at least {MOMENTS} "
            f"moments, {wavelet.name!r} keeps {wavelet.moments}: what it lets go is felt far away",
            hint='AdaptiveMesh(wavelet="4.4")',
        )
    if mesh.block < LEAST:
        raise InputError(
            f"local corrections of the velocity need blocks of at least {LEAST} nodes, got "
            f"block={mesh.block}: its ghosts do not reach as far as corrections are felt",
            hint="AdaptiveMesh(block=16)",
        )


def _reach(mesh: AdaptiveMesh) -> int:
    """The least reach whose cut stays below the mesh's tolerance."""
    limits = {8: 2e-3, 10: 2e-4} if mesh.ndim == 2 else {6: 1e-2, 8: 1e-3, 10: 1e-4}
    return next((reach for reach, least in limits.items() if mesh.tolerance >= least), 12)


class _Solvers(dict[str, CoarsestSolver]):
    """The solvers of the coarsest level by precision, made when first asked for."""

    def __init__(self, owner: AdaptiveSolver) -> None:
        super().__init__()
        self.owner = owner

    def __missing__(self, kind: str) -> CoarsestSolver:
        own, inner = self.owner, self.owner.mesh.level_grid(0)
        ends = zip(inner.shape, inner.periodic, strict=True)
        shape = tuple(n if wraps else n + 2 * MARGIN for n, wraps in ends)
        grid = Grid(shape, inner.spacing, boundary=inner.boundary)
        order = own._wavelet.order
        self[kind] = CoarsestSolver(grid, order=order, dtype=kind, threads=own.threads)
        return self[kind]


def _groups(start: int, stop: int) -> NDArray[np.int64]:
    """Numbers of blocks, as many in a row as are corrected together; -1 where there are no more."""
    count = -(-(stop - start) // LANES)
    numbers = np.full(count * LANES, -1, np.int64)
    numbers[: stop - start] = np.arange(start, stop)
    return numbers.reshape(count, LANES)


@lru_cache(maxsize=16)
def _tables(
    wavelet: Wavelet, order: int, radius: float | None, ndim: int, reach: int, kind: str
) -> tuple[Array, NDArray[np.int64]]:
    """Taps as the loops take them, for all levels but the finest [0] and for that [1]; extents."""
    m = np.arange(reach + 1)
    squares = np.asarray(sum(np.ix_(*(m**2,) * (ndim - 1))))
    lengths = np.floor(np.sqrt(np.maximum((reach + 0.5) ** 2 - squares, 0)))
    extents = np.where(squares > (reach + 0.5) ** 2, -1, (lengths + 1) // 2).astype(np.int64)
    tables = [
        _by_slots(correction_taps(wavelet, *kernel), extents, reach)
        for kernel in ((wavelet.order, ndim, reach), (order, ndim, reach, radius))
    ]
    return np.ascontiguousarray(np.stack(tables), dtype=kind), extents


def _by_slots(
    taps: dict[tuple[int, ...], NDArray[np.float64]], extents: NDArray[np.int64], reach: int
) -> NDArray[np.float64]:
    """[parities of rows][component][m..][phase of the source][parity of the target][slot].

    In 2-D the components are those of the velocity, d_1 G and -d_0 G; in 3-D those of grad G.
    Rows m and -m come as their sum or difference: the taps of the middle row, which is then
    twice itself, are halved.
    """
    ndim = next(iter(taps.values())).ndim
    axes = (1, 0) if ndim == 2 else (0, 1, 2)
    slots = (2 * int(extents.max()) + 4) // 4 * 4
    rows = (2,) * (ndim - 1)
    result = np.zeros((*rows, len(axes), *extents.shape, 2, 2, slots))
    half = np.ones(reach + 1)
    half[0] = 0.5
    shares = half if ndim == 2 else np.multiply.outer(half, half)
    for parity in taps:
        own = parity[-1]
        for c, axis in enumerate(axes):
            swapped = list(parity)
            swapped[0], swapped[axis] = swapped[axis], swapped[0]
            values = np.swapaxes(taps[tuple(swapped)], 0, axis)
            values = values * (-1.0 if ndim == 2 and axis == 0 else 1.0)
            ahead = values[(slice(reach, None),) * (ndim - 1)] * shares[..., None]
            for place in np.ndindex(*extents.shape):
                for m in range(-reach, reach + 1):
                    phase = (own + m) % 2
                    slot = (own + m - phase) // 2 + extents[place]
                    if ahead[place][m + reach] != 0:
                        index = (*parity[:-1], c, *place, phase, own, slot)
                        result[index] = ahead[place][m + reach]
    return result
