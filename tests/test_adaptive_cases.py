"""The elliptical vortex and the cylinder on adaptive meshes: their meshes, judgements, pictures."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.cases.cylinder_adaptive import BOX, NODES, CylinderAdaptive
from pmesh.cases.elliptic_vortex_adaptive import EllipticVortexAdaptive
from pmesh.cases.runner import run_case
from pmesh.run.checkpoint import load
from pmesh.run.loop import run
from pmesh.run.tree import same
from remesh.errors import InputError


@pytest.fixture(scope="module")
def vortex(tmp_path_factory):
    """The quick run of the elliptical vortex to t = 0.6."""
    folder = tmp_path_factory.mktemp("elliptic") / "run"
    case = EllipticVortexAdaptive.make({"until": 0.5, "every": 0.25}, quick=True)
    return case, run_case("elliptic-vortex-adaptive", case, folder), folder


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory):
    """The quick run of the cylinder."""
    folder = tmp_path_factory.mktemp("cylinder") / "run"
    case = CylinderAdaptive.make({"until": 0.54, "every": 0.18}, quick=True)
    return case, run_case("cylinder-adaptive", case, folder), folder


@pytest.mark.parametrize(("name", "count"), [("vortex", 4), ("cylinder", 4)])
def test_what_is_judged_passes_and_the_picture_is_drawn(name, count, request):
    case, report, folder = request.getfixturevalue(name)
    judged = [m for m in report.metrics if m.passed is not None]
    assert [m.name for m in judged if not m.passed] == []
    assert len(judged) == count
    assert (folder / "figure.png").stat().st_size > 50_000
    figure = case.draw(report.outcome)
    assert "1/" in figure._suptitle.get_text() or "Re" in figure._suptitle.get_text()


@pytest.mark.parametrize("name", ["vortex", "cylinder"])
def test_series_tell_what_the_mesh_holds(name, request):
    case, report, _ = request.getfixturevalue(name)
    series, mesh = report.outcome.series, case.mesh()
    np.testing.assert_allclose(series["compression"] * series["active"], mesh.grid.size)
    assert series["finest_level"].max() == mesh.levels
    assert (series["blocks"] >= 4).all()
    largest = next(m for m in report.metrics if m.name == "active nodes, largest")
    assert largest.value == series["active"].max()


@pytest.mark.parametrize("name", ["vortex", "cylinder"])
def test_snapshots_hold_the_blocks(name, request):
    _, report, _ = request.getfixturevalue(name)
    shots = report.outcome.snapshots()
    active = np.interp([shot.time for shot in shots], *(report.outcome.series[c] for c in
                       ("time", "active")))  # fmt: skip
    for shot, nodes in zip(shots[1:], active[1:], strict=True):
        assert shot.blocks.active == nodes
        assert shot.on_blocks("vorticity").shape == shot.blocks.shape


def test_the_vortex_keeps_its_moments_to_the_tolerance_and_loses_its_aspect(vortex):
    case, report, _ = vortex
    values = {m.name: m.value for m in report.metrics}
    assert values["drift of circulation"] < 0.1 * case.tolerance
    assert values["aspect ratio at t = 0"] == pytest.approx(2.0, abs=1e-6)
    assert 1.3 < values["aspect ratio at the end"] < 1.9
    assert report.outcome.series["largest"].max() < 20 * (1 + 2 * case.tolerance)


def test_the_drag_is_within_two_percent_of_what_is_published(cylinder):
    _, report, _ = cylinder
    values = {m.name: m.value for m in report.metrics}
    off = next(value for name, value in values.items() if name.startswith("drag off published"))
    assert off < 0.02


def test_a_resumed_case_is_the_unbroken_one(tmp_path):
    case = CylinderAdaptive.make({"every": 0.03}, quick=True)  # a step ends where one run does
    flow, state = case.build()
    run(flow, state, until=0.03, watch=case.watchers(), out=tmp_path / "b")
    whole = run(flow, state, until=0.06, watch=case.watchers(), out=tmp_path / "a")
    end = run(flow, state, until=0.06, watch=case.watchers(), out=tmp_path / "b", resume=True)
    assert same(end, whole)
    assert same(load(tmp_path / "b/checkpoint.h5", like=end), whole)
    read = [(tmp_path / name / "series.csv").read_text() for name in "ab"]
    assert read[0] == read[1]


@pytest.mark.parametrize("reynolds", [550.0, 3000.0, 9500.0])
def test_the_cylinders_mesh_has_the_published_resolution_in_a_box_of_16_by_8_radii(reynolds):
    case = CylinderAdaptive(reynolds=reynolds)
    mesh = case.mesh()
    assert 2.0 / mesh.grid.spacing == pytest.approx(NODES[reynolds])
    for axis, (low, high) in enumerate(BOX):
        first, last = mesh.grid.axes()[axis][[0, -1]]
        assert first < low + mesh.grid.spacing
        assert last > high - mesh.grid.spacing
        node = -mesh.grid.origin[axis] / mesh.grid.spacing
        assert node % 1 == pytest.approx(0.5)  # the centre lies between nodes
    assert mesh.spacing(0) <= 0.3
    assert mesh.tolerance == case.mesh_tolerance


def test_other_reynolds_numbers_get_nodes_that_follow_the_boundary_layer():
    finer = [2 / CylinderAdaptive(reynolds=re).spacing for re in (100.0, 1000.0, 4000.0)]
    assert finer == sorted(finer)
    assert finer[2] / finer[1] == pytest.approx(2, rel=0.1)


def test_the_vortex_box_is_whole_blocks_on_all_levels_and_grows_with_viscosity():
    inviscid, thick = (EllipticVortexAdaptive(viscosity=nu).mesh() for nu in (0.0, 0.01))
    for mesh in (inviscid, thick):
        assert all(n % (mesh.block * 2**mesh.levels) == 0 for n in mesh.grid.shape)
        assert mesh.grid.length[0] >= 2.8
    assert thick.grid.length[0] >= 2.8 + 8 * math.sqrt(0.01 * 6.0)


@pytest.mark.parametrize(
    ("case", "options"),
    [
        (EllipticVortexAdaptive, {"tolerance": 2.0}),
        (EllipticVortexAdaptive, {"levels": 0}),
        (EllipticVortexAdaptive, {"block": 8}),
        (EllipticVortexAdaptive, {"block": 12}),
        (EllipticVortexAdaptive, {"spacing": 0.2}),
        (CylinderAdaptive, {"mesh_tolerance": 0.0}),
        (CylinderAdaptive, {"levels": 0}),
        (CylinderAdaptive, {"nodes": 2}),
    ],
)
def test_parameters_outside_the_cases_are_refused_with_advice(case, options):
    with pytest.raises(InputError) as caught:
        case(**options)
    assert caught.value.hint
