"""Reversed cases on adaptive meshes: what is refused, what a study holds, which particles count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmesh.cases import adaptive_interface
from pmesh.cases.adaptive_interface import Run, active_particles
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
    assert adaptive[case.tolerance].most == found.outcome.series["active"].max()
    assert all(
        run.most >= max(run.start, run.end) for run in (*adaptive.values(), *uniform.values())
    )


def test_a_study_leaves_out_what_is_no_tolerance(report, monkeypatch):
    case, found = report
    asked: list[float] = []

    def told(case):
        asked.append(getattr(case, "tolerance", 0.0))
        return Run(1, 2, 1, 0.0, 0.0)

    monkeypatch.setattr(adaptive_interface, "_run_of", told)
    adaptive, _ = replace(case, tolerance=0.8).runs(found.outcome)
    assert list(adaptive) == [0.8 * 0.1, 0.8 * 0.25, 0.8]
    assert set(asked) == {0.0, 0.8 * 0.1, 0.8 * 0.25}


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
        ({"nodes": 500}, r"nodes must be a multiple of 128 .*got 500\n.*--nodes 512, or fewer"),
        ({"levels": 0}, "levels must be from 1 to 20, got 0"),
        ({"tolerance": 0.0}, r"tolerance must be between 0 and 1, got 0.0\n.*--tolerance 0.01"),
        ({"tolerance": 2.0}, "tolerance must be between 0 and 1, got 2.0"),
        ({"refinement": 0.5}, "refinement must be at least 1, got 0.5"),
        (
            {"band": 0.07},
            r"at least 4 coarsest cells .* got 2.24: .*\n.*--levels 3 .* --band 0.125",
        ),
        ({"levels": 9}, r"got 0.156: 0.15625 after 9 halvings of 1/512\n.*--levels 4$"),
        ({"kernel": "M5"}, "kernel"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        SingleVortexAdaptive(**options)
