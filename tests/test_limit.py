"""Limits of a time step, and which of several wins."""

import math

import pytest

from remesh.errors import InputError
from remesh.limit import Limit, tightest


def test_the_tightest_limit_wins_and_of_equal_ones_the_first():
    first, other = Limit(0.1, "body"), Limit(0.1, "motion")
    assert tightest(Limit(0.2, "diffusion"), first, other) is first
    broken = Limit(math.nan, "deformation")
    assert tightest(first, broken) is broken
    with pytest.raises(InputError, match="compares limits, got none"):
        tightest()
