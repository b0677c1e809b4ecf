"""The cases without bodies: what each must show, at sizes that fit, and how it is measured."""

from __future__ import annotations

import csv
import json
import tomllib

import numpy as np
import pytest

from pmesh.cases.elliptic_vortex import EllipticVortexCase
from pmesh.cases.lamb_oseen import LambOseenCase
from pmesh.cases.moments import aspect_ratio, relative_error, vortex_moments
from pmesh.cases.perlman import PerlmanCase
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.cases.taylor_green import TaylorGreenCase
from pmesh.run.snapshots import read_snapshots
from remesh.errors import InputError
from remesh.grid import Grid

FREE = {
    "taylor-green": TaylorGreenCase,
    "lamb-oseen": LambOseenCase,
    "perlman": PerlmanCase,
    "elliptic-vortex": EllipticVortexCase,
}


@pytest.fixture(scope="module", params=FREE)
def quick(request, tmp_path_factory):
    """A quick run of each case: its name, its report, its directory."""
    folder = tmp_path_factory.mktemp("cases") / request.param
    case = FREE[request.param].make({}, quick=True)
    return request.param, run_case(request.param, case, folder), folder


def metric(report, name):
    """The metric with this name."""
    (found,) = (m for m in report.metrics if m.name == name)
    return found


def test_every_judged_metric_of_a_quick_run_passes(quick):
    _, report, _ = quick
    assert any(m.passed for m in report.metrics)
    assert [m for m in report.metrics if m.passed is False] == []


def test_every_judged_metric_names_its_source(quick):
    _, report, _ = quick
    assert all(m.source for m in report.metrics if m.passed is not None)


def test_a_run_leaves_the_files_of_the_contract(quick):
    name, _, folder = quick
    assert tomllib.loads((folder / "case.toml").read_text())["case"] == name
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["case"] == name
    assert all(m["pass"] is not False for m in summary["metrics"])
    with (folder / "series.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert {"time", "dt", "rule", "circulation"} <= rows[0].keys()
    assert (folder / "checkpoint.h5").stat().st_size > 0
    assert len(read_snapshots(folder)) >= 2, "the start and the end"
    assert (folder / "fields.vtkhdf").stat().st_size > 0
    picture = (folder / "figure.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 50_000


def test_lamb_oseen_is_within_half_a_percent(tmp_path):
    """Core growth 4 nu, circulation and angular moment, at the default spacing."""
    case = LambOseenCase(until=2.0, every=1.0)
    report = run_case("lamb-oseen", case, tmp_path / "run")
    assert metric(report, "core growth d(a^2)/dt").reference == pytest.approx(4e-3)
    for name in ("core growth d(a^2)/dt", "circulation", "angular moment"):
        assert abs(metric(report, name).error) < 0.005


def test_the_elliptic_vortex_keeps_circulation_and_second_moments_to_t_6(tmp_path):
    case = EllipticVortexCase(spacing=1 / 40)
    report = run_case("elliptic-vortex", case, tmp_path / "run")
    assert metric(report, "drift of circulation").value <= 1e-6
    assert metric(report, "drift of second moments' sum").value <= 1e-3
    series = report.outcome.series
    ratio = aspect_ratio(series["moment_xx"], series["moment_yy"], series["moment_xy"])
    assert ratio[0] == pytest.approx(2.0, rel=1e-4)
    assert ratio[-1] < 1.4


def test_viscosity_spreads_the_elliptic_vortex_at_4_nu_gamma(tmp_path):
    case = EllipticVortexCase(spacing=1 / 32, until=1.0, viscosity=1e-3, kind="II")
    report = run_case("elliptic-vortex", case, tmp_path / "run")
    series = report.outcome.series
    rate = (series["angular_moment"][-1] - series["angular_moment"][0]) / 1.0
    assert rate == pytest.approx(4 * 1e-3 * 13.4041287, rel=0.02)


def test_perlmans_velocity_is_within_one_in_a_thousand_at_one_64th():
    case = PerlmanCase()
    assert case.spacing == 1 / 64
    velocity, vorticity = case.errors(case.build()[1])
    assert velocity < 1e-3
    assert vorticity == 0.0


def test_the_order_after_advection_is_what_the_kernel_keeps(tmp_path):
    """M6' keeps moments 0-4: order 4 when dt follows h, from the two finest of three spacings."""
    report = run_case("perlman", PerlmanCase.make({}, quick=True), tmp_path / "run")
    assert metric(report, "order of the velocity at the end").value == pytest.approx(4.0, abs=0.2)


def test_taylor_green_rates_do_not_depend_on_the_free_stream(tmp_path):
    rates = []
    for drift in ((0.0, 0.0), (0.7, -0.4)):
        case = TaylorGreenCase(nodes=48, until=0.2, drift=drift)
        report = run_case("taylor-green", case, tmp_path / f"run{drift[0]}")
        rates.append(metric(report, "decay rate 2 nu k^2").value)
    assert rates == pytest.approx([8 * np.pi**2 / 100] * 2, rel=0.01)


@pytest.mark.parametrize("name", FREE)
def test_the_registry_leads_to_the_case(name):
    assert find(name) is FREE[name]
    assert CASES[name].line


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: TaylorGreenCase(reynolds=-1.0), "reynolds must be positive, got -1.0"),
        (lambda: TaylorGreenCase(nodes=4), "nodes must be at least 16, got 4"),
        (lambda: LambOseenCase(viscosity=0.0), "viscosity must be positive"),
        (lambda: LambOseenCase(circulation=0.0), "circulation must be not zero"),
        (lambda: LambOseenCase(spacing=0.1), "spacing must be at most a quarter of the core"),
        (lambda: PerlmanCase(spacing=0.5), "spacing must be at most 1/8 of the radius"),
        (lambda: PerlmanCase(p=0), "p must be positive"),
        (lambda: EllipticVortexCase(viscosity=-1e-3), "viscosity must be not negative"),
        (lambda: EllipticVortexCase(kind="III"), "kind must be one of I, II"),
        (lambda: EllipticVortexCase(every=0.0), "every must be positive"),
    ],
)
def test_options_out_of_range_are_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_moments_of_a_turned_gaussian_are_known(dtype):
    """w = exp(-X^2/(2 s^2) - Y^2/(2 t^2)): Gamma = 2 pi s t, ratio s/t."""
    grid = Grid((161, 161), 0.05, (-4.0, -4.0))
    x, y = grid.points()
    cos, sin = np.cos(0.6), np.sin(0.6)
    along, across = cos * x + sin * y, cos * y - sin * x
    w = np.exp(-(along**2) / (2 * 0.6**2) - across**2 / (2 * 0.3**2)).astype(dtype)
    found = vortex_moments(w, grid)
    digits = 1e-6 if dtype == np.float32 else 1e-10
    gamma = 2 * np.pi * 0.6 * 0.3
    spread = found["moment_xx"] + found["moment_yy"]
    assert spread == pytest.approx(gamma * (0.6**2 + 0.3**2), rel=digits)
    assert found["largest"] == pytest.approx(1.0, rel=1e-6)
    assert found["moment_xy"] == pytest.approx(gamma * cos * sin * (0.6**2 - 0.3**2), rel=digits)
    ratio = aspect_ratio(found["moment_xx"], found["moment_yy"], found["moment_xy"])
    assert ratio == pytest.approx(2.0, rel=10 * digits)


def test_the_relative_error_is_scale_free():
    field = np.random.default_rng(0).normal(size=(2, 30, 20))
    assert relative_error(1.01 * field, field) == pytest.approx(0.01, rel=1e-10)
    assert relative_error(field, field) == 0.0


def test_drawing_leaves_the_users_matplotlib_settings_alone():
    import matplotlib

    from pmesh.cases.style import LETTERS, panels, styled

    before = dict(matplotlib.rcParams)

    @styled
    def draw():
        assert matplotlib.rcParams["axes.linewidth"] == LETTERS["axes.linewidth"]
        return panels(1, 2, (4, 2))

    figure, axes = draw()
    assert axes.shape == (1, 2)
    assert tuple(figure.get_size_inches()) == (4, 2)
    assert dict(matplotlib.rcParams) == before
