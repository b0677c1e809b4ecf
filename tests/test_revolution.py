"""Laws of surfaces of revolution that shrink by their mean curvature."""

import numpy as np
import pytest

from pmesh.cases.revolution import drop, shrink, spaced


def half_circle(count, start):
    turn = np.linspace(start, 0.0, count)
    line = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    line[-1, 1] = 0.0
    if start == np.pi:
        line[0, 1] = 0.0
    return line


@pytest.mark.parametrize(("start", "mirrored"), [(np.pi / 2, True), (np.pi, False)])
def test_a_sphere_vanishes_after_a_quarter_of_its_squared_radius(start, mirrored):
    found = shrink(half_circle(200, start), until=1.0, mirrored=mirrored)
    assert found.end == pytest.approx(0.25, rel=1e-3)
    share = 0.5 if mirrored else 1.0
    radius = np.sqrt(np.maximum(1 - 4 * found.time, 0))
    np.testing.assert_allclose(found.volume, share * 4 / 3 * np.pi * radius**3, atol=2e-3)


def test_a_long_bar_pinches_like_a_cylinder():
    # a ball at the end of a bar so long that its middle does not know of it
    turn = np.linspace(np.pi - np.arcsin(0.05 / 0.2), 0.0, 400)
    ball = np.stack([1.4 + 0.2 * np.cos(turn), 0.2 * np.sin(turn)], axis=1)
    ball[-1, 1] = 0.0
    line = spaced(np.concatenate([[[0.0, 0.05]], ball]), 400)
    found = shrink(line, until=1.0, mirrored=True)
    assert found.end == pytest.approx(0.05**2 / 2, rel=2e-3)
    half = found.time < 0.5 * found.end
    np.testing.assert_allclose(
        found.curves[half, 0, 1], np.sqrt(0.05**2 - 2 * found.time[half]), rtol=1e-3
    )


def test_the_curve_stops_when_the_time_is_up():
    found = shrink(half_circle(50, np.pi), until=0.1, mirrored=False, frames=5)
    assert found.end == 0.1
    assert found.curves.shape == (5, 50, 2)
    np.testing.assert_allclose(found.curves[-1, 0], [-np.sqrt(0.6), 0], atol=2e-3)


def test_a_drop_begins_on_the_axis_where_the_neck_grows():
    x = np.linspace(0, 1, 101)
    line = np.stack([x, 0.01 + x**2], axis=1)
    closed = drop(line)
    assert closed.shape == line.shape
    assert closed[0, 1] == 0
    assert closed[0, 0] == pytest.approx(0.1, abs=0.011)
    np.testing.assert_allclose(np.hypot(*np.diff(closed, axis=0).T).std(), 0, atol=1e-3)
