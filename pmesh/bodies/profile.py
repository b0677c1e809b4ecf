"""How tall a swimmer in space is: the half-height of its straight body as a law of the place.

Places and half-heights are in body lengths; its sections are ellipses, as wide as the outline says.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]


class Profile(Protocol):
    """What a swimmer in space asks of its height. A value: hashable (a frozen dataclass)."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Places [L] between which it is smooth, the ends left out."""

    def half_height(self, s: Values) -> Values:
        """Half-height [L] at places ``s`` in 0 ... 1 from the head; it may end with an edge."""

    def __hash__(self) -> int:
        """Of its values."""


@dataclass(frozen=True, kw_only=True)
class Arch:
    """Half an ellipse over the midline: height sqrt(1 - ((s - middle)/middle)^2).

    That of the anguilliform swimmer in space (S. Kern, P. Koumoutsakos, J. Exp. Biol. 209, 4841,
    2006; as SophT has it): zero at the nose; the ellipse ends behind the tail, at s = 1.02, so
    that the tail ends in an upright edge, 0.0222 L to each side. With ``Eel(exponent=2)`` the
    volume is 0.0059326147 L^3.
    """

    height: float = 0.08
    middle: float = 0.51

    def __post_init__(self) -> None:
        """Refuse an arch that ends before the tail, and one that is not tall."""
        if not (self.height > 0 and self.middle >= 0.5):
            raise InputError(
                f"an Arch needs a positive height and its middle at 0.5 or behind, got {self}",
                hint="Arch()",
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def half_height(self, s: Values) -> Values:
        """Half-height [L] at places ``s``."""
        away = (s - self.middle) / self.middle
        return np.asarray(self.height * np.sqrt(np.clip(1 - away**2, 0.0, None)))
