"""Boxes around turned shapes: they hold the shape, and touch it."""

from __future__ import annotations

import numpy as np
import pytest
from test_second import cuboid

from levelset.shapes import Box, Capsule, Ellipsoid, SlottedSphere, Sphere, Torus
from levelset.support import support, turned_box

ANGLE, SHIFT = (0.3, -0.5, 0.9), (1.0, 2.0, 3.0)
TIGHT = [
    Sphere(0.5, center=(0.1, 0.2, 0.3)),
    Ellipsoid((0.5, 0.3, 0.1)),
    Torus(0.4, 0.1),
    Capsule((0.0, 0.0, 0.0), (0.3, 0.4, -0.2), 0.1),
    Box((0.5, 0.6, 0.2)),
    cuboid(np.array([0.5, 0.6, 0.2]), np.zeros(3)),
]


@pytest.mark.parametrize("shape", TIGHT, ids=lambda shape: type(shape).__name__)
def test_the_box_around_a_turned_shape_touches_it_on_all_sides(shape):
    moved = shape.moved(SHIFT, ANGLE)
    low, high = (np.array(corner) for corner in turned_box(moved))
    axes = [np.linspace(a, b, 81) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"))
    near = moved.distance(points) < 0.01
    for axis in range(3):
        others = tuple(k for k in range(3) if k != axis)
        assert near.any(axis=others)[[0, -1]].all()
    beyond = np.array([low - 1e-9, high + 1e-9])
    for axis in range(3):
        for side in beyond[:, axis]:
            face = [np.linspace(a - 0.1, b + 0.1, 60) for a, b in zip(low, high, strict=True)]
            face[axis] = np.array([side])
            assert moved.distance(np.stack(np.meshgrid(*face, indexing="ij"))).min() > 0


def test_a_set_reaches_as_far_as_its_parts_and_other_shapes_as_their_box():
    one, other = Sphere(0.5), Sphere(0.5, center=(1.0, 0.0, 0.0))
    assert turned_box(one | other) == ((-0.5, -0.5, -0.5), (1.5, 0.5, 0.5))
    assert turned_box(one & other) == ((0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    assert turned_box(one - other) == ((-0.5,) * 3, (0.5,) * 3)
    slotted = SlottedSphere(0.5, width=0.2, depth=0.6)
    assert support(slotted, np.array([[1.0, 1.0, 0.0]])) == pytest.approx(1.0)
