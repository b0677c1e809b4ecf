"""Torus, capsule and dumbbell: distances by hand, insides by formula, measures of known bodies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.measure import measure
from levelset.shapes import Capsule, Disk, Dumbbell, Sphere, Torus

POINTS = np.random.default_rng(7).uniform(-2, 2, (3, 3000))


def test_distances_known_by_hand():
    torus = Torus(2.0, 0.5)
    points = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [0.0, 0.0, 0.0]])
    assert torus.distance(points) == pytest.approx([1.5, -0.5, 0.5])
    capsule = Capsule((0, 0), (2, 0), 0.5)
    points = np.array([[1.0, 5.0, 1.0], [0.0, 4.0, 2.0]])
    assert capsule.distance(points) == pytest.approx([-0.5, 4.5, 1.5])
    bell = Dumbbell(1.0, separation=4.0, bar=0.3)
    points = np.array([[0.0, 2.0, -2.0, 0.0, 5.0], [0.0, 0.0, 0.0, 1.3, 0.0], [0, 0, 0, 0, 4.0]])
    assert bell.distance(points) == pytest.approx([-0.3, -1.0, -1.0, 1.0, 4.0])


def test_the_inside_of_a_torus_and_a_capsule_is_that_of_their_formulas():
    x, y, z = POINTS
    r, t = 1.0, 0.4
    quartic = (x * x + y * y + z * z + r * r - t * t) ** 2 < 4 * r * r * (x * x + y * y)
    assert np.array_equal(Torus(r, t).distance(POINTS) < 0, quartic)
    a, b = np.array([-0.5, 0.3, 0.1]), np.array([0.9, 0.2, -0.4])
    steps = np.linspace(0, 1, 4001)[:, None]
    line = a + steps * (b - a)
    near = np.min([np.sum((POINTS.T - p) ** 2, axis=1) for p in line[::4]], axis=0)
    found = Capsule(tuple(a), tuple(b), 0.6).distance(POINTS)
    assert found == pytest.approx(np.sqrt(near) - 0.6, abs=1e-5)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_sharp_dumbbell_is_the_union_of_balls_and_a_bar(ndim):
    """Exact inside too, where the union is a bound only."""
    points = POINTS[:ndim]
    bell = Dumbbell(0.7, separation=2.0, bar=0.2, center=(0.0,) * ndim)
    kind = Disk if ndim == 2 else Sphere
    ends = [kind(0.7, center=(x, *(0.0,) * (ndim - 1))) for x in (-1.0, 1.0)]
    off = np.sqrt((points[1:] ** 2).sum(axis=0))
    inside = (off < 0.2) & (np.abs(points[0]) < 1.0)
    inside |= (ends[0].distance(points) < 0) | (ends[1].distance(points) < 0)
    found = bell.distance(points)
    assert np.array_equal(found < 0, inside)
    outside = points[:, ~inside]
    across = np.hypot(np.maximum(np.abs(outside[0]) - 1, 0), np.maximum(off[~inside] - 0.2, 0))
    both = np.minimum(np.minimum(*(end.distance(outside) for end in ends)), across)
    assert found[~inside] == pytest.approx(both, abs=1e-14)


@pytest.mark.parametrize("fillet", [0.0, 0.1, 0.4])
@pytest.mark.parametrize("ndim", [2, 3])
def test_the_distance_to_a_dumbbell_is_that_to_its_drawn_profile(ndim, fillet):
    bell = Dumbbell(0.7, separation=2.4, bar=0.2, fillet=fillet, center=(0.0,) * ndim)
    foot = 1.2 - math.sqrt((0.7 + fillet) ** 2 - (0.2 + fillet) ** 2)
    lean = math.atan2(0.2 + fillet, 1.2 - foot)
    share = np.linspace(0, 1, 2001)
    bar = np.stack([foot * share, 0.2 + 0 * share])
    turn = -math.pi / 2 + share * (math.pi / 2 - lean)
    round_ = np.stack([foot + fillet * np.cos(turn), 0.2 + fillet + fillet * np.sin(turn)])
    turn = (math.pi - lean) * share
    ball = np.stack([1.2 + 0.7 * np.cos(turn), 0.7 * np.sin(turn)])
    profile = np.concatenate([bar, round_, ball], axis=1)
    points = POINTS[:ndim, :1000]
    flat = np.stack([np.abs(points[0]), np.sqrt((points[1:] ** 2).sum(axis=0))])
    near = np.sqrt(((profile[:, None] - flat[:, :, None]) ** 2).sum(axis=0).min(axis=1))
    found = np.abs(bell.distance(points))
    assert np.all(found <= near + 1e-14)  # nothing drawn is nearer
    assert np.all(near <= np.hypot(found, 1e-3))  # and what is drawn is 1e-3 apart, or less


def test_a_fillet_joins_bar_and_balls_without_a_corner():
    """The distance has a slope of one on the whole boundary, across the joints too."""
    bell = Dumbbell(0.7, separation=2.4, bar=0.2, fillet=0.4, center=(0, 0))
    x, y, _, _ = bell._profile()
    assert np.abs(bell.distance(np.stack([x, y]))).max() < 1e-15
    foot = np.stack([x, y])
    eps = 1e-6 * np.eye(2)[:, :, None]
    normal = np.stack([bell.distance(foot + e) - bell.distance(foot - e) for e in eps]) / 2e-6
    assert np.sum(normal**2, axis=0) == pytest.approx(1.0, abs=1e-6)


def test_the_fillet_shrunk_to_nothing_is_the_sharp_dumbbell():
    sharp = Dumbbell(0.7, separation=2.4, bar=0.2)
    smooth = Dumbbell(0.7, separation=2.4, bar=0.2, fillet=1e-9)
    assert smooth.distance(POINTS) == pytest.approx(sharp.distance(POINTS), abs=1e-8)
    assert smooth.volume == pytest.approx(sharp.volume, rel=1e-9)


def test_a_sharp_dumbbell_has_the_volume_of_two_capped_balls_and_a_cylinder():
    r, b, d = 1.0, 0.4, 4.0
    reach = math.sqrt(r * r - b * b)
    cap = math.pi * (r - reach) ** 2 * (2 * r + reach) / 3  # inside the bar
    bar = math.pi * b * b * (d - 2 * reach)
    solid = Dumbbell(r, separation=d, bar=b)
    assert solid.volume == pytest.approx(2 * (4 / 3 * math.pi * r**3 - cap) + bar, rel=1e-14)
    sides = 2 * math.pi * b * (d - 2 * reach) + 2 * (4 * math.pi - 2 * math.pi * (r - reach))
    assert solid.surface == pytest.approx(sides, rel=1e-14)
    flat = Dumbbell(r, separation=d, bar=b, center=(0, 0))
    turn = math.asin(b / r)
    ends = 2 * (math.pi * r * r - (turn * r * r - b * reach))
    assert flat.volume == pytest.approx(ends + 2 * b * (d - 2 * reach), rel=1e-14)
    assert flat.surface == pytest.approx(4 * (math.pi - turn) + 2 * (d - 2 * reach), rel=1e-14)


@pytest.mark.parametrize(
    "shape",
    [
        Torus(1.0, 0.4, center=(1, 2, 3)),
        Capsule((1.0, 2.0, 3.0), (2.0, 2.5, 2.0), 0.6),
        Capsule((1.0, 2.0), (2.0, 2.5), 0.6),
        Dumbbell(0.7, separation=2.4, bar=0.3, fillet=0.4, center=(1, 2, 3)),
        Dumbbell(0.7, separation=2.4, bar=0.3, fillet=0.4, center=(1, 2)),
        Dumbbell(0.7, separation=2.4, bar=0.3),
    ],
)
def test_the_moments_agree_with_those_of_the_general_measure(shape):
    found, general = measure(shape), measure(shape | shape)
    tolerance = 2e-5 if shape.ndim == 2 else 1e-4
    assert found.volume == shape.volume == pytest.approx(general.volume, rel=tolerance)
    assert found.center == pytest.approx(general.center, abs=tolerance)
    assert found.inertia == pytest.approx(general.inertia, rel=2 * tolerance)


def test_a_long_capsule_is_a_rod_and_a_short_one_a_ball():
    rod = measure(Capsule((0, 0, 0), (0, 0, 1000), 0.01))
    assert rod.inertia == pytest.approx(rod.volume * 1000**2 / 12, rel=1e-4)
    ball = measure(Capsule((0, 0, 0), (0, 0, 1e-9), 2.0))
    assert ball.inertia == pytest.approx(measure(Sphere(2.0)).inertia, rel=1e-8)
    disk = measure(Capsule((0, 0), (0, 1e-9), 2.0))
    assert disk.inertia == pytest.approx(measure(Disk(2.0)).inertia, rel=1e-8)
