"""What lies beyond a band: runs of nodes along rows that are inside or outside as a whole."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


class Runs(NamedTuple):
    """Runs of nodes without band between two places of a row; rows go along the last axis."""

    row: Nodes  # which row
    first: Nodes  # first node of the run
    stop: Nodes  # the node after its last
    inside: NDArray[np.bool_]


def runs(nodes: Nodes, values: Array, grid: Grid) -> Runs:
    """All runs beyond the band, their side as their neighbours' in the band.

    Rows without band have the side of the next row. Cost: that of the nodes and of the rows.
    An empty band has no inside. Refuses a band with a hole where the side changes.
    """
    length = grid.shape[-1]
    count = math.prod(grid.shape[:-1])
    row, place = np.divmod(nodes, length)
    inside = np.asarray(values) < 0
    begins = np.ones(len(nodes), bool)
    begins[1:] = row[1:] != row[:-1]
    ends = np.roll(begins, -1) if len(nodes) else begins
    between = ~begins[1:] & (np.diff(place) > 1)
    left = np.flatnonzero(between)
    if (inside[left] != inside[left + 1]).any():
        raise InputError(
            "the contour crosses where the level set is unknown: the band has a hole",
            hint="a wider band, at least two nodes on each side of the contour",
        )
    known = np.zeros(count, bool)
    side = np.zeros(count, bool)
    known[row[begins]] = True
    side[row[begins]] = inside[begins]
    empty = np.flatnonzero(~known)
    _spread(side, known, grid.shape[:-1])
    parts = [
        (row[left], place[left] + 1, place[left + 1], inside[left]),
        (row[begins], np.zeros_like(row[begins]), place[begins], inside[begins]),
        (row[ends], place[ends] + 1, np.full_like(row[ends], length), inside[ends]),
        (empty, np.zeros_like(empty), np.full_like(empty, length), side[empty]),
    ]
    return Runs(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def filled(nodes: Nodes, values: Array, grid: Grid, beyond: float) -> Array:
    """The level set on all nodes: +-``beyond`` outside the band, by the side that they are on."""
    steps = np.zeros(grid.size + 1, np.int8)
    found = runs(nodes, values, grid)
    start = found.row[found.inside] * grid.shape[-1]
    np.add.at(steps, start + found.first[found.inside], 1)
    np.add.at(steps, start + found.stop[found.inside], -1)
    field = np.where(np.cumsum(steps[:-1], dtype=np.int8) > 0, -beyond, beyond).astype(values.dtype)
    field[nodes] = values
    return field.reshape(grid.shape)


def _spread(side: NDArray[np.bool_], known: NDArray[np.bool_], shape: tuple[int, ...]) -> None:
    """Give rows without band the side of the nearest row before them, else of the first after."""
    sides, knowns = side.reshape(shape), known.reshape(shape)
    for axis in reversed(range(len(shape))):
        lines = np.moveaxis(sides, axis, -1)
        found = np.moveaxis(knowns, axis, -1)
        before = np.maximum.accumulate(np.where(found, np.arange(shape[axis]), -1), axis=-1)
        before = np.where(before < 0, found.argmax(axis=-1, keepdims=True), before)
        lines[...] = np.take_along_axis(lines, before, axis=-1)
        found[...] = found.any(axis=-1, keepdims=True)
