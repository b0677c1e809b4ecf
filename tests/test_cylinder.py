"""The cylinder case: its drag at a size that fits, its parameters, metrics and figure."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pmesh.cases.cylinder import Cylinder, Drag
from pmesh.cases.reference import cylinder_drag, cylinder_reynolds
from pmesh.cases.runner import run_case
from pmesh.cases.short_time_drag import linear_drag, short_time_drag
from remesh.errors import InputError


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Re = 550 to T = 3 at half the default resolution: its case, report and directory."""
    folder = tmp_path_factory.mktemp("cylinder") / "run"
    case = Cylinder(nodes=48, until=3.0, deformation=0.5, every=0.5)
    return case, run_case("cylinder", case, folder), folder


def value(report, start):
    """The metric whose name starts so."""
    (found,) = (m for m in report.metrics if m.name.startswith(start))
    return found


def test_the_drag_follows_koumoutsakos_and_leonard(short):
    """Within 6 % at 48 nodes per diameter; the case's own size is within 4 %."""
    case, report, _ = short
    assert value(report, "drag off published").value < 0.06
    drag, curve = case.drag(report.outcome), cylinder_drag(550)
    for time in (0.5, 1.0, 2.0, 2.5):
        assert np.interp(time, drag.time, drag.momentum) == pytest.approx(
            float(curve.at(np.array([time]))[0]), rel=0.06
        )


def test_the_drag_has_its_minimum_where_it_is_published(short):
    _, report, _ = short
    assert value(report, "smallest drag").value == pytest.approx(0.703, rel=0.05)
    assert value(report, "at T (a flat minimum").value == pytest.approx(0.79, abs=0.15)


def test_the_early_drag_follows_the_short_time_law(short):
    _, report, _ = short
    found = value(report, "drag off the short-time law")
    assert found.value < 0.05
    assert found.grade == "A/B"


def test_both_force_routes_agree_and_the_slip_is_what_was_asked(short):
    case, report, _ = short
    assert value(report, "drag routes apart").value < 1e-4
    assert value(report, "slip residual").value <= case.tolerance
    assert value(report, "slip, rms").value < 0.01
    series = report.outcome.series
    assert np.abs(series["body0_force_y"][1:]).max() < 1e-3, "no lift"
    assert np.abs(series["circulation"] + series["lost_circulation"]).max() < 1e-10


def test_the_run_leaves_a_figure_and_a_summary(short):
    _, report, folder = short
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "figure.png").stat().st_size > 50_000
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["case"] == "cylinder"
    assert len(summary["metrics"]) == len(report.metrics)
    assert summary["cost"]["steps"] > 50


@pytest.mark.parametrize(
    ("reynolds", "until", "wanted"),
    [
        (550, 6.0, {"drag off published", "smallest drag", "largest drag", "drag off the short"}),
        (3000, 6.0, {"drag off published", "drag off the short"}),
        (40, 5.0, {"drag off published", "drag off the short"}),
        (100, 1.0, {"drag off the short"}),
        (550, 0.2, {"drag off the short"}),
    ],
)
def test_what_is_known_at_a_reynolds_number_is_judged(reynolds, until, wanted):
    """A made-up run whose drag is the reference itself: all its metrics pass."""
    case = Cylinder(reynolds=reynolds, until=until)
    metrics = case.metrics(pretend(case))
    names = {m.name for m in metrics}
    found = {start for start in wanted if any(name.startswith(start) for name in names)}
    assert found == wanted
    judged = [m for m in metrics if m.passed is not None]
    assert all(m.passed for m in judged), [m for m in judged if not m.passed]
    assert all(m.source for m in judged if "off" in m.name)
    for word in ("off published", "smallest", "largest drag"):
        assert any(word in name for name in names) == any(word in name for name in wanted)


def pretend(case: Cylinder) -> SimpleNamespace:
    """The series of a run that meets the references: the law, then the published curve."""
    dt = 0.01
    time = np.arange(0, case.until + dt / 2, dt)
    middle = time[1:] - dt / 2
    drag = case.short_time_mean(Drag(middle, np.full_like(middle, dt), middle, middle))
    if case.reynolds in cylinder_reynolds():
        curve = cylinder_drag(case.reynolds)
        late = middle > 0.25
        drag[late] = curve.at(np.minimum(middle[late], curve.span[1]))
    drag = np.concatenate([[math.nan], drag])
    series = {
        "time": time, "dt": np.full_like(time, dt), "body0_force_x": drag,
        "impulse_force_x": 1.001 * drag, "slip_residual": np.full_like(time, 5e-7),
        "slip": np.full_like(time, 1e-3),
    }  # fmt: skip
    return SimpleNamespace(series=series)


def test_the_mean_of_the_law_over_a_step_is_its_integral():
    """Of the singular first step too: int_0^dt of 1/sqrt(T) is finite."""
    case = Cylinder(reynolds=550)
    edges = np.array([0.0, 0.01, 0.05, 0.2])
    middle, dt = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    found = case.short_time_mean(Drag(middle, dt, middle, middle))
    for mean, first, last in zip(found, edges[:-1], edges[1:], strict=True):
        root = np.linspace(math.sqrt(first), math.sqrt(last), 401)
        root = 0.5 * (root[1:] + root[:-1])
        exact = np.mean(short_time_drag(550, root**2) * 2 * root) / (
            math.sqrt(last) + math.sqrt(first)
        )
        assert mean == pytest.approx(exact, rel=1e-3)


def test_the_short_time_law_is_the_linear_one_where_inertia_is_not_known():
    time = np.array([0.1])
    assert Cylinder(reynolds=40).short_time(time) == linear_drag(40, time)
    assert Cylinder(reynolds=550).short_time(time) == short_time_drag(550, time)


@pytest.mark.parametrize(
    ("reynolds", "nodes"), [(20, 96), (100, 96), (550, 112), (3000, 272), (9500, 480)]
)
def test_the_spacing_follows_the_reynolds_number(reynolds, nodes):
    """At least 96 nodes per diameter, and about 5 sqrt(Re): five in a length sqrt(nu D/U)."""
    case = Cylinder(reynolds=reynolds)
    assert 2 / case.spacing == pytest.approx(nodes)
    assert nodes == 96 or abs(nodes - 5 * math.sqrt(reynolds)) <= 8
    assert Cylinder(reynolds=reynolds, nodes=32).spacing == 2 / 32
    assert case.viscosity == 2 / reynolds


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"reynolds": 19.9}, "reynolds must be between 20 and 9500, got 19.9"),
        ({"reynolds": 9501.0}, "reynolds must be between 20 and 9500"),
        ({"nodes": 15}, "nodes must be at least 16 per diameter, got 15"),
        ({"deformation": 0.0}, "deformation must be positive"),
        ({"strength": -1.0}, "strength must be positive"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"width": math.nan}, "width must be"),
        ({"every": 0.0}, "every must be positive"),
        ({"until": 0.0}, "until must be a positive time"),
    ],
)
def test_parameters_outside_the_case_are_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        Cylinder(**options)
    assert caught.value.hint


def test_an_unknown_kernel_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match="unknown kernel"):
        run_case("cylinder", Cylinder.make({"kernel": "M5'"}, quick=True), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_the_cylinder_lies_in_the_middle_of_four_nodes():
    flow, state = Cylinder(nodes=32).build()
    (x, y), h = state.grid.axes(), 2 / 32
    assert np.abs(x).min() == pytest.approx(h / 2)
    assert np.abs(y).min() == pytest.approx(h / 2)
    np.testing.assert_allclose(state.vorticity, -state.vorticity[:, ::-1], atol=1e-6)
    assert flow.limit(state).rule == "deformation"
