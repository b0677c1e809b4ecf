"""Zalesak's bodies: published measures, and distances against a search of the whole boundary."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.measure import measure
from levelset.slotted import SlottedDisk, SlottedSphere
from remesh.errors import InputError

SLOTS = [(1.0, 0.4, 0.9), (1.0, 0.4, 1.5), (1.0, 1.2, 0.3), (1.0, 0.5, 1.0)]


def test_zalesaks_disk_has_the_published_area_and_perimeter():
    """Area 582.2070306 and perimeter 143.8047 for radius 15, slot 5 x 25."""
    disk = SlottedDisk()
    assert disk.area == pytest.approx(582.2070306, rel=1e-9)
    assert disk.perimeter == pytest.approx(143.8047, abs=5e-5)


def test_zalesaks_sphere_has_the_published_volume():
    """12757.888 for radius 15 and a slot 5 wide and 12.5 deep."""
    assert SlottedSphere().volume == pytest.approx(12757.888, abs=5e-4)


def boundary(shape, count):
    """Points of all pieces of a slotted ball's boundary."""
    rng = np.random.default_rng(8)
    r, h, e = shape.radius, 0.5 * shape.width, shape.depth - shape.radius
    ball = rng.normal(size=(3, count))
    ball *= r / np.sqrt((ball**2).sum(axis=0))
    flat = rng.uniform(-r, r, (2, count))
    wall = np.stack([np.full(count, h), *flat])
    end = np.stack([*flat, np.full(count, e)])
    return np.concatenate(
        [
            ball[:, (np.abs(ball[0]) >= h) | (ball[2] >= e)],
            *(
                (np.array([[sign], [1], [1]]) * wall)[
                    :, (flat[1] <= e) & (h**2 + (flat**2).sum(0) <= r**2)
                ]
                for sign in (-1, 1)
            ),
            end[:, (np.abs(flat[0]) <= h) & (e**2 + (flat**2).sum(0) <= r**2)],
        ],
        axis=1,
    ).T


@pytest.mark.parametrize("slot", SLOTS)
def test_the_distance_is_that_to_the_nearest_point_of_the_boundary(slot):
    from scipy.spatial import KDTree

    shape = SlottedSphere(*slot)
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (3, 3000))
    near, _ = KDTree(boundary(shape, 200_000)).query(points.T)
    gap = near - np.abs(shape.distance(points))
    assert gap.min() > -1e-12  # no sample is nearer
    assert gap.max() < 0.05  # and some are nearly as near
    assert np.mean(gap) < 2e-3


@pytest.mark.parametrize("slot", SLOTS)
def test_the_inside_is_the_ball_without_the_slot(slot):
    shape = SlottedSphere(*slot, center=(0.1, -0.2, 0.3))
    x, y, z = points = np.random.default_rng(2).uniform(-1.5, 1.5, (3, 5000))
    r, w, d = slot
    ball = (x - 0.1) ** 2 + (y + 0.2) ** 2 + (z - 0.3) ** 2 < r * r
    slit = (np.abs(x - 0.1) < 0.5 * w) & (z - 0.3 < d - r)
    assert np.array_equal(shape.distance(points) < 0, ball & ~slit)


@pytest.mark.parametrize("slot", SLOTS)
def test_volume_centre_and_inertia_are_those_of_a_sum_over_slices(slot):
    """Sections at x: circles, their part below the slot's end cut away; Gauss in x, z."""
    shape = SlottedSphere(*slot, center=(1.0, 2.0, 3.0))
    r, h, e = slot[0], 0.5 * slot[1], slot[2] - slot[0]
    nodes, weights = np.polynomial.legendre.leggauss(80)
    sums = np.zeros(3)
    for a, b, bottom in ((h, r, False), (-h, h, True), (-r, -h, False)):
        low, high = np.arcsin(min(a, b) / r), np.arcsin(max(a, b) / r)
        turn = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        for x, across, w in zip(
            r * np.sin(turn), r * np.cos(turn), 0.5 * (high - low) * weights, strict=True
        ):
            start = np.arcsin(e / across) if bottom else -0.5 * np.pi
            lift = 0.5 * (0.5 * np.pi - start)
            angle = start + lift * (1 + nodes)
            z, y = across * np.sin(angle), across * np.cos(angle)
            area = w * across * lift * weights * y * 2 * y  # dz = y dangle, 2 y wide; dx = r cos
            sums += area.sum(), (area * z).sum(), (area * (x * x + z * z + y * y / 3)).sum()
    found = measure(shape)
    assert found.volume == pytest.approx(sums[0], rel=1e-9)
    assert found.center == pytest.approx((1, 2, 3 + sums[1] / sums[0]), abs=1e-9)
    about = sums[2] - sums[1] ** 2 / sums[0]
    assert found.inertia == pytest.approx(about, rel=1e-9)


def test_the_slotted_disk_has_the_moments_of_its_fine_contour():
    shape = SlottedDisk(1.0, 0.4, 1.5, center=(1.0, 2.0))
    found, drawn = measure(shape), measure(shape | shape)  # a union is measured by its contour
    assert found.volume == pytest.approx(drawn.volume, rel=1e-5)
    assert found.center == pytest.approx(drawn.center, abs=1e-5)
    assert found.inertia == pytest.approx(drawn.inertia, rel=1e-5)


@pytest.mark.parametrize("slot", [(1.0, 2.5, 1.0), (1.0, 0.5, 2.5), (1.0, 0.5, 0.01)])
def test_a_slot_that_does_not_end_inside_is_refused(slot):
    with pytest.raises(InputError, match="must end inside the ball of radius 1"):
        SlottedSphere(*slot)
