"""Periodic axes: what lies across a seam."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]


def image_distance(shape: Shape, grid: Grid, points: Array | None = None) -> Array:
    """Signed distance on the nodes; on periodic axes that of the nearest image of the shape.

    Or at ``points`` (ndim, ...) [L]. Refuses a shape of another dimension.
    """
    if shape.ndim != grid.ndim:
        raise InputError(
            f"the shape has {shape.ndim} dimensions, the grid {grid.ndim}",
            hint="a shape and a grid of one dimension",
        )
    ways = [
        (-length, 0.0, length) if wraps else (0.0,)
        for length, wraps in zip(grid.length, grid.periodic, strict=True)
    ]
    at = grid.points() if points is None else points
    column = (grid.ndim, *(1,) * (at.ndim - 1))
    nearest: Array = shape.distance(at)
    for way in product(*ways):
        if any(way):
            nearest = np.minimum(nearest, shape.distance(at + np.reshape(way, column)))
    return nearest


def across_seams(
    positions: Array, values: Array, points: Array, grid: Grid, reach: float
) -> tuple[Array, Array, Array]:
    """Particles and points in the box, and images of the particles within ``reach`` of a seam."""
    places: Array = np.array(positions, np.float64)
    targets: Array = np.array(points, np.float64)
    for axis, (low, length) in enumerate(zip(grid.origin, grid.length, strict=True)):
        if not grid.periodic[axis]:
            continue
        for at in (places, targets):
            at[:, axis] = low + np.mod(at[:, axis] - low, length)
        copies, carried = [places], [values]
        for way in (-length, length):
            image = places.copy()
            image[:, axis] += way
            near = (image[:, axis] > low - reach) & (image[:, axis] < low + length + reach)
            copies.append(image[near])
            carried.append(values[near])
        places, values = np.concatenate(copies), np.concatenate(carried)
    return places, values, targets
