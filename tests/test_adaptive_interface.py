"""Reversed cases on adaptive meshes: what is refused, what a study holds, which particles count."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.cases.adaptive_interface import active_particles
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.cases.single_vortex_adaptive import SingleVortexAdaptive
from remesh.errors import InputError


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    case = SingleVortexAdaptive.make({"study": True, "nodes": 128, "levels": 2, "period": 2.0,
                                      "until": 2.0}, quick=True)  # fmt: skip
    return case, run_case("single-vortex-adaptive", case, tmp_path_factory.mktemp("run") / "out")


def test_the_active_particles_of_a_snapshot_are_those_of_its_state(report):
    case, found = report
    shots = found.outcome.snapshots()
    places, levels = active_particles(shots[-1], case.levels)
    state = found.outcome.state
    assert len(places) == state.size == found.outcome.series["active"][-1]
    own = {tuple(at) for at in np.rint(state.positions * 128).astype(int)}
    assert {tuple(at) for at in np.rint(places * 128).astype(int)} == own
    assert levels.max() == state.finest


def test_a_study_holds_runs_by_tolerance_and_on_uniform_meshes(report):
    case, found = report
    adaptive, uniform = case.runs(found.outcome)
    assert list(adaptive) == sorted(case.tolerance * part for part in (1.0, *case.parts))
    assert list(uniform) == [32, 64]
    errors = [run.error for run in adaptive.values()]
    assert errors[0] < errors[-1]
    assert uniform[64].error < uniform[32].error
    assert adaptive[case.tolerance].start < uniform[64].start


def test_the_step_follows_the_courant_number_of_the_finest_cells():
    flow, state = SingleVortexAdaptive().build()
    limit = flow.limit(state)
    assert (limit.dt, limit.rule) == (pytest.approx(40 / 512), "largest_step")
    assert flow.substeps == 4
    assert flow.width == 5.0
    assert flow.mesh.thresholds == (0.01, 0.02)


def test_the_registry_leads_to_the_cases():
    for name in ("single-vortex-adaptive", "enright-adaptive"):
        assert CASES[name].line
        assert find(name).title.endswith("on an adaptive mesh")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"nodes": 500}, "need multiples of 128 nodes on each axis"),
        ({"levels": 0}, "levels must be a whole number >= 1, got 0"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"tolerance": 2.0}, r"tolerance must lie in \(0, 1\)"),
        ({"refinement": 0.5}, "refinement must be at least 1, got 0.5"),
        ({"band": 0.07}, "band must be at least 4 coarsest cells, got 0.07"),
        ({"kernel": "M5"}, "kernel"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        SingleVortexAdaptive(**options)
