"""Volume, centre and second moment: exact where a form is known, of order 2 elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.measure import measure
from levelset.shapes import Box, Disk, Ellipse, Ellipsoid, Naca, Polygon, Sphere, Torus

KNOWN = [
    (Disk(0.5, center=(1, 2)), math.pi / 4, (1.0, 2.0), math.pi / 2 * 0.5**4),
    (Sphere(2.0, center=(1, 0, 0)), 32 / 3 * math.pi, (1.0, 0.0, 0.0), 0.6 * 4 * 32 / 3 * math.pi),
    (Ellipse((2.0, 0.5)), math.pi, (0.0, 0.0), math.pi / 4 * (2.0**2 + 0.5**2)),
    (Box((3.0, 1.0)), 3.0, (0.0, 0.0), 3.0 * (9 + 1) / 12),
    (Box((3.0, 1.0, 2.0)), 6.0, (0.0, 0.0, 0.0), 6.0 * (9 + 1 + 4) / 12),
    (Polygon(((0, 0), (0, 2), (3, 2), (3, 0))), 6.0, (1.5, 1.0), 6.0 * (9 + 4) / 12),
    (Polygon(((0, 0), (3, 0), (0, 3))), 4.5, (1.0, 1.0), 4.5),
]


@pytest.mark.parametrize(("shape", "volume", "center", "inertia"), KNOWN)
def test_the_moments_of_plain_shapes_are_exact(shape, volume, center, inertia):
    found = measure(shape)
    assert found.volume == pytest.approx(volume, rel=1e-13)
    assert found.center == pytest.approx(center, abs=1e-13)
    assert found.inertia == pytest.approx(inertia, rel=1e-13)


@pytest.mark.parametrize(("shape", "volume", "center", "inertia"), KNOWN)
def test_the_general_measure_agrees_with_the_exact_one(shape, volume, center, inertia):
    found = measure(shape | shape)  # a union is measured by its contour, or cell by cell
    tolerance = 1e-5 if shape.ndim == 2 else 2e-4
    assert found.volume == pytest.approx(volume, rel=tolerance)
    assert found.center == pytest.approx(center, abs=tolerance)
    assert found.inertia == pytest.approx(inertia, rel=tolerance)


@pytest.mark.parametrize("shape", [Box((2.0, 1.0)) - Disk(0.3, center=(0.5, 0.0)), Naca("4412")])
def test_moving_a_shape_turns_its_centre_and_keeps_its_volume_and_inertia(shape):
    there, turned = measure(shape), measure(shape.moved((1.0, -2.0), math.pi / 2))
    assert turned.volume == there.volume
    assert turned.inertia == there.inertia
    x, y = there.center
    assert turned.center == pytest.approx((1.0 - y, -2.0 + x), abs=1e-14)


def test_a_smooth_body_in_space_is_measured_to_six_digits():
    for shape in (
        Sphere(1.0),
        Torus(0.8, 0.3),
        Ellipsoid((1.3, 0.4, 0.8)).moved((1, 2, 3), (1, 2, 0)),
    ):
        found, known = measure(shape | shape), measure(shape)
        assert found.volume == pytest.approx(known.volume, rel=3e-6)
        assert found.center == pytest.approx(known.center, abs=3e-6)
        assert found.inertia == pytest.approx(known.inertia, rel=1e-5)


def test_holes_are_subtracted_and_parts_are_added():
    ring = measure(Disk(1.0) - Disk(0.5))
    assert ring.volume == pytest.approx(0.75 * math.pi, rel=1e-5)
    assert ring.inertia == pytest.approx(math.pi / 2 * (1 - 0.5**4), rel=1e-5)
    pair = measure(Disk(0.2) | Disk(0.1, center=(1.0, 0.0)))
    assert pair.volume == pytest.approx(0.05 * math.pi, rel=1e-4)
    assert pair.center == pytest.approx((0.2, 0.0), abs=1e-4)
    parallel_axes = math.pi / 2 * (0.2**4 + 0.1**4) + 0.04 * math.pi * 0.04 + 0.01 * math.pi * 0.64
    assert pair.inertia == pytest.approx(parallel_axes, rel=1e-4)


def test_the_measure_of_a_far_shape_keeps_its_digits():
    near, far = measure(Naca("2412")), measure(Naca("2412", center=(1e4, 1e4)))
    assert far.inertia == pytest.approx(near.inertia, rel=1e-7)
    assert np.subtract(far.center, 1e4) == pytest.approx(near.center, abs=1e-9)
