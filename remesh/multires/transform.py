"""Wavelet transforms of fields on uniform meshes: to coefficients at their own nodes, and back."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, precision, split
from remesh.multires.lines import Split, halvings, node_ages, split_line
from remesh.multires.wavelets import Wavelet, get_wavelet
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Slices = tuple[slice, ...]


def max_levels(grid: Grid, wavelet: str | Wavelet = "4.4") -> int:
    """How often the mesh can be halved along all axes.

    A periodic axis must have an even number of nodes each time; every axis keeps as many nodes as
    a step of the wavelet reads, N at least.
    """
    found = get_wavelet(wavelet)
    axes = zip(grid.shape, grid.periodic, strict=True)
    return min(halvings(found, nodes, wraps) for nodes, wraps in axes)


def forward(
    field: Array,
    grid: Grid,
    wavelet: str | Wavelet = "4.4",
    levels: int | None = None,
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Array:
    """Wavelet coefficients of a field, each at the node that it belongs to; same shape.

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)``. After L ``levels`` (by default as many as
    the mesh allows) the nodes of the coarsest mesh hold the values c^0, the others the details
    d^l of the mesh l + 1 where they first appear (`node_levels`). A tensor product of lifting steps
    along the axes; on unbounded ones the end nodes stay to the coarsest mesh and predictions
    lean inward. Details have the unit of the field and are O(h^N) where it is smooth, zero for
    polynomials of degree < N on each axis, up to the ends of unbounded axes too. The coarse
    values keep the sums of f x^a y^b z^c over the nodes for a, b, c < N~, on periodic axes for
    exponent 0. ``out`` may be the field itself. O(nodes); same bits for any number of threads.
    Refuses more levels than the mesh allows.
    Source: Sweldens, SIAM J. Math. Anal. 29 (1998) 511.
    """
    plan = _Plan(field, grid, wavelet, levels, out, threads)
    plan.sweep(plan.values, 0, True)
    return plan.result


def inverse(
    coefficients: Array,
    grid: Grid,
    wavelet: str | Wavelet = "4.4",
    levels: int | None = None,
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Array:
    """The field of wavelet coefficients: undoes `forward` with the same arguments to round-off.

    ``out`` may be ``coefficients`` itself. O(nodes); same bits for any number of threads.
    """
    plan = _Plan(coefficients, grid, wavelet, levels, out, threads)
    plan.sweep(plan.values, 0, False)
    return plan.result


def node_levels(grid: Grid, levels: int) -> NDArray[np.int8]:
    """For each node the level where it first appears: 0 for coarsest values, l + 1 for d^l."""
    result = np.zeros(grid.shape, np.int8)
    for axis, (nodes, wraps) in enumerate(zip(grid.shape, grid.periodic, strict=True)):
        first = levels - node_ages(nodes, wraps, levels)
        np.maximum(result, first.reshape(-1, *(1,) * (grid.ndim - 1 - axis)), out=result)
    return result


@lru_cache(maxsize=512)
def _steps(line: Split, dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """Both lifting steps as the compiled loops take them."""
    return line.predict.arguments(dtype), line.update.arguments(dtype)


def _kept(lines: list[Split]) -> list[tuple[Slices, Slices]]:
    """Where the nodes that go on lie on the coarser and on the finer mesh, as pairs of slices."""
    choices = []
    for line in lines:
        even = (line.nodes + 1) // 2
        sides = [(slice(0, even), slice(0, None, 2))]
        if line.coarse > even:
            sides.append((slice(even, None), slice(line.nodes - 1, None)))
        choices.append(sides)
    every = slice(None)
    return [
        ((every, *(there for there, _ in sides)), (every, *(here for _, here in sides)))
        for sides in product(*choices)
    ]


def check_levels(grid: Grid, wavelet: Wavelet, levels: int | None) -> int:
    """The number of levels asked for, or all; refuses what the mesh does not allow."""
    most = max_levels(grid, wavelet)
    if levels is None:
        return most
    if int(levels) != levels or not 0 <= levels <= most:
        raise InputError(
            f"levels must be a whole number from 0 to {most} for wavelet {wavelet.name!r} on "
            f"{grid.shape} nodes ({', '.join(grid.boundary)}), got {levels}",
            hint="periodic axes of 2^levels * n nodes; levels=None takes as many as there are",
        )
    return int(levels)


class _Plan:
    """The arguments of both transforms, checked; the splits of each axis; the array in work."""

    def __init__(
        self,
        field: Array,
        grid: Grid,
        wavelet: str | Wavelet,
        levels: int | None,
        out: Array | None,
        threads: int | None,
    ) -> None:
        values = check_field(field, grid)
        dtype = precision(values)
        if out is not None and (
            out.shape != values.shape or out.dtype != dtype or not out.flags.c_contiguous
        ):
            raise InputError(
                f"out must be a contiguous {dtype} array of shape {values.shape}, "
                f"got {out.dtype} {out.shape}",
                hint="np.empty_like(field), or the field itself",
            )
        found = get_wavelet(wavelet)
        self.levels = check_levels(grid, found, levels)
        self.splits = [
            split_line(found, nodes, wraps, self.levels)
            for nodes, wraps in zip(grid.shape, grid.periodic, strict=True)
        ]
        self.threads = thread_count(threads)
        self.result: Array = np.empty(values.shape, dtype) if out is None else out
        if self.result is not values:
            self.result[...] = values
        self.values = self.result.reshape(-1, *grid.shape)

    def sweep(self, values: Array, level: int, forward: bool) -> None:
        """This level and all coarser ones; a coarser level works on a packed copy of its nodes."""
        if level == self.levels:
            return
        axes = range(values.ndim - 1)
        if forward:
            for axis in axes:
                self.lift(values, axis, self.splits[axis][level], forward)
        if level + 1 < self.levels:
            lines = [line[level] for line in self.splits]
            packed = np.empty((values.shape[0], *(line.coarse for line in lines)), values.dtype)
            for there, here in _kept(lines):
                packed[there] = values[here]
            self.sweep(packed, level + 1, forward)
            for there, here in _kept(lines):
                values[here] = packed[there]
        if not forward:
            for axis in reversed(axes):
                self.lift(values, axis, self.splits[axis][level], forward)

    def lift(self, values: Array, axis: int, line: Split, forward: bool) -> None:
        """Both lifting steps of one axis, in place."""
        from remesh.multires import _transform

        steps = _steps(line, values.dtype)
        if axis == values.ndim - 2:
            lines = values.reshape(-1, line.nodes)
            block, pieces = split(lines.shape[0])
            share(
                _transform.along, pieces, self.threads, block, line.coarse, lines, *steps, forward
            )
            return
        part = values.reshape(-1, line.nodes, int(np.prod(values.shape[axis + 2 :])))
        pieces = part.shape[0] * -(-part.shape[2] // _transform.CHUNK)
        share(_transform.across, pieces, self.threads, line.coarse, part, *steps, forward)
