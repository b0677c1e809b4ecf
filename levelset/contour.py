"""The zero contour of a plane shape as closed lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from remesh.errors import InputError

Values = NDArray[np.float64]


def contour(shape: Shape, *, cells: int = 256) -> list[Values]:
    """Closed lines (n, 2) on which the distance is zero, anticlockwise around the inside.

    ``cells``: of the mesh along the longest side of the shape's box; second order in their size.
    Refuses a shape in space.
    """
    if shape.ndim != 2:
        raise InputError(
            f"a contour is drawn of a plane shape, got {shape.ndim} dimensions",
            hint="levelset.shapes.Disk",
        )
    from contourpy import contour_generator

    low, high = (np.array(corner) for corner in shape.bounds())
    step = float((high - low).max()) / cells
    counts = np.ceil((high - low) / step - 1e-9).astype(int) + 4
    axes = [  # laid out from the middle: a shape that is its own mirror image has such a contour
        middle + step * (np.arange(count) - 0.5 * (count - 1))
        for middle, count in zip(0.5 * (low + high), counts, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"))
    values = shape.distance(points)
    lines = contour_generator(axes[1], axes[0], values, line_type="Separate").lines(0.0)
    closed = []
    for line in lines:
        ring = np.asarray(line, np.float64)[:-1, ::-1]
        closed.append(_oriented(ring, shape))
    return closed


def even(line: Values, step: float) -> Values:
    """A closed line (n, 2) with its points spread evenly, about ``step`` [L] apart."""
    ring = np.concatenate([line, line[:1]]).astype(np.float64)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(ring, axis=0).T))])
    count = max(round(arc[-1] / step), 8)
    places = arc[-1] * np.arange(count) / count
    return np.stack([np.interp(places, arc, part) for part in ring.T], axis=1)


def _oriented(ring: Values, shape: Shape) -> Values:
    """The ring with the inside on its left."""
    here, there = ring, np.roll(ring, -1, axis=0)
    along = there - here
    longest = int(np.argmax((along**2).sum(axis=1)))
    left = np.array([-along[longest, 1], along[longest, 0]])
    middle = 0.5 * (here + there)[longest]
    inside = shape.distance((middle + 0.1 * left)[:, None])[0] < shape.distance(middle[:, None])[0]
    return ring if inside else ring[::-1].copy()
