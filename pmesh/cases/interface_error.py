"""How far an interface is from a shape's surface on the mean: what lies between them, counted."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from remesh.errors import InputError

Values = NDArray[np.float64]
TILT = 0.6  # [rad], of the lattice that counts: no wall of a shape lies along it


def mean_error(
    shape: Shape,
    value_at: Callable[[Values], Values],
    spacing: float,
    *,
    fine: int = 10,
    reach: float = 1.5,
) -> float:
    """Mean distance between an interface and a shape's surface, in spacings.

    The volume between them over the shape's surface, counted on a tilted lattice of ``fine``
    points per spacing, up to ``reach`` spacings away from the surface. ``value_at`` gives the
    level set at points (m, ndim). Refuses a shape whose surface has no closed form.
    """
    surface = shape.surface
    if surface is None:
        raise InputError("the shape's surface is not known", hint="levelset.shapes.SlottedDisk()")
    points, inside = _samples(shape, spacing / fine, reach * spacing)
    wrong = int(((value_at(points) < 0) != inside).sum())
    return wrong * (spacing / fine) ** shape.ndim / (surface * spacing)


@lru_cache(maxsize=4)
def _samples(shape: Shape, step: float, reach: float) -> tuple[Values, NDArray[np.bool_]]:
    """A tilted lattice (m, ndim) around a surface, and which of its points are inside."""
    low, high = (np.array(corner) for corner in shape.reach(reach))
    half = 0.5 * math.dist(low, high)
    line = np.arange(-half, half, step)
    kept = []
    turn = np.eye(shape.ndim)
    for a, b in ((0, 1), (1, 2), (0, 2))[: 1 if shape.ndim == 2 else 3]:
        part = np.eye(shape.ndim)
        part[[a, a, b, b], [a, b, a, b]] = (
            math.cos(TILT), -math.sin(TILT), math.sin(TILT), math.cos(TILT),
        )  # fmt: skip
        turn = turn @ part
    for x in line:  # a layer at a time: in space they are many
        layer = np.meshgrid([x], *(line,) * (shape.ndim - 1), indexing="ij")
        points = np.stack([part.ravel() for part in layer]).T @ turn.T + 0.5 * (low + high)
        points = points[((points > low) & (points < high)).all(axis=1)]
        kept.append(points[np.abs(shape.distance(points.T)) < reach])
    found = np.concatenate(kept)
    return found, np.asarray(shape.distance(found.T) < 0)
