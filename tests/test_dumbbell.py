"""The case of the collapsing dumbbell."""

import numpy as np
import pytest

from pmesh.cases.dumbbell import DumbbellCase, neck_of, zero_of
from pmesh.cases.runner import run_case
from remesh.errors import InputError


def test_a_zero_is_found_between_steps_to_high_order():
    time = np.linspace(0, 1, 11)
    assert zero_of(time, np.sin(time - 0.537)) == pytest.approx(0.537, abs=1e-6)
    assert zero_of(time, time + 1) is None
    assert zero_of(time[:2], np.array([-1.0, 3.0])) == pytest.approx(0.025)
    assert neck_of(np.array([-0.2, -0.1, 0.0, 0.1]), 0.5) == pytest.approx(1.0)
    assert neck_of(np.array([0.2, 0.3]), 0.5) == 0.0


def test_a_short_run_pinches_off_in_the_middle_at_the_right_time(tmp_path):
    case = DumbbellCase.make({"until": 0.008}, quick=True)
    report = run_case("dumbbell", case, tmp_path)
    metrics = {metric.name: metric for metric in report.metrics}
    assert all(metric.passed is not False for metric in report.metrics)
    assert metrics["pinch-off time"].error < 0.02
    assert metrics["pieces after the pinch"].value == 2
    assert metrics["asymmetry, largest over max |phi|"].value <= 1e-12
    series = report.outcome.series
    assert (np.diff(series["volume"]) < 0).all()
    assert (np.diff(series["area"]) < 0).all()
    assert (tmp_path / "figure.png").stat().st_size > 20000
    titles = [panel.get_title("left") for panel in case.draw(report.outcome).get_axes()]
    assert sorted(title[:3] for title in titles) == [f"({k})" for k in "abcdef"]


def test_what_is_no_dumbbell_is_refused():
    for wrong in ({"bar": 0.4}, {"cells": 8}, {"separation": 0.5}, {"every": 0.0}):
        with pytest.raises(InputError):
            DumbbellCase(**wrong)
