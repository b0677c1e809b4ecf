"""The sheet on particles of several spacings: volume, pieces, and its picture."""

from __future__ import annotations

from pmesh.cases.enright_adaptive import EnrightAdaptive
from pmesh.cases.runner import run_case


def test_a_quick_run_passes_what_is_judged_and_leaves_its_picture(tmp_path):
    report = run_case("enright-adaptive", EnrightAdaptive.make({}, quick=True), tmp_path / "run")
    judged = [m for m in report.metrics if m.passed is not None]
    assert len(judged) == 7
    assert all(m.passed and m.source for m in judged), [m for m in judged if not m.passed]
    assert (tmp_path / "run" / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert report.outcome.series["finest_level"].max() == 2


def test_the_step_keeps_to_what_fine_bands_bear():
    flow, state = EnrightAdaptive(nodes=128, levels=2, courant=64.0).build()
    limit = flow.limit(state)
    assert limit.rule == "deformation"
    assert limit.dt * state.gradient < 1.001
    flow, state = EnrightAdaptive().build()
    assert (flow.limit(state).rule, flow.substeps) == ("largest_step", 2)
