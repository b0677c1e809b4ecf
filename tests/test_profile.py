"""The profile that particles carry, and its inverse."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from levelset.profile import LEVEL, distance_of, profile


@given(st.floats(-3.0, 3.0), st.floats(0.1, 10.0))
def test_the_profile_is_odd_rises_and_is_level_beyond_its_width(distance, width):
    value = profile(np.array(distance * width), width)
    assert profile(np.array(-distance * width), width) == -value
    assert abs(value) <= LEVEL * width * (1 + 1e-15)
    if abs(distance) >= 1:
        assert abs(value) == pytest.approx(LEVEL * width)


def test_its_slope_is_the_square_of_one_less_the_square():
    """So it is 1 on the interface, and flat with its two derivatives at the band's edge."""
    d, step, width = np.linspace(-1.9, 1.9, 77), 1e-5, 2.0
    slope = (profile(d + step, width) - profile(d - step, width)) / (2 * step)
    np.testing.assert_allclose(slope, (1 - (d / width) ** 2) ** 2, atol=1e-9)
    near_edge = width * (1 - np.array([1e-2, 1e-3]))
    missing = LEVEL * width - profile(near_edge, width)
    assert missing[0] / missing[1] == pytest.approx(
        1e3, rel=0.02
    )  # the third power of what is left


def test_the_distance_is_found_again():
    for width in (0.05, 3.0):
        distances = np.linspace(-0.99, 0.99, 1001) * width
        found = distance_of(profile(distances, width), width)
        np.testing.assert_allclose(found, distances, atol=1e-9 * width)
    beyond = distance_of(np.array([LEVEL * 2.0, -LEVEL * 2.0, 5.0, 0.0]), 2.0)
    np.testing.assert_allclose(beyond, [2.0, -2.0, 2.0, 0.0], atol=1e-4)
