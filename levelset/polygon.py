"""The polygon, with its exact signed distance; from its corners or from a file of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Array, Bounds, Shape, vector
from remesh.errors import InputError

Corner = tuple[float, float]
Values = NDArray[np.float64]


@dataclass(frozen=True)
class Polygon(Shape):
    """A simple polygon from its corners in order, either way round.

    Exact everywhere; costs corners times points.
    """

    corners: tuple[Corner, ...]  # [L]

    def __post_init__(self) -> None:
        """Refuse fewer than 3 corners, repeated ones, and sides that meet."""
        given = list(self.corners) if isinstance(self.corners, Iterable) else []
        corners = [vector(f"Polygon: corner {i}", corner, 2) for i, corner in enumerate(given)]
        if len(corners) < 3:
            raise InputError(
                f"Polygon: needs at least 3 corners, got {self.corners!r}",
                hint="Polygon(((0, 0), (1, 0), (0, 1)))",
            )
        object.__setattr__(self, "corners", tuple(corners))
        if any(a == b for a, b in self._sides()) or self.volume == 0.0:
            raise InputError("Polygon: repeated corners or no area", hint="each corner once")
        met = _crossing(np.array(corners))
        if met is not None:
            raise InputError(
                f"Polygon: sides {met[0]} and {met[1]} meet",
                hint="corners in order around the edge",
            )

    @classmethod
    def from_file(cls, path: str | Path, *, scale: float = 1.0) -> Polygon:
        """The polygon whose corners a text file holds: two columns, x and y, a corner per line.

        Titles above the numbers, blank lines and ``#`` comments are passed over; columns are
        parted by blanks, commas or semicolons. The last corner is joined to the first, which may
        be repeated at the end. Reads aerofoil files in Selig's order (once around from the
        trailing edge) and in Lednicer's (two counts, then each side from the nose). ``scale``:
        [L] per unit of the file. Refuses other lines, naming them.
        """
        rows = _rows(Path(path))
        rows = _lednicer(rows) or rows
        corners = [row for i, row in enumerate(rows) if i == 0 or row != rows[i - 1]]
        if len(corners) > 1 and corners[0] == corners[-1]:
            corners.pop()
        if len(corners) < 3:
            raise InputError(
                f"{path} holds {len(corners)} corners, a polygon needs 3",
                hint="a text file with x and y of one corner per line",
            )
        return cls(tuple((scale * x, scale * y) for x, y in corners))

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    def _sides(self) -> list[tuple[Corner, Corner]]:
        """Pairs of neighbouring corners."""
        return list(zip(self.corners, self.corners[1:] + self.corners[:1], strict=True))

    @property
    def volume(self) -> float:
        """Area, by the shoelace formula."""
        return abs(0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in self._sides()))

    @property
    def surface(self) -> float:
        """Length of the boundary."""
        return sum(math.dist(a, b) for a, b in self._sides())

    def bounds(self) -> Bounds:
        """The rectangle around the corners."""
        xs, ys = zip(*self.corners, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))

    def _distance(self, points: Array) -> Array:
        from levelset._edges import polygon

        x, y = (np.ascontiguousarray(p).ravel() for p in points)
        out = np.empty(x.size, points.dtype)
        polygon(x, y, np.array(self.corners), out)
        return out.reshape(points.shape[1:])


def _rows(path: Path) -> list[Corner]:
    """The pairs of numbers in a file; refuses what is neither a title nor a pair."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror}", hint="a text file with x and y in two columns"
        ) from error
    rows: list[Corner] = []
    for number, line in enumerate(lines, 1):
        words = line.split("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers = []
        if len(numbers) == 2 and all(map(math.isfinite, numbers)):
            rows.append((numbers[0], numbers[1]))
        elif rows or numbers:
            raise InputError(
                f"{path}, line {number}: two numbers asked, got {line.strip()!r}",
                hint="x and y of one corner per line, titles only above them",
            )
    return rows


def _lednicer(rows: list[Corner]) -> list[Corner] | None:
    """One ring from two sides that both begin at the nose; None if the first row is no count."""
    if not rows:
        return None
    upper, lower = rows[0]
    if min(upper, lower) < 2 or upper % 1 or lower % 1 or len(rows) != 1 + upper + lower:
        return None
    split = 1 + int(upper)
    return rows[1:split][::-1] + rows[split:]


def _crossing(corners: Values) -> tuple[int, int] | None:
    """The first two sides, not neighbours, that share a point."""
    a, b = corners, np.roll(corners, -1, axis=0)
    count = len(a)
    for i in range(count - 2):
        j = np.arange(i + 2, count - (i == 0))
        apart = (np.maximum(a[i], b[i]) < np.minimum(a[j], b[j])) | (
            np.maximum(a[j], b[j]) < np.minimum(a[i], b[i])
        )
        j = j[~apart.any(axis=1)]
        here = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j])
        there = _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i])
        met = np.flatnonzero((here <= 0) & (there <= 0))
        if met.size:
            return i, int(j[met[0]])
    return None


def _side(p: Values, q: Values, r: Values) -> Values:
    """On which side of the line pq the point r lies."""
    edge, arm = q - p, r - p
    return np.asarray(edge[..., 0] * arm[..., 1] - edge[..., 1] * arm[..., 0])
