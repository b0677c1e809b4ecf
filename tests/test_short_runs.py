"""Every case tells and draws a run of two steps: a run that was cut short is no error."""

from __future__ import annotations

import json

import pytest

from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case

SIZES = {
    "cylinder": {"nodes": 32},
    "cylinder-wake": {"nodes": 12},
    "airfoil-start": {"nodes": 68},
    "moving-cylinder": {"nodes": 32},
    "oscillating-cylinder": {"nodes": 16, "keulegan": 0.5, "until": 0.5},  # a period at least
    "falling-disk": {"nodes": 16},
    "swimmer": {"nodes": 104},
    "swimmer-pair": {"nodes": 104, "alone": False},
}
SHEDDING = {"reynolds": 150.0, "nodes": 12}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        *((name, SIZES.get(name, {})) for name in CASES),
        ("cylinder-wake", SHEDDING),
        ("swimmer", {"nodes": 104, "tether": "fixed"}),
    ],
)
def test_a_run_of_two_steps_has_its_metrics_and_its_figure(name, options, tmp_path):
    cls = find(name)
    if "until" not in options:
        flow, state = cls.make(options, quick=True).build()
        options = {**options, "until": 1.5 * flow.limit(state).dt}
    report = run_case(name, cls.make(options, quick=True), tmp_path)
    assert "until" in SIZES.get(name, {}) or report.cost.steps == 2
    assert report.metrics
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    told = json.loads((tmp_path / "summary.json").read_text())["metrics"]
    assert len(told) == len(report.metrics)
