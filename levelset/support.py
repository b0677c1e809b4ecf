"""How far a shape reaches in a direction: tight boxes around shapes that are turned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from levelset.ellipse import Ellipsoid
from levelset.shape import Bounds, Difference, Intersection, Moved, Shape, Union, rotation
from levelset.shapes import Sphere
from levelset.solids import Capsule, Torus
from levelset.triangle_mesh import TriangleMesh

Values = NDArray[np.float64]


def support(shape: Shape, ways: Values) -> Values:
    """Largest ``way . x`` over the points x of a shape, for ways (n, ndim); never too small.

    Exact for convex solids, tori, triangle meshes and their unions, moved or not; others as far as
    the corners of their box.
    """
    if isinstance(shape, Moved):
        turned = support(shape.shape, ways @ rotation(shape.angle))
        return np.asarray(ways @ np.array(shape.shift) + turned)
    if isinstance(shape, Union):
        return np.maximum(support(shape.first, ways), support(shape.second, ways))
    if isinstance(shape, Intersection):
        return np.minimum(support(shape.first, ways), support(shape.second, ways))
    if isinstance(shape, Difference):
        return support(shape.first, ways)
    return _known(shape, ways)


def turned_box(shape: Shape) -> Bounds:
    """The box around a shape, by its support along the axes."""
    axes = np.eye(shape.ndim)
    low, high = -support(shape, -axes), support(shape, axes)
    return tuple(low.tolist()), tuple(high.tolist())


def _known(shape: Shape, ways: Values) -> Values:
    length = np.linalg.norm(ways, axis=1)
    if isinstance(shape, Sphere):
        return np.asarray(ways @ np.array(shape.center) + shape.radius * length)
    if isinstance(shape, Ellipsoid):
        reach = np.linalg.norm(ways * shape.axes, axis=1)
        return np.asarray(ways @ np.array(shape.center) + reach)
    if isinstance(shape, Torus):
        flat = shape.radius * np.hypot(ways[:, 0], ways[:, 1])
        return np.asarray(ways @ np.array(shape.center) + flat + shape.tube * length)
    if isinstance(shape, Capsule):
        ends = ways @ np.array([shape.start, shape.end]).T
        return np.asarray(ends.max(axis=1) + shape.radius * length)
    if isinstance(shape, TriangleMesh):
        return np.asarray((ways @ shape.vertices.T).max(axis=1))
    low, high = (np.array(corner) for corner in shape.bounds())
    return np.asarray(np.where(ways > 0, ways * high, ways * low).sum(axis=1))
