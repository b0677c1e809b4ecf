"""The starting aerofoil: its numbers from a made-up record, and a short run of its own."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.airfoil_start import AirfoilStart
from pmesh.cases.runner import run_case
from pmesh.cases.wagner import wagner
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A NACA 0012 at 8 degrees for 1.2 half chords of travel, on a coarse mesh."""
    folder = tmp_path_factory.mktemp("airfoil") / "run"
    case = AirfoilStart(nodes=80, until=0.6, angle=8.0, every=0.15)
    return case, run_case("airfoil-start", case, folder), folder


def named(metrics, start):
    """The metric whose name starts so."""
    (found,) = (m for m in metrics if m.name.startswith(start))
    return found


def test_the_early_lift_is_a_little_below_wagners(short):
    """By 3 to 20 %, for the boundary layer and a trailing edge too thin for the mesh; it grows."""
    case, report, _ = short
    routes = case.routes(report.outcome)
    for travel in (0.5, 1.0):
        part = case.lift(routes, travel) / case.steady_lift / float(wagner(travel))
        assert 0.80 < part < 0.97
    assert case.lift(routes, 1.0) > case.lift(routes, 0.5) > 0


def test_a_starting_vortex_leaves_and_turns_against_the_aerofoil(short):
    case, report, _ = short
    shed = named(report.metrics, "circulation of the starting vortex").value
    assert 0.1 < shed / (math.pi * math.sin(math.radians(case.angle))) < 0.6
    assert named(report.metrics, "circulation in all").passed
    assert report.outcome.state.vorticity.max() > 0


def test_both_routes_agree_and_nothing_leaks(short):
    _, report, _ = short
    assert named(report.metrics, "lift, impulse").value < 1e-3
    assert named(report.metrics, "drag, impulse").value < 1e-3
    assert named(report.metrics, "slip, rms").passed


def test_the_run_leaves_a_figure_and_a_summary(short):
    _, report, folder = short
    assert (folder / "figure.png").stat().st_size > 50_000
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["case"] == "airfoil-start"
    assert len(summary["metrics"]) == len(report.metrics)


def pretend(case: AirfoilStart, law) -> SimpleNamespace:
    """A run whose lift follows a law of the travel, with a starting vortex of circulation 0.3."""
    dt = 0.01
    time = np.arange(0, case.until + dt / 2, dt)
    lift = 0.5 * case.steady_lift * law(2 * np.maximum(time - dt / 2, 0))
    ones = np.ones_like(time)
    series = {"time": time, "dt": dt * ones, "slip": 1e-3 * ones}
    series |= {"circulation": 0 * ones, "lost_circulation": 0 * ones}
    for route in ("body0", "impulse"):
        series |= {f"{route}_force_x": 0.05 * ones, f"{route}_force_y": lift.copy()}
    grid = Grid((40, 10), 0.1, (-1.0, -0.5))
    x, y = grid.points()
    vortex = np.where((np.abs(x - 2.0) < 0.01) & (np.abs(y) < 0.01), 30.0, 0.0)
    bound = np.where((np.abs(x) < 0.01) & (np.abs(y) < 0.01), -30.0, 0.0)
    state = SimpleNamespace(grid=grid, vorticity=vortex + bound)
    return SimpleNamespace(series=series, state=state)


def test_wagners_own_lift_passes_and_another_fails():
    case = AirfoilStart(until=2.0)
    metrics = case.metrics(pretend(case, wagner))
    assert all(m.passed for m in metrics if m.passed is not None)
    growth = named(metrics, "growth of the lift")
    assert growth.value == pytest.approx(growth.reference, rel=1e-3)
    assert named(metrics, "lift over the steady inviscid one, s = 1").error == pytest.approx(
        0, abs=1e-3
    )
    assert named(metrics, "circulation of the starting vortex").value == pytest.approx(0.3)
    constant = case.metrics(pretend(case, np.ones_like))
    assert named(constant, "growth of the lift").passed is False


def test_a_short_run_is_not_judged_by_its_growth():
    case = AirfoilStart(until=0.8)
    names = [m.name for m in case.metrics(pretend(case, wagner))]
    assert any("s = 1" in name for name in names)
    assert not any("growth" in name for name in names)


@pytest.mark.parametrize(("digits", "meant"), [("99", "0012"), ("1200", "0012"), ("2012", "2412")])
def test_a_refused_aerofoil_says_which_option_to_give(digits, meant):
    with pytest.raises(InputError) as caught:
        AirfoilStart(digits=digits)
    assert caught.value.hint == f"--digits {meant}"


def test_a_quick_run_has_a_snapshot_at_every_quarter():
    case = AirfoilStart.make({}, quick=True)
    assert case.until / 4 % case.every == 0


def test_the_nose_points_up_at_a_positive_angle():
    shape = AirfoilStart(angle=10.0).shape
    nose = np.array([[-0.49 * math.cos(math.radians(10))], [0.49 * math.sin(math.radians(10))]])
    assert float(shape.distance(nose)[0]) < 0
    assert float(shape.distance(nose * [[1.0], [-1.0]])[0]) > 0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reynolds": 100.0}, "reynolds must be between 200 and 20000"),
        ({"angle": -1.0}, "angle must be from 0 to 30"),
        ({"angle": 31.0}, "angle must be from 0 to 30"),
        ({"nodes": 63}, "nodes must be at least 64"),
        ({"digits": "12"}, "digits must be four digits"),
        ({"deformation": math.nan}, "deformation must be"),
        ({"every": 0.0}, "every must be positive"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        AirfoilStart(**options)
    assert caught.value.hint
