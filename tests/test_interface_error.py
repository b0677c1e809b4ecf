"""The mean distance between an interface and a shape's surface is what lies between them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.shapes import Box, Disk, SlottedDisk, Sphere
from pmesh.cases.interface_error import mean_error
from remesh.errors import InputError


def test_a_shape_is_no_distance_from_itself():
    disk = SlottedDisk(center=(50.0, 75.0))
    assert mean_error(disk, lambda points: disk.distance(points.T), 1.0) == 0.0


@pytest.mark.parametrize("gap", [0.05, 0.5])
def test_a_larger_disk_is_its_ring_away(gap):
    """(R + g)^2 - R^2 over 2 R, in spacings of h = 0.1: g + g^2 / 2 R."""
    disk, wider = Disk(2.0), Disk(2.0 + 0.1 * gap)
    found = mean_error(disk, lambda points: wider.distance(points.T), 0.1)
    assert found == pytest.approx(gap + 0.1 * gap**2 / 4.0, abs=3e-3)


def test_a_larger_sphere_is_its_shell_away():
    ball, wider = Sphere(1.0), Sphere(1.02)
    found = mean_error(ball, lambda points: wider.distance(points.T), 0.1, fine=6, reach=1.0)
    assert found == pytest.approx((1.02**3 - 1) / 3 / 0.1, rel=0.02)


def test_walls_along_the_mesh_are_counted_fairly():
    """A box moved by a hundredth of a spacing: two of four walls, |shift| each."""
    box = Box((4.0, 4.0))
    moved = box.moved((0.01, 0.0))
    found = mean_error(box, lambda points: moved.distance(points.T), 1.0, fine=30, reach=0.5)
    assert found == pytest.approx(0.005, rel=0.1)


def test_both_sides_count():
    disk = Disk(1.0)
    moved = disk.moved((0.02, 0.0))
    found = mean_error(disk, lambda points: moved.distance(points.T), 0.1)
    assert found == pytest.approx(0.2 * 2 / math.pi, rel=0.03)  # the mean of |cos|


def test_a_surface_without_closed_form_is_refused():
    both = Disk(1.0) | Disk(1.0, center=(0.5, 0.0))
    with pytest.raises(InputError, match="surface is not known"):
        mean_error(both, lambda points: np.ones(len(points)), 0.1)
