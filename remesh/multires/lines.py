"""How a line of nodes is split level by level: which nodes go on, and its two lifting steps."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from remesh.multires.ends import Moments, keeping_update
from remesh.multires.lifting import Rows, whole, wrapped
from remesh.multires.wavelets import Wavelet


@dataclass(frozen=True, eq=False)
class Split:
    """One level of a line: ``nodes`` of which ``coarse`` go on, the others become details.

    The even nodes go on; on a line with ends the last one does too.
    """

    nodes: int
    coarse: int
    predict: Rows
    update: Rows

    @property
    def details(self) -> int:
        """Number of nodes that become details: node 2i + 1 is detail i."""
        return self.nodes - self.coarse


def coarser(nodes: int, periodic: bool) -> int:
    """Number of nodes that go on."""
    return nodes // 2 if periodic else nodes // 2 + 1


def halvings(wavelet: Wavelet, nodes: int, periodic: bool) -> int:
    """How often a line can be split: wrapped ones must be even; N nodes must be left, or N + 1."""
    count = 0
    least = max(len(wavelet.predict), len(wavelet.update)) + (not periodic)
    while not (periodic and nodes % 2) and least <= coarser(nodes, periodic) < nodes:
        nodes = coarser(nodes, periodic)
        count += 1
    return count


@lru_cache(maxsize=128)
def split_line(wavelet: Wavelet, nodes: int, periodic: bool, levels: int) -> tuple[Split, ...]:
    """The splits of a line, finest first.

    Periodic lines wrap. A line with ends keeps both end nodes on all levels, so that every
    prediction interpolates: where the number of nodes is even, the last cell of the coarser line
    is a shorter one. Nodes near an end are predicted to the same order N from those N nodes that
    give the smallest weights: a window that leans inward, and does without one of the last two
    nodes where these have come close. Updates there keep the moments of
    the finest nodes (`ends.keeping_update`).
    """
    splits = []
    finer = Moments(wavelet.moments, nodes, Fraction(nodes - 1))
    for _ in range(levels):
        coarse = coarser(nodes, periodic)
        if periodic:
            predict = wrapped(wavelet.predict, 1 - len(wavelet.predict) // 2, coarse)
            update = wrapped(wavelet.update, -(len(wavelet.update) // 2), coarse)
        else:
            predict = leaning_predict(wavelet, nodes - coarse, coarse, finer.end)
            above = finer.coarser(wavelet, predict, coarse)
            update = keeping_update(wavelet, finer, above)
            finer = above
        splits.append(Split(nodes, coarse, predict, update))
        nodes = coarse
    return tuple(splits)


def node_ages(nodes: int, periodic: bool, levels: int) -> NDArray[np.int8]:
    """For each node of a line, how many splits it goes on through, 0 to ``levels``."""
    ages = np.zeros(nodes, np.int8)
    left = np.arange(nodes)
    for _ in range(levels):
        ends = left[-1:] if not periodic and left.size % 2 == 0 else left[:0]
        left = np.concatenate([left[::2], ends])
        ages[left] += 1
    return ages


def leaning_predict(wavelet: Wavelet, details: int, coarse: int, end: Fraction) -> Rows:
    """Predictions on a line with ends; the last node sits at ``end``, in cells of this level."""
    taps = len(wavelet.predict)
    shift = 1 - taps // 2
    places = [*(Fraction(2 * k) for k in range(coarse - 1)), end]
    alike = coarse if end == 2 * (coarse - 1) else coarse - 1
    first, last = whole(taps, shift, details, alike)
    special = {}
    rows = [*range(coarse)], [*range(coarse - 2), coarse - 1]
    for i in [*range(first), *range(last, details)]:
        low, high = max(0, i + 2 - taps), min(i, coarse - taps)
        windows = [row[s : s + taps] for row in rows for s in range(min(low, high), high + 1)]
        choices = [
            (_lagrange([places[k] for k in window], Fraction(2 * i + 1)), window)
            for window in windows
            if len(window) == taps
        ]
        weights, window = min(
            choices, key=lambda choice: (sum(map(abs, choice[0])), abs(choice[1][0] - i - shift))
        )
        special[i] = dict(zip(window, weights, strict=True))
    return Rows(wavelet.predict, shift, first, last, special)


def _lagrange(places: list[Fraction], x: Fraction) -> list[Fraction]:
    """Weights of the polynomial through values at the places, at x."""
    result = []
    for k, here in enumerate(places):
        weight = Fraction(1)
        for m, other in enumerate(places):
            if m != k:
                weight *= (x - other) / (here - other)
        result.append(weight)
    return result
