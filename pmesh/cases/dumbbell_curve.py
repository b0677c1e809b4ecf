"""A dumbbell that shrinks by its mean curvature, followed as a curve: the reference of the case."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.solids import Dumbbell
from pmesh.cases.revolution import Shrinking, drop, shrink, spaced

Values = NDArray[np.float64]
CURVE = "the same surface of revolution followed as a curve, converged"
POINTS = 500  # of the curve


class Reference(NamedTuple):
    """The curve until it pinches, and one of the two drops from there on."""

    before: Shrinking
    after: Shrinking

    @property
    def pinch(self) -> float:
        """When the neck is gone [T]."""
        return self.before.end

    @property
    def end(self) -> float:
        """When the drops are [T]."""
        return self.before.end + self.after.end

    @property
    def volume(self) -> tuple[Values, Values]:
        """Times and volumes of the whole, from the start to the end."""
        time = np.concatenate([self.before.time, self.before.end + self.after.time])
        volume = 2.0 * np.concatenate([self.before.volume, self.after.volume])
        return np.append(time, self.end), np.append(volume, 0.0)

    def curve(self, time: float) -> Values:
        """The half with x > 0 at a time, points (n, 2); empty after the end."""
        part, start = (self.before, 0.0) if time < self.pinch else (self.after, self.pinch)
        if time > start + part.end:
            return np.empty((0, 2))
        return np.asarray(part.curves[int(np.abs(part.time - (time - start)).argmin())])


@lru_cache(maxsize=4)
def followed(shape: Dumbbell) -> Reference:
    """The shape's outline on its way."""
    before = shrink(outline(shape, POINTS), until=1e3 * shape.radius**2, mirrored=True)
    after = shrink(drop(before.curves[-1]), until=1e3 * shape.radius**2, mirrored=False)
    return Reference(before, after)


def outline(shape: Dumbbell, count: int) -> Values:
    """The outline with x > 0 and r > 0, from the bar's middle to the axis, evenly spaced."""
    half, middle = 0.5 * shape.separation, shape.bar + shape.fillet
    reach = shape.radius + shape.fillet
    foot = half - math.sqrt((reach - middle) * (reach + middle))
    lean = math.atan2(middle, half - foot)
    turn = np.linspace(-0.5 * np.pi, -lean, 200)
    fillet = np.stack([foot + shape.fillet * np.cos(turn), middle + shape.fillet * np.sin(turn)], 1)
    turn = np.linspace(np.pi - lean, 0.0, 4 * count)
    ball = np.stack([half + shape.radius * np.cos(turn), shape.radius * np.sin(turn)], axis=1)
    ball[-1, 1] = 0.0
    return spaced(np.concatenate([[[0.0, shape.bar]], fillet, ball]), count)
