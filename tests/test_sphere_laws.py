"""The sphere's laws: its first drag, published numbers, the velocity on its axis."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.reference import read_table
from pmesh.cases.sphere import FORCE
from pmesh.cases.sphere_laws import axis_velocity, published, stokes_drag
from pmesh.cases.unsteady_stokes import inverse_laplace
from remesh.grid import Grid


def test_the_first_law_is_the_force_in_laplace_space():
    """``6 pi mu a (1 + a sqrt(s / nu)) / s``: Stokes' friction and its history, radius 1/2."""
    reynolds, times = 100.0, np.array([0.01, 0.1, 1.0])
    nu, a = 1 / reynolds, 0.5
    force = inverse_laplace(
        lambda s: 6 * math.pi * nu * a * (1 + a * np.sqrt(s / nu)) / s, times
    )  # fmt: skip
    np.testing.assert_allclose(stokes_drag(reynolds, times, times), FORCE * force, rtol=1e-7)


def test_the_law_of_a_step_is_the_mean_over_it():
    begin, end = np.array([0.0, 0.02]), np.array([0.02, 0.05])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    for a, b, mean in zip(begin, end, stokes_drag(300.0, begin, end), strict=True):
        roots = 0.5 * (math.sqrt(b) + math.sqrt(a)) + 0.5 * (math.sqrt(b) - math.sqrt(a)) * nodes
        whole = 0.5 * (math.sqrt(b) - math.sqrt(a)) * weights @ (
            2 * roots * stokes_drag(300.0, roots**2, roots**2)
        )  # fmt: skip
        assert whole / (b - a) == pytest.approx(mean, rel=1e-12)


def test_every_published_number_has_its_grade_and_source():
    for row in read_table("sphere.csv"):
        assert row["grade"] in "ABC"
        assert row["source"]
        assert 0 < float(row["tolerance"]) <= 0.1
    assert published(100)["drag"].value == 1.087
    assert published(211) == {}


def test_the_velocity_on_the_axis_is_exact_for_cubics():
    grid = Grid((6, 8, 9), 0.25, (0.0, -0.9, -1.1))
    x, y, z = grid.points()
    field = np.stack([x + 3.0 - 2 * y + y**2 + 4 * y**3 - z**3 + y * z, x, x])
    places, values = axis_velocity(field, grid)
    np.testing.assert_allclose(places, grid.axes()[0])
    np.testing.assert_allclose(values, places + 3.0, atol=1e-12)
