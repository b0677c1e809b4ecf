"""Zalesak's sphere on particles: what the issue asks of it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.cases.zalesak import PERIOD
from pmesh.cases.zalesak_sphere import ZalesakSphere
from pmesh.run.loop import run

VOLUME = 12757.888


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A quick run: its report and its directory."""
    folder = tmp_path_factory.mktemp("zalesak") / "sphere"
    return run_case("zalesak-sphere", ZalesakSphere.make({}, quick=True), folder), folder


def test_a_quick_run_passes_and_leaves_its_files(quick):
    report, folder = quick
    assert [m for m in report.metrics if m.passed is False] == []
    assert json.loads((folder / "summary.json").read_text())["case"] == "zalesak-sphere"
    assert len((folder / "figure.png").read_bytes()) > 50_000
    assert {"volume", "departure", "path_error"} <= set(report.outcome.series)


def test_the_interface_is_within_a_millionth_and_the_volume_within_a_percent(quick):
    report, _ = quick
    found = {m.name: m for m in report.metrics}
    assert found["departure of the rebuilt interface"].value < 1e-6
    assert found["departure of the particles"].value < 1e-6
    assert found["volume at the end"].reference == pytest.approx(VOLUME, abs=1e-3)
    assert abs(found["volume at the end"].error) < 0.01


def test_a_whole_turn_brings_every_particle_back():
    case = ZalesakSphere(nodes=50)
    flow, state = case.build()
    end = run(flow, state, until=PERIOD)
    assert case.path_error(end) < 1e-6
    assert np.abs(end.positions - state.positions).max() < 1e-6
    assert end.values is state.values


def test_a_turn_in_few_steps_remeshed_at_each_keeps_the_volume():
    case = ZalesakSphere(nodes=50, remeshing="always", steps=16)
    flow, state = case.build()
    end = run(flow, state, until=PERIOD)
    assert flow.ledger(end)["volume"] == pytest.approx(VOLUME, rel=0.02)


def test_the_registry_leads_to_the_case():
    assert find("zalesak-sphere") is ZalesakSphere
    assert CASES["zalesak-sphere"].line
