"""Bodies: where they are, and that they stand still."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Sphere
from pmesh.bodies.body import Fixed, RigidBody
from remesh.errors import InputError


@pytest.mark.parametrize(
    ("shape", "ndim"),
    [(Disk(radius=0.5, center=(1, 2)), 2), (Box(size=(1.0, 2.0)), 2), (Sphere(0.5), 3)],
)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_rigid_body_is_where_its_shape_is_and_does_not_move(shape, ndim, dtype):
    body = RigidBody(shape)
    assert body.ndim == ndim
    points = np.random.default_rng(3).uniform(-3, 3, (ndim, 50)).astype(dtype)
    for time in (0.0, 7.0):
        np.testing.assert_array_equal(body.distance(points, time), shape.distance(points))
        velocity = body.velocity(points, time)
        assert velocity.shape == points.shape
        assert velocity.dtype == dtype
        assert not velocity.any()
        assert body.bounds(time) == shape.bounds()


def test_the_bounds_hold_the_body():
    body = RigidBody(Disk(radius=0.5, center=(1.0, 2.0)) | Box(size=(1.0, 3.0)))
    low, high = body.bounds(0.0)
    points = np.random.default_rng(4).uniform(-4, 4, (2, 4000))
    inside = points[:, body.distance(points, 0.0) < 0]
    assert (inside.min(axis=1) >= low).all()
    assert (inside.max(axis=1) <= high).all()


def test_a_body_is_a_value():
    assert RigidBody(Disk(radius=0.5)) == RigidBody(Disk(radius=0.5), motion=Fixed())
    assert hash(RigidBody(Disk(radius=0.5))) == hash(RigidBody(Disk(radius=0.5)))
    assert RigidBody(Disk(radius=0.5)) != RigidBody(Disk(radius=0.6))


def test_what_is_no_shape_or_no_motion_is_refused():
    with pytest.raises(InputError, match="needs a shape, got float"):
        RigidBody(0.5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"motion must be Fixed\(\)") as caught:
        RigidBody(Disk(radius=0.5), motion="still")  # type: ignore[arg-type]
    assert caught.value.hint == "motion=pmesh.Fixed()"
