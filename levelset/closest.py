"""Closest points: for every node near a contour its foot, the nearest point of the contour."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.layout import PIECES, precision
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Values = NDArray[np.float64]
LEAST = 128  # nodes in a piece of work
NEAR = 2.0  # node spacings that a front goes in any case: through the cells that are crossed
DEPTH = 1e-12  # node spacings: a node inside stays inside
PASSES = 100  # of improvement, at most: a few are needed


class ClosestPoints(NamedTuple):
    """The nearest points of a contour to some nodes."""

    nodes: Nodes  # flat indices in C order, ascending
    points: Values  # (n, ndim) [L]; past a periodic edge they stay beside their node
    distance: Values  # signed, negative inside [L]


def closest_points(
    phi: Array,
    grid: Grid,
    *,
    nodes: Nodes | None = None,
    width: float | None = None,
    threads: int | None = None,
) -> ClosestPoints:
    """The nearest point of phi = 0 to every node within ``width`` [L] of it (None: to all).

    ``phi`` has ``grid.shape`` and any slope; with ``nodes``, sorted flat indices, it is known
    there only (then ``(len(nodes),)`` will do too), and without ``width`` these are the nodes
    answered, as far as the contour is reached through them. The contour is that of the cubic
    interpolant: points are of order 4 off it, 3 along it. Next to it feet are found by Newton
    from the nearest crossing of a mesh line, farther out from the feet of neighbours, then
    exchanged between neighbours until no one knows a nearer one. Where Newton fails, at kinks,
    the foot slides along the contour as long as it comes nearer. Beyond an unbounded edge the
    contour goes on straight. Cost: O(nodes answered), without ``nodes`` also one look at every
    node. Same bits for any number of threads. Refuses a phi of one sign or not finite.
    Source: D. L. Chopp, SIAM J. Sci. Comput. 23 (2001) 230.
    """
    front = Front(phi, grid, nodes, threads)
    front.run(None if width is None else check_width(width), confined=nodes is not None)
    kept = front.within(math.inf if width is None else float(width))
    return ClosestPoints(front.nodes[kept], front.points(kept), front.signed(kept))


class Front:
    """The nodes reached so far, their feet and their sides; private to the laws of this package."""

    def __init__(self, phi: Array, grid: Grid, nodes: Nodes | None, threads: int | None) -> None:
        values = np.asarray(phi)
        self.grid, self.threads, self.dtype = grid, thread_count(threads), precision(values)
        if nodes is None:
            values = check_level_set(values, grid)
            known = np.empty(0, np.int64)
            self.flat: Array = np.ascontiguousarray(values, np.float64).reshape(-1)
        else:
            known = check_nodes(nodes, grid)
            values = check_band_values(values, grid, known).astype(np.float64, copy=False)
            self.flat = scattered(values, known, grid)
        self.gaps = nodes is not None
        middle = grid.ndim == 3
        self.shape = (grid.shape[0], grid.shape[1] if middle else 1, grid.shape[-1])
        self.wraps = (grid.periodic[0], middle and grid.periodic[1], grid.periodic[-1])
        self._start(known)

    def _start(self, known: Nodes) -> None:
        """The nodes that have neighbours of the other sign."""
        from levelset import _closest, _kinks

        count = len(known) if self.gaps else self.grid.size
        rows, pieces = pieces_of(count)
        found = np.empty(count, np.int64)
        counts = np.zeros(pieces, np.int64)
        share(
            _closest.crossed, pieces, self.threads, rows, self.flat, self.shape, self.wraps,
            known, self.gaps, found, counts,
        )  # fmt: skip
        parts = [found[k * rows : k * rows + counts[k]] for k in range(pieces)]
        first = np.concatenate([found[:0], *parts])
        if not len(first):
            raise InputError(
                "phi has no interface: it is of one sign",
                hint="a level set that is negative inside a shape that the grid resolves",
            )
        self.count = len(first)
        self._nodes = first
        self._feet = np.empty((self.count, 3))
        self._away = np.empty(self.count)
        self._inside = self.flat[first] < 0
        self.slot = np.zeros(self.grid.size, np.int32)
        self.slot[first] = np.arange(1, self.count + 1, dtype=np.int32)
        self.kinds = np.zeros(self.grid.size, np.uint8)
        rows, pieces = pieces_of(self.count)
        share(
            _kinks.find_kinks, pieces, self.threads, rows, self.flat, self.shape, self.wraps,
            self.gaps, self.grid.spacing, first, self.kinds,
        )  # fmt: skip
        share(
            _closest.land_first, pieces, self.threads, rows, self.flat, self.kinds, self.shape,
            self.wraps, self.gaps, first, self._feet, self._away,
        )  # fmt: skip

    def run(self, width: float | None, *, confined: bool = False) -> None:
        """Reach all nodes within ``width`` [L], or all; ``confined``: only where phi is known."""
        reach = math.inf if width is None else max(width / self.grid.spacing, NEAR)
        confined = confined and width is None
        start, stop = 0, self.count
        while stop > start:
            start, stop = stop, self._ring(start, stop, reach, confined)
        self._improve()

    def _ring(self, start: int, stop: int, reach: float, confined: bool) -> int:
        """One ring of neighbours farther; the new length of the list."""
        from levelset import _closest

        self._grow(min(stop + 2 * self.grid.ndim * (stop - start), self.grid.size))
        self.count = _closest.advance(
            self.flat, self.shape, self.wraps, self.gaps, confined, reach, self.slot, self._nodes,
            self._inside, self._away, start, stop,
        )  # fmt: skip
        rows, pieces = pieces_of(self.count - stop)
        share(
            _closest.land_ring, pieces, self.threads, rows, self.flat, self.kinds, self.shape,
            self.wraps, self.gaps, self.slot, self._nodes, self._feet, self._away, stop, self.count,
        )  # fmt: skip
        return self.count

    def _improve(self) -> None:
        """Exchange feet between neighbours until no node learns of a nearer one."""
        from levelset import _closest

        nodes, feet, away = self.nodes, self._feet[: self.count], self._away[: self.count]
        asked = np.arange(self.count)
        marks = np.zeros(self.count, np.uint8)
        for _ in range(PASSES):
            fresh = np.empty((len(asked), 4))
            rows, pieces = pieces_of(len(asked))
            share(
                _closest.improve, pieces, self.threads, rows, self.flat, self.kinds, self.shape,
                self.wraps, self.gaps, self.slot, nodes, feet, away, asked, fresh,
            )  # fmt: skip
            asked = _closest.accept(
                self.shape, self.wraps, self.slot, nodes, feet, away, asked, fresh, marks
            )
            if not len(asked):
                return

    def keep(self) -> None:
        """Leave distances that were given where the contour, at a kink, is known no better."""
        from levelset import _closest

        rows, pieces = pieces_of(self.count)
        share(
            _closest.keep, pieces, self.threads, rows, self.flat, self.kinds, self.shape,
            self.wraps, self.gaps, self.grid.spacing, self.nodes, self._feet, self._away,
        )  # fmt: skip

    def _grow(self, length: int) -> None:
        """Room for so many nodes; the lists double, so that growth costs as much as they do."""
        if length <= len(self._nodes):
            return
        length = min(max(length, 2 * len(self._nodes)), self.grid.size)
        for name in ("_nodes", "_feet", "_away", "_inside"):
            old = getattr(self, name)
            new = np.empty((length, *old.shape[1:]), old.dtype)
            new[: self.count] = old[: self.count]
            setattr(self, name, new)

    @property
    def nodes(self) -> Nodes:
        """Flat indices of the nodes reached, in the order in which they were."""
        return self._nodes[: self.count]

    def within(self, width: float) -> Nodes:
        """Places in the list of the nodes within ``width`` [L], by ascending node."""
        places = np.flatnonzero(self._away[: self.count] <= width / self.grid.spacing)
        return places[np.argsort(self._nodes[places])]

    def signed(self, places: Nodes | slice) -> Values:
        """Signed distances [L]."""
        away, inside = self._away[: self.count][places], self._inside[: self.count][places]
        depth = np.where(inside, -np.maximum(away, DEPTH), away)
        return np.asarray(self.grid.spacing * depth)

    def points(self, places: Nodes) -> Values:
        """Positions (n, ndim) of feet [L]."""
        axes = [0, 2] if self.grid.ndim == 2 else [0, 1, 2]
        cells = np.stack(np.unravel_index(self._nodes[places], self.grid.shape), axis=1)
        offsets = self._feet[places][:, axes]
        return np.asarray(self.grid.origin + self.grid.spacing * (cells + offsets))


def pieces_of(count: int) -> tuple[int, int]:
    """Size and number of the pieces of so many nodes."""
    size = max(LEAST, -(-count // PIECES))
    return size, -(-count // size)


def check_level_set(phi: Array, grid: Grid, name: str = "phi") -> Array:
    """Refuse what is not a finite value per node."""
    if phi.shape != grid.shape:
        raise InputError(
            f"{name} must have shape {grid.shape}, got {phi.shape}", hint="one value per node"
        )
    _refuse_not_finite(phi, name)
    return phi


def check_nodes(nodes: Nodes, grid: Grid) -> Nodes:
    """Refuse what are not ascending flat indices of the grid."""
    known = np.asarray(nodes)
    if known.ndim != 1 or not np.issubdtype(known.dtype, np.integer):
        raise InputError(
            f"nodes must be flat indices of shape (n,), got {known.dtype} {known.shape}",
            hint="np.flatnonzero(abs(phi) < width)",
        )
    if len(known) and (known[0] < 0 or known[-1] >= grid.size or np.any(np.diff(known) <= 0)):
        raise InputError(
            f"nodes must ascend and lie between 0 and {grid.size - 1}", hint="np.unique(nodes)"
        )
    return known.astype(np.int64, copy=False)


def check_band_values(phi: Array, grid: Grid, nodes: Nodes, name: str = "phi") -> Array:
    """The values at the nodes; refuses other shapes and what is not finite there."""
    if phi.shape not in (grid.shape, nodes.shape):
        raise InputError(
            f"{name} must have shape {grid.shape} or {nodes.shape}, got {phi.shape}",
            hint="one value per node of the grid, or per node of the band",
        )
    values = phi if phi.shape == nodes.shape else phi.reshape(-1)[nodes]
    _refuse_not_finite(values, name)
    return values


def check_width(width: float) -> float:
    """Refuse a width that is no positive length."""
    given = as_number("width", width, hint="width=4 * grid.spacing")
    if not (math.isfinite(given) and given > 0):
        raise InputError(
            f"width must be a positive length, got {width}", hint="width=4 * grid.spacing"
        )
    return given


def scattered(values: Array, nodes: Nodes, grid: Grid) -> Array:
    """The values on the grid, unset nodes zero, known zeros tiny; as the interpolants ask."""
    from levelset._interpolant import TINY

    dtype = precision(values)
    known = np.where(values == 0, dtype.type(TINY), values).astype(dtype, copy=False)
    return Band(grid, nodes, known).on_grid().reshape(-1)


def _refuse_not_finite(values: Array, name: str) -> None:
    bad = int(np.size(values) - np.count_nonzero(np.isfinite(values)))
    if bad:
        raise InputError(
            f"{name} must be finite, it is not at {bad} of {values.size} nodes",
            hint="check the velocity that moved it",
        )
