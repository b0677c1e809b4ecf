"""Rows of a lifting step: a gather from one half of a line of nodes to the other."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Row = dict[int, Fraction]


@dataclass(frozen=True, eq=False)
class Rows:
    """target_i += sum_k weight_k source_k, for each i.

    Rows ``first`` to ``last`` - 1 all have the same ``weights``, on the sources from i + ``shift``
    on. The others are ``special``: row number to sources and their weights.
    """

    weights: tuple[Fraction, ...]
    shift: int
    first: int
    last: int
    special: dict[int, Row]

    def arguments(self, dtype: np.dtype[Any]) -> tuple[Any, ...]:
        """As compiled loops take it: weights, shift, first, last, and special rows."""
        index = np.array(sorted(self.special), np.int64)
        entries = [sorted(self.special[i].items()) for i in index.tolist()]
        starts = np.cumsum([0, *map(len, entries)]).astype(np.int64)
        columns = np.array([k for row in entries for k, _ in row], np.int64)
        values = np.array([float(w) for row in entries for _, w in row], dtype)
        weights = np.array([float(w) for w in self.weights], dtype)
        return weights, self.shift, self.first, self.last, index, starts, columns, values

    def matrix(self, targets: int, sources: int) -> NDArray[np.float64]:
        """The same as a dense matrix: the text that the compiled loops are tested against."""
        result = np.zeros((targets, sources))
        for i in range(self.first, self.last):
            for k, weight in enumerate(self.weights):
                result[i, i + self.shift + k] = float(weight)
        for i, row in self.special.items():
            for k, weight in row.items():
                result[i, k] = float(weight)
        return result


def whole(taps: int, shift: int, targets: int, sources: int) -> tuple[int, int]:
    """First and last + 1 of the rows whose taps all lie on the line."""
    first = min(max(0, -shift), targets)
    return first, max(first, min(targets, sources - shift - taps + 1))


def wrapped(weights: tuple[Fraction, ...], shift: int, count: int) -> Rows:
    """The same weights everywhere, on a line that wraps."""
    first, last = whole(len(weights), shift, count, count)
    special: dict[int, Row] = {}
    for i in [*range(first), *range(last, count)]:
        row: Row = {}
        for k, weight in enumerate(weights):
            source = (i + shift + k) % count
            row[source] = row.get(source, Fraction(0)) + weight
        special[i] = row
    return Rows(weights, shift, first, last, special if weights else {})
