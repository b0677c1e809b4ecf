"""The star: its distance against a dense search, at hard places too; its measures."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from levelset.measure import measure
from levelset.shapes import Disk
from levelset.star import Star


def searched(star, points, count=200_001):
    """Least distance to a dense sample of the edge, then of the edge around its best place."""
    x, y = points
    least = np.inf
    low, high = 0.0, 2 * np.pi
    for _ in range(4):
        t = np.linspace(low, high, count)
        r = star.radius * (1 + star.amplitude * np.cos(star.arms * t))
        away = np.hypot(r * np.cos(t) - x, r * np.sin(t) - y)
        best = int(np.argmin(away))
        least = min(least, away[best])
        step = t[1] - t[0]
        low, high, count = t[best] - 2 * step, t[best] + 2 * step, 2001
    return least


@settings(max_examples=150, deadline=None)
@given(
    st.floats(0, 0.95),
    st.integers(1, 12),
    st.tuples(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5)),
)
def test_the_distance_is_that_of_a_dense_search(amplitude, arms, point):
    star = Star(1.0, amplitude=amplitude, arms=arms)
    found = abs(star.distance(np.array(point)))
    best = searched(star, point, 20_001)
    assert found <= best + 1e-14  # nothing sampled is nearer
    assert found == pytest.approx(best, abs=1e-7)


@pytest.mark.parametrize(("amplitude", "arms"), [(0.3, 5), (0.9, 1), (0.5, 2), (0.6, 9)])
def test_centres_of_curvature_and_axes_of_mirrors_are_met(amplitude, arms):
    """There the squared distance is flat to third order, or two points are equally near."""
    star = Star(1.0, amplitude=amplitude, arms=arms)
    t = np.linspace(0, 2 * np.pi, 37)
    phase = arms * t
    r, dr = 1 + amplitude * np.cos(phase), -amplitude * arms * np.sin(phase)
    ddr = -amplitude * arms**2 * np.cos(phase)
    bend = (r * r + 2 * dr * dr - r * ddr) / (r * r + dr * dr) ** 1.5
    x, y = r * np.cos(t), r * np.sin(t)
    slope = np.stack([dr * np.cos(t) - y, dr * np.sin(t) + x]) / np.hypot(r, dr)
    centres = np.stack([x, y]) + np.stack([-slope[1], slope[0]]) / np.where(bend == 0, 1, bend)
    rays = np.stack([np.cos(np.pi * t / arms), np.sin(np.pi * t / arms)]) * 0.4
    for point in [*centres.T, *rays.T, (0.0, 0.0), (1e-300, 0.0)]:
        best = searched(star, point)
        found = abs(star.distance(np.array(point)))
        assert best - 1e-9 < found <= best + 1e-12 * max(1.0, best)


def test_a_star_without_amplitude_is_a_disk():
    points = np.random.default_rng(3).uniform(-2, 2, (2, 500))
    found = Star(0.7, amplitude=0.0).distance(points)
    assert found == pytest.approx(Disk(0.7).distance(points), abs=1e-15)
    assert Star(0.7, amplitude=0.0).surface == pytest.approx(Disk(0.7).surface, rel=1e-14)


def test_points_stepped_off_along_the_normal_are_found_again_to_rounding():
    star = Star(1.0, amplitude=0.3, arms=5)
    t = np.random.default_rng(3).uniform(0, 2 * np.pi, 500)
    r, dr = 1 + 0.3 * np.cos(5 * t), -1.5 * np.sin(5 * t)
    normal = np.stack([dr * np.sin(t) + r * np.cos(t), r * np.sin(t) - dr * np.cos(t)])
    normal /= np.hypot(r, dr)
    away = np.random.default_rng(4).uniform(-0.07, 0.07, 500)  # least radius of curvature: 0.0721
    places = r * np.stack([np.cos(t), np.sin(t)]) + away * normal
    assert star.distance(places) == pytest.approx(away, abs=1e-14)


@pytest.mark.parametrize("arms", [1, 2, 5])
def test_the_moments_are_those_of_a_fine_polygon(arms):
    star = Star(1.2, amplitude=0.6, arms=arms, center=(1.0, 2.0))
    found, drawn = measure(star), measure(star | star)  # a union is measured by its contour
    assert found.volume == star.volume == pytest.approx(drawn.volume, rel=2e-5)
    assert found.center == pytest.approx(drawn.center, abs=2e-5)
    assert found.inertia == pytest.approx(drawn.inertia, rel=5e-5)


def test_the_box_is_tight():
    low, high = Star(2.0, amplitude=0.5, arms=4, center=(1, 0)).bounds()
    assert high == pytest.approx((4.0, 3.0), abs=1e-4)
    assert low == pytest.approx((-2.0, -3.0), abs=1e-4)
    assert math.isclose(Star().bounds()[1][0], 1.3, rel_tol=1e-5)
