"""Pictures of a series: which columns, over which published curves, at which frequencies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_run import PERIOD, make

from pmesh.cases.histories import (
    alive,
    forces,
    history_figure,
    motions,
    spectrum_figure,
    spoken,
    statistics_of,
)
from pmesh.cases.reference import Curve
from pmesh.run.series import read_series


def test_forces_are_known_by_their_names_and_round_off_is_no_force(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    named = ["body0_force_x", "body0_force_y", "body0_power"]
    assert forces(series) == named
    assert alive(series, named) == named[:2]
    assert forces({"enforced": np.ones(3), "thrust": np.ones(3), "lift": np.full(3, np.nan)}) == [
        "thrust"
    ]


def test_velocities_are_at_the_ends_of_steps_forces_at_their_middles(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    series |= {"body0_u": np.sin(series["time"]), "body0_spin": np.zeros(401)}
    assert motions(series) == ["body0_u", "body0_spin"]
    assert alive(series, motions(series)) == ["body0_u"]
    figure = history_figure(series, ["body0_u"], {})
    (panel,) = figure.axes
    assert panel.get_ylabel() == "u $[L/T]$"
    assert panel.lines[0].get_xdata() == pytest.approx(series["time"])
    assert statistics_of(series, ["body0_u"])["body0_u"].start > 0


def test_names_are_spoken() -> None:
    assert spoken("body12_force_x") == "body 12, force x"
    assert spoken("impulse_force_y") == "impulse force y"
    assert spoken("bodyguard") == "bodyguard"


def test_statistics_of_forces_are_exact_on_exact_forces(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    found = statistics_of(series, ["body0_force_x", "body0_force_y"])
    lift, drag = found["body0_force_y"].cycle, found["body0_force_x"].cycle
    assert lift is not None
    assert drag is not None
    assert lift.period.value == pytest.approx(PERIOD, rel=1e-5)
    assert drag.period.value == pytest.approx(PERIOD / 2, rel=1e-5)
    assert lift.amplitude.value == pytest.approx(0.4, rel=5e-3)
    assert drag.mean.value == pytest.approx(1.3, abs=1e-6)


def test_histories_have_a_panel_per_kind_and_published_points_over_ours(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    curve = Curve(np.array([1.0, 30.0]), np.array([1.25, 1.6]), "B", "Somebody 1999")
    names = ["body0_force_x", "body0_force_y"]
    figure = history_figure(series, names, {"body0_force_x": curve})
    above, below = figure.axes
    assert (above.get_ylabel(), below.get_ylabel()) == (
        "force x $[L^3/T^2]$",
        "force y $[L^3/T^2]$",
    )
    ours, theirs = above.lines
    assert ours.get_ydata() == pytest.approx(series["body0_force_x"][1:])
    assert ours.get_xdata()[4] == pytest.approx(series["time"][5] - 0.025)
    assert (theirs.get_label(), list(theirs.get_ydata())) == ("Somebody 1999", [1.25, 1.6])
    low, high = above.get_ylim()
    assert low < 1.25
    assert 1.32 < high < 1.4  # what is published after the end does not count
    assert below.get_ylim()[0] < -0.4 < 0.4 < below.get_ylim()[1]


def test_a_route_asked_at_every_fifth_step_is_drawn_through_its_points(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    seldom = np.where(np.arange(401) % 5 == 0, series["body0_force_x"], np.nan)
    series |= {"body0_flux_force_x": seldom}
    figure = history_figure(series, ["body0_force_x", "body0_flux_force_x"], {})
    (panel,) = figure.axes
    _, line = panel.lines
    known = np.flatnonzero(np.isfinite(seldom))
    assert known.size > 70
    assert line.get_ydata() == pytest.approx(seldom[known])
    assert line.get_xdata() == pytest.approx((series["time"] - 0.5 * series["dt"])[known])


def test_axes_name_the_unit_of_what_they_show() -> None:
    time = np.linspace(0.0, 1.0, 9)
    units = {"u": "L/T", "v": "L/T", "spin": "rad/T", "torque": "L^4/T^2", "power": "L^4/T^3"}
    series = {"time": time, "dt": np.full(9, 0.125)} | {f"body0_{x}": time for x in units}
    figure = history_figure(series, [f"body0_{x}" for x in units], {})
    shown = [panel.get_ylabel() for panel in figure.axes]
    assert shown == [f"{name} $[{unit}]$" for name, unit in units.items()]


def test_the_spectrum_marks_the_dominant_frequencies(tmp_path: Path) -> None:
    series = read_series(make(tmp_path))
    found = statistics_of(series, ["body0_force_x", "body0_force_y"])
    figure = spectrum_figure(series, found)
    assert figure is not None
    (panel,) = figure.axes
    marks = [line.get_xdata()[0] for line in panel.lines if len(line.get_xdata()) == 2]
    assert marks == [pytest.approx(2 / PERIOD, rel=1e-4), pytest.approx(1 / PERIOD, rel=1e-4)]
    assert spectrum_figure(series, {}) is None
