"""Exact slow motion of a cylinder: the inversion, known limits, and laws that must agree."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.short_time_drag import linear_drag
from pmesh.cases.unsteady_stokes import (
    friction_of_acceleration,
    history,
    inverse_laplace,
    released,
)
from remesh.errors import InputError

TIMES = np.array([0.01, 0.1, 0.5, 2.0, 20.0])


@pytest.mark.parametrize(
    ("transform", "law"),
    [
        (lambda s: 1 / (s + 1), lambda t: np.exp(-t)),
        (lambda s: s**-1.5, lambda t: 2 * np.sqrt(t / math.pi)),
        (lambda s: 1 / s**2, lambda t: t),
        (lambda s: np.exp(-np.sqrt(s)) / s, lambda t: np.vectorize(math.erfc)(0.5 / np.sqrt(t))),
    ],
)
def test_the_inverse_of_a_known_transform_is_known(transform, law):
    np.testing.assert_allclose(inverse_laplace(transform, TIMES), law(TIMES), atol=1e-9)


def test_the_force_after_an_impulse_is_the_linear_drag_found_another_way():
    """Cd = F/(rho U^2 a) = pi times the inverse of the history, with U = a = 1 and nu = 2/Re."""
    for reynolds in (40.0, 550.0):
        force = math.pi * inverse_laplace(lambda s: history(s, 2 / reynolds, 1.0), TIMES)  # noqa: B023
        np.testing.assert_allclose(force, linear_drag(reynolds, TIMES), rtol=1e-7)


def test_the_friction_of_an_acceleration_begins_like_the_root_of_time():
    """Like a plate's, friction and pressure: 8 sqrt(nu t / pi) / a."""
    time, viscosity, radius = 1e-6, 0.01, 0.5
    found = friction_of_acceleration(time, viscosity=viscosity, radius=radius)
    assert found == pytest.approx(8 * math.sqrt(viscosity * time / math.pi) / radius, rel=1e-3)


@pytest.mark.parametrize("density", [0.1, 1.5, 8.0])
def test_what_is_let_go_obeys_newton_and_sets_off_with_its_added_mass(density):
    motion = released(TIMES, density=density, pull=2.0, viscosity=0.01, radius=0.5)
    np.testing.assert_allclose(
        (density + 1) * motion.acceleration + motion.friction, 2.0, rtol=1e-7
    )
    first = released(1e-9, density=density, pull=2.0, viscosity=0.01, radius=0.5)
    assert first.acceleration == pytest.approx(2.0 / (density + 1), rel=1e-3)
    assert first.speed == pytest.approx(1e-9 * first.acceleration, rel=1e-3)


def test_the_speed_is_the_integral_of_the_acceleration():
    time = np.linspace(0.5, 1.0, 201)
    motion = released(time, density=2.0, pull=1.0, viscosity=0.02, radius=0.5)
    gained = np.trapezoid(motion.acceleration, time)
    assert motion.speed[-1] - motion.speed[0] == pytest.approx(gained, rel=1e-5)


@pytest.mark.parametrize("time", [0.0, -1.0, math.nan])
def test_times_before_the_start_are_refused(time):
    with pytest.raises(InputError, match="after t = 0 only") as caught:
        inverse_laplace(lambda s: 1 / s, time)
    assert caught.value.hint
