"""Limits of a time step, and which of several wins."""

import math

import pytest

from remesh.errors import InputError
from remesh.limit import Limit, check_step, tightest


def test_the_tightest_limit_wins_and_of_equal_ones_the_first():
    first, other = Limit(0.1, "body"), Limit(0.1, "motion")
    assert tightest(Limit(0.2, "diffusion"), first, other) is first
    broken = Limit(math.nan, "deformation")
    assert tightest(first, broken) is broken
    with pytest.raises(InputError, match="compares limits, got none"):
        tightest()


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf, "a", None])
def test_a_step_that_is_no_positive_number_is_refused(dt):
    with pytest.raises(InputError, match="dt must be"):
        check_step(dt)
    assert check_step(0.5) == 0.5
