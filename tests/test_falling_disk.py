"""The falling disk: added mass, the first motion, a light disk, Newton's law, at small sizes."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.falling_disk import DRAGS, FallingDisk
from pmesh.cases.runner import run_case
from remesh.errors import InputError


@pytest.fixture(scope="module", params=[2.0, 0.1], ids=["heavy", "light"])
def early(request, tmp_path_factory):
    """The first moments of a heavy and of a light disk."""
    folder = tmp_path_factory.mktemp("falling") / "run"
    case = FallingDisk.make({"density": request.param, "until": 0.8}, quick=True)
    return case, run_case("falling-disk", case, folder), folder


def test_it_sets_off_with_its_added_mass(early):
    """Force less friction over acceleration is pi rho R^2 within 2 %."""
    case, report, _ = early
    assert case.added_mass(case.fall(report.outcome)) == pytest.approx(1.0, abs=0.02)


def test_its_first_motion_is_that_of_unsteady_stokes_flow(early):
    case, report, _ = early
    fall = case.fall(report.outcome)
    first = (fall.time > 0.1) & (fall.time < 0.4)
    np.testing.assert_allclose(fall.speed[first], case.slow(fall.time[first]).speed, rtol=0.02)


def test_a_heavy_disk_falls_and_a_light_one_rises(early):
    case, report, folder = early
    assert np.sign(report.outcome.series["body0_y"][-1]) == (-1 if case.density > 1 else 1)
    assert [m.name for m in report.metrics if m.passed is False] == []
    assert (folder / "figure.png").stat().st_size > 40_000


def test_the_terminal_speed_is_that_at_which_the_drag_carries_the_weight():
    """Weight less buoyancy = Cd U^2 D / 2 at U = 1."""
    for reynolds, (drag, _) in DRAGS.items():
        for density in (0.5, 3.0):
            case = FallingDisk(reynolds=reynolds, density=density)
            weight = abs((density - 1) * math.pi / 4 * case.gravity[1])
            assert weight == pytest.approx(0.5 * drag)
            assert case.gravity[1] < 0


def test_a_run_that_meets_the_law_passes_and_one_that_does_not_fails():
    """A made-up fall: the exact first motion, then the terminal speed."""
    case = FallingDisk(until=20.0)
    time = np.linspace(0.0, 20.0, 1001)
    slow = np.concatenate([[0.0], case.slow(time[1:]).speed])
    for factor, passes in ((1.0, True), (1.05, False)):
        speed = factor * np.where(time < 0.5, slow, np.maximum(slow[25], np.tanh(time / 4)))
        dt = np.diff(time, prepend=0.0)
        gain = np.diff(speed, prepend=0.0) / np.where(dt > 0, dt, 1.0)
        force = math.pi / 4 * (case.pull - case.density * gain)
        flat = np.zeros_like(time)
        series = {
            "time": time, "dt": dt, "body0_v": -speed, "body0_u": flat, "body0_spin": flat,
            "body0_force_y": force, "impulse_force_y": force, "slip": flat,
        }  # fmt: skip
        metrics = {m.name: m for m in case.metrics(SimpleNamespace(series=series))}
        assert metrics["terminal speed"].passed is passes
        assert metrics["off Newton's law, over the weight"].passed
        off = next(m for name, m in metrics.items() if name.startswith("speed off"))
        assert off.passed is passes
        assert metrics["added mass over pi rho R^2"].passed is passes


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"density": 1.0}, "density must be not that of the fluid"),
        ({"density": -1.0}, "density must be positive"),
        ({"reynolds": 50.0}, "reynolds must be 20 or 40"),
        ({"nodes": 8}, "nodes must be at least 16"),
        ({"wake": 1.0}, "wake must be at least 4"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        FallingDisk(**options)
    assert caught.value.hint
