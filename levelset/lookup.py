"""Remeshing of a band of particles: every node looks up, through their map, what it gets."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset import _lattice, _layers, _lookup
from levelset.band import Band
from levelset.nodal import axes
from levelset.profile import LEVEL
from levelset.scratch import borrow, give_back
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.layout import split, tables
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
CORE = 0.6  # of the level value: nodes below it make the band, whether the contour is near or not,
OUTER = 0.75  # and nodes around them out to this part of the half width (97 % of the level value)
INNER = 0.34  # from this one, where the profile has the value of the core, and what a kernel needs.
LEAST = 0.8  # of the level value, of nodes that are new at the edge: they make no band of their own


class Lattice:
    """Particles by their home nodes: where each has gone, and what it carries."""

    def __init__(
        self, grid: Grid, nodes: Nodes, positions: Array, values: Array, threads: int | None = None
    ) -> None:
        self.grid, self.nodes = grid, nodes
        self.threads = thread_count(threads)
        self.shape, self.wraps = map(np.array, axes(grid))
        self.mid = (0, 0) if grid.ndim == 3 else (0,)  # corners of a cell along the middle axis
        mesh = tuple(int(n) for n in self.shape)
        self.known = borrow("known", mesh, np.uint8)  # zero but at the nodes
        self.fields = borrow("fields", (*mesh, grid.ndim + 1), np.float64)  # displacement, value
        self.size, self.pieces = split(len(nodes))
        local: Array = (positions - np.array(grid.origin)) / grid.spacing
        share(
            _lookup.lay, self.pieces, self.threads, self.size, nodes, local, values,
            self.shape, self.known, self.fields,
        )  # fmt: skip

    def distortion(self) -> float:
        """Largest |ln(principal stretch)| over the cells between particles; infinite if folded.

        Of the gradient in the middle of each cell. Zero for translations and rotations, however
        large.
        """
        grams = np.empty((len(self.nodes), 3, 3))
        folds = np.zeros(self.pieces, np.int64)
        share(
            _lattice.principal, self.pieces, self.threads, self.size, self.nodes, self.shape,
            self.wraps, self.known, self.fields, self.mid, grams, folds,
        )  # fmt: skip
        if folds.any():
            return math.inf
        if self.grid.ndim == 2:  # closed form: many times faster than a decomposition per cell
            a, b, c = grams[:, 0, 0], grams[:, 0, 2], grams[:, 2, 2]
            middle, half = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
            squares: Array = np.stack([middle - half, middle + half])
        else:
            squares = np.linalg.eigvalsh(grams)
        stretches = 0.5 * np.log(np.maximum(squares, np.finfo(float).tiny))
        return float(np.abs(stretches).max(initial=0.0))

    def gradient(self, velocities: Array) -> float:
        """Largest row sum max_i sum_j |du_i/dx_j| [1/T] over the cells between particles.

        ``velocities`` ``(n, ndim)`` [L/T], of the particles where they are.
        """
        rates = np.zeros_like(self.fields)
        moved = places(self.grid, self.nodes) + velocities
        local: Array = (moved - np.array(self.grid.origin)) / self.grid.spacing
        share(
            _lookup.lay, self.pieces, self.threads, self.size, self.nodes, local,
            np.zeros(len(self.nodes)), self.shape, self.known, rates,
        )  # fmt: skip
        largest = np.zeros(self.pieces)
        share(
            _lattice.strain, self.pieces, self.threads, self.size, self.nodes, self.shape,
            self.wraps, self.known, self.fields, rates, self.mid, largest,
        )  # fmt: skip
        return float(largest.max(initial=0.0))

    def look_up(self, kernel: str | Kernel, level: float, cells: Nodes | None = None) -> Looked:
        """The values where the nodes are, those of the level parts +-``level``.

        Told by all cells between particles, or by those that begin at the nodes ``cells``.
        """
        _, coeffs, taps, mid, terms = tables(kernel, self.grid, np.dtype(np.float64))
        begins = self.nodes if cells is None else cells
        size, pieces = split(len(begins))
        counts = np.zeros(pieces, np.int64)
        folds = np.zeros(pieces, np.int64)
        room = 2 * size + 64
        while True:
            found = np.empty((pieces, room), np.int64)
            values = np.empty((pieces, room))
            share(
                _lookup.look_up, pieces, self.threads, size, begins, self.shape,
                self.wraps, self.known, self.fields, level, coeffs, taps, mid, self.mid, terms,
                found, values, counts, folds,
            )  # fmt: skip
            if counts.max(initial=0) <= room:
                break
            room = int(counts.max())
        marks = borrow("marks", (self.grid.size,), np.uint8)
        field = borrow("field", (self.grid.size,), np.float64)
        nodes = np.empty(int(counts.sum()), np.int64)
        total = _lookup.merge(found, values, counts, marks, field, nodes)
        return Looked(self, nodes[:total], field, marks, int(folds.sum()))

    def close(self) -> None:
        """Let others use its scratch; it is no more."""
        self.known.reshape(-1)[self.nodes] = 0
        give_back("known", self.known)
        give_back("fields", self.fields)


class Looked(NamedTuple):
    """Nodes that the particles' map reaches, with their values in a field of the mesh."""

    lattice: Lattice
    nodes: Nodes
    field: Array
    marks: NDArray[np.uint8]  # 1 where the field is known
    folds: int  # cells that are turned inside out

    def close(self, band: Band) -> None:
        """Let others use its scratch, and that of its lattice, after a band was made of it."""
        self.marks[self.nodes] = 0
        self.marks[band.nodes] = 0
        give_back("marks", self.marks)
        give_back("field", self.field)
        self.lattice.close()


def remeshed(
    grid: Grid,
    nodes: Nodes,
    positions: Array,
    values: Array,
    kernel: str | Kernel,
    width: float,
    *,
    threads: int | None = None,
) -> Band:
    """Particles that left their home ``nodes``, remeshed: a band of nodes around the interface.

    ``positions`` ``(n, ndim)`` [L], ``values`` ``(n,)`` of the profile of half width ``width`` [L].
    A node takes the value of the place that the particles' map brings to it: x(X) is interpolated
    by the kernel between the particles' homes X and solved for the node by Newton, the value is
    interpolated at X. Exact for maps and values that are polynomials of degree kernel.moments;
    order kernel.moments + 1 for each remeshing, however large the (invertible) deformation.
    Same bits for any number of threads. Cost: O(n). Refuses particles that have crossed each other.
    """
    lattice = Lattice(grid, nodes, positions, values, threads)
    found = lattice.look_up(kernel, LEVEL * width)
    if found.folds:
        raise InputError(
            f"particles have crossed each other in {found.folds} cells of their lattice",
            hint="a smaller dt or `deformation`, or remeshing more often",
        )
    half = get_kernel(kernel).half_width
    band = around(found.nodes, found.field, found.marks, grid, width, half)
    found.close(band)
    return band


def around(
    nodes: Nodes, field: Array, marks: NDArray[np.uint8], grid: Grid, width: float, more: int,
    also: Nodes | None = None,
) -> Band:  # fmt: skip
    """The band of nodes around the interface of a field, as wide as its profile and ``more`` nodes.

    A filament too thin to change a sign stays in it as a dip, and may come back.

    ``marks``: 1 at the ``nodes``, where the flat ``field`` is known; both are used up.
    ``also``: nodes that the band is to be around as well.
    """
    shape, wraps = map(np.array, axes(grid))
    core = np.empty(len(nodes), np.int64)
    bound = CORE * LEVEL * width
    count = _layers.select(nodes, field, marks, bound, shape, wraps, core)
    if also is not None:
        core = np.union1d(core[:count], also)
        count = len(core)
    layers = math.ceil((OUTER - INNER) * width / grid.spacing) + more
    room = min(grid.size, 4 * len(nodes) + 1024)
    while True:
        wide = np.empty(room, np.int64)
        total = _layers.widen(
            core, count, layers, shape, wraps, marks, field, LEVEL * width, LEAST, wide
        )
        if total >= 0:
            break
        marks[wide] = 1
        room = min(grid.size, 2 * room)
    kept = np.empty(total, np.int64)
    starts = np.zeros(grid.size // grid.shape[-1] + 1, np.int64)
    _layers.order(wide, total, grid.shape[-1], starts, kept)
    return Band(grid, kept, field[kept])


def places(grid: Grid, nodes: Nodes) -> Array:
    """Where nodes are, (n, ndim) [L]."""
    indices = np.unravel_index(nodes, grid.shape)
    return np.stack(
        [x0 + grid.spacing * i for x0, i in zip(grid.origin, indices, strict=True)], axis=1
    )
