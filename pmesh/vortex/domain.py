"""A mesh that follows the vorticity: it grows before anything reaches an edge, and trims rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

Array = NDArray[np.floating[Any]]

SIGNIFICANT = 1e-6  # vorticity below this part of the largest is nothing to make room for
PROJECTED = 1e-4  # the same where vorticity is projected: that leaves 1/r^3 over the whole mesh
SLAB = 65_536  # nodes looked at in one go
STRIDE = 16  # a mesh grows and shrinks by multiples of this many nodes


@dataclass(frozen=True)
class Shift:
    """Nodes added (negative: removed) before and after each axis."""

    before: tuple[int, ...]
    after: tuple[int, ...]

    def __bool__(self) -> bool:
        """Whether anything changes."""
        return any(self.before) or any(self.after)

    def covering(self, grid: Grid, box: Grid) -> Shift:
        """The same change, or more, so that the changed mesh holds a box of its lattice."""
        before, after = list(self.before), list(self.after)
        for axis, n in enumerate(grid.shape):
            if not grid.periodic[axis]:
                first = round((box.origin[axis] - grid.origin[axis]) / grid.spacing)
                before[axis] = max(before[axis], strides(-first))
                after[axis] = max(after[axis], strides(first + box.shape[axis] - n))
        return Shift(tuple(before), tuple(after))

    def grid(self, grid: Grid) -> Grid:
        """The changed mesh, on the same lattice."""
        shape = tuple(
            n + a + b for n, a, b in zip(grid.shape, self.before, self.after, strict=True)
        )
        origin = tuple(
            start - a * grid.spacing for start, a in zip(grid.origin, self.before, strict=True)
        )
        return Grid(shape, grid.spacing, origin, grid.boundary)

    def field(self, values: Array) -> Array:
        """The values on the changed mesh, zero on new nodes; component axes in front stay."""
        front = values.ndim - len(self.before)
        pads = [(0, 0)] * front
        cuts: list[slice] = [slice(None)] * front
        for axis, (a, b) in enumerate(zip(self.before, self.after, strict=True)):
            pads.append((max(a, 0), max(b, 0)))
            cuts.append(slice(max(-a, 0), values.shape[front + axis] - max(-b, 0)))
        return np.ascontiguousarray(np.pad(values[tuple(cuts)], pads))


def room(
    vorticity: Array, grid: Grid, margin: int, *, follow: bool, negligible: float = SIGNIFICANT
) -> Shift:
    """How the mesh must change so that vorticity keeps ``margin`` nodes to each unbounded edge.

    A plane mesh grows by an eighth of the axis at least, so that it seldom happens; with ``follow``
    it also lets go of ends that are at rest over more than a quarter of the axis beyond the margin.
    In space, where nodes are dear, it grows by single strides and lets go of single ones, half a
    stride in reserve. Vorticity below the part ``negligible`` of the largest is nothing to make
    room for.
    """
    profiles = _extents(vorticity, grid.ndim)
    floor = negligible * float(profiles[0].max())
    before, after = [0] * grid.ndim, [0] * grid.ndim
    if not 0.0 < floor < np.inf:  # nothing there, or nothing that is a number
        return Shift(tuple(before), tuple(after))
    for axis, n in enumerate(grid.shape):
        if grid.periodic[axis]:
            continue
        live = np.flatnonzero(profiles[axis] > floor)
        pace = _pace(n, grid.ndim)
        before[axis] = _change(int(live[0]), margin, pace, follow)
        after[axis] = _change(n - 1 - int(live[-1]), margin, pace, follow)
    return Shift(tuple(before), tuple(after))


def _extents(vorticity: Array, ndim: int) -> list[Array]:
    """Largest size of any component along each axis, over all others; slab by slab."""
    parts = vorticity if vorticity.ndim > ndim else vorticity[None]
    shape = parts.shape[1:]
    first = np.zeros(shape[0], parts.dtype)
    across = np.zeros(shape[1:], parts.dtype)
    thick = max(1, SLAB // across.size)
    for part in parts:
        for low in range(0, shape[0], thick):
            size = np.abs(part[low : low + thick])
            first[low : low + thick] = np.maximum(
                first[low : low + thick], size.reshape(len(size), -1).max(axis=1)
            )
            np.maximum(across, size.max(axis=0), out=across)
    if ndim == 2:
        return [first, across]
    return [first, across.max(axis=1), across.max(axis=0)]


class _Pace(NamedTuple):
    """How a mesh changes at an end, in nodes."""

    least: int  # added at once
    reserve: int  # kept beyond the margin by a mesh that lets go
    slack: int  # at rest beyond that before any are let go


def _pace(nodes: int, ndim: int) -> _Pace:
    """The pace of an axis."""
    if ndim == 2:
        return _Pace(nodes // 8, nodes // 8, nodes // 4)
    return _Pace(1, STRIDE // 2, STRIDE - 1)


def _change(free: int, margin: int, pace: _Pace, follow: bool) -> int:
    """Nodes to add at an end with ``free`` nodes at rest; negative to remove."""
    if free < margin:
        return strides(max(margin - free, pace.least))
    spare = free - margin - pace.reserve
    if follow and spare > pace.slack:
        return -(spare // STRIDE) * STRIDE
    return 0


def strides(nodes: float) -> int:
    """Nodes in whole strides, rounded up."""
    return math.ceil(nodes / STRIDE - 1e-9) * STRIDE
