"""The towed cylinder: its drag is that of the held one, at a size that fits."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.cases.moving_cylinder import HELD, MovingCylinder
from pmesh.cases.runner import run_case
from remesh.errors import InputError


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The quick run: 64 nodes per diameter to T = 1."""
    folder = tmp_path_factory.mktemp("moving") / "run"
    case = MovingCylinder.make({}, quick=True)
    return case, run_case("moving-cylinder", case, folder), folder


def test_the_towed_cylinder_feels_what_the_held_one_feels(quick):
    """Within 1 % at every step after T = 0.3."""
    case, report, _ = quick
    moving, held = case.drag(report.outcome), case.held(report.outcome)
    late = moving.time > 0.3
    np.testing.assert_allclose(moving.momentum[late], held.momentum[late], rtol=0.01)
    np.testing.assert_allclose(moving.impulse[late], held.impulse[late], rtol=0.01)
    assert held.momentum[late].min() > 0.5, "a drag"


def test_every_judged_metric_passes_and_names_its_source(quick):
    _, report, _ = quick
    judged = [m for m in report.metrics if m.passed is not None]
    assert [m.name for m in judged if not m.passed] == []
    assert judged[0].name.startswith("towed off held")
    assert judged[0].grade == "A"
    assert any("published" in m.name for m in judged)


def test_the_two_are_seen_from_frames_that_move_past_each_other(quick):
    """Power: the towed one works on the fluid at rest, the held one does none."""
    case, report, folder = quick
    series = report.outcome.series
    assert series["body0_x"][-1] == pytest.approx(-1.0)
    assert f"{HELD}body0_x" not in series
    late = series["time"] > 0.3
    power, drag = series["body0_power"][late], series["body0_force_x"][late]
    np.testing.assert_allclose(power, drag, rtol=0.02)
    assert np.abs(series[f"{HELD}body0_power"][late]).max() < 1e-12
    assert case.drag(report.outcome).dt is not None
    assert (folder / "figure.png").stat().st_size > 50_000


def test_the_towed_wake_holds_the_impulse_that_the_held_one_holds(quick):
    """The impulse of a vorticity without circulation is the same in both frames."""
    _, report, _ = quick
    last = {name: column[-1] for name, column in report.outcome.series.items() if name != "rule"}
    assert last["impulse_x"] == pytest.approx(last[f"{HELD}impulse_x"], rel=0.005)
    assert last["impulse_x"] < -2 * np.pi * 0.9, "that of the potential flow, and the drag's"
    assert abs(last["circulation"]) < 1e-9


def test_parameters_outside_the_case_are_refused():
    for options in ({"reynolds": 10.0}, {"nodes": 8}, {"until": -1.0}):
        with pytest.raises(InputError) as caught:
            MovingCylinder(**options)
        assert caught.value.hint
