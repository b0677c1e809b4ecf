"""Rotations: they compose, go back, and follow a spin to the second order."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.shape import rotation
from pmesh.bodies.turning import (
    inverse,
    product,
    quaternion,
    rotation_vector,
    turn_between,
    turned_on,
)

RNG = np.random.default_rng(3)
TURNS = [tuple(turn) for turn in RNG.normal(size=(6, 3)) * 0.8]
SMALL = [(0.0, 0.0, 0.0), (1e-9, -2e-9, 0.0), (0.0, 0.0, math.pi - 1e-9)]


@pytest.mark.parametrize("turn", TURNS + SMALL)
def test_a_rotation_vector_comes_back_from_its_quaternion(turn):
    found = quaternion(turn)
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(rotation_vector(found), turn, rtol=1e-8, atol=1e-16)
    np.testing.assert_allclose(rotation_vector(-2.0 * found), turn, rtol=1e-8, atol=1e-16)


def test_more_than_half_a_turn_is_told_the_other_way_round():
    assert rotation_vector(quaternion((0.0, 4.0, 0.0))) == pytest.approx((0, 4 - 2 * math.pi, 0))


@pytest.mark.parametrize("first", TURNS[:3])
@pytest.mark.parametrize("last", TURNS[3:])
def test_quaternions_compose_as_matrices_do(first, last):
    both = rotation_vector(product(quaternion(last), quaternion(first)))
    np.testing.assert_allclose(rotation(both), rotation(last) @ rotation(first), atol=1e-14)
    np.testing.assert_allclose(rotation(turned_on(first, last)), rotation(both), atol=1e-14)
    np.testing.assert_allclose(turned_on(first, turn_between(first, last)), last, atol=1e-14)
    back = product(inverse(quaternion(first)), quaternion(first))
    np.testing.assert_allclose(back, [1, 0, 0, 0], atol=1e-15)


def test_a_quarter_turn_about_z_takes_x_to_y():
    np.testing.assert_allclose(rotation((0.0, 0.0, math.pi / 2)) @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    assert turned_on((0.0, 0.0, 0.5), (0.0, 0.0, 0.25)) == pytest.approx((0.0, 0.0, 0.75))


def test_turns_in_the_plane_add():
    assert turned_on((6.0,), (1.5,)) == (7.5,)
    assert turn_between((6.0,), (7.5,)) == (1.5,)


def test_spins_in_mid_step_turn_to_the_second_order():
    """Precession about z of a spin about a leaning axis: R(t) = exp(a t z) exp(b t x), in closed
    form, and its world spin a z + exp(a t z) b x."""
    a, b = 0.7, 1.9

    def spin(t):
        return np.array([0, 0, a]) + rotation((0.0, 0.0, a * t)) @ [b, 0, 0]

    exact = rotation((0.0, 0.0, a)) @ rotation((b, 0.0, 0.0))
    wrong = []
    for steps in (20, 40):
        angle, dt = (0.0, 0.0, 0.0), 1.0 / steps
        for k in range(steps):
            angle = turned_on(angle, dt * spin((k + 0.5) * dt))
        wrong.append(np.abs(rotation(angle) - exact).max())
    assert wrong[1] < 1e-3
    assert math.log2(wrong[0] / wrong[1]) == pytest.approx(2.0, abs=0.1)
