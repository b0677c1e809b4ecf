"""Exact cases in space: how they are measured, what they show at sizes that fit, refusals."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.hill import HillCase, silhouette
from pmesh.cases.runner import run_case
from pmesh.cases.strained_ring import StrainedRingCase
from pmesh.cases.taylor_green_cube import TaylorGreenCubeCase, asymmetry
from pmesh.vortex.exact import HillVortex, TaylorGreenCube
from remesh.errors import InputError
from remesh.grid import Grid


def metric(report, name):
    """The metric with this name."""
    return next(one for one in report.metrics if one.name == name)


def box(nodes: int, half: float, shift: float = 0.0) -> Grid:
    h, c = 1.0 / nodes, round(half * nodes)
    return Grid((2 * c + 1,) * 3, h, (-c * h, -c * h, -c * h + shift * h))


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_the_silhouette_of_hills_vortex_is_a_sphere_that_does_not_depend_on_the_mesh(shift):
    case = HillCase(nodes=20)
    grid = box(20, 1.4, shift)
    told = silhouette(case.vorticity(grid.points(), 0.1), grid, case.level)
    assert told["place"] == pytest.approx(0.1, abs=1e-3)
    assert told["volume"] == pytest.approx(4 / 3 * math.pi, rel=0.01)
    assert told["along"] == pytest.approx(1.0, rel=5e-3)
    assert told["across"] == pytest.approx(1.0, rel=5e-3)


def test_the_silhouette_tells_a_sphere_from_an_ellipsoid():
    """Half as long again along the axis, and a tenth wider across."""
    grid = box(16, 1.8)
    stretch = np.array([1.1, 1.1, 1.5])[:, None, None, None]
    vorticity = HillVortex(width=0.1).vorticity(grid.points() / stretch)
    vorticity[:2] *= 1.1  # w_theta/r as it was
    told = silhouette(vorticity, grid, 3.75)
    assert told["along"] / told["across"] == pytest.approx(1.5 / 1.1, rel=5e-3)


def test_hills_vortex_begins_with_its_speed_and_energy():
    case = HillCase(nodes=12)
    flow, state = case.build()
    row = flow.ledger(state)
    assert row["energy"] == pytest.approx(HillVortex().energy, rel=0.01)
    assert row["impulse_z"] == pytest.approx(2 * math.pi, rel=1e-4)
    after = flow.step(state, 0.02)
    places = [silhouette(s.vorticity, s.grid, case.level)["place"] for s in (state, after)]
    assert (places[1] - places[0]) / 0.02 == pytest.approx(1.0, rel=0.01)


def test_taylor_and_greens_vortices_have_all_their_symmetries():
    grid = Grid((16,) * 3, 2 * math.pi / 16, boundary="periodic")
    vorticity = TaylorGreenCube().vorticity(grid.points())
    assert asymmetry(vorticity) < 1e-14
    broken = vorticity.copy()
    broken[1, 3, 4, 5] += 0.1
    assert asymmetry(broken) == pytest.approx(0.1 / np.abs(vorticity).max(), rel=0.1)


@pytest.mark.parametrize(("early", "passes"), [(1e-5, True), (1e-2, False)])
def test_symmetries_are_judged_before_the_vortices_break_down(early, passes):
    """Round-off of single precision grows like any other difference afterwards."""
    case = TaylorGreenCubeCase(dtype="float32")
    grid = Grid((16,) * 3, 2 * math.pi / 16, boundary="periodic")
    smooth = case.exact.vorticity(grid.points())

    def broken(size):
        field = smooth.copy()
        field[1, 3, 4, 5] += size * np.abs(smooth).max()
        return field

    class Shot(dict):
        time = 3.0

    shots = [SimpleNamespace(time=0.0), Shot(vorticity=broken(early)), SimpleNamespace(time=9.0)]
    state = SimpleNamespace(time=10.0, vorticity=broken(0.1))
    outcome = SimpleNamespace(state=state, snapshots=lambda: shots)
    judged, told = case._symmetries(outcome)
    assert judged.passed is passes
    assert told.passed is None
    assert told.value == pytest.approx(0.1, rel=0.1)


def test_taylor_and_greens_vortices_lose_the_energy_that_a_fourier_method_tells(tmp_path):
    case = TaylorGreenCubeCase.make({"kernel": "M6'", "until": 0.8}, quick=True)
    report = run_case("taylor-green-3d", case, tmp_path)
    assert abs(metric(report, "energy at t = 0.8").error) < 1e-3
    assert metric(report, "departure from the symmetries").passed
    assert metric(report, "rms div w over rms |grad w|").value < 1e-10
    names = {path.name for path in tmp_path.iterdir()}
    assert {"case.toml", "series.csv", "fields.vtkhdf", "checkpoint.h5", "figure.png",
            "summary.json"} <= names  # fmt: skip


@pytest.mark.parametrize(("more", "passes"), [(0.0, True), (0.1, False)])
def test_energy_that_viscosity_did_not_take_fails_also_beyond_the_known_history(more, passes):
    """Energy (1 + exp(-t/5))/16, and a tenth more of the loss than the dissipation tells."""
    case = TaylorGreenCubeCase(reynolds=400.0, until=12.0)
    time = np.linspace(0.0, 12.0, 241)
    fall = np.exp(-time / 5.0) / 16.0
    energy = 0.125 - (1.0 + more) * (1.0 / 16.0 - fall)
    series = {"time": time, "energy": energy * case.volume, "divergence": 0 * time,
              "dissipation": fall / 5.0 * case.volume}  # fmt: skip
    grid = Grid((16,) * 3, 2 * math.pi / 16, boundary="periodic")
    state = SimpleNamespace(time=12.0, vorticity=case.exact.vorticity(grid.points()))
    outcome = SimpleNamespace(series=series, state=state, snapshots=list)
    report = SimpleNamespace(metrics=case.metrics(outcome))
    found = metric(report, "energy lost beyond viscosity, of what that took")
    assert found.value == pytest.approx(more, abs=1e-4)
    assert found.passed is passes
    (known,) = (m for m in report.metrics if m.name.startswith("energy at t = ") and m.reference
                and m.grade == "A-num")  # fmt: skip
    end = float(known.name.rpartition(" ")[2])
    assert end < 12.0
    assert known.value == pytest.approx(np.interp(end, time, energy), rel=1e-3)


def test_a_strained_ring_passes_all_that_it_is_judged_by(tmp_path):
    case = StrainedRingCase.make({"every": 0.4}, quick=True)
    report = run_case("strained-ring", case, tmp_path)
    assert [one.name for one in report.metrics if one.passed is False] == []
    assert metric(report, "impulse, largest error").value < 1e-4


@pytest.mark.parametrize(
    ("cls", "options", "said"),
    [
        (HillCase, {"nodes": 4}, "nodes must be at least 8"),
        (HillCase, {"nodes": 8, "edge": 4.0}, "edge must be positive"),
        (TaylorGreenCubeCase, {"nodes": 31}, "nodes must be an even number"),
        (TaylorGreenCubeCase, {"reynolds": -1.0}, "reynolds must be positive"),
        (StrainedRingCase, {"strain": (1.0, 0.0, 0.0)}, "add up to 0"),
        (StrainedRingCase, {"strain": (0.0, 0.0, 0.0)}, "not all zero"),
        (StrainedRingCase, {"spacing": 0.5}, "spacing must be at most"),
    ],
)
def test_options_that_make_no_sense_are_refused(cls, options, said):
    with pytest.raises(InputError, match=said):
        cls(**options)
