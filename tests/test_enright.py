"""The reversed deformation of a ball: what is kept, that it stays whole, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.laws import Deformation
from levelset.shapes import Sphere
from pmesh.cases.deformation import exact_surface, traced
from pmesh.cases.enright import BOX, CENTER, EnrightCase
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from remesh.errors import InputError

HOME = Sphere(0.15, center=CENTER)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cases") / "enright"
    return run_case("enright", EnrightCase.make({}, quick=True), folder), folder


def metric(report, name):
    (found,) = (m for m in report.metrics if m.name == name)
    return found


def test_a_quick_run_passes_what_is_judged_and_leaves_its_picture(quick):
    report, folder = quick
    judged = [m for m in report.metrics if m.passed is not None]
    assert len(judged) >= 7
    assert all(m.passed and m.source for m in judged)
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_the_ball_stays_whole_and_comes_back(quick):
    report, _ = quick
    assert metric(report, "pieces at half the period").value == 1
    assert metric(report, "holes in the sheet at half the period").value == 0
    assert metric(report, "L1 interface error in cells").value < 0.1


def test_the_exact_area_begins_with_the_balls_and_has_settled():
    """0.2827433 = 4 pi 0.15^2; at T/2 of the short period checked with Richardson's sequence."""
    law = Deformation(period=3.0)
    assert exact_surface(law, HOME, 0.0) == pytest.approx(0.2827433, rel=1e-6)
    assert exact_surface(law, HOME, 1.5) == pytest.approx(1.1642, rel=3e-4)


def test_the_box_that_is_shown_holds_the_ball_on_its_way():
    k = np.arange(2000) + 0.5
    height, turn = 1 - 2 * k / 2000, k * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - height**2)
    ball = 0.35 + 0.15 * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    for time in (0.0, 0.5, 1.0, 1.5):
        found = traced(ball, Deformation(period=3.0), 0.0, time)
        assert (found > np.array(BOX[0]) - 1e-2).all()
        assert (found < np.array(BOX[1]) + 1e-2).all()


def test_the_registry_leads_to_the_case():
    assert find("enright") is EnrightCase
    assert CASES["enright"].line


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"nodes": 8}, "nodes must be at least 16"),
        ({"radius": 0.4}, "radius must be at most 0.3"),
        ({"band": 0.0}, "band must be positive"),
        ({"period": 0.0}, "period must be positive"),
        ({"until": -1.0}, "until must be a positive time"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        EnrightCase(**options)
