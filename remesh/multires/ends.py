"""Updates near the ends of a line, from the moments of the scaling functions there."""

from __future__ import annotations

from fractions import Fraction

from remesh.multires.lifting import Row, Rows, whole
from remesh.multires.wavelets import Wavelet

EXTRA = 2  # nodes an update near an end has to choose from, beyond the N~ that it needs
Powers = tuple[Fraction, ...]


class Moments:
    """Moments sum_i x_i^a zeta_k(x_i), a < N~, of the scaling functions of one level, exactly.

    The sum is over the finest nodes and x counts them. Away from the ends the moments are
    s (s k)^a with s the ``step`` of this level; where they are not, ``near`` holds them. ``end`` is
    where the last node sits, in steps.
    """

    def __init__(self, count: int, nodes: int, end: Fraction, step: int = 1) -> None:
        self.count, self.nodes, self.end, self.step = count, nodes, end, step
        self.near: dict[int, Powers] = {}

    def regular(self, k: int) -> Powers:
        """What they are away from the ends."""
        return tuple(Fraction(self.step * (self.step * k) ** a) for a in range(self.count))

    def __getitem__(self, k: int) -> Powers:
        """Those of function k."""
        return self.near.get(k) or self.regular(k)

    def coarser(self, wavelet: Wavelet, predict: Rows, coarse: int) -> Moments:
        """Those one level up: a coarse function is its node and its share of the details' nodes."""
        result = Moments(self.count, coarse, self.end / 2, 2 * self.step)
        if not self.count:
            return result
        shares: dict[int, list[tuple[int, Fraction]]] = {}
        for i, row in predict.special.items():
            for k, weight in row.items():
                shares.setdefault(k, []).append((i, weight))
        reach = len(wavelet.predict)
        around = {*(k // 2 for k in self.near), *shares, 0, coarse - 1}
        for k in sorted({k + m for k in around for m in range(-reach, reach + 1)}):
            if not 0 <= k < coarse:
                continue
            parts = shares.get(k, [])
            for m, weight in enumerate(wavelet.predict):
                i = k - predict.shift - m
                if predict.first <= i < predict.last:
                    parts = [*parts, (i, weight)]
            own = self[min(2 * k, self.nodes - 1)]
            total = tuple(
                own[a] + sum((w * self[2 * i + 1][a] for i, w in parts), Fraction(0))
                for a in range(self.count)
            )
            if total != result.regular(k):
                result.near[k] = total
        return result


def keeping_update(wavelet: Wavelet, finer: Moments, coarser: Moments) -> Rows:
    """The update of a line with ends, as rows of coarse nodes.

    Each detail's moments are taken over by coarse nodes around it: by the wavelet's own weights
    where these do, else by the smallest weights (least squares) on N~ + 2 nodes that do.
    """
    taps = len(wavelet.update)
    coarse, details = coarser.nodes, finer.nodes - coarser.nodes
    shift = -(taps // 2)
    if not taps:
        return Rows((), 0, 0, coarse, {})
    first, last = whole(taps, shift, coarse, details)
    ends = {*range(first), *range(last, coarse)}
    columns: dict[int, Row] = {}
    for j in range(details):
        start = j + 1 - taps // 2
        window = range(start, start + taps)
        inside = start >= 0 and start + taps <= coarse and 2 * j + 1 not in finer.near
        if inside and coarser.near.keys().isdisjoint(window):
            continue
        columns[j] = _taken_over(wavelet, finer[2 * j + 1], coarser, start)
        ends |= {k for k in (*window, *columns[j]) if 0 <= k < coarse}
    first = max((k + 1 for k in ends if k < coarse // 2), default=0)
    last = min((k for k in ends if k >= coarse // 2), default=coarse)
    special: dict[int, Row] = {}
    for k in [*range(first), *range(last, coarse)]:
        special[k] = {j: column[k] for j, column in columns.items() if k in column}
        for m, weight in enumerate(wavelet.update):
            j = k + shift + m
            if 0 <= j < details and j not in columns:
                special[k][j] = weight
    return Rows(wavelet.update, shift, first, last, special)


def _taken_over(wavelet: Wavelet, wanted: Powers, coarser: Moments, start: int) -> Row:
    """The smallest weights on coarse nodes near a detail that take over its moments."""
    width = min(wavelet.moments + EXTRA, coarser.nodes)
    start = min(max(0, start - EXTRA // 2), coarser.nodes - width)
    nodes = range(start, start + width)
    matrix = [[coarser[k][a] for k in nodes] for a in range(wavelet.moments)]
    normal = [[_dot(a, b) for b in matrix] for a in matrix]
    factors = _solve(normal, list(wanted))
    return {k: _dot(factors, [row[m] for row in matrix]) for m, k in enumerate(nodes)}


def _dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _solve(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """Exact solution of a small linear system, by elimination."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(len(rows)):
        pivot = next(r for r in range(i, len(rows)) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for r in range(len(rows)):
            if r != i and rows[r][i] != 0:
                rows[r] = [a - rows[r][i] * b for a, b in zip(rows[r], rows[i], strict=True)]
    return [row[-1] for row in rows]
