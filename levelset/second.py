"""Second moments of a shape: how its matter lies about its centre."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from levelset.ellipse import Ellipsoid
from levelset.measure import cell_shares, measure
from levelset.shape import Moved, Shape, rotation
from levelset.shapes import Box, Sphere
from levelset.solids import Capsule, Dumbbell, Torus
from levelset.triangle_mesh import TriangleMesh

Values = NDArray[np.float64]


def second_moments(shape: Shape) -> Values:
    """``int r r^T dV`` about the centre, (ndim, ndim) [L^(ndim+2)]; its trace is ``inertia``.

    Exact for all plain solids but the slotted ball, for triangle meshes, and those moved. Of other
    shapes from the distance on 96 cells along the longest side, about 1e-6 for a smooth shape,
    1e-4 with edges, and made to have the trace of ``measure``.
    """
    return np.array(_second(shape))


@lru_cache(maxsize=64)
def _second(shape: Shape) -> tuple[tuple[float, ...], ...]:
    found = _known(shape)
    if found is None:
        found = _of_cells(shape)
        found *= measure(shape).inertia / np.trace(found)
    return tuple(map(tuple, found.tolist()))


def _known(shape: Shape) -> Values | None:
    """The moments where a closed form is known."""
    if isinstance(shape, Moved):
        turn = rotation(shape.angle)
        return np.asarray(turn @ second_moments(shape.shape) @ turn.T)
    if isinstance(shape, Sphere):
        return measure(shape).inertia / 3.0 * np.eye(3)
    if isinstance(shape, Box):
        return np.diag(np.square(shape.size)) * measure(shape).volume / 12.0
    if isinstance(shape, Ellipsoid):
        return np.diag(np.square(shape.axes)) * measure(shape).volume / 5.0
    if isinstance(shape, TriangleMesh):
        return _of_triangles(shape)
    return _about_an_axis(shape)


def _about_an_axis(shape: Shape) -> Values | None:
    """Those of solids about an axis, from what lies across it and the sum of all."""
    if shape.ndim != 3:
        return None
    if isinstance(shape, Torus):  # across z, along x: V (R^2 / 2 + 3 r^2 / 8)
        axis = np.array([0.0, 0.0, 1.0])
        across = measure(shape).volume * (0.5 * shape.radius**2 + 0.375 * shape.tube**2)
    elif isinstance(shape, Capsule):
        axis = np.subtract(shape.end, shape.start) / shape.length
        bar, ends = shape._parts()
        across = shape.radius**2 * (bar / 4.0 + ends / 5.0)
    elif isinstance(shape, Dumbbell):  # a slice of radius y holds pi y^4 / 4
        axis = np.array([1.0, 0.0, 0.0])
        _, y, dx, _ = shape._profile()
        across = 0.5 * np.pi * float(np.sum(y**4 * dx))
    else:
        return None
    along = measure(shape).inertia - 2.0 * across
    return np.asarray(across * np.eye(3) + (along - across) * np.outer(axis, axis))


def _of_triangles(shape: TriangleMesh) -> Values:
    """The sum of signed tetrahedra: exact."""
    center = np.array(measure(shape).center)
    a, b, c = shape._corners() - center
    six = np.einsum("ij,ij->i", a, np.cross(b, c))
    total = a + b + c
    found = sum((six * part.T) @ part for part in (a, b, c, total))
    return np.asarray(found) / 120.0


def _of_cells(shape: Shape) -> Values:
    """Those of the cells' shares."""
    points, share, middle = cell_shares(shape)
    arm = points + (middle - np.array(measure(shape).center)).reshape(-1, *(1,) * shape.ndim)
    flat = arm.reshape(shape.ndim, -1)
    return np.asarray((flat * share.ravel()) @ flat.T)
