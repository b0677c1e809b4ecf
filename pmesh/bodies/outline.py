"""How wide a swimmer is: the half-width of its straight body as a law of the place.

Places and half-widths are in body lengths; the body is symmetric about its midline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]


class Outline(Protocol):
    """What a swimmer asks of its outline. A value: it must be hashable (a frozen dataclass)."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Places [L] between which it is smooth, the ends left out."""

    def half_width(self, s: Values) -> Values:
        """Half-width [L] at places ``s`` in 0 ... 1 from the head; zero at both ends."""

    def __hash__(self) -> int:
        """Of its values."""


@dataclass(frozen=True, kw_only=True)
class Eel:
    """The anguilliform swimmer: a round head, a body that narrows, a pointed tail.

    sqrt(2 head s - s^2) up to the neck, where s = head; then from ``head`` to ``tail`` as a power
    of the place; from ``peduncle`` on straight to a point. The plane swimmer has exponent 1, the
    one in space 2 (S. Kern, P. Koumoutsakos, J. Exp. Biol. 209, 4841, 2006; as MRAG-I2D and SophT
    have it). Its area is 0.0485132741 L^2.
    """

    head: float = 0.04
    tail: float = 0.01
    peduncle: float = 0.95
    exponent: float = 1.0

    def __post_init__(self) -> None:
        """Refuse parts that are not in order."""
        if not (0 < self.head < self.peduncle < 1 and self.tail > 0 and self.exponent > 0):
            raise InputError(
                f"an Eel needs 0 < head < peduncle < 1 and positive tail and exponent, got {self}",
                hint="Eel()",
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """The neck, as far from the nose as the head is wide, and the peduncle."""
        return (self.head, self.peduncle)

    def half_width(self, s: Values) -> Values:
        """Half-width [L] at places ``s``."""
        along = np.clip((s - self.head) / (self.peduncle - self.head), 0.0, 1.0)
        body = self.head - (self.head - self.tail) * along**self.exponent
        nose = np.sqrt(np.clip(2 * self.head * s - s**2, 0.0, None))
        tip = self.tail * (1 - s) / (1 - self.peduncle)
        return np.asarray(np.where(s < self.head, nose, np.where(s < self.peduncle, body, tip)))


@dataclass(frozen=True, kw_only=True)
class Larva:
    """A larval fish: a wide head up to ``shoulder`` and a thin body from ``body`` to the tail.

    The plane larva of M. Gazzola, W. M. van Rees, P. Koumoutsakos, J. Fluid Mech. 698, 5 (2012),
    numbers as CubismUP_2D has them.
    """

    head: float = 0.0635
    shoulder: float = 0.0862
    body: float = 0.3448
    tail: float = 0.0254

    @property
    def breaks(self) -> tuple[float, ...]:
        """Shoulder and body."""
        return (self.shoulder, self.body)

    def half_width(self, s: Values) -> Values:
        """Half-width [L] at places ``s``."""
        front = self.head * np.sqrt(np.clip(1 - ((self.shoulder - s) / self.shoulder) ** 2, 0, 1))
        reach = self.body - self.shoulder
        u = np.clip((s - self.shoulder) / reach, 0.0, 1.0)
        drop, slope = self.tail - self.head, self.tail * reach
        middle = self.head + (3 * drop + slope) * u**2 - (2 * drop + slope) * u**3
        rear = self.tail * (1 - np.clip((s - self.body) / (1 - self.body), 0.0, 1.0) ** 2)
        return np.asarray(np.where(s < self.shoulder, front, np.where(s < self.body, middle, rear)))


@dataclass(frozen=True, kw_only=True)
class Foil:
    """A symmetric NACA four-digit section of a given thickness, closed at the trailing edge."""

    thickness: float = 0.12

    def __post_init__(self) -> None:
        """Refuse a thickness that is none."""
        if not 0 < self.thickness < 1:
            raise InputError(
                f"the thickness of a Foil is between 0 and 1, got {self.thickness}", hint="0.12"
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def half_width(self, s: Values) -> Values:
        """Half-width [L] at places ``s``."""
        even = s * (-0.1260 + s * (-0.3516 + s * (0.2843 - 0.1036 * s)))
        return np.asarray(np.clip(5 * self.thickness * (0.2969 * np.sqrt(s) + even), 0.0, None))


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """An outline of one's own: half-widths [L] at places from 0 to 1, zero at both ends.

    Between them a cubic that keeps their order (PCHIP), in the angle of which the place is
    (1 - cos)/2, so that round and pointed ends both come out right.
    """

    places: tuple[float, ...]
    half_widths: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse places that do not go from 0 to 1 and widths that are not positive between."""
        for name in ("places", "half_widths"):
            object.__setattr__(self, name, tuple(map(float, getattr(self, name))))
        s, w = self.places, self.half_widths
        if len(s) != len(w) or len(s) < 3 or s[0] != 0 or s[-1] != 1 or min(np.diff(s)) <= 0:
            raise InputError(
                f"places must rise from 0 to 1, one for each half-width, got {len(s)} places and "
                f"{len(w)} half-widths",
                hint="places=(0, 0.3, 1), half_widths=(0, 0.05, 0)",
            )
        if w[0] != 0 or w[-1] != 0 or not all(0 < x < math.inf for x in w[1:-1]):
            raise InputError(
                f"half-widths must be zero at both ends and positive between, got {w}",
                hint="half_widths=(0, 0.05, 0)",
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """The places."""
        return self.places[1:-1]

    def half_width(self, s: Values) -> Values:
        """Half-width [L] at places ``s``."""
        from scipy.interpolate import PchipInterpolator

        turn = np.arccos(1 - 2 * np.asarray(self.places))
        values = PchipInterpolator(turn, self.half_widths)(np.arccos(1 - 2 * np.clip(s, 0, 1)))
        return np.asarray(np.clip(values, 0.0, None))
