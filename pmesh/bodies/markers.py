"""Markers of bodies: points on lines that follow the outline and fill the inside."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.mask import at_rest
from pmesh.bodies.pose import Pose
from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
KERNEL = "M6'"  # between markers and mesh: it keeps the moments of a force up to the fourth
FINER = 2  # cells per spacing of the lattice on which lines of equal distance are drawn


class Markers(NamedTuple):
    """Where the fluid is held."""

    positions: Array  # (n, ndim) [L]
    weight: Array  # (n,) area of each over that of a cell


@lru_cache(maxsize=8)
def markers_of(
    bodies: tuple[Body, ...],
    poses: tuple[Pose, ...],
    grid: Grid,
    spacing: float,
    retraction: float,
) -> Markers:
    """Markers of all bodies at their poses, on lines ``retraction`` [L] and more inside.

    ``grid``: the mesh; ``spacing`` of the markers along a line, in its spacings. Lines lie one
    spacing of the mesh apart and fill the bodies.
    Refuses a plane body too thin for a line, and bodies in space.
    """
    if grid.ndim != 2:
        raise InputError(
            f"direct forcing holds plane bodies, got {grid.ndim} dimensions",
            hint="penalisation=pmesh.Penalisation()",
        )
    places: list[Values] = []
    weights: list[Values] = []
    for body, pose in zip(bodies, at_rest(bodies, poses), strict=True):
        found = _lines(body, pose, grid, retraction)
        if not found:
            raise InputError(
                f"a body has no inside deeper than {retraction:.3g}, where its markers lie",
                hint="a smaller spacing of the mesh",
            )
        for line in found:
            points, step = _even(line, spacing * grid.spacing)
            places.append(points)
            weights.append(np.full(len(points), step / grid.spacing))
    return Markers(np.concatenate(places), np.concatenate(weights))


def _lines(body: Body, pose: Pose, grid: Grid, first: float) -> list[Values]:
    """Closed lines (n, 2) of equal distance, one spacing apart, from ``first`` inwards."""
    from contourpy import contour_generator

    low, high = (np.asarray(corner) for corner in body.bounds(pose))
    step = grid.spacing / FINER
    axes = [
        a - 2 * step + step * np.arange(math.ceil((b - a) / step) + 5)
        for a, b in zip(low, high, strict=True)
    ]
    distance = body.distance(np.stack(np.meshgrid(*axes, indexing="ij")), pose)
    drawn = contour_generator(axes[1], axes[0], distance, line_type="Separate")
    levels = np.arange(-first, float(distance.min()), -grid.spacing)
    lines = [line for level in levels for line in drawn.lines(float(level))]
    return [np.asarray(line, np.float64)[:, ::-1] for line in lines]


def _even(line: Values, spacing: float) -> tuple[Values, float]:
    """Points evenly along a closed line, whose last point is its first, and their spacing."""
    pieces = np.hypot(*np.diff(line, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(pieces)])
    count = max(3, round(along[-1] / spacing))
    step = along[-1] / count
    places = step * (np.arange(count) + 0.5)
    return np.stack([np.interp(places, along, column) for column in line.T], axis=1), step
