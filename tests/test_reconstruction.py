"""Moving least squares: the mollified sum that keeps polynomials."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from levelset.shape import rotation
from remesh.errors import InputError
from remesh.mollifier import mollify
from remesh.reconstruction import reconstruct

RNG = np.random.default_rng(4)


def scattered(ndim: int, per_side: int = 9) -> tuple[np.ndarray, float]:
    """Particles on [0, 1]^ndim, each a third of a spacing off its place; and the spacing."""
    h = 1.0 / (per_side - 1)
    axes = np.meshgrid(*[np.linspace(0, 1, per_side)] * ndim, indexing="ij")
    places = np.stack(axes, axis=-1).reshape(-1, ndim)
    return places + RNG.uniform(-h / 3, h / 3, places.shape), h


def polynomial(places: np.ndarray, degree: int) -> np.ndarray:
    total = np.full(len(places), 1.7)
    if degree > 0:
        total += places @ np.array([0.3, -1.1, 0.7])[: places.shape[1]]
    if degree > 1:
        total += places[:, 0] * places[:, 1] - 0.4 * places[:, -1] ** 2
    return total


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_polynomials_of_its_degree_are_kept_and_no_others(ndim, degree):
    places, h = scattered(ndim)
    points = RNG.uniform(0.2, 0.8, (40, ndim))
    kept = reconstruct(places, polynomial(places, degree), points, 1.3 * h, degree=degree)
    np.testing.assert_allclose(kept, polynomial(points, degree), atol=1e-11)
    if degree < 2:
        next_one = reconstruct(
            places, polynomial(places, degree + 1), points, 1.3 * h, degree=degree
        )
        assert np.abs(next_one - polynomial(points, degree + 1)).max() > 1e-4


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_error_falls_with_the_order_it_states(degree):
    points = np.random.default_rng(1).uniform(0.3, 0.7, (200, 2))
    errors = []
    for per_side in (21, 41):
        axes = np.meshgrid(*[np.linspace(0, 1, per_side)] * 2, indexing="ij")
        places = np.stack(axes, axis=-1).reshape(-1, 2)
        h = 1.0 / (per_side - 1)
        places = places + 0.2 * h * np.sin(9.0 * places[:, ::-1])
        values = np.exp(places[:, 0]) * np.cos(2.0 * places[:, 1])
        exact = np.exp(points[:, 0]) * np.cos(2.0 * points[:, 1])
        found = reconstruct(places, values, points, 1.2 * h, degree=degree)
        errors.append(np.sqrt(np.mean((found - exact) ** 2)))
    claimed = degree + 1 + (degree % 2 == 0)  # even degrees gain one where particles are even
    assert math.log2(errors[0] / errors[1]) == pytest.approx(claimed, abs=0.35)
    assert math.log2(errors[0] / errors[1]) >= degree + 0.8


@settings(max_examples=20, deadline=None)
@given(turn=st.floats(0.1, 6.0), shift=st.floats(-3.0, 3.0))
def test_the_field_turns_and_shifts_with_its_particles(turn, shift):
    places, h = scattered(2)
    values = np.sin(5.0 * places[:, 0]) + places[:, 1] ** 2
    points = np.random.default_rng(2).uniform(0.1, 0.9, (30, 2))
    matrix = rotation((turn,))
    before = reconstruct(places, values, points, 1.4 * h)
    after = reconstruct(places @ matrix.T + shift, values, points @ matrix.T + shift, 1.4 * h)
    np.testing.assert_allclose(
        after, before, atol=1e-7
    )  # particles at the cutoff: 2e-9 of a weight


def test_degree_zero_is_the_mollified_sum_over_that_of_ones():
    places, h = scattered(3, 6)
    values = RNG.standard_normal(len(places))
    points = RNG.uniform(0.2, 0.8, (20, 3))
    both = mollify(places, np.stack([values, np.ones_like(values)], axis=1), 1.0, points, h)
    found = reconstruct(places, values, points, h, degree=0)
    np.testing.assert_allclose(found, both[:, 0] / both[:, 1], atol=1e-7)


def test_points_that_no_particle_reaches_are_not_numbers_and_few_particles_give_a_mean():
    places = np.array([[0.0, 0.0], [0.1, 0.0]])
    values = np.array([[1.0, 5.0], [3.0, 7.0]])
    found = reconstruct(places, values, np.array([[0.05, 0.0], [9.0, 9.0]]), 0.1, degree=2)
    np.testing.assert_allclose(found[0], [2.0, 6.0])
    assert np.isnan(found[1]).all()
    assert reconstruct(np.zeros((0, 2)), np.zeros(0), places, 0.1).shape == (2,)


def test_the_same_bits_for_any_number_of_threads_and_float32_stays():
    places, h = scattered(2, 20)
    values = np.cos(places[:, 0]).astype(np.float32)
    points = RNG.uniform(0, 1, (500, 2))
    one = reconstruct(places, values, points, h, threads=1)
    assert one.dtype == np.float32
    np.testing.assert_array_equal(one, reconstruct(places, values, points, h, threads=3))


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"radius": 0.0}, "radius must be a positive length"),
        ({"degree": 3}, "degree must be 0, 1 or 2, got 3"),
        ({"values": np.full(4, np.nan)}, "values must be finite"),
        ({"values": np.zeros(3)}, r"values must have shape \(4,\)"),
        ({"points": np.zeros((2, 3))}, r"points must have shape \(m, 2\)"),
        ({"positions": np.zeros((2, 4))}, "positions must have shape"),
    ],
)
def test_what_makes_no_sense_is_refused(change, match):
    given_ = {
        "positions": np.zeros((4, 2)), "values": np.zeros(4), "points": np.zeros((2, 2)),
        "radius": 1.0, **change,
    }  # fmt: skip
    with pytest.raises(InputError, match=match):
        reconstruct(**given_)
