"""The case cutting: what a quick run of it must show."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pmesh.cases.cutting import CuttingCase
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.run.snapshots import read_snapshots
from remesh.errors import InputError


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A quick run: its report and its directory."""
    folder = tmp_path_factory.mktemp("cutting") / "run"
    return run_case("cutting", CuttingCase.make({}, quick=True), folder), folder


def metric(report, name: str):
    """The metric with this name."""
    (found,) = (m for m in report.metrics if m.name == name)
    return found


def test_every_judged_metric_passes_and_names_its_source(quick) -> None:
    report, _ = quick
    judged = [m for m in report.metrics if m.passed is not None]
    assert len(judged) == 5
    assert all(m.passed and m.source and m.grade in ("A", "A-num") for m in judged)


def test_removed_is_what_was_swept_within_a_percent(quick) -> None:
    report, _ = quick
    assert abs(metric(report, "volume removed").error) < 0.01
    assert abs(metric(report, "removed by a ball in a block").error) < 0.002


def test_the_blade_leaves_two_pieces_and_nothing_is_remeshed(quick) -> None:
    series = quick[0].outcome.series
    assert series["pieces"][0] == 1
    assert series["pieces"][-1] == 2
    assert np.all(series["remeshings"] == 0)
    assert np.all(np.diff(series["removed"]) > -1e-9)
    assert np.ptp(series["volume"] + series["removed"]) < 1e-3 * series["volume"][0]


def test_the_panel_of_the_volume_says_where_its_axis_begins(quick) -> None:
    figure = CuttingCase.make({}, quick=True).draw(quick[0].outcome)
    (panel,) = (p for p in figure.get_axes() if "volume" in p.get_title("left"))
    assert f"from {panel.get_ylim()[0]:g} up" in panel.get_title("left")


def test_a_run_leaves_the_files_of_the_contract(quick) -> None:
    _, folder = quick
    assert json.loads((folder / "summary.json").read_text())["case"] == "cutting"
    assert len(read_snapshots(folder)) == 3
    for name in ("case.toml", "series.csv", "checkpoint.h5", "fields.vtkhdf"):
        assert (folder / name).stat().st_size > 0
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_the_registry_leads_to_the_case() -> None:
    assert find("cutting") is CuttingCase
    assert CASES["cutting"].line


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: CuttingCase(cells=20), "cells must be at least 28, got 20"),
        (lambda: CuttingCase(burr=0.0), "burr must be positive"),
        (lambda: CuttingCase(burr=0.03), "burr must be at least two spacings, got 0.03"),
        (lambda: CuttingCase(burr=0.5), "burr must be at most 0.3"),
        (lambda: CuttingCase(breathing=-0.1), "breathing must be between 0 and 0.3"),
        (lambda: CuttingCase(largest_step=0.0), "largest_step must be positive"),
    ],
)
def test_options_out_of_range_are_refused(make, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()
