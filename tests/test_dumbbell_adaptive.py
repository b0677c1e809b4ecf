"""The case of the dumbbell on an adaptive mesh."""

import numpy as np
import pytest

from pmesh.cases.dumbbell_adaptive import DumbbellAdaptive, asymmetry, particles
from pmesh.cases.runner import run_case
from pmesh.run.checkpoint import load
from pmesh.run.tree import same
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A short run past the pinch."""
    folder = tmp_path_factory.mktemp("dumbbell")
    case = DumbbellAdaptive.make({"until": 0.007}, quick=True)
    return case, run_case("dumbbell-adaptive", case, folder), folder


def test_a_short_run_pinches_off_at_the_right_time(short):
    case, report, folder = short
    metrics = {metric.name: metric for metric in report.metrics}
    assert all(metric.passed is not False for metric in report.metrics)
    assert metrics["pinch-off time"].error < 0.01
    assert metrics["pieces after the pinch"].value == 2
    series = report.outcome.series
    assert (np.diff(series["volume"]) < 0).all()
    assert (np.diff(series["area"]) < 0).all()
    active = sum(series[f"level_{level}"] for level in range(case.levels + 1))
    np.testing.assert_array_equal(active, series["active"])
    assert (folder / "figure.png").stat().st_size > 20000
    titles = [panel.get_title("left") for panel in case.draw(report.outcome).get_axes()]
    letters = "abcdefghijk"[: len(titles)]
    assert len(titles) > 6
    assert sorted(title[:3] for title in titles) == [f"({k})" for k in letters]


def test_the_finest_level_is_at_the_neck_and_the_bells_are_coarse(short):
    case, report, _ = short
    before = min(report.outcome.snapshots(), key=lambda shot: abs(shot.time - 0.004))
    points, levels = particles(before["level"], before.grid, case.levels)
    finest = points[levels == case.levels]
    assert len(finest)
    far = np.abs(finest[:, 0]) > 0.5 * case.separation  # beyond the bells' middle
    assert far.mean() < 0.02
    assert np.hypot(*finest.T).min() < case.bar


def test_a_resumed_run_is_the_unbroken_one(short, tmp_path):
    case, _, folder = short
    part = DumbbellAdaptive.make({"until": 0.004}, quick=True)
    run_case("dumbbell-adaptive", part, tmp_path)
    from pmesh.run.loop import run

    flow, state = case.build()
    end = run(flow, state, until=0.007, watch=case.watchers(), out=tmp_path, resume=True)
    assert same(end, load(folder / "checkpoint.h5", like=end))


def test_particles_in_the_middle_plane_are_those_of_their_levels():
    field = np.zeros((8, 8, 8))
    field[:4, :, :] = 1  # of nodes at level 1 of 0..2, two spacings apart at level 0
    field[:2, :2, :] = 2
    points, levels = particles(field, Grid((8, 8, 8), 0.5), 2)
    assert np.bincount(levels).tolist() == [8, 28, 16]
    assert len(np.unique(points, axis=0)) == len(points)
    fine = points[levels == 2]
    np.testing.assert_allclose(np.unique(fine), [0.0, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(np.unique(points[levels == 0][:, 0]), [2.0, 3.0])


def test_asymmetry_is_seen_near_the_surface_only():
    x = np.arange(-4, 4)  # one node more on the negative side
    phi = np.abs(x[:, None]) + 0.0 * x[None, :] - 2.0
    assert asymmetry(phi, 1.5) == 0.0
    phi[7, 3] += 5.0
    assert asymmetry(phi, 0.5) == 0.0
    phi[6, 4] += 0.25
    assert asymmetry(phi, 0.5) == pytest.approx(0.25)


def test_what_is_no_mesh_is_refused():
    for wrong in ({"levels": 0}, {"levels": 9}, {"tolerance": 0.5}, {"tolerance": 0.0},
                  {"bar": 0.4}, {"every": 0.0}):  # fmt: skip
        with pytest.raises(InputError):
            DumbbellAdaptive(**wrong)
