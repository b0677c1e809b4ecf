"""Ellipses and ellipsoids: foot points, degenerate places, lengths and areas known otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.ellipse import Ellipse, Ellipsoid
from levelset.shapes import Disk, Sphere
from remesh.errors import InputError


def test_ellipse_distance_equals_a_dense_search_of_its_edge():
    for a, b in ((2.0, 0.05), (1.0, 1.0), (0.3, 1.7)):
        ellipse = Ellipse((a, b))
        angle = np.linspace(0.0, 2.0 * np.pi, 400_001)
        edge = np.stack([a * np.cos(angle), b * np.sin(angle)])
        points = np.array(
            [
                [0.0, 0.5 * a, a, 1.9, 1e-12, -0.7, 0.0],
                [0.0, 0.0, 0.0, 1e-14, 0.9 * b, 2.2, 1.5 * b],
            ]
        )
        nearest = [np.hypot(*(edge - p[:, None])).min() for p in points.T]
        assert np.abs(ellipse.distance(points)) == pytest.approx(nearest, abs=1e-9)


@pytest.mark.parametrize("axes", [(1.0, 0.3, 0.6), (0.2, 1.5, 1.5), (0.7, 0.7, 0.7), (2, 0.05, 1)])
def test_an_ellipsoid_stepped_off_along_its_normal_is_found_again(axes):
    """From a point of the surface along the normal, less far than the least radius of curvature."""
    rng = np.random.default_rng(4)
    way = rng.normal(size=(3, 400))
    way /= np.sqrt((way**2).sum(axis=0))
    column = np.array(axes, float)[:, None]
    foot, normal = column * way, way / column
    normal /= np.sqrt((normal**2).sum(axis=0))
    away = rng.uniform(-0.99 * min(axes) ** 2 / max(axes), 2.0, 400)
    found = Ellipsoid(axes).distance(foot + away * normal)
    assert found == pytest.approx(away, abs=1e-13)


def test_the_sections_and_the_middle_of_an_ellipsoid_are_met():
    solid = Ellipsoid((1.5, 0.5, 0.8))
    points = np.array([[0.0, 1.5, 0, 0, 1.4], [0.0, 0, 0.5, 0, 0], [0.0, 0, 0, 0.8, 0]])
    # on the long axis, beyond a - b^2/a, the end is nearest
    assert solid.distance(points) == pytest.approx([-0.5, 0, 0, 0, -0.1], abs=1e-15)
    flat, plane = Ellipsoid((1.5, 0.5, 1e9)), Ellipse((1.5, 0.5))
    points = np.random.default_rng(1).uniform(-2, 2, (3, 200))
    assert flat.distance(points) == pytest.approx(plane.distance(points[:2]), abs=1e-6)


def test_round_ones_are_disks_and_balls():
    points = np.random.default_rng(1).uniform(-2, 2, (3, 200))
    assert Ellipsoid((0.7,) * 3).distance(points) == pytest.approx(Sphere(0.7).distance(points))
    assert Ellipse((0.7,) * 2).distance(points[:2]) == pytest.approx(Disk(0.7).distance(points[:2]))
    assert Ellipsoid((0.7,) * 3).surface == pytest.approx(Sphere(0.7).surface, rel=1e-14)
    assert Ellipse((0.7,) * 2).surface == pytest.approx(Disk(0.7).surface, rel=1e-14)


def test_spheroids_have_the_area_of_the_plain_formulas():
    a, c = 1.0, 0.4  # oblate, then prolate
    e = math.sqrt(1 - c * c / (a * a))
    oblate = 2 * math.pi * a * a * (1 + (1 - e * e) / e * math.atanh(e))
    prolate = 2 * math.pi * c * c * (1 + a / (c * e) * math.asin(e))
    assert Ellipsoid((a, a, c)).surface == pytest.approx(oblate, rel=1e-14)
    assert Ellipsoid((a, c, c)).surface == pytest.approx(prolate, rel=1e-14)


def test_an_ellipsoid_needs_three_axes():
    with pytest.raises(InputError, match="Ellipsoid: axes must hold 3 finite numbers"):
        Ellipsoid((1.0, 2.0))
