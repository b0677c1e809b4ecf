"""Cameras: where points are in a picture, by the laws of perspective."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.camera import LENS, MARGIN, aimed

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-2, 2) for z in (0, 1)], float)
VIEWS = [(-90.0, 0.0), (-55.0, 22.0), (130.0, 60.0), (10.0, -35.0), (0.0, 90.0)]


@pytest.mark.parametrize("view", VIEWS)
def test_all_points_are_in_the_picture_and_reach_its_margin(view: tuple[float, float]) -> None:
    size = (400, 300)
    places = aimed(CORNERS, view, size).project(CORNERS)
    x, y = places[:, 0] + 0.5, places[:, 1] + 0.5
    edges = [MARGIN * 400, (1 - MARGIN) * 400, MARGIN * 300, (1 - MARGIN) * 300]
    found = np.array([x.min(), x.max(), y.min(), y.max()])
    gaps = (found - edges) * [1, -1, 1, -1]
    assert (gaps > -1e-9).all()
    assert min(gaps[0] + gaps[1], gaps[2] + gaps[3]) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("view", VIEWS)
def test_the_ray_of_a_pixel_meets_what_is_seen_there(view: tuple[float, float]) -> None:
    camera = aimed(CORNERS, view, (64, 48))
    rays = camera.rays()
    points = camera.eye + 3.7 * rays
    places = camera.project(points.reshape(-1, 3)).reshape(48, 64, 3)
    rows, columns = np.mgrid[:48, :64]
    assert places[..., 0] == pytest.approx(columns, abs=1e-9)
    assert places[..., 1] == pytest.approx(rows, abs=1e-9)
    assert places[..., 2] == pytest.approx(1 / 3.7)


def test_the_axes_of_the_picture_are_those_told() -> None:
    camera = aimed(CORNERS, (-90.0, 0.0), (64, 48))
    assert camera.right == pytest.approx([1, 0, 0])
    assert camera.up == pytest.approx([0, 0, 1])
    assert camera.back == pytest.approx([0, -1, 0])


def test_twice_as_far_is_half_as_large() -> None:
    camera = aimed(CORNERS, (-90.0, 0.0), (200, 100))
    sizes = []
    for depth in (1.0, 2.0):
        here = camera.eye - depth * camera.back
        ends = camera.project(np.stack([here - 0.1 * camera.up, here + 0.1 * camera.up]))
        sizes.append(ends[0, 1] - ends[1, 1])
    assert sizes[0] == pytest.approx(2 * sizes[1])
    assert sizes[0] == pytest.approx(0.2 / (2 * math.tan(math.radians(LENS / 2))) * 100)


def test_what_is_behind_the_eye_has_a_negative_nearness() -> None:
    camera = aimed(CORNERS, (-90.0, 0.0), (200, 100))
    assert camera.project((camera.eye + camera.back)[None])[0, 2] == pytest.approx(-1.0)
