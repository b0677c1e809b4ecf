"""Closest points: for every node near a contour its foot, the nearest point of the contour."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.nodal import check_width, laid_out
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import split
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
    phi: Array | Band,
    grid: Grid | None = None,
    *,
    nodes: Nodes | None = None,
    width: float | None = None,
    threads: int | None = None,
) -> ClosestPoints:
    """The nearest point of phi = 0 to every node within ``width`` [L] of it (None: to all).

    ``phi`` has ``grid.shape`` and any slope; with ``nodes``, sorted flat indices, it is known
    there only (then ``(len(nodes),)`` will do too, or a `Band` for all three), and without
    ``width`` these are the nodes answered, as far as the contour is reached through them. The
    contour is that of the cubic interpolant: points are of order 4 off it, 3 along it. Next to it
    feet are found by Newton from the nearest crossing of a mesh line, farther out from the feet of
    neighbours, then exchanged between neighbours until no one knows a nearer one. Where Newton
    fails, at kinks, the foot slides along the contour as long as it comes nearer. Beyond an
    unbounded edge the contour goes on straight. Cost: O(nodes answered), without ``nodes`` also one
    look at every node. Same bits for any number of threads. Refuses a phi of one sign or not
    finite.
    Source: D. L. Chopp, SIAM J. Sci. Comput. 23 (2001) 230.
    """
    front = Front(phi, grid, nodes, threads)
    front.run(None if width is None else check_width(width), confined=front.gaps)
    kept = front.within(math.inf if width is None else float(width))
    return ClosestPoints(front.nodes[kept], front.points(kept), front.signed(kept))


class Front:
    """The nodes reached so far, their feet and their sides; private to the laws of this package."""

    def __init__(
        self, phi: Array | Band, grid: Grid | None, nodes: Nodes | None, threads: int | None
    ) -> None:
        laid = laid_out(phi, grid, nodes)
        self.grid, self.threads, self.dtype = laid.grid, thread_count(threads), laid.dtype
        self.flat, self.gaps = laid.flat, laid.gaps
        self.shape, self.wraps = laid.shape, laid.wraps
        self._start(laid.nodes if laid.gaps else np.empty(0, np.int64))

    def _start(self, known: Nodes) -> None:
        """The nodes that have neighbours of the other sign."""
        from levelset import _closest, _kinks

        count = len(known) if self.gaps else self.grid.size
        rows, pieces = split(count, LEAST)
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
        rows, pieces = split(self.count, LEAST)
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
        rows, pieces = split(self.count - stop, LEAST)
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
            rows, pieces = split(len(asked), LEAST)
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

        rows, pieces = split(self.count, LEAST)
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
