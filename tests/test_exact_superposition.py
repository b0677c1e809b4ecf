"""Sums of flows."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.vortex.exact import GaussianRing, HillVortex, StrainedRing, Superposition, VortexRing
from remesh.errors import InputError

POINTS = np.random.default_rng(0).normal(size=(3, 50))
PARTS = (HillVortex(), VortexRing(center=(0.0, 0.0, 2.0)))


def test_a_sum_has_the_fields_and_the_impulse_of_its_parts():
    both = Superposition(parts=PARTS)
    one, other = PARTS
    assert both.vorticity(POINTS) == pytest.approx(one.vorticity(POINTS) + other.vorticity(POINTS))
    assert both.velocity(POINTS) == pytest.approx(one.velocity(POINTS) + other.velocity(POINTS))
    assert both.impulse == pytest.approx(one.impulse + other.impulse)


def test_an_impulse_that_moves_is_taken_at_the_start():
    both = Superposition(parts=(StrainedRing(), GaussianRing()))
    assert both.impulse == pytest.approx(StrainedRing().impulse() + GaussianRing().impulse)


def test_what_a_part_does_not_know_is_refused_with_its_name():
    with pytest.raises(InputError, match="GaussianRing has no velocity"):
        Superposition(parts=(HillVortex(), GaussianRing())).velocity(POINTS)
    with pytest.raises(InputError, match="parts must be flows"):
        Superposition(parts=(1.0,))
