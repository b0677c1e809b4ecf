"""A field on every second, fourth, ... node, smoothed so that what is finer does not alias."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, precision

Array = NDArray[np.floating[Any]]
HALF_BAND = ((-3, -1 / 32), (-1, 9 / 32), (0, 1 / 2), (1, 9 / 32), (3, -1 / 32))
REACH = 3  # nodes on either side that it reads


def halved(field: Array, grid: Grid, times: int = 1, first: Sequence[int] | None = None) -> Array:
    """A field on every 2^times-th node along each axis: that of ``halved_grid``.

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)``; ``first`` counts the nodes of each
    unbounded axis that lie before the first one kept (0 by default, less than 2^times). Each
    halving sums nodes along an axis by the half-band weights (-1, 0, 9, 16, 9, 0, -1) / 32: those
    by which Deslauriers & Dubuc's cubics interpolate, read the other way. They leave cubics
    unchanged and smooth fields to order 4, wipe out waves of two nodes, and keep moments: sums of
    f x^a y^b z^c times the cell volume for a, b, c < 4 (a wrapped axis: the total), of what is
    zero within 3 * 2^times nodes of unbounded edges, where lines go on point-symmetric about the
    end.
    float32 in, float32 out. Refuses what `halved_grid` refuses.
    Source: Deslauriers & Dubuc, Constr. Approx. 5 (1989) 49.
    """
    values = check_field(field, grid)
    starts = _checked(grid, times, first)
    values = values.astype(precision(values), copy=False)
    for axis, (periodic, start) in enumerate(zip(grid.periodic, starts, strict=True)):
        along = values.ndim - grid.ndim + axis
        for power in range(times):
            # before each halving the place of the first node kept is told in its own spacings
            values = _half(values, along, periodic, (start >> power) & 1)
    return np.ascontiguousarray(values)


def halved_grid(grid: Grid, times: int = 1, first: Sequence[int] | None = None) -> Grid:
    """The grid of every 2^times-th node, the same boundaries; a periodic axis keeps its length.

    Refuses periodic axes whose nodes cannot be halved so often, and fewer than 4 nodes left.
    """
    starts, step = _checked(grid, times, first), 2**times
    shape = [-(-(n - start) // step) for n, start in zip(grid.shape, starts, strict=True)]
    origin = [x + k * grid.spacing for x, k in zip(grid.origin, starts, strict=True)]
    return Grid(shape, step * grid.spacing, origin, grid.boundary)


def _checked(grid: Grid, times: int, first: Sequence[int] | None) -> tuple[int, ...]:
    """Nodes before the first one kept, per axis."""
    step = 2**times
    starts = (0,) * grid.ndim if first is None else tuple(first)
    if len(starts) != grid.ndim or not all(0 <= start < step for start in starts):
        raise InputError(
            f"first must hold {grid.ndim} counts of nodes below {step}, got {first}",
            hint=f"first={(0,) * grid.ndim}",
        )
    for axis, (nodes, wraps) in enumerate(zip(grid.shape, grid.periodic, strict=True)):
        left = -(-(nodes - starts[axis]) // step)
        if (wraps and (nodes % step or starts[axis])) or left < 4:
            rule = f"a multiple of {step}, " if wraps else ""
            raise InputError(
                f"every {step}th node of axis {axis} cannot be kept: it needs {rule}"
                f"{4 * step} nodes or more, it has {nodes}",
                hint="fewer halvings, or a grid whose nodes can be halved so often",
            )
    return starts


def _half(values: Array, along: int, periodic: bool, start: int) -> Array:
    """Every second node of one axis from ``start`` on."""
    line = np.moveaxis(values, along, 0)
    if periodic:
        ends = line[-REACH:], line[:REACH]
    else:
        reach = np.arange(1, REACH + 1)
        ends = 2 * line[:1] - line[reach[::-1]], 2 * line[-1:] - line[-1 - reach]
    line = np.concatenate([ends[0], line, ends[1]])
    count = -(-(values.shape[along] - start) // 2)
    result = np.zeros((count, *line.shape[1:]), values.dtype)
    for offset, weight in HALF_BAND:
        low = REACH + start + offset
        result += values.dtype.type(weight) * line[low : low + 2 * count - 1 : 2]
    return np.moveaxis(result, 0, along)
