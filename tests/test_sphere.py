"""The sphere in a stream: its laws, numbers of made-up records, and a short run of its own."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.runner import run_case
from pmesh.cases.sphere import FORCE, SphereCase
from pmesh.cases.sphere_laws import published
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """The first tenth of a diameter at Re = 100."""
    folder = tmp_path_factory.mktemp("sphere") / "run"
    case = SphereCase.make({"dtype": "float32"}, quick=True)
    return case, run_case("sphere", case, folder), folder


def named(metrics, start):
    """The metric whose name starts so."""
    (found,) = (m for m in metrics if m.name.startswith(start))
    return found


def test_the_first_drag_is_that_of_unsteady_stokes_flow(quick):
    """Within 5 % from where the mesh, of 22 nodes per diameter, sees the boundary layer."""
    _, report, _ = quick
    metric = named(report.metrics, "drag off the first law")
    assert metric.passed
    assert metric.value < 0.05


def test_the_routes_agree_and_what_symmetry_forbids_is_nothing(quick):
    case, report, _ = quick
    drag = case.drag(report.outcome)
    np.testing.assert_allclose(drag.impulse[1:], drag.momentum[1:], rtol=2e-3)
    assert named(report.metrics, "what symmetry about the axis forbids").passed
    assert named(report.metrics, "slip residual").passed


def test_a_run_leaves_a_figure_and_a_summary(quick):
    _, report, folder = quick
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "figure.png").stat().st_size > 50_000
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["case"] == "sphere"
    assert len(summary["metrics"]) == len(report.metrics)


def pretend(case: SphereCase, *, drag: float, lift: float, frequency: float) -> SimpleNamespace:
    """The series of a run that sheds from the start, with a side force of one sign."""
    dt = 0.05
    time = np.arange(0, case.until + dt / 2, dt)
    phase = 2 * math.pi * frequency * (time - dt / 2)
    forces = {
        "force_x": drag + 0.003 * np.cos(phase), "force_y": -lift + 0.016 * np.sin(phase),
        "force_z": 1e-6 * np.cos(phase),
    }  # fmt: skip
    series = {"time": time, "dt": np.full_like(time, dt), "slip": np.full_like(time, 1e-3)}
    series |= {"slip_residual": np.full_like(time, 9e-5), "divergence": np.full_like(time, 0.01)}
    for name, column in forces.items():
        series |= {f"body0_{name}": column / FORCE, f"impulse_{name}": 1.002 * column / FORCE}
    series |= {f"body0_torque_{axis}": 0 * time for axis in "xyz"}
    for name in series:
        if "force" in name or "torque" in name:
            series[name][0] = np.nan
    return SimpleNamespace(series=series)


def test_a_run_that_is_the_reference_passes():
    known, case = published(300), SphereCase(reynolds=300.0, until=60.0)
    numbers = {name: row.value for name, row in known.items()}
    told = pretend(case, drag=0.656, lift=0.069, frequency=numbers["strouhal"])
    metrics = [m for m in case.metrics(told) if not m.name.startswith("drag off the first law")]
    assert all(m.passed for m in metrics if m.passed is not None)
    found = {m.name: m.value for m in metrics}
    assert found["mean drag"] == pytest.approx(0.656, rel=1e-4)
    assert found["mean side force"] == pytest.approx(0.069, rel=1e-3)
    assert found["Strouhal number"] == pytest.approx(0.137, rel=1e-3)
    assert found["side force, amplitude"] == pytest.approx(0.016, rel=1e-2)
    assert found["mean drag, impulse and momentum apart"] == pytest.approx(0.002, rel=1e-6)


def test_the_wrong_drag_and_a_side_force_out_of_the_plane_fail():
    case = SphereCase(reynolds=300.0, until=60.0)
    told = pretend(case, drag=0.71, lift=0.069, frequency=0.137)
    told.series["body0_force_z"][500] = 0.01
    found = {m.name: m for m in case.metrics(told)}
    assert found["mean drag"].passed is False
    assert found["what symmetry on the plane z = 0 forbids, largest"].passed is False


def test_a_run_too_short_for_cycles_is_not_judged():
    case = SphereCase(reynolds=300.0, until=12.0)
    metrics = case.metrics(pretend(case, drag=0.9, lift=0.0, frequency=0.137))
    found = {m.name.partition(" (")[0]: m for m in metrics}
    assert found["mean drag"].passed is found["mean side force"].passed is None


def test_cycles_that_differ_leave_the_mean_drag_and_the_peak_of_the_spectrum():
    case = SphereCase(reynolds=300.0, until=60.0)
    run = pretend(case, drag=0.66, lift=0.07, frequency=0.13)
    time = run.series["time"]
    side = run.series["body0_force_y"] + 0.07 / FORCE
    run.series["body0_force_y"] = side * (1 + 0.3 * np.sin(0.2 * time)) - 0.07 / FORCE
    metrics = case.metrics(run)
    found = {m.name.partition(" (")[0]: m for m in metrics}
    assert found["mean side force"].passed is None
    assert found["mean drag"].passed is True
    assert found["Strouhal number"].kind == "report"
    assert found["Strouhal number"].value == pytest.approx(0.13, rel=0.05)


def test_the_eddy_that_starts_shedding_has_an_impulse_along_y_and_no_divergence():
    case = SphereCase(reynolds=300.0, kick=0.2)
    grid = Grid((72, 64, 64), 0.04, (-0.3, -1.26, -1.26))
    points = grid.points()
    eddy, cell = case.eddy(points), grid.cell_volume
    assert np.abs(eddy.sum(axis=(1, 2, 3))).max() * cell < 1e-9
    impulse = 0.5 * np.cross(points, eddy, axis=0).sum(axis=(1, 2, 3)) * cell
    np.testing.assert_allclose(impulse, [0, 0.2, 0], atol=1e-7)
    slopes = [np.gradient(eddy[k], 0.04, axis=k) for k in range(3)]
    assert np.abs(sum(slopes)[1:-1, 1:-1, 1:-1]).max() < 0.01 * np.abs(slopes).max()
    assert SphereCase(reynolds=100.0).impulse == 0


def test_the_recirculation_ends_where_the_velocity_turns():
    case, grid = SphereCase(), Grid((40, 8, 8), 0.1, (-1.0, -0.35, -0.35))
    x = grid.points()[0]
    state = SimpleNamespace(grid=grid)
    for velocity, length in ((x - 1.37, 0.87), (1 + 0 * x, math.nan)):
        flow = SimpleNamespace(velocity=lambda state, u=velocity: np.stack([u, u, u]))
        outcome = SimpleNamespace(flow=flow, state=state)
        assert case.recirculation(outcome) == pytest.approx(length, nan_ok=True)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reynolds": 19.0}, "reynolds must be between 20 and 400"),
        ({"reynolds": 401.0}, "reynolds must be between 20 and 400"),
        ({"nodes": 9}, "nodes must be at least 10"),
        ({"behind": 0.9}, "behind must be from 1 to 100"),
        ({"ahead": 2.0, "beside": 1.2, "fade": 0.7}, "beside must be from 1.3 to 100"),
        ({"ahead": math.nan}, "ahead must be"),
        ({"fade": 0.0}, "fade must be positive"),
        ({"kick": 3.0}, "kick must be at most 1"),
        ({"deformation": 0.0}, "deformation must be positive"),
        ({"dtype": "float16"}, "dtype must be one of"),
        ({"stretching": "none"}, "stretching must be one of"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        SphereCase.make(options)
    assert caught.value.hint


@pytest.mark.parametrize(("until", "times"), [(4.0, 1), (7.0, 2), (15.0, 3), (0.1, 1)])
def test_the_last_snapshot_is_at_the_end(until, times):
    (snapshots,) = (one for one in SphereCase(until=until).watchers() if hasattr(one, "every"))
    assert snapshots.every <= 5.0
    assert snapshots.every * times == pytest.approx(until, rel=1e-15)
