"""The oscillating cylinder: Morison's coefficients and measured profiles, at a size that fits."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.oscillating_cylinder import COEFFICIENTS, OscillatingCylinder, measured
from pmesh.cases.runner import run_case
from remesh.errors import InputError


@pytest.fixture(scope="module")
def coarse(tmp_path_factory):
    """Two periods with 20 nodes per diameter."""
    folder = tmp_path_factory.mktemp("oscillating") / "run"
    case = OscillatingCylinder(nodes=20, until=10.0, deformation=0.5)
    return case, run_case("oscillating-cylinder", case, folder), folder


def test_the_force_is_what_duetsch_and_others_found(coarse):
    """Within 6 % after two periods with 20 nodes; the case's own size is within 4 %."""
    case, report, _ = coarse
    fourier, least = case.morison(report.outcome)
    assert fourier == pytest.approx(COEFFICIENTS, rel=0.06)
    assert least == pytest.approx(COEFFICIENTS, rel=0.06)


def test_the_velocity_is_what_was_measured(coarse):
    """In sign and size: rms 0.12 U, where its own is 0.4 U."""
    case, report, _ = coarse
    profiles = case.profiles(report.outcome)
    assert len(profiles) == 12
    ours = np.concatenate([p.ours for p in profiles])
    known = np.concatenate([p.measured for p in profiles])
    assert math.sqrt(np.mean((ours - known) ** 2)) < 0.12
    assert math.sqrt(np.mean(known**2)) > 0.35
    assert np.corrcoef(ours, known)[0, 1] > 0.95


def test_the_cylinder_is_where_the_law_says_and_forces_agree(coarse):
    case, report, folder = coarse
    series = report.outcome.series
    np.testing.assert_allclose(
        series["body0_x"], [case.place(t)[0] for t in series["time"]], atol=1e-12
    )
    by_name = {m.name: m for m in report.metrics}
    for name in ("force routes apart", "lift, for the flow is symmetric"):
        assert by_name[name].passed, name
    assert (folder / "figure.png").stat().st_size > 50_000


def test_only_the_last_period_is_kept_as_snapshots(coarse):
    _, report, _ = coarse
    times = [shot.time for shot in report.outcome.snapshots()]
    np.testing.assert_allclose(times, 5.0 + np.arange(13) * 5.0 / 12, atol=1e-9)


def made_up(case, drag, added):
    """The series of a force that is Morison's."""
    time = np.linspace(0, case.until, 4001)
    dt = np.diff(time, prepend=0.0)
    phase = case.rate * (time - 0.5 * dt)
    speed, gain = -np.cos(phase), case.rate * np.sin(phase)
    force = -0.5 * drag * np.abs(speed) * speed - 0.25 * math.pi * added * gain
    return SimpleNamespace(series={"time": time, "dt": dt, "body0_force_x": force})


@pytest.mark.parametrize("cycle", [1, 2, None])
def test_morisons_coefficients_of_morisons_force_are_found(cycle):
    case = OscillatingCylinder(until=11.0)
    for found in case.morison(made_up(case, 2.2, 1.4), cycle):
        assert found == pytest.approx((2.2, 1.4), rel=2e-3)


def test_the_motion_begins_at_full_speed_and_its_speed_is_its_rate():
    case = OscillatingCylinder(keulegan=4.0)
    assert case.place(0.0) == (0.0, 0.0)
    assert case.speed(0.0) == (-1.0, 0.0)
    step = 1e-6
    for time in (0.3, 1.7):
        slope = (case.place(time + step)[0] - case.place(time - step)[0]) / (2 * step)
        assert slope == pytest.approx(case.speed(time)[0], abs=1e-8)
    assert case.place(case.keulegan)[0] == pytest.approx(0.0, abs=1e-14)


def test_the_measured_profiles_are_whole():
    rows = measured()
    assert {row["phase"] for row in rows} == {"180", "210", "330"}
    assert {row["x"] for row in rows} == {"-0.6", "0.0", "0.6", "1.2"}
    assert max(abs(float(row["u"])) for row in rows) < 1.1


def test_nothing_is_judged_where_nothing_is_known():
    case = OscillatingCylinder(reynolds=80.0, until=10.0)
    assert case.profiles(SimpleNamespace(snapshots=list)) == []


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reynolds": 5.0}, "reynolds must be between 10 and 500"),
        ({"keulegan": 0.1}, "keulegan must be between 0.5 and 20"),
        ({"nodes": 8}, "nodes must be at least 16 per diameter"),
        ({"until": 4.0}, "until must be at least one period, 5, got 4"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        OscillatingCylinder(**options)
    assert caught.value.hint
