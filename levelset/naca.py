"""The four-digit NACA aerofoil, with its exact signed distance."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Array, Bounds, Point, Shape, store_lengths, store_vector
from remesh.errors import InputError

Values = NDArray[np.float64]
# half thickness 5 t (...): of sqrt(x), x, x^2, x^3, x^4 (Jacobs, Ward and Pinkerton, eq. on p. 4)
THICKNESS = (0.2969, -0.1260, -0.3516, 0.2843, -0.1015)
CLOSING = -0.1036  # of x^4, the least change that makes the trailing edge sharp
VERTICES = 64  # per side, from which the search for the nearest point begins


@dataclass(frozen=True)
class Naca(Shape):
    """A four-digit aerofoil: ``Naca("2412", chord=1.0)``; nose at -x, ``center`` at half chord.

    First digit: camber in hundredths of the chord; second: its place in tenths; last two:
    thickness in hundredths. ``closed=False`` keeps the published blunt trailing edge, 0.2 % of
    the chord thick at 12 % thickness. Positive incidence a is ``.moved(angle=-a)``. Exact to
    rounding: the nearest point is solved for. Refuses what are not four digits of an aerofoil.

    Source: E. N. Jacobs, K. E. Ward and R. M. Pinkerton, NACA Report 460 (1933): thickness laid
    off at right angles to the mean line, two parabolas that meet at the largest camber.
    """

    digits: str
    chord: float = 1.0  # [L]
    center: Point = field(default=(0.0, 0.0), kw_only=True)  # of the chord [L]
    closed: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        """Refuse digits without thickness, and camber at the nose."""
        store_lengths(self, "chord")
        store_vector(self, "center", 2)
        digits = self.digits
        if not (isinstance(digits, str) and len(digits) == 4 and digits.isdecimal()):
            raise InputError(f"Naca: digits must be four digits, got {digits!r}", hint='"0012"')
        if int(digits[2:]) == 0:
            raise InputError(f"Naca {digits} has no thickness", hint='"0012"')
        if digits[0] != "0" and digits[1] == "0":
            raise InputError(f"Naca {digits} has its camber at the nose", hint='"2412"')

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def volume(self) -> float:
        """Area: the thickness along the mean line, since it is laid off on both sides alike."""
        nodes, weights = np.polynomial.legendre.leggauss(40)
        law, place = _law(self.digits, self.closed), int(self.digits[1]) / 10
        total = 0.0
        for a, b in ((0.0, np.sqrt(place)), (np.sqrt(place), 1.0)):
            s = 0.5 * (a + b) + 0.5 * (b - a) * nodes
            x = s * s
            half = law[0] * s + x * np.polynomial.polynomial.polyval(x, law[1:5])
            arc = np.hypot(1.0, _slope(x, law)) * 2.0 * s
            total += 0.5 * (b - a) * float(np.sum(weights * 2.0 * half * arc))
        return total * self.chord**2

    def outline(self, count: int = 400) -> Values:
        """Points (n, 2) [L] of the edge, anticlockwise from the trailing edge; denser at the nose.

        ``count`` is about their number.
        """
        upper, lower = _vertices(self.digits, self.closed, max(count // 2, 2))
        ring = np.concatenate([upper[::-1], lower[1:] if not self.closed else lower[1:-1]])
        return np.asarray(self.chord * (ring - (0.5, 0.0)) + self.center)

    def bounds(self) -> Bounds:
        """The rectangle around the edge, within 1e-6 of the chord."""
        low, high = (
            self.chord * (corner - (0.5, 0.0)) + self.center
            for corner in _corners(self.digits, self.closed)
        )
        return tuple(low.tolist()), tuple(high.tolist())

    def _distance(self, points: Array) -> Array:
        from levelset._edges import aerofoil

        x, y = (
            ((p.astype(np.float64) - c) / self.chord).ravel()
            for p, c in zip(points, self.center, strict=True)
        )
        out = np.empty(x.size)
        vertices = _vertices(self.digits, self.closed, VERTICES)
        aerofoil(x + 0.5, y, _law(self.digits, self.closed), vertices, out)
        return (self.chord * out).reshape(points.shape[1:])


@lru_cache(maxsize=64)
def _law(digits: str, closed: bool) -> Values:
    """Thickness coefficients times 5 t, camber, and its place, for a unit chord."""
    last = CLOSING if closed else THICKNESS[-1]
    thickness = 5.0 * int(digits[2:]) / 100 * np.array([*THICKNESS[:-1], last])
    return np.array([*thickness, int(digits[0]) / 100, int(digits[1]) / 10])


def _slope(x: Values, law: Values) -> Values:
    """Slope of the mean line."""
    camber, place = law[5:]
    if camber == 0.0:
        return np.zeros_like(x)
    span = np.where(x < place, place, 1.0 - place)
    return np.asarray(2.0 * camber / span**2 * (place - x))


@lru_cache(maxsize=64)
def _vertices(digits: str, closed: bool, count: int) -> Values:
    """Points (2, count + 1, 2) of the upper and lower side from nose to tail, unit chord."""
    from levelset._edges import on_edge

    law = _law(digits, closed)
    sides = [[on_edge(k / count, law, side)[:2] for k in range(count + 1)] for side in (0, 1)]
    return np.array(sides)


@lru_cache(maxsize=64)
def _corners(digits: str, closed: bool) -> tuple[Values, Values]:
    """Corners of the box around a unit chord, 1e-6 wider than the edge."""
    edge = _vertices(digits, closed, 4000)
    return edge.min(axis=(0, 1)) - 1e-6, edge.max(axis=(0, 1)) + 1e-6
