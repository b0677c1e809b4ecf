"""Published curves and short-time laws: the values that the literature gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.reference import cylinder_drag, cylinder_reynolds, read_table
from pmesh.cases.short_time_drag import linear_drag, short_time_drag
from remesh.errors import InputError

# Exact linear unsteady Stokes drag, by numerical Laplace inversion in extended precision: T = Ut/R
LINEAR = {
    40: {0.01: 16.16552506076572, 0.1: 5.321512182419288, 0.6: 2.3474302042711264},
    550: {0.01: 4.298128836587201, 0.1: 1.3747018219008518, 0.6: 0.5745000877463364},
    3000: {0.01: 1.8347682119217532, 0.1: 0.5830602149853106, 0.6: 0.24049274690366063},
}


@pytest.mark.parametrize("reynolds", LINEAR)
def test_linear_drag_equals_the_laplace_inversion(reynolds):
    times = np.array(list(LINEAR[reynolds]))
    assert linear_drag(reynolds, times) == pytest.approx(list(LINEAR[reynolds].values()), rel=1e-8)


def test_linear_drag_starts_half_friction_half_pressure():
    """4 sqrt(pi/(Re t)) with t in diameters."""
    time = 1e-7
    leading = 4 * math.sqrt(math.pi / (550 * time / 2))
    assert linear_drag(550, time) == pytest.approx(leading, rel=1e-4)


def test_linear_drag_follows_its_published_series():
    """(pi/sqrt(Re t)) [2.2567583 + k - 0.1410474 k^2 + 0.0625 k^3], k = 4 sqrt(t/Re)."""
    t = np.array([0.001, 0.01, 0.05])
    k = 4 * np.sqrt(t / 550)
    series = np.pi / np.sqrt(550 * t) * (2.2567583 + k - 0.1410474 * k**2 + 0.0625 * k**3)
    assert linear_drag(550, 2 * t) == pytest.approx(series, rel=1e-6)


def test_the_short_time_law_joins_the_published_curve():
    curve = cylinder_drag(550)
    times = np.array([0.1, 0.2, 0.3, 0.45])
    assert short_time_drag(550, times) == pytest.approx(curve.at(times), rel=0.02)
    assert np.all(short_time_drag(550, times) > linear_drag(550, times))
    assert np.isnan(short_time_drag(550, np.array([0.6]))).all()


def test_koumoutsakos_and_leonard_give_re_550_as_quoted():
    """T = 0.5, 1, 2, 3, 4, 5; minimum 0.703 at T = 0.79, maximum 1.287 at T = 2.9."""
    curve = cylinder_drag(550)
    quoted = [0.739, 0.741, 1.113, 1.287, 1.207, 1.125]
    assert curve.at(np.array([0.5, 1, 2, 3, 4, 5])) == pytest.approx(quoted, rel=4e-3)
    falling = curve.time < 1.5
    assert curve.value[falling].min() == pytest.approx(0.703, abs=5e-4)
    assert curve.time[falling][curve.value[falling].argmin()] == pytest.approx(0.79, abs=0.01)
    assert curve.value[curve.time > 1].max() == pytest.approx(1.287, abs=5e-4)
    assert (curve.grade, curve.source) == ("B", "Koumoutsakos & Leonard 1995")


def test_koumoutsakos_and_leonard_give_re_40_and_3000_as_quoted():
    times = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    quoted = {40: [2.173, 2.027, 1.962, 1.909, 1.871], 3000: [0.386, 0.962, 1.196, 1.377, 1.195]}
    for reynolds, drag in quoted.items():
        assert cylinder_drag(reynolds).at(times) == pytest.approx(drag, rel=5e-3)
    assert cylinder_reynolds() == (40.0, 550.0, 3000.0)


def test_two_digitisations_of_one_figure_agree_to_what_is_claimed():
    other = cylinder_drag(550, "Koumoutsakos & Leonard 1995 (second digitisation)")
    shared = (other.time > 1.0) & (other.time < 6.0)
    once = cylinder_drag(550).at(other.time[shared])
    assert other.value[shared] == pytest.approx(once, rel=0.025)


def test_curves_pass_through_their_points_and_end_where_the_data_end():
    curve = cylinder_drag(3000)
    assert curve.at(curve.time) == pytest.approx(curve.value, rel=1e-13)
    assert np.all(np.diff(curve.time) > 0)
    assert np.isnan(curve.at(np.array([curve.span[0] / 2, curve.span[1] * 2]))).all()


def test_every_row_of_the_data_carries_grade_and_source():
    rows = read_table("cylinder_drag.csv")
    assert len(rows) == 137
    assert all(row["grade"] in {"A", "A-num", "B", "C"} and row["source"] for row in rows)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: cylinder_drag(100), "give no drag at Re = 100\n  try: Re = 40, 550, 3000"),
        (lambda: cylinder_drag(550, "nobody"), "no drag curves from 'nobody'\n  try: one of"),
        (lambda: linear_drag(-1, 1.0), "reynolds must be positive, got -1"),
        (lambda: linear_drag(550, 0.0), "infinite at T = 0"),
        (lambda: short_time_drag(550, np.array([0.1, np.nan])), "infinite at T = 0"),
    ],
)
def test_what_is_not_known_is_refused(ask, said):
    with pytest.raises(InputError, match=said):
        ask()
