"""Zalesak's disk on particles: what the issue asks of it."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.cases.zalesak import PERIOD
from pmesh.cases.zalesak_disk import ZalesakDisk
from pmesh.run.loop import run

AREA = 582.2070306  # less the slot, closed form


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A quick run: its report and its directory."""
    folder = tmp_path_factory.mktemp("zalesak") / "disk"
    return run_case("zalesak-disk", ZalesakDisk.make({}, quick=True), folder), folder


def metric(report, name):
    """The metric with this name."""
    (found,) = (m for m in report.metrics if m.name == name)
    return found


def test_a_quick_run_passes_and_leaves_its_files(quick):
    report, folder = quick
    assert [m for m in report.metrics if m.passed is False] == []
    assert all(m.source for m in report.metrics if m.passed is not None)
    assert json.loads((folder / "summary.json").read_text())["case"] == "zalesak-disk"
    assert len((folder / "figure.png").read_bytes()) > 50_000
    with (folder / "series.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert {"area", "departure", "mean_error", "path_error", "particles"} <= rows[0].keys()
    assert len(rows) == 158


def test_about_800_particles_hold_the_disk(quick):
    report, _ = quick
    assert 750 <= metric(report, "particles").value <= 850
    assert metric(report, "mean interface error in cells, end").value < 0.01


def test_the_area_is_the_closed_form(quick):
    report, _ = quick
    found = metric(report, "area at the end")
    assert found.reference == pytest.approx(AREA, abs=1e-6)
    assert abs(found.error) < 1e-3


def test_a_whole_turn_departs_by_less_than_a_millionth():
    case = ZalesakDisk()
    flow, state = case.build()
    end = run(flow, state, until=PERIOD)
    assert case.departure(end) < 1e-6
    assert case.path_error(end) < 1e-6


@pytest.mark.parametrize(("kernel", "most"), [("M6'", 0.05), ("L4,4", 0.05), ("L6,4", 0.04)])
def test_a_turn_remeshed_at_every_step_keeps_the_area(kernel, most):
    """In 63 steps, where the maximum grid CFL is 4: 1 % of the area, a few hundredths of a cell."""
    case = ZalesakDisk(remeshing="always", kernel=kernel, steps=63)
    flow, state = case.build()
    end = run(flow, state, until=PERIOD)
    assert end.remeshings == 63
    assert flow.ledger(end)["volume"] == pytest.approx(AREA, rel=0.01)
    assert case.mean_error(end) < most


def test_the_figure_of_a_remeshed_run_is_drawn(tmp_path):
    case = ZalesakDisk(remeshing="always", steps=40, until=PERIOD / 8, every=PERIOD / 8)
    report = run_case("zalesak-disk", case, tmp_path / "run")
    assert not any("departure" in m.name for m in report.metrics)
    series = report.outcome.series
    assert np.isnan(series["path_error"][1:]).all()
    assert (tmp_path / "run/figure.png").stat().st_size > 50_000


def test_the_registry_leads_to_the_case():
    assert find("zalesak-disk") is ZalesakDisk
    assert CASES["zalesak-disk"].line
