"""Gaps between bodies in space: exact, along the common normal, apart or overlapping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from levelset.shape import rotation
from levelset.shapes import Box, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.gaps import contacts
from pmesh.bodies.motion import Free

REACH = 0.1
WAYS = np.random.default_rng(4).normal(size=(3, 3))
WALL = RigidBody(Box((4.0, 4.0, 1.0), center=(0.0, 0.0, -0.5)))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("gap", [-0.03, 0.0, 0.02, 0.09])
def test_two_balls_touch_on_the_line_between_their_centres(way, gap):
    way = way / np.linalg.norm(way)
    one = RigidBody(Sphere(0.5, center=(0.2, 0.1, -0.3)), motion=Free())
    middle = (0.9 + gap) * way + (0.2, 0.1, -0.3)
    two = RigidBody(Sphere(0.4, center=tuple(middle)))
    contact, *others = contacts([one, two], [one.start(), two.start()], REACH)
    assert (contact.first, contact.second) == (0, 1)
    assert contact.gap == pytest.approx(gap, abs=1e-7)
    assert contact.normal == pytest.approx(-way, abs=1e-4)  # from the second to the first
    assert contact.point == pytest.approx((0.5 + gap / 2) * way + (0.2, 0.1, -0.3), abs=1e-4)
    assert all(other.gap >= contact.gap for other in others)


@pytest.mark.parametrize("gap", [-0.02, 0.05])
@pytest.mark.parametrize("angle", [(0.3, 0.2, -0.7), (0.0, 1.2, 0.4)])
def test_the_gap_of_an_ellipsoid_to_a_wall_is_that_of_its_support(gap, angle):
    axes = np.array([0.7, 0.4, 0.5])
    body = RigidBody(Ellipsoid(tuple(axes)), motion=Free())
    below = rotation(angle).T @ [0, 0, 1]
    depth = np.linalg.norm(axes * below)
    foot = -rotation(angle) @ (axes**2 * below) / depth
    pose = replace(body.start(), center=(0.3, 0.2, depth + gap), angle=angle)
    contact = contacts([body, WALL], [pose, WALL.start()], REACH)[0]
    assert contact.gap == pytest.approx(gap, abs=1e-6)
    assert contact.normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-4)
    assert contact.point == pytest.approx((0.3 + foot[0], 0.2 + foot[1], gap / 2), abs=2e-3)


def test_the_corner_of_a_tilted_box_is_what_touches_a_wall():
    box, angle = RigidBody(Box((1.0, 0.8, 0.6)), motion=Free()), (0.5, 0.7, 0.2)
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    corners = (signs * (0.5, 0.4, 0.3)) @ rotation(angle).T
    corner = corners[corners[:, 2].argmin()]
    pose = replace(box.start(), center=(0.0, 0.0, 0.04 - corner[2]), angle=angle)
    contact = contacts([box, WALL], [pose, WALL.start()], REACH)[0]
    assert contact.gap == pytest.approx(0.04, abs=1e-6)
    assert contact.point == pytest.approx((corner[0], corner[1], 0.02), abs=1e-4)


def test_a_box_that_lies_flat_is_held_at_its_corners():
    box = RigidBody(Box((1.0, 0.8, 0.6), center=(0.0, 0.0, 0.33)), motion=Free())
    found = contacts([box, WALL], [box.start(), WALL.start()], REACH)
    assert len(found) >= 4
    places = np.array([contact.point for contact in found])
    assert {(x > 0, y > 0) for x, y, _ in places[np.abs(places[:, 0]) > 0.35]} == {
        (a, b) for a in (False, True) for b in (False, True)
    }
    for contact in found:
        assert contact.gap == pytest.approx(0.03, abs=1e-7)
        assert contact.normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)


def test_bodies_beyond_reach_or_held_have_no_contact():
    one = RigidBody(Sphere(0.5), motion=Free())
    far = RigidBody(Sphere(0.5, center=(0.0, 1.101, 0.0)))
    assert contacts([one, far], [one.start(), far.start()], REACH) == ()
    near = RigidBody(Sphere(0.5, center=(0.0, 1.05, 0.0)))
    assert contacts([near, RigidBody(Sphere(0.5))], [near.start(), one.start()], REACH) == ()
