"""Runge-Kutta schemes as tables, and the paths of points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.paths import SCHEMES, Scheme, get_scheme, travel

every_scheme = pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda scheme: scheme.name)


def tableau(scheme: Scheme) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    b = np.array(scheme.weights)
    a = np.zeros((len(b), len(b)))
    for stage, row in enumerate(scheme.rows, start=1):
        a[stage, : len(row)] = row
    return a, b, a.sum(axis=1)


@every_scheme
def test_a_scheme_meets_the_conditions_of_its_order_and_not_of_the_next(scheme):
    """Butcher's conditions; Hairer, Norsett & Wanner (1993), table II.2.1."""
    a, b, c = tableau(scheme)
    conditions = {
        1: [(b.sum(), 1)],
        2: [(b @ c, 1 / 2)],
        3: [(b @ c**2, 1 / 3), (b @ a @ c, 1 / 6)],
        4: [
            (b @ c**3, 1 / 4),
            (b @ (c * (a @ c)), 1 / 8),
            (b @ a @ c**2, 1 / 12),
            (b @ a @ a @ c, 1 / 24),
        ],
        5: [(b @ c**4, 1 / 5)],
    }
    met = [
        all(math.isclose(found, asked) for found, asked in conditions[order])
        for order in range(1, scheme.order + 2)
    ]
    assert met == [True] * scheme.order + [False]
    assert scheme.source


@every_scheme
def test_points_in_an_unsteady_flow_arrive_with_the_order_of_the_scheme(scheme):
    """u = cos(t) (-y, x): turned by sin(t)."""

    def velocity(time: float, places: np.ndarray) -> np.ndarray:
        return math.cos(time) * np.stack([-places[:, 1], places[:, 0]], axis=1)

    errors = []
    for steps in (16, 32):
        place, dt = np.array([[1.0, 0.0]]), 1.0 / steps
        for k in range(steps):
            place = travel(place, velocity, k * dt, dt, scheme)
        turned = math.sin(1.0)
        errors.append(np.abs(place[0] - [math.cos(turned), math.sin(turned)]).max())
    assert math.log2(errors[0] / errors[1]) == pytest.approx(scheme.order, abs=0.2)


def test_a_step_back_undoes_a_step_to_the_order_of_the_scheme():
    def velocity(time: float, places: np.ndarray) -> np.ndarray:
        return np.sin(places + time)

    start = np.array([[0.3, -0.4, 0.9]])
    there = travel(start, velocity, 0.2, 0.05, SCHEMES["RK4"])
    back = travel(there, velocity, 0.25, -0.05, SCHEMES["RK4"])
    np.testing.assert_allclose(back, start, atol=1e-8)
    assert np.abs(there - start).max() > 0.01


def test_a_scheme_that_is_not_there_is_refused_by_name():
    with pytest.raises(InputError, match="time_scheme must be one of RK2, RK3, RK4, got 'Euler'"):
        get_scheme("Euler")
