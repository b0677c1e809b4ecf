"""Markers lie evenly on lines of equal distance and fill the bodies."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.markers import markers_of
from remesh.errors import InputError
from remesh.grid import Grid

H = 1 / 16
GRID = Grid((64, 64), H, (-2.0, -2.0))
DISK = RigidBody(Disk(radius=1.0, center=(0.1, -0.2)))


def found(*bodies: RigidBody, depth: float = 0.7 * H, spacing: float = 1.0):
    poses = tuple(body.start() for body in bodies)
    return markers_of(bodies, poses, GRID, spacing, depth)


def test_lines_lie_one_spacing_apart_from_the_given_depth():
    markers = found(DISK)
    depth = -DISK.distance(markers.positions.T, DISK.start())
    lines = (depth[depth < 0.7] - 0.7 * H) / H  # rings around the centre are polygons
    np.testing.assert_allclose(lines, np.round(lines), atol=0.02)
    assert depth.min() == pytest.approx(0.7 * H, abs=1e-3)
    assert depth.max() > 1.0 - H


@pytest.mark.parametrize("spacing", [0.7, 1.0, 1.5])
def test_markers_of_a_line_are_spaced_as_asked(spacing):
    markers = found(DISK, spacing=spacing)
    depth = -DISK.distance(markers.positions.T, DISK.start())
    first = markers.positions[depth < H]
    gaps = np.hypot(*(np.roll(first, -1, axis=0) - first).T)
    np.testing.assert_allclose(gaps, spacing * H, rtol=0.03)
    np.testing.assert_allclose(markers.weight[: len(first)], spacing, rtol=0.02)


def test_weights_sum_to_the_area_that_is_held():
    """Each line stands for a ring of one spacing: the disk of radius R - depth + h/2."""
    markers = found(DISK)
    area = np.pi * (1.0 - 0.7 * H + 0.5 * H) ** 2
    assert markers.weight.sum() * H**2 == pytest.approx(area, rel=0.01)


def test_markers_go_with_their_body():
    here = found(DISK)
    pose = DISK.start()
    there = markers_of(
        (DISK,), (type(pose)(time=1.0, center=(0.1 + 8 * H, -0.2), angle=(0.0,),
        velocity=(1.0, 0.0), spin=(0.0,)),), GRID, 1.0, 0.7 * H,
    )  # fmt: skip
    np.testing.assert_allclose(
        there.positions - here.positions, [[8 * H, 0.0]] * len(here.weight), atol=1e-12
    )


def test_bodies_stand_one_after_the_other():
    box = RigidBody(Box(size=(0.4, 0.6), center=(1.5, 0.0)))
    both = found(DISK, box)
    assert len(both.weight) == len(found(DISK).weight) + len(found(box).weight)


def test_a_body_too_thin_for_a_line_is_refused():
    with pytest.raises(InputError, match="no inside deeper"):
        found(RigidBody(Disk(radius=0.5 * H)))


def test_bodies_in_space_are_refused():
    ball = RigidBody.__new__(RigidBody)
    object.__setattr__(ball, "shape", Sphere(radius=1.0))
    with pytest.raises(InputError, match="plane bodies"):
        markers_of((ball,), (), Grid((8, 8, 8), 1.0), 1.0, 0.5)
