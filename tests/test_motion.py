"""Motions: held, led by laws whose rates are their derivatives, or free within what they state."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import pmesh.bodies.motion as motions
from levelset.shape import rotation
from pmesh.bodies.motion import Fixed, Free, Prescribed, Spring
from pmesh.bodies.pose import still
from pmesh.bodies.turning import turned_on
from remesh.errors import InputError

START = still((0.3, -0.2))


def test_a_fixed_body_stays_at_rest_where_it_was_placed():
    later = Fixed().pose(START, 7.0)
    assert later.time == 7.0
    assert (later.center, later.angle) == (START.center, START.angle)
    assert not any((*later.velocity, *later.spin))


def test_a_prescribed_body_is_where_its_laws_say():
    motion = Prescribed(shift=lambda t: (math.sin(t), t**2), angle=lambda t: 0.5 * t)
    pose = motion.pose(START, 1.2)
    assert pose.center == pytest.approx((0.3 + math.sin(1.2), -0.2 + 1.44))
    assert pose.angle == pytest.approx((0.6,))
    assert pose.velocity == pytest.approx((math.cos(1.2), 2.4), abs=1e-10)
    assert pose.spin == pytest.approx((0.5,), abs=1e-10)


def test_rates_that_are_given_are_taken_as_they_are():
    motion = Prescribed(shift=lambda t: (t, 0.0), velocity=lambda t: (1.0, 0.0), spin=lambda t: 3.0)
    pose = motion.pose(START, 0.0)
    assert pose.velocity == (1.0, 0.0)
    assert pose.spin == (3.0,)
    assert pose.angle == (0.0,)


def test_the_differences_are_of_order_four(monkeypatch):
    errors = []
    for nudge in (0.2, 0.1):
        monkeypatch.setattr(motions, "NUDGE", nudge)
        pose = Prescribed(shift=lambda t: (math.sin(t), 0.0), scale=1.0).pose(START, 0.4)
        errors.append(abs(pose.velocity[0] - math.cos(0.4)))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)


def test_the_scale_resolves_a_fast_law_and_keeps_the_digits_of_a_slow_one():
    for scale in (1e-4, 1e4):
        law = Prescribed(shift=lambda t, s=scale: (math.sin(t / s), 0.0), scale=scale)
        pose = law.pose(START, 0.7 * scale)
        assert pose.velocity[0] * scale == pytest.approx(math.cos(0.7), abs=1e-10)


def test_laws_in_space_have_three_components():
    motion = Prescribed(shift=lambda t: (0.0, t, 0.0), angle=lambda t: (0.0, 0.0, t))
    pose = motion.pose(still((0.0, 0.0, 1.0)), 2.0)
    assert pose.center == (0.0, 2.0, 1.0)
    assert pose.spin == pytest.approx((0.0, 0.0, 1.0), abs=1e-10)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Prescribed(shift=(1.0, 0.0)), "Prescribed shift must be a function of time"),
        (lambda: Prescribed(spin=2.0), "Prescribed spin must be a function of time, got 2.0"),
        (lambda: Prescribed(scale=0.0), "Prescribed scale must be positive, got 0"),
        (
            lambda: Prescribed(shift=lambda t: 1.0).pose(START, 0.5),
            r"shift must give 2 finite numbers, gave \(1.0,\) at t = 0.5",
        ),
        (
            lambda: Prescribed(angle=lambda t: math.nan).pose(START, 0.0),
            "angle must give 1 finite numbers",
        ),
        (lambda: Free(density=0.0), "Free density must be positive, got 0"),
        (lambda: Free(density=math.inf), "Free density must be positive"),
        (lambda: Free(density="light"), "Free density must be a number, got 'light'"),
        (lambda: Free(gravity=(0.0, math.nan)), "Free gravity must be finite"),
        (lambda: Free(gravity=-9.81), "Free gravity must be numbers, one along each axis"),
        (lambda: Free(velocity=("a", 0.0)), "Free velocity must be a number, got 'a'"),
        (lambda: Free(spin=math.inf), "Free spin must be finite"),
        (lambda: Free(locked=("w",)), r"Free locked must hold names among .* got \('w',\)"),
        (lambda: Free(locked="xy"), "Free locked must hold names among .* got 'xy'"),
        (lambda: Free(locked="x"), "Free locked must hold names among .* got 'x'"),
        (
            lambda: Free(velocity=(1.0, 0.0), locked=("x",)),
            'Free locks "x" and gives it the velocity 1',
        ),
        (lambda: Free(spin=-2.0, locked=("angle",)), 'Free locks "angle" and gives it .* -2'),
        (lambda: Free(spring=3.0), "Free spring must be a Spring, got 3.0"),
        (lambda: Spring(stiffness=(-1.0, 0.0)), "Spring constants must not be negative, got -1"),
        (lambda: Spring(twist_damping=math.nan), "Spring twist_damping must be finite"),
        (lambda: Spring(damping=2.0), "Spring damping must be numbers, one along each axis"),
    ],
)
def test_what_is_no_motion_is_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()


def test_what_is_locked_may_be_told_to_rest_and_the_rest_to_move():
    tied = Free(velocity=(0.0, 1.0), spin=2.0, locked=["x"])
    assert tied.locked == ("x",)
    assert hash(tied) == hash(Free(velocity=(0.0, 1.0), spin=2.0, locked=("x",)))


def test_motions_of_equal_numbers_are_equal_and_can_be_hashed():
    given = Free(density=2, gravity=np.array([0, -1]), spring=Spring(stiffness=[1, 2]), spin=1)
    plain = Free(density=2.0, gravity=(0.0, -1.0), spring=Spring(stiffness=(1.0, 2.0)), spin=1.0)
    assert given == plain
    assert hash(given) == hash(plain)


def test_the_spin_in_space_is_the_angular_velocity_of_turns_that_do_not_commute():
    """R(t) = exp(a t z) exp(b x): a about z and, leaning with it, the rate of b along x."""
    a = 1.3

    def angle(t):
        return turned_on((0.7 + 0.4 * t, 0.0, 0.0), (0.0, 0.0, a * t))

    law = Prescribed(angle=angle)
    for t in (0.0, 0.9, 2.6):  # passes half a turn
        pose = law.pose(still((0.0, 0.0, 0.0)), t)
        exact = np.array([0, 0, a]) + 0.4 * rotation((0.0, 0.0, a * t))[:, 0]
        assert pose.spin == pytest.approx(exact, abs=1e-10)
        np.testing.assert_allclose(
            rotation(pose.angle),
            rotation((0.0, 0.0, a * t)) @ rotation((0.7 + 0.4 * t, 0.0, 0.0)),
            atol=1e-14,
        )
        assert math.hypot(*pose.angle) <= math.pi + 1e-12


def test_a_law_in_space_turns_what_already_stands_turned():
    law = Prescribed(angle=lambda t: (0.0, 0.0, t))
    start = replace(still((0.0, 0.0, 0.0)), angle=(math.pi / 2, 0.0, 0.0))
    pose = law.pose(start, 0.5)
    exact = rotation((0.0, 0.0, 0.5)) @ rotation((math.pi / 2, 0.0, 0.0))
    np.testing.assert_allclose(rotation(pose.angle), exact, atol=1e-14)


def test_locks_and_speeds_in_space_go_by_their_names():
    Free(velocity=(1.0, 0.0, 0.0), spin=(0.0, 2.0, 0.0), locked=("y", "z", "turn_x"))
    with pytest.raises(InputError, match='locks "turn_y" and gives it the velocity 2'):
        Free(spin=(0.0, 2.0, 0.0), locked=("turn_y",))
    with pytest.raises(InputError, match="Free locked must hold names among"):
        Free(locked=("angle", "turn_x"))
