"""Particles in a vortex lose their overlap and the interface, unless they are remeshed."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest

from pmesh.cases.registry import CASES, find
from pmesh.cases.remeshing_effect import AREA, RemeshingEffect
from pmesh.cases.runner import run_case
from remesh.errors import InputError


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A quick run: its report and its directory."""
    folder = tmp_path_factory.mktemp("remeshing") / "run"
    return run_case("remeshing-effect", RemeshingEffect.make({}, quick=True), folder), folder


def test_a_quick_run_passes_and_leaves_its_files(quick):
    report, folder = quick
    assert [m for m in report.metrics if m.passed is False] == []
    assert json.loads((folder / "summary.json").read_text())["case"] == "remeshing-effect"
    assert len((folder / "figure.png").read_bytes()) > 50_000
    with (folder / "series.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert {"area_with", "error_without", "gap_without", "marker_area"} <= rows[0].keys()


def test_remeshing_keeps_the_area_and_the_interface(quick):
    """Without it a sixth of the area is holes, and the error several times as large."""
    found = {m.name: m.value for m in quick[0].metrics}
    assert found["area with remeshing"] == pytest.approx(AREA, rel=0.02)
    assert found["area without remeshing"] < 0.9 * AREA
    small = found["mean error with remeshing, in cells"]
    assert small < 0.1
    assert found["mean error without remeshing, in cells"] > 4 * small


def test_holes_come_when_neighbours_are_farther_apart_than_the_mollifier_is_wide(quick):
    series = quick[0].outcome.series
    seen = np.isfinite(series["area_without"])
    gap, area = series["gap_without"][seen], series["area_without"][seen]
    assert area[gap < 1.2] == pytest.approx(AREA, rel=5e-3)
    assert (area[gap > 6.0] < 0.95 * AREA).all()
    assert series["gap_with"].max() < 2.0


def test_at_the_start_both_rebuild_the_disk():
    case = RemeshingEffect(nodes=64)
    flow, state = case.build()
    area, error, other, same = case.measured(flow, state, 4)
    assert [area, other] == pytest.approx([AREA] * 2, rel=2e-3)
    assert max(error, same) < 0.03


def test_the_start_is_a_disk_whose_middle_holds_particles_too():
    case = RemeshingEffect(nodes=64)
    flow, state = case.build()
    apart = state.without.positions - (0.5, 0.75)
    assert np.hypot(*apart.T).min() < case.spacing
    assert state.without.values.min() == pytest.approx(-8 / 15 * flow.without.reach)
    assert math.isclose(flow.limit(state).dt, 1 / 64)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"nodes": 4}, "nodes must be at least 16"),
        ({"order": 3}, "order must be 2, 4 or 6"),
        ({"courant": 0.0}, "courant must be positive"),
        ({"radius": -1.0}, "radius must be positive"),
        ({"remeshing": "never"}, "remeshing must be distorted, always or a number"),
        ({"every": 0.0}, "every must be positive"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        RemeshingEffect(**options)


def test_the_registry_leads_to_the_case():
    assert find("remeshing-effect") is RemeshingEffect
    assert CASES["remeshing-effect"].line
