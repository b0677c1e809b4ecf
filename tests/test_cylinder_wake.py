"""The long cylinder runs: numbers of made-up records, and short runs of their own."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.cylinder_wake import CylinderWake, centre_line, published
from pmesh.cases.reference import read_table
from pmesh.cases.runner import run_case
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """Re = 40 for ten diameters of travel, on a coarse mesh."""
    folder = tmp_path_factory.mktemp("wake") / "run"
    case = CylinderWake.make({"nodes": 12}, quick=True)
    return case, run_case("cylinder-wake", case, folder), folder


@pytest.fixture(scope="module")
def street(tmp_path_factory):
    """Re = 100 at 12 nodes per diameter, in a window of 6 behind: its lift over time."""
    folder = tmp_path_factory.mktemp("street") / "run"
    case = CylinderWake(
        nodes=12, behind=6.0, ahead=2.0, beside=3.0, until=44.0, every=44.0, kick=0.5
    )
    return case, run_case("cylinder-wake", case, folder)


def named(metrics, start):
    """The metric whose name starts so."""
    (found,) = (m for m in metrics if m.name.startswith(start))
    return found


def test_a_street_leaves_a_short_window_and_sheds_at_the_published_frequency(street):
    """Within 4 %; the drag within 5 %; the eddies that left are not felt."""
    case, report = street
    routes = case.routes(report.outcome)
    time, lift = routes.time, routes.of_main("lift")
    up = np.flatnonzero((lift[:-1] < 0) & (lift[1:] >= 0) & (time[1:] > 24))
    turns = time[up] - lift[up] * np.diff(time)[up] / np.diff(lift)[up]
    known = published(100)
    assert len(turns) >= 2
    assert 1 / np.diff(turns)[-1] == pytest.approx(known["strouhal"].value, rel=0.04)
    last = (time > turns[-2]) & (time < turns[-1])
    drag = np.average(routes.of_main("drag")[last], weights=routes.dt[last])
    assert drag == pytest.approx(known["drag"].value, rel=0.05)
    assert 0.5 * np.ptp(lift[last]) == pytest.approx(known["lift"].value, rel=0.15)
    assert abs(np.average(lift[last], weights=routes.dt[last])) < 0.03


def test_the_routes_agree_while_eddies_leave(street):
    """Momentum of the constraint, impulse of the vorticity, and a box of fluid: within 1 %."""
    case, report = street
    routes = case.routes(report.outcome)
    late = routes.time > 30
    for route in ("impulse", "control volume"):
        for component in ("drag", "lift"):
            main, other = routes.of_main(component)[late], routes.curves[route, component][late]
            assert np.abs(other - main).max() < 0.01, (route, component)


def test_the_window_holds_the_mesh(street):
    """To the 16 nodes by which a mesh grows; eddies leave, and what they take is counted."""
    case, report = street
    grid = report.outcome.state.grid
    more = 17 * grid.spacing
    assert grid.origin[0] >= -case.ahead - more
    assert grid.origin[0] + grid.length[0] <= case.behind + more
    assert abs(grid.origin[1]) <= case.beside + more
    series = report.outcome.series
    assert np.abs(series["lost_circulation"]).max() > 0.1
    assert named(report.metrics, "circulation, kept").passed


def test_a_steady_wake_is_symmetric_and_grows_behind(quick):
    case, report, _ = quick
    assert not case.sheds
    assert case.impulse == 0
    assert np.abs(report.outcome.series["body0_force_y"][1:]).max() < 1e-3, "no lift"
    length = named(report.metrics, "recirculation length")
    assert 1.5 < length.value < 2.31
    assert length.reference == 2.31
    assert length.passed is None, "not judged before it is steady"
    assert named(report.metrics, "drag, impulse").value < 2e-3
    assert named(report.metrics, "drag's change").value < 0


def test_a_run_leaves_a_figure_and_a_summary(quick):
    _, report, folder = quick
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "figure.png").stat().st_size > 50_000
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["case"] == "cylinder-wake"
    assert len(summary["metrics"]) == len(report.metrics)


def pretend(case: CylinderWake, frequency: float, amplitude: float) -> SimpleNamespace:
    """The series of a run that sheds from the start; one route is 1 % larger, one asked seldom."""
    dt = 0.05
    time = np.arange(0, case.until + dt / 2, dt)
    phase = 2 * math.pi * frequency * (time - dt / 2)
    lift = 0.5 * amplitude * np.sin(phase)
    drag = 0.5 * (1.364 + 0.01 * np.cos(2 * phase))
    seldom = np.where(np.arange(time.size) % 4 == 0, 1.0, np.nan)
    series = {"time": time, "dt": np.full_like(time, dt), "slip": np.full_like(time, 1e-3)}
    series["slip_residual"] = np.full_like(time, 9e-6)
    series["circulation"] = np.full_like(time, 0.3)
    series["lost_circulation"] = np.full_like(time, -0.3)
    for stem, factor in (("body0", 1.0), ("impulse", 1.01), ("body0_flux", 0.99 * seldom)):
        series |= {f"{stem}_force_x": factor * drag, f"{stem}_force_y": factor * lift}
    for name in series:
        if "force" in name:
            series[name][0] = np.nan
    return SimpleNamespace(series=series)


@pytest.mark.parametrize("reynolds", [100.0, 200.0])
def test_a_run_that_is_the_reference_passes(reynolds):
    known = published(reynolds)
    case = CylinderWake(reynolds=reynolds, until=100.0)
    amplitude = known["lift"].value if "lift" in known else 0.6
    metrics = case.metrics(pretend(case, known["strouhal"].value, amplitude))
    assert all(m.passed for m in metrics if m.passed is not None)
    found = {m.name: m for m in metrics}
    assert found["Strouhal number"].value == pytest.approx(known["strouhal"].value, rel=1e-3)
    assert found["lift amplitude"].value == pytest.approx(amplitude, rel=2e-3)
    assert found["mean drag"].value == pytest.approx(1.364, rel=1e-3)
    assert found["mean drag, impulse and momentum apart"].value == pytest.approx(0.01, rel=0.02)
    assert found["lift amplitude, control volume and momentum apart"].value == pytest.approx(
        0.01, rel=0.1
    )
    assert not any("traction" in name for name in found), "a route that was not asked"


def test_a_run_too_short_for_cycles_is_not_judged():
    case = CylinderWake(until=10.0)
    metrics = case.metrics(pretend(case, 0.16, 0.3))
    assert named(metrics, "mean drag (").passed is None
    assert "cycles" in named(metrics, "mean drag (").name


def test_the_wrong_frequency_or_amplitude_fails():
    case = CylinderWake(until=100.0)
    metrics = {m.name: m for m in case.metrics(pretend(case, 0.15, 0.4))}
    assert metrics["Strouhal number"].passed is False
    assert metrics["lift amplitude"].passed is False
    assert metrics["mean drag"].passed is True


def test_every_published_number_has_its_grade_and_source():
    for row in read_table("cylinder_wake.csv"):
        assert row["grade"] in "ABC"
        assert row["source"]
        assert 0 < float(row["tolerance"]) <= 0.06
    assert published(100)["strouhal"].grade == "B"
    assert published(47) == {}


def test_the_centre_line_is_exact_for_cubics():
    grid = Grid((6, 8), 0.25, (0.0, -0.9))
    x, y = grid.points()
    field = np.stack([x + 3.0 - 2 * y + y**2 + 4 * y**3, x])
    places, values = centre_line(field, grid)
    np.testing.assert_allclose(places, grid.axes()[0])
    np.testing.assert_allclose(values, places + 3.0, atol=1e-12)


def test_the_recirculation_ends_where_the_velocity_turns():
    case = CylinderWake()
    grid = Grid((80, 8), 0.1, (-1.0, -0.35))
    x, _ = grid.points()
    turned = SimpleNamespace(
        flow=SimpleNamespace(velocity=lambda state: np.stack([x - 2.81, x])),
        state=SimpleNamespace(grid=grid),
    )
    assert case.recirculation(turned) == pytest.approx(2.31)
    forward = SimpleNamespace(
        flow=SimpleNamespace(velocity=lambda state: np.ones((2, *grid.shape))), state=turned.state
    )
    assert math.isnan(case.recirculation(forward))


def test_the_eddy_that_starts_shedding_has_an_impulse_and_no_circulation():
    case = CylinderWake(nodes=16, kick=0.2)
    grid = Grid((200, 160), 0.02, (-0.8, -1.59))
    x, y = grid.points()
    eddy, cell = case.eddy(grid.points()), grid.cell_volume
    assert float(eddy.sum()) * cell == pytest.approx(0, abs=1e-12)
    assert -float((x * eddy).sum()) * cell == pytest.approx(0.2, rel=1e-6)
    assert float((y * eddy).sum()) * cell == pytest.approx(0, abs=1e-12)
    flow, state = case.build()
    assert abs(float(state.vorticity.sum()) * state.grid.cell_volume) < 1e-9
    assert flow.window.upper[0] == case.behind


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reynolds": 19.0}, "reynolds must be between 20 and 400"),
        ({"reynolds": 401.0}, "reynolds must be between 20 and 400"),
        ({"nodes": 11}, "nodes must be at least 12"),
        ({"behind": 1.5}, "behind must be from 2 to 200"),
        ({"beside": 3.0, "ahead": 4.0, "fade": 2.5}, "beside must be from 3.5 to 200"),
        ({"ahead": math.nan}, "ahead must be"),
        ({"fade": 0.0}, "fade must be positive"),
        ({"kick": 3.0}, "kick must be at most 2"),
        ({"deformation": 0.0}, "deformation must be positive"),
        ({"every": 0.0}, "every must be positive"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        CylinderWake(**options)
    assert caught.value.hint
