"""The spiral on particles of several spacings: area within 0.2 % with few of them."""

from __future__ import annotations

import pytest

from pmesh.cases.runner import run_case
from pmesh.cases.single_vortex_adaptive import SingleVortexAdaptive
from pmesh.run.loop import run


def test_the_area_stays_within_two_thousandths_with_fewer_particles_than_a_128_mesh_has_nodes():
    """The case at its full size: T = 8, finest 512^2, CFL 40."""
    case = SingleVortexAdaptive()
    flow, state = case.build()
    most, worst = 0, 0.0
    while state.time < 8.0 - 1e-9:
        state = run(flow, state, until=state.time + 1.0)
        told = flow.ledger(state)
        most = max(most, state.size)
        worst = max(worst, abs(told["volume"] / case.shape.volume - 1))
    assert worst < 2e-3
    assert most < 128**2
    assert state.size < 128**2 / 4
    assert case.error(flow, state) < case.tolerance * case.band


def test_a_quick_run_passes_what_is_judged_and_leaves_its_picture(tmp_path):
    report = run_case(
        "single-vortex-adaptive", SingleVortexAdaptive.make({}, quick=True), tmp_path / "run"
    )
    judged = [m for m in report.metrics if m.passed is not None]
    assert len(judged) == 5
    assert all(m.passed and m.source for m in judged)
    assert (tmp_path / "run" / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert {"active", "compression", "finest_level"} <= report.outcome.series.keys()
    active = report.outcome.series["active"]
    assert active.max() > 4 * active[0]
    assert report.outcome.series["volume"][0] == pytest.approx(0.0706858347, rel=1e-3)
