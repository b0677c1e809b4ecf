"""Poses: seeing and placing are inverse, and the rigid velocity is the rate of the place."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmesh.bodies.pose import Pose, still

PLANE = Pose(time=0.3, center=(0.4, -1.2), angle=(0.7,), velocity=(0.5, -0.25), spin=(1.5,))
SPACE = Pose(
    time=0.3,
    center=(0.4, -1.2, 0.1),
    angle=(0.7, -0.2, 0.4),
    velocity=(0.5, -0.25, 2.0),
    spin=(1.5, 0.3, -0.6),
)
POSES = pytest.mark.parametrize("pose", [PLANE, SPACE], ids=["plane", "space"])


def scattered(pose, *shape):
    return np.random.default_rng(2).uniform(-2, 2, (len(pose.center), *shape))


@POSES
@pytest.mark.parametrize("shape", [(), (5,), (3, 4)])
def test_seeing_and_placing_are_inverse(pose, shape):
    points = scattered(pose, *shape)
    assert pose.seen(points).shape == points.shape
    assert pose.placed(pose.seen(points)) == pytest.approx(points, abs=1e-14)
    assert pose.seen(pose.placed(points)) == pytest.approx(points, abs=1e-14)


@POSES
def test_the_centre_is_seen_at_the_origin_and_distances_are_kept(pose):
    center = np.array(pose.center)
    assert pose.seen(center) == pytest.approx(np.zeros(len(center)))
    points = scattered(pose, 20)
    away = np.linalg.norm(points - center[:, None], axis=0)
    assert np.linalg.norm(pose.seen(points), axis=0) == pytest.approx(away, rel=1e-14)
    assert np.linalg.norm(pose.turned(points), axis=0) == pytest.approx(
        np.linalg.norm(points, axis=0), rel=1e-14
    )


def test_a_positive_angle_turns_anticlockwise():
    pose = replace(still((1.0, 0.0)), angle=(math.pi / 2,))
    assert pose.turned(np.array([1.0, 0.0])) == pytest.approx([0.0, 1.0])
    assert pose.seen(np.array([1.0, 2.0])) == pytest.approx([2.0, 0.0])


@POSES
def test_the_rigid_velocity_is_the_rate_of_the_place(pose):
    if len(pose.spin) == 3:  # angles add up about one axis only
        pose = replace(pose, angle=(0.0, 0.0, 0.7), spin=(0.0, 0.0, 1.5))
    step = 1e-5

    def later(dt):
        return replace(
            pose,
            center=tuple(np.add(pose.center, np.multiply(dt, pose.velocity))),
            angle=tuple(np.add(pose.angle, np.multiply(dt, pose.spin))),
        )

    own = scattered(pose, 30)
    rate = (later(step).placed(own) - later(-step).placed(own)) / (2 * step)
    assert pose.rigid(pose.placed(own)) == pytest.approx(rate, abs=1e-8)


def test_a_rigid_velocity_in_space_turns_about_the_spin():
    pose = replace(SPACE, velocity=(0.0, 0.0, 0.0))
    along = np.array(pose.center) + 2.0 * np.array(pose.spin)
    assert pose.rigid(along) == pytest.approx(np.zeros(3), abs=1e-15)
    point = np.array([1.0, 2.0, 3.0])
    expected = np.cross(pose.spin, point - pose.center)
    assert pose.rigid(point) == pytest.approx(expected, abs=1e-15)


@POSES
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_precision_is_kept(pose, dtype):
    points = scattered(pose, 7).astype(dtype)
    for law in (pose.seen, pose.placed, pose.turned, pose.rigid):
        assert law(points).dtype == dtype
        assert law(points) == pytest.approx(law(points.astype(float)), abs=3e-6)


@pytest.mark.parametrize("center", [(0.5, 1.0), (0.5, 1.0, 2.0)])
def test_a_still_pose_neither_moves_nor_turns(center):
    pose = still(center, 2.0)
    points = scattered(pose, 5)
    assert pose.time == 2.0
    assert not pose.rigid(points).any()
    assert pose.seen(points) == pytest.approx(points - np.array(center)[:, None])
