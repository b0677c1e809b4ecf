"""Smooth set algebra: a bound everywhere, the sharp algebra away from the seam, smooth in it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from levelset.measure import measure
from levelset.shapes import (
    Box,
    Disk,
    SmoothDifference,
    SmoothIntersection,
    SmoothUnion,
    Sphere,
)
from remesh.errors import InputError

PAIRS = [
    (Disk(0.6, center=(-0.4, 0)), Disk(0.5, center=(0.4, 0.1))),
    (Box((1.4, 0.5)), Box((0.5, 1.2))),
    (Sphere(0.6, center=(-0.4, 0, 0)), Box((0.8, 0.8, 0.8), center=(0.3, 0, 0))),
]
KINDS = [
    (SmoothUnion, lambda a, b: a | b, -1),
    (SmoothIntersection, lambda a, b: a & b, 1),
    (SmoothDifference, lambda a, b: a - b, 1),
]


def scattered(ndim, count=3000):
    return np.random.default_rng(2).uniform(-1.5, 1.5, (ndim, count))


@pytest.mark.parametrize(("kind", "sharp", "sign"), KINDS)
@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_the_seam_moves_by_a_sixth_of_the_radius_at_most_and_ends_at_the_radius(
    kind, sharp, sign, a, b
):
    points = scattered(a.ndim)
    moved = sign * (kind(a, b, 0.3).distance(points) - sharp(a, b).distance(points))
    assert moved.min() >= 0
    assert moved.max() <= 0.05 + 1e-15
    other = -b.distance(points) if kind is SmoothDifference else b.distance(points)
    assert np.all(moved[np.abs(a.distance(points) - other) >= 0.3] == 0)


@pytest.mark.parametrize(("kind", "sharp", "sign"), KINDS)
@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_the_value_is_a_lower_bound_of_the_distance(kind, sharp, sign, a, b):
    """Its slope is at most one: the boundary is no nearer than the value says."""
    shape, points = kind(a, b, 0.3), scattered(a.ndim)
    others = np.random.default_rng(3).uniform(-1.5, 1.5, points.shape)
    change = np.abs(shape.distance(points) - shape.distance(others))
    assert np.all(change <= np.sqrt(((points - others) ** 2).sum(axis=0)) * (1 + 1e-12))


def test_the_seam_has_a_continuous_curvature():
    """Second differences across the seam's middle and ends do not jump, where the union's do."""
    a, b = PAIRS[0]
    x = np.linspace(-0.2, 0.2, 40001)
    line = np.stack([x, 0.9 + 0 * x])

    def jump(shape):
        second = np.diff(shape.distance(line), 2) / (x[1] - x[0]) ** 2
        return np.abs(np.diff(second)).max()

    assert jump(SmoothUnion(a, b, 0.3)) < 0.1
    assert jump(a | b) > 1e3


@given(st.floats(0.01, 1.0), st.floats(-1, 1), st.floats(-1, 1))
def test_the_bounds_hold_what_the_seam_adds(radius, x, y):
    bar = Box((2.0, 0.2)) & Disk(0.8)
    shape = SmoothUnion(bar, Disk(0.3, center=(x, y)), radius)
    low, high = (np.array(corner)[:, None] for corner in shape.bounds())
    points = scattered(2)
    outside = np.any((points < low) | (points > high), axis=0)
    assert np.all(shape.distance(points[:, outside]) > 0)


def test_a_blend_can_be_moved_measured_and_hashed():
    a, b = PAIRS[0]
    shape = SmoothUnion(a, b, 0.3)
    assert shape == SmoothUnion(a, b, np.float64(0.3))
    assert hash(shape) == hash(SmoothUnion(a, b, 0.3))
    assert shape != SmoothIntersection(a, b, 0.3)
    found, sharp = measure(shape), measure(a | b)
    assert sharp.volume < found.volume < 1.1 * sharp.volume
    there = measure(shape.moved((1, 0)))
    assert there.center == pytest.approx((found.center[0] + 1, found.center[1]), abs=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: SmoothUnion(Disk(1.0), Disk(1.0), 0.0), "radius must be a positive length"),
        (lambda: SmoothUnion(Disk(1.0), Sphere(1.0), 0.1), "2 and 3 dimensions cannot be joined"),
        (lambda: SmoothUnion(Disk(1.0), "disk", 0.1), "set algebra joins shapes, got str"),
        (
            lambda: SmoothIntersection(Disk(1.0), Disk(1.0, center=(9, 0)), 0.1).bounds(),
            "intersection is empty",
        ),
    ],
)
def test_what_cannot_be_blended_is_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()
