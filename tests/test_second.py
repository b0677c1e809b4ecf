"""Second moments: closed forms against integrals over cells, and how they turn."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.measure import measure
from levelset.second import _of_cells, second_moments
from levelset.shape import rotation
from levelset.shapes import (
    Box,
    Capsule,
    Dumbbell,
    Ellipsoid,
    SlottedSphere,
    Sphere,
    Torus,
    TriangleMesh,
)

EXACT = [
    Sphere(0.5, center=(1.0, 2.0, 3.0)),
    Ellipsoid((0.5, 0.3, 0.4)),
    Torus(1.0, 0.3),
    Capsule((0.0, 0.1, 0.2), (0.5, 0.7, -0.3), 0.3),
    Dumbbell(0.5, separation=1.6, bar=0.25, fillet=0.1),
]


@pytest.mark.parametrize("shape", EXACT, ids=lambda shape: type(shape).__name__)
def test_closed_forms_are_the_integrals_over_the_inside(shape):
    found = second_moments(shape)
    size = measure(shape).inertia
    np.testing.assert_allclose(found, _of_cells(shape), atol=2e-5 * size)
    assert np.trace(found) == pytest.approx(size, rel=1e-12)


def test_a_cuboid_has_a_twelfth_of_its_squared_sides():
    found = second_moments(Box((1.0, 2.0, 3.0)))
    np.testing.assert_allclose(found, np.diag([1.0, 4.0, 9.0]) / 2.0)


def test_what_is_moved_has_its_moments_turned():
    box, angle = Box((1.0, 2.0, 3.0)), (0.3, -0.5, 0.9)
    turn = rotation(angle)
    found = second_moments(box.moved((4.0, 5.0, 6.0), angle))
    np.testing.assert_allclose(found, turn @ second_moments(box) @ turn.T, atol=1e-12)


def cuboid(sides, center):
    """A cuboid of twelve triangles."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - 0.5
    square = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in square for face in ((a, b, c), (a, c, d))]
    return TriangleMesh(corners * sides + center, faces)


def test_a_triangle_mesh_has_those_of_its_solid():
    solid = cuboid(np.array([1.0, 2.0, 3.0]), np.array([5.0, -2.0, 0.5]))
    np.testing.assert_allclose(second_moments(solid), np.diag([0.5, 2.0, 4.5]), atol=1e-12)


def test_other_shapes_are_measured_on_cells_with_the_trace_of_their_measure():
    ball = SlottedSphere(0.5, width=0.2, depth=0.6)
    found = second_moments(ball)
    assert np.trace(found) == pytest.approx(measure(ball).inertia, rel=1e-12)
    np.testing.assert_allclose(found, found.T, atol=1e-15)
    assert found[0, 0] > found[1, 1]  # the slot is cut along y, near x = 0
