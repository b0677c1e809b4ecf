"""Records: curves from uneven steps, whose integrals are those of the rows."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.run.record import record
from remesh.errors import InputError

STEPS = 0.05 * (1 + 0.5 * np.random.default_rng(7).random(400))
TIME = np.cumsum(STEPS)


def test_means_over_steps_give_back_their_integral_to_round_off() -> None:
    values = np.sin(TIME)
    curve = record(TIME, values, STEPS)
    assert curve.means(curve.edges) == pytest.approx(values, abs=1e-13)
    assert curve.means(np.array([curve.start, curve.end]))[0] * curve.span == pytest.approx(
        float(values @ STEPS), rel=1e-14
    )


def test_the_curve_through_means_is_the_curve_itself_at_fourth_order() -> None:
    errors = []
    for n in (100, 200):
        edges = np.linspace(0, 10, n + 1) + 0.02 * np.sin(np.linspace(0, 20, n + 1))
        dt = np.diff(edges)
        means = -np.diff(np.cos(edges)) / dt
        middle = np.linspace(2, 8, 777)
        errors.append(np.abs(record(edges[1:], means, dt).at(middle) - np.sin(middle)).max())
    assert np.log2(errors[0] / errors[1]) > 2.8  # the derivative of a fourth-order curve
    assert errors[1] < 1e-5


def test_a_polynomial_of_third_degree_at_uneven_times_is_exact() -> None:
    law = np.polynomial.Polynomial([1, -2, 0.5, 0.1])
    curve = record(TIME, law(TIME))
    assert curve.at(TIME + 0.01)[:-1] == pytest.approx(law(TIME + 0.01)[:-1], rel=1e-10)
    whole = law.integ()(TIME[-1]) - law.integ()(TIME[0])
    assert curve.means(TIME[[0, -1]])[0] * curve.span == pytest.approx(whole, rel=1e-11)


def test_the_rows_of_a_start_are_left_out() -> None:
    time = np.concatenate([[0.0], TIME])
    value = np.concatenate([[np.nan], TIME])
    dt = np.concatenate([[0.0], STEPS])
    assert record(time, value, dt).start == pytest.approx(0.0, abs=1e-15)
    assert record(time, value).start == TIME[0]


def test_a_part_begins_where_asked_and_keeps_the_curve() -> None:
    curve = record(TIME, np.sin(TIME), STEPS)
    part = curve.after(5.03)
    assert (part.start, part.end) == (5.03, curve.end)
    assert part.at(7.7) == curve.at(7.7)
    with pytest.raises(InputError, match="a longer run"):
        curve.after(1e9)


def test_what_is_no_record_is_refused() -> None:
    with pytest.raises(InputError, match="columns of one length"):
        record(TIME, TIME[1:])
    with pytest.raises(InputError, match="at least 8 rows"):
        record(TIME[:5], TIME[:5])
    with pytest.raises(InputError, match="at least 8 rows"):
        record(TIME, np.full(TIME.size, np.nan))
    with pytest.raises(InputError, match="not finite at"):
        record(TIME, np.where(np.arange(400) == 200, np.nan, 1.0))
    with pytest.raises(InputError, match="must increase"):
        record(TIME[::-1], TIME)
    with pytest.raises(InputError, match="leave gaps"):
        record(TIME, TIME, 0.5 * STEPS)
