"""Contours lie on the edge, go around the inside anticlockwise, and are closed."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.contour import contour
from levelset.shapes import Box, Disk, Ellipse, Naca, Sphere
from remesh.errors import InputError


def area(ring):
    there = np.roll(ring, -1, axis=0)
    return 0.5 * np.sum(ring[:, 0] * there[:, 1] - there[:, 0] * ring[:, 1])


def test_the_points_are_on_the_edge_to_second_order():
    ellipse = Ellipse((1.0, 0.4), center=(0.2, 0.1))
    off = [
        max(np.abs(ellipse.distance(r.T)).max() for r in contour(ellipse, cells=n))
        for n in (100, 400)
    ]
    assert 4**1.8 < off[0] / off[1] < 4**2.2  # the order is 2 within 0.2


def test_neighbours_are_within_a_cell_and_the_line_is_closed():
    (ring,) = contour(Disk(0.5), cells=64)
    steps = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    assert steps.max() < np.sqrt(2.0) / 64 * (1 + 1e-12)


@pytest.mark.parametrize("shape", [Disk(0.5, center=(3, 1)), Box((2.0, 0.3)), Naca("2412")])
def test_the_line_goes_anticlockwise_around_the_inside(shape):
    (ring,) = contour(shape)
    assert area(ring) == pytest.approx(shape.volume, rel=1e-3)


def test_holes_go_clockwise_and_parts_are_apart():
    areas = sorted(area(ring) for ring in contour(Disk(1.0) - Disk(0.5)))
    assert areas == pytest.approx([-np.pi / 4, np.pi], rel=1e-3)
    areas = sorted(area(r) for r in contour(Disk(0.3) | Disk(0.2, center=(1.0, 0.0))))
    assert areas == pytest.approx([0.04 * np.pi, 0.09 * np.pi], rel=1e-3)


def test_the_contour_of_a_mirrored_shape_is_mirrored():
    points = np.concatenate(contour(Ellipse((1.0, 0.3)), cells=101))
    flipped = points * (1.0, -1.0)
    apart = np.hypot(*(points[:, None] - flipped[None]).transpose(2, 0, 1)).min(axis=1)
    assert apart.max() < 1e-12


def test_a_shape_in_space_is_refused():
    with pytest.raises(InputError, match="a contour is drawn of a plane shape, got 3 dimensions"):
        contour(Sphere(1.0))
