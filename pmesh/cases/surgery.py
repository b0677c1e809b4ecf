"""An operation: an organ that breathes, tools that cut it, and the volume that they sweep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.blend import SmoothDifference, SmoothUnion
from levelset.ellipse import Ellipsoid
from levelset.shape import Shape
from levelset.shapes import Box, Sphere
from levelset.tool import Swept, Tool
from remesh.grid import Grid

Values = NDArray[np.floating[Any]]
SWITCH = 0.45  # when the burr has left and the blade comes [T]
BREATH = 0.5  # period [T]
FINE = 1 / 80  # between the points that the reference sums over [L]
BLADE = (0.08, 0.9, 0.45)  # its sides [L]
PACE = 0.08  # of the tools, from pose to pose, in the reference [L]


@dataclass(frozen=True)
class Breathing:
    """The body goes up and down: amplitude/2 (1 - cos(2 pi t/period)) along z."""

    amplitude: float  # [L]

    def shift(self, time: float) -> tuple[float, float, float]:
        """How far it is from where it started [L]."""
        return 0.0, 0.0, 0.5 * self.amplitude * (1.0 - math.cos(2.0 * math.pi * time / BREATH))

    def max_gradient(self, time: float) -> float:
        """None [1/T]: it is rigid."""
        return 0.0

    def __call__(self, time: float, positions: Values) -> Values:
        """The same velocity everywhere [L/T]."""
        rate = math.pi * self.amplitude / BREATH * math.sin(2.0 * math.pi * time / BREATH)
        return np.broadcast_to(np.array([0.0, 0.0, rate]), positions.shape)


@dataclass(frozen=True)
class Operation:
    """Who is cut, and by what."""

    burr: float  # radius of the burr [L]
    breathing: float  # how far the organ goes up and down [L]

    @property
    def organ(self) -> Shape:
        """Two lobes and a small one between, hollow below."""
        right = Ellipsoid((0.60, 0.46, 0.38), center=(-0.26, 0.0, 0.0))
        left = Ellipsoid((0.52, 0.27, 0.17), center=(0.40, 0.08, 0.10))
        small = Ellipsoid((0.20, 0.16, 0.20), center=(-0.02, -0.32, -0.08))
        lobes = SmoothUnion(SmoothUnion(right, left, radius=0.22), small, radius=0.15)
        return SmoothDifference(lobes, Sphere(0.45, center=(0.12, 0.0, -0.58)), radius=0.2)

    @property
    def motion(self) -> Breathing:
        """How the organ moves."""
        return Breathing(self.breathing)

    @property
    def tools(self) -> tuple[Tool, Tool]:
        """The burr and the blade."""
        return (
            Tool(shape=Sphere(self.burr), shift=_scoop),
            Tool(shape=Box(BLADE), shift=_lower, angle=_rock),
        )

    def taken(self, time: float, places: Values) -> Values:
        """Signed distance (n,) of places in the organ's frame (3, n) from all that was swept."""
        away = np.full(places.shape[1], 1.0)
        for swept in _paths(self, time):
            low, high = (np.reshape(corner, (3, 1)) for corner in swept.bounds())
            near = ((low < places) & (places < high)).all(axis=0)
            if near.any():
                away[near] = np.minimum(away[near], swept.distance(places[:, near]))
        return away

    def section(self, time: float, points: Values) -> tuple[Values, Values]:
        """Level sets of what is left and of what was removed, at points (3, ...), in their place.

        From the exact shapes; far from the organ the size means nothing.
        """
        places = points - np.reshape(self.motion.shift(time), (3, *(1,) * (points.ndim - 1)))
        organ = self.organ.distance(places)
        near = organ < 0.1
        away = np.full(organ.shape, 1.0)
        if time > 0.0:
            away[near] = self.taken(time, places[:, near])
        return np.maximum(organ, -away), np.maximum(organ, away)


@lru_cache(maxsize=8)
def _paths(operation: Operation, time: float) -> tuple[Swept, ...]:
    """What the tools have swept by a time, seen from the organ."""
    shift = operation.motion.shift

    def seen(law: Any) -> Any:
        return lambda t: np.subtract(law(t), shift(t))

    return tuple(
        Swept(
            Tool(shape=tool.shape, shift=seen(tool.shift), angle=tool.angle), 0.0, time, pace=PACE
        )
        for tool in operation.tools
    )


@lru_cache(maxsize=64)
def swept_volume(operation: Operation, time: float) -> float:
    """Volume of the organ that the tools have swept by a time [L^3], from the exact shapes.

    A sum over points, each weighed by how far inside it is: within 0.1 % of what finer ones tell.
    """
    if time <= 0.0:
        return 0.0
    places, inside = _points(operation)
    both = np.maximum(inside, operation.taken(time, places))
    return float(np.clip(0.5 - both / FINE, 0.0, 1.0).sum()) * FINE**3


@lru_cache(maxsize=1)
def _points(operation: Operation) -> tuple[Values, Values]:
    """Points ``FINE`` apart in the organ (3, n), and the signed distance there."""
    organ = operation.organ
    ends = zip(*organ.bounds(), strict=True)
    axes = [np.arange(low - FINE, high + 2.0 * FINE, FINE) for low, high in ends]
    places = np.stack(np.meshgrid(*axes, indexing="ij")).reshape(3, -1)
    inside = organ.distance(places)
    near = inside < FINE
    return places[:, near], inside[near]


def _scoop(time: float) -> tuple[float, float, float]:
    """The burr dives into the right lobe and comes out again."""
    part = min(time / SWITCH, 1.0)
    away = 2.0 * max(time - SWITCH, 0.0)
    return -0.85 + 0.95 * part, -0.18, 0.62 - 0.33 * math.sin(math.pi * part) + away


def _lower(time: float) -> tuple[float, float, float]:
    """The blade goes down through the left lobe."""
    part = max(time - SWITCH, 0.0) / (1.0 - SWITCH)
    return 0.42, 0.08, 0.72 - 1.22 * part


def _rock(time: float) -> tuple[float, float, float]:
    """It rocks, and leans."""
    part = max(time - SWITCH, 0.0) / (1.0 - SWITCH)
    return 0.3 * math.sin(2.0 * math.pi * part), 0.25, 0.0


@lru_cache(maxsize=4)
def bore(radius: float, cells: int) -> tuple[float, float]:
    """What a ball takes out of a block at this resolution, and what it should [L^3]."""
    from levelset.cutting import Cutting
    from levelset.laws import Uniform
    from levelset.transport import ParticleLevelSet

    h, depth = 1.0 / cells, 1.3 * radius
    wide = 2.0 * radius + 12.0 * h
    count = math.ceil((1.3 * wide) / h) + 12
    grid = Grid((count,) * 3, h, (-0.5 * h * (count - 1),) * 3)
    still = ParticleLevelSet(grid=grid, velocity=Uniform(velocity=(0.0, 0.0, 0.0)))
    half, far = 0.5 * wide, 0.5 * wide + 1.5 * radius
    ball = Tool(shape=Sphere(radius), shift=lambda t: (far + t * (half - depth - far), 0.0, 0.0))
    recipe = Cutting(carrier=still, tools=ball)
    state = recipe.start(Box((wide, wide, wide)))
    for _ in range(2):
        state = recipe.step(state, 0.5)
    return state.removed, math.pi * radius**2 * depth + 2.0 / 3.0 * math.pi * radius**3
