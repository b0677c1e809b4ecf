"""Wagner's law of the lift that grows after a start."""

import numpy as np
import pytest

from pmesh.cases.wagner import wagner
from remesh.errors import InputError


def test_half_of_the_lift_is_there_at_once():
    assert float(wagner(0.0)) == pytest.approx(0.5, abs=1e-10)


def test_the_lift_grows_to_the_steady_one():
    """And lacks 1/s of it late, what a starting vortex s half chords away takes."""
    s = np.array([0.0, 0.5, 1.0, 3.0, 10.0, 100.0, 1000.0, 1e4])
    lift = wagner(s)
    assert (np.diff(lift) > 0).all()
    assert (lift < 1).all()
    assert (1 - lift[-1]) * s[-1] == pytest.approx(1.0, rel=2e-3)


def test_the_law_is_as_its_known_approximations():
    """Jones (1940), within 1.1 %; Garrick (1938), (s + 2)/(s + 4), within 2.5 %."""
    s = np.linspace(0, 20, 81)
    jones = 1 - 0.165 * np.exp(-0.0455 * s) - 0.335 * np.exp(-0.3 * s)
    assert np.abs(wagner(s) / jones - 1).max() < 0.011
    assert np.abs(wagner(s) / ((s + 2) / (s + 4)) - 1).max() < 0.025


def test_a_negative_travel_is_refused():
    with pytest.raises(InputError, match="travel must not be negative"):
        wagner(np.array([1.0, -0.1]))
