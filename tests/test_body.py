"""Bodies: a shape that a pose carries, with the mass and motion it states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.measure import measure
from levelset.shape import rotation
from levelset.shapes import Box, Disk, Ellipsoid, Naca, Sphere, TriangleMesh
from pmesh.bodies.body import RigidBody, launched
from pmesh.bodies.motion import Fixed, Free, Prescribed, Spring
from pmesh.bodies.pose import still
from remesh.errors import InputError

SHAPES = [
    Disk(radius=0.5, center=(1, 2)),
    Box(size=(1.0, 2.0)),
    Naca("2412").moved((0.3, 0.1), -0.2),
    Disk(0.5) | Box((2.0, 0.2), center=(1.0, 0.0)),
    Sphere(0.5, center=(0, 1, 0)),
]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_body_starts_where_its_shape_was_placed(shape, dtype):
    body = RigidBody(shape)
    pose = body.start()
    points = np.random.default_rng(3).uniform(-3, 3, (body.ndim, 50)).astype(dtype)
    assert body.ndim == shape.ndim
    assert pose.center == measure(shape).center
    np.testing.assert_array_equal(body.distance(points, pose), shape.distance(points))
    assert body.bounds(pose) == shape.bounds()
    assert not pose.rigid(points).any()
    assert body.deformation(points, pose) is None
    assert body.placed() == pose
    inertia = body.inertia(replace(pose, time=3.0))
    sides = 1 if body.ndim == 2 else 2  # the trace of the tensor is twice the polar moment
    total = float(np.trace(np.atleast_2d(inertia)))
    assert total == pytest.approx(sides * measure(shape).inertia, rel=1e-14)
    assert not body.deforming
    assert body.period == math.inf


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_distance_goes_with_the_pose(shape, dtype):
    body = RigidBody(shape)
    turns = (0.8,) if shape.ndim == 2 else (0.3, -0.5, 0.8)
    pose = replace(still((0.4, -0.7, 0.2)[: shape.ndim]), angle=turns)
    own = np.random.default_rng(3).uniform(-2, 2, (body.ndim, 9, 5)).astype(dtype)
    there = pose.placed(own)
    asked = shape.distance(own + np.array(body.measure.center, dtype)[:, None, None])
    found = body.distance(there, pose)
    assert found.dtype == dtype
    assert found == pytest.approx(asked, abs=1e-13 if dtype == np.float64 else 2e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_bounds_hold_the_body_at_any_pose(shape):
    body = RigidBody(shape)
    turns = (2.2,) if shape.ndim == 2 else (0.3, -0.5, 0.8)
    pose = replace(still((0.4, -0.7, 0.2)[: shape.ndim]), angle=turns)
    low, high = body.bounds(pose)
    points = np.random.default_rng(4).uniform(-4, 4, (body.ndim, 20000))
    inside = points[:, body.distance(points, pose) < 0]
    assert inside.size
    assert (inside.min(axis=1) >= low).all()
    assert (inside.max(axis=1) <= high).all()


def test_the_length_is_the_longest_extent():
    assert RigidBody(Box((1.0, 3.0))).length == 3.0
    assert RigidBody(Naca("0012", chord=2.0)).length == pytest.approx(2.0, rel=1e-5)


def test_a_free_body_starts_with_its_own_velocity_and_a_led_one_with_its_law():
    free = RigidBody(Disk(0.5), motion=Free(velocity=(1.0, 2.0), spin=3.0)).start()
    assert (free.velocity, free.spin) == ((1.0, 2.0), (3.0,))
    assert RigidBody(Disk(0.5), motion=Free()).start() == still((0.0, 0.0))
    led = RigidBody(Disk(0.5, center=(1, 0)), motion=Prescribed(shift=lambda t: (1 + t, 0))).start()
    assert led.center == (2.0, 0.0)
    assert led.velocity == pytest.approx((1.0, 0.0), abs=1e-10)


def test_a_body_is_a_value():
    assert RigidBody(Disk(radius=0.5)) == RigidBody(Disk(radius=0.5), motion=Fixed())
    assert hash(RigidBody(Disk(radius=0.5))) == hash(RigidBody(Disk(radius=0.5)))
    assert RigidBody(Disk(radius=0.5)) != RigidBody(Disk(radius=0.6))
    assert RigidBody(Disk(0.5), motion=Free()) != RigidBody(Disk(0.5), motion=Free(density=2))


def test_what_is_no_shape_or_no_motion_is_refused():
    with pytest.raises(InputError, match="needs a shape, got float"):
        RigidBody(0.5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"motion must be Fixed\(\)") as caught:
        RigidBody(Disk(radius=0.5), motion="still")  # type: ignore[arg-type]
    assert caught.value.hint == "motion=pmesh.Fixed()"


def test_a_free_body_in_space_has_three_spins_and_a_tensor_that_turns_with_it():
    motion = Free(velocity=(1.0, 2.0, 3.0), spin=(0.1, 0.2, 0.3), locked=())
    body = RigidBody(Ellipsoid((0.5, 0.3, 0.2)), motion=motion)
    start = body.start()
    assert (start.velocity, start.spin) == ((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    volume = body.measure.volume
    own = volume / 5 * np.diag([0.13, 0.29, 0.34])
    np.testing.assert_allclose(body.inertia(start), own, rtol=1e-12)
    turn = (0.3, -0.5, 0.8)
    matrix = rotation(turn)
    found = body.inertia(replace(start, angle=turn))
    np.testing.assert_allclose(found, matrix @ own @ matrix.T, atol=1e-12)


def test_a_body_from_an_stl_file_weighs_as_much_as_its_solid(tmp_path):
    """A cuboid 1 x 2 x 3 of twelve triangles, written and read again."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) * (1, 2, 3.0)
    square = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in square for face in ((a, b, c), (a, c, d))]
    lines = ["solid cuboid"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*corners[k]) for k in face]
        lines += ["endloop", "endfacet"]
    path = tmp_path / "cuboid.stl"
    path.write_text("\n".join([*lines, "endsolid cuboid"]))
    solid = TriangleMesh.from_file(str(path))
    body = RigidBody(solid.moved((1.0, 0.0, 0.0)), motion=Free(density=2.0))
    pose = body.start()
    assert pose.center == pytest.approx((1.5, 1.0, 1.5))
    assert body.measure.volume == pytest.approx(6.0)
    np.testing.assert_allclose(body.inertia(pose), np.diag([6.5, 5.0, 2.5]), atol=1e-12)
    turned = replace(pose, angle=(0.0, 0.0, np.pi / 2))
    assert body.bounds(turned)[0] == pytest.approx((0.5, 0.5, 0.0))
    assert body.bounds(turned)[1] == pytest.approx((2.5, 1.5, 3.0))
    points = np.array([[1.5, 2.4], [1.0, 1.0], [1.5, 1.5]])
    np.testing.assert_allclose(body.distance(points, turned), [-0.5, -0.1], atol=1e-12)


def test_a_ball_that_turns_keeps_its_box():
    body = RigidBody(Sphere(0.5, center=(1.0, 0.0, 0.0)), motion=Free())
    turned = replace(body.start(), angle=(0.3, -0.5, 0.8))
    assert body.bounds(turned)[0] == pytest.approx((0.5, -0.5, -0.5))


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        (Free(velocity=(1.0,)), r"Free velocity must have 2 components, got \(1.0,\)"),
        (Free(gravity=(0.0, 0.0, -1.0)), "Free gravity must have 2 components"),
        (Free(spring=Spring(stiffness=(1.0,))), "Free spring stiffness must have 2 components"),
        (Free(spin=(0.0, 0.0, 1.0)), "Free spin must be a number in 2 dimensions"),
        (Free(locked=("turn_x",)), 'Free locks "turn_x" of a body in 2 dimensions'),
    ],
)
def test_vectors_of_another_dimension_are_refused(motion, said):
    with pytest.raises(InputError, match=said):
        launched(still((0.0, 0.0)), motion)


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        (Free(velocity=(1.0, 0.0)), "Free velocity must have 3 components"),
        (Free(spin=1.0), "Free spin must be 3 numbers in 3 dimensions, got 1.0"),
        (Free(locked=("angle",)), 'Free locks "angle" of a body in 3 dimensions'),
    ],
)
def test_vectors_of_the_plane_are_refused_in_space(motion, said):
    with pytest.raises(InputError, match=said):
        RigidBody(Sphere(0.5), motion=motion)
