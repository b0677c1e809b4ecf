"""How thick a shape is where it is thickest: whether a mesh sees it at all."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from remesh.errors import InputError

SAMPLES = {2: 48, 3: 16}  # points along each side of the box, by dimension
STARTS = 8  # deepest points from which deeper ones are searched
HALVINGS = 10  # of the way of a search


def thickness(shape: Shape) -> float:
    """Twice the depth of a shape's deepest point [L], however the shape is turned.

    Found on a mesh of its box and then by a search around the deepest nodes: from below, and within
    a thousandth of the box's sides if the deepest part is not missed. Of shapes whose distance is a
    lower bound inside, as that of unions, it is one too. Refuses a shape with no inside.
    """
    low, high = (np.array(corner, np.float64) for corner in shape.bounds())
    count = SAMPLES[shape.ndim]
    step = (high - low) / count
    middles = [a + d * (np.arange(count) + 0.5) for a, d in zip(low, step, strict=True)]
    places = np.stack(np.meshgrid(*middles, indexing="ij")).reshape(shape.ndim, -1)
    depth = -shape.distance(places)
    first = np.argpartition(-depth, STARTS)[:STARTS]
    around = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=shape.ndim))).T
    best, deepest = places[:, first], np.asarray(depth[first], np.float64)
    for _ in range(HALVINGS):
        best, deepest = _deeper(shape, best, deepest, step[:, None] * around)
        step = 0.5 * step
    found = 2.0 * float(deepest.max())
    if not found > 0.0:
        raise InputError(
            f"the shape has no inside: {type(shape).__name__} within {shape.bounds()}",
            hint="a solid that is not empty",
        )
    return found


def _deeper(
    shape: Shape, best: NDArray[np.float64], deepest: NDArray[np.float64], ways: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The deepest of the places (ndim, n) and of those a way (ndim, m) from them, and its depth."""
    near = best[:, :, None] + ways[:, None, :]
    depth = -shape.distance(near)
    which = depth.argmax(axis=1)
    own = np.arange(len(which))
    return near[:, own, which], np.maximum(deepest, depth[own, which])
