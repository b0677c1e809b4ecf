"""The cases of vortex rings: what each must show, at sizes that fit, and how it is measured."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.leapfrog import LeapfrogCase, Tracks, passages, tracks
from pmesh.cases.registry import CASES, find
from pmesh.cases.ring import PROJECTED, RingCase
from pmesh.cases.ring_collision import RingCollision
from pmesh.cases.ring_waves import RingWaves, growth
from pmesh.cases.rings import balance, drift, imbalance, loss
from pmesh.cases.runner import run_case
from pmesh.run.snapshots import read_snapshots
from remesh.errors import InputError

RINGS = {
    "ring": RingCase,
    "leapfrog": LeapfrogCase,
    "ring-collision": RingCollision,
    "ring-7500": RingWaves,
}
BRIEF = {
    "ring": 0.2, "leapfrog": 0.12, "ring-collision": 0.13, "ring-7500": 0.16,
}  # fmt: skip


@pytest.fixture(scope="module", params=RINGS)
def brief(request, tmp_path_factory):
    """A run of a few steps of each case: its name, its report, its directory."""
    folder = tmp_path_factory.mktemp("rings") / request.param
    case = RINGS[request.param].make({"until": BRIEF[request.param]}, quick=True)
    return request.param, run_case(request.param, case, folder), folder


def test_every_judged_metric_of_a_brief_run_passes_and_names_its_source(brief):
    _, report, _ = brief
    judged = [m for m in report.metrics if m.passed is not None]
    assert judged
    assert [m for m in judged if not m.passed] == []
    assert all(m.source and m.grade for m in judged)


def test_a_run_leaves_the_files_of_the_contract(brief):
    name, _, folder = brief
    assert json.loads((folder / "summary.json").read_text())["case"] == name
    assert len(read_snapshots(folder)) == 2
    for left in ("case.toml", "series.csv", "checkpoint.h5", "fields.vtkhdf"):
        assert (folder / left).stat().st_size > 0
    assert (folder / "figure.png").stat().st_size > 50_000


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_a_projected_ring_is_solenoidal_to_the_round_off_of_its_precision(dtype, tmp_path):
    case = RingCase.make({"until": 0.1, "projection": 1, "dtype": dtype}, quick=True)
    report = run_case("ring", case, tmp_path)
    (own,) = [m for m in report.metrics if m.name == "divergence, largest"]
    assert own.passed
    assert own.tolerance == PROJECTED[dtype] < 1e-4  # without projection 1e-3 is allowed


@pytest.mark.parametrize("name", RINGS)
def test_the_registry_leads_to_the_case(name):
    assert find(name) is RINGS[name]
    assert CASES[name].line


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: RingCase(core=0.6), "core must be at most half"),
        (lambda: RingCase(spacing=0.05), "spacing must be at most the core radius over 2.5"),
        (lambda: RingCase(viscosity=-1.0), "viscosity must be not negative"),
        (lambda: RingCase(projection=-1), "projection must be not negative"),
        (lambda: RingCase(dtype="float16"), "dtype must be one of"),
        (lambda: LeapfrogCase(gap=0.3), "gap must be at least four core radii"),
        (lambda: LeapfrogCase(pictures=0), "pictures must be at least 1"),
        (lambda: RingCollision(reynolds=0.0), "reynolds must be positive"),
        (lambda: RingCollision(amplitude=0.5), "amplitude must be at most 0.1"),
        (lambda: RingCollision(waves=(0,)), "waves must be whole numbers from 1 on"),
        (lambda: RingWaves(nodes=4), "spacing must be at most the core radius over 2.5"),
        (lambda: RingWaves(amplitude=0.0), "amplitude must be positive"),
    ],
)
def test_options_out_of_range_are_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()


def test_nodes_of_the_thick_ring_set_its_spacing():
    assert RingWaves(nodes=20).recipe().grid.spacing == 1 / 20


def test_cores_that_change_places_in_the_columns_keep_their_names():
    """The rows come the stronger first; a core that is lost for a while stays where it was."""
    time = np.arange(4.0)
    below, above = np.array([-1.0, -0.8, -0.6, -0.4]), np.array([1.0, 1.2, 1.4, 1.6])
    radii = np.full(4, 0.9), np.full(4, 1.1)
    series = {
        "time": time,
        "core0_r": np.array([1.1, 0.9, 1.1, 1.1]), "core1_r": np.array([0.9, 1.1, np.nan, 0.9]),
        "core0_z": np.array([1.0, -0.8, 1.4, 1.6]), "core1_z": np.array([-1.0, 1.2, np.nan, -0.4]),
    }  # fmt: skip
    path = tracks(series)
    known = np.array([below, above])
    known[0, 2] = -0.8
    assert path.heights == pytest.approx(known)
    assert path.radii == pytest.approx(np.array(radii))


def test_passages_are_half_a_period_apart_in_theory():
    case = LeapfrogCase()
    period = case.theory.leapfrog_period()
    path = case.theory.trajectory(np.linspace(0.0, 2.0 * period, 4001))
    times = passages(Tracks(path.times, path.radii, path.heights))
    assert np.diff(times) == pytest.approx(0.5 * period, rel=1e-5)
    passed, half = case._known()
    assert passed == pytest.approx(times[:2], rel=1e-5)
    assert half == pytest.approx(0.5 * period, rel=1e-5)
    assert 1.05 * half < case.until, "the default run sees half a period"


@pytest.mark.parametrize(("merged", "passes"), [(False, True), (True, False)])
def test_rings_that_merge_before_they_have_passed_fail(merged, passes):
    case = LeapfrogCase()
    times = np.linspace(0.0, 4.2, 400)
    path = case.theory.trajectory(times)
    heights = np.where(merged, np.minimum(path.heights[0], path.heights[1] - 0.1), path.heights[0])
    series = {
        "time": times, "core0_r": path.radii[0], "core1_r": path.radii[1], "core0_z": heights,
        "core1_z": path.heights[1], "ring_height": path.heights.mean(axis=0),
    }  # fmt: skip
    series |= {name: np.ones(400) for name in ("impulse_z", "ring_circulation", "energy")}
    series["divergence"] = np.zeros(400)
    found = {m.name: m for m in case.metrics(SimpleNamespace(series=series))}
    for name in ("first passage", "period, twice that from equal radii to equal radii"):
        assert found[name].passed is passes


def test_growth_is_that_of_an_exponential_between_seed_and_saturation():
    time = np.linspace(0.0, 40.0, 401)
    size = np.minimum(1e-3 * np.maximum(1.0, np.exp(0.25 * (time - 10.0))), 0.2)
    rate, line = growth(time, size)
    assert rate == pytest.approx(0.25, rel=1e-3)
    assert line[200] == pytest.approx(size[200], rel=1e-2)
    assert np.isnan(growth(time, np.full_like(time, 1e-3))[0])


def test_the_energys_balance_is_what_was_lost_but_not_dissipated():
    """E = exp(-t), dissipation exp(-t): balanced; a tenth more lost: off by that."""
    time = np.linspace(0.0, 1.0, 2001)
    series = {"time": time, "energy": np.exp(-time), "dissipation": np.exp(-time)}
    gone, spent = loss(series)
    assert gone == pytest.approx(spent, abs=1e-6)
    assert imbalance(series) == pytest.approx(0.0, abs=1e-6)
    assert imbalance(series | {"dissipation": np.exp(-time) / 1.1}) == pytest.approx(0.1, rel=1e-4)
    assert drift([2.0, 2.1, 1.6]) == pytest.approx(0.2)


def test_the_balance_says_what_it_is_a_part_of():
    time = np.linspace(0.0, 1.0, 2001)
    spent = {"time": time, "energy": np.exp(-time), "dissipation": np.exp(-time)}
    assert balance(spent).name.endswith("of what that took")
    little = {"time": time, "energy": 1.0 - 0.02 * time, "dissipation": 0.01 + 0 * time}
    assert balance(little).name.endswith("of a tenth of the first")
    assert balance(little).value == pytest.approx(0.1)
    assert not balance(little).passed


def test_on_a_coarse_mesh_the_strongest_wave_is_doubted_and_no_rate_is_told(brief):
    name, report, _ = brief
    if name != "ring-7500":
        return
    names = [metric.name for metric in report.metrics]
    assert "strongest wave, coarse: under 5 nodes per core" in names
    assert "its growth rate" not in names
