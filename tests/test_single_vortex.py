"""The reversed vortex: what comes back, what is exact on the way, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.contour import ContourSet

from levelset.laws import Deformation, SingleVortex
from levelset.shapes import Disk, Sphere
from pmesh.cases.deformation import (
    exact_level_set,
    exact_surface,
    interface_error,
    refined,
    topology,
    traced,
)
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import run_case
from pmesh.cases.single_vortex import SingleVortexCase
from pmesh.run.loop import run
from remesh.errors import InputError
from remesh.grid import Grid

HOME = Disk(0.15, center=(0.5, 0.75))


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cases") / "single-vortex"
    return run_case("single-vortex", SingleVortexCase.make({}, quick=True), folder), folder


def metric(report, name):
    (found,) = (m for m in report.metrics if m.name == name)
    return found


def test_the_body_is_drawn_without_steps(quick):
    figure = SingleVortexCase.make({}, quick=True).draw(quick[0].outcome)
    filled = [
        found
        for panel in figure.get_axes()
        for found in panel.collections
        if isinstance(found, ContourSet) and found.filled
    ]
    assert len(filled) == 5
    assert all(np.all(found.get_antialiased()) for found in filled)


def test_a_quick_run_passes_what_is_judged_and_leaves_its_picture(quick):
    report, folder = quick
    judged = [m for m in report.metrics if m.passed is not None]
    assert len(judged) >= 4
    assert all(m.passed and m.source for m in judged)
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert {"volume", "surface", "particles"} <= report.outcome.series.keys()


def test_the_error_falls_with_better_than_second_order_in_a_band_of_given_width(quick):
    assert metric(quick[0], "order of the interface error, 32 to 64 cells").value > 2.0


def test_the_step_follows_the_courant_number():
    flow, state = SingleVortexCase(nodes=64, courant=4.0).build()
    limit = flow.limit(state)
    assert (limit.dt, limit.rule) == (pytest.approx(4.0 / 64), "largest_step")
    flow, state = SingleVortexCase(nodes=64, courant=40.0).build()
    assert flow.limit(state).dt == pytest.approx(40.0 / 64)
    assert flow.substeps == 8  # dt max|grad u| = 3.9, at most 0.5 in each
    flow, state = SingleVortexCase(nodes=64, courant=40.0, substeps=1).build()
    assert flow.limit(state).rule == "deformation"


def test_at_a_courant_number_of_20_the_area_still_comes_back(tmp_path):
    case = SingleVortexCase.make(
        {"courant": 20.0, "period": 2.0, "until": 2.0, "coarse": False}, quick=True
    )
    report = run_case("single-vortex", case, tmp_path / "run")
    assert abs(metric(report, "area back at the start").error) < 0.005
    assert metric(report, "L1 interface error in cells").value < 0.1


def test_the_error_at_a_courant_number_of_40_is_within_twice_that_at_5():
    """dt max|grad u| = 2 instead of 0.25: four RK4 steps from one remeshing to the next."""
    errors = []
    for options in ({"courant": 5.0}, {"courant": 40.0}):
        case = SingleVortexCase(nodes=128, **options)
        flow, state = case.build()
        errors.append(case.error(flow, run(flow, state, until=8.0)))
    assert errors[1] < 2.0 * errors[0]


def test_a_run_that_ends_early_is_not_judged_by_the_start(tmp_path):
    case = SingleVortexCase.make({"until": 0.5, "every": 0.25}, quick=True)
    report = run_case("single-vortex", case, tmp_path / "run")
    assert [m.name for m in report.metrics] == ["area at t = 0"]


@pytest.mark.parametrize("ndim", [2, 3])
def test_traced_points_come_back_after_the_period(ndim):
    law = SingleVortex(period=2.0) if ndim == 2 else Deformation(period=2.0)
    points = np.random.default_rng(0).uniform(0.2, 0.8, (200, ndim))
    there = traced(points, law, 0.0, 1.0)
    assert np.abs(there - points).max() > 0.1
    assert np.abs(traced(there, law, 1.0, 2.0) - points).max() < 1e-6


def test_the_exact_length_is_that_of_the_reference():
    """6.450336 at half the period of 8: the project's table of references, exact."""
    assert exact_surface(SingleVortex(period=8.0), HOME, 4.0) == pytest.approx(6.450336, abs=2e-5)
    assert exact_surface(SingleVortex(period=8.0), HOME, 0.0) == pytest.approx(0.3 * math.pi)


def test_the_exact_level_set_is_the_distance_at_the_start_and_goes_with_the_flow():
    points = np.random.default_rng(1).uniform(0.2, 0.8, (100, 2))
    law = SingleVortex(period=8.0)
    np.testing.assert_allclose(
        exact_level_set(points, law, HOME, 0.0), HOME.distance(points.T), atol=1e-14
    )
    moved = traced(points, law, 0.0, 1.0)
    np.testing.assert_allclose(
        exact_level_set(moved, law, HOME, 1.0), HOME.distance(points.T), atol=1e-6
    )


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_the_interface_error_of_a_swollen_ball_is_how_much_it_swelled(ndim, dtype):
    grid = Grid((41,) * ndim, 1 / 40)
    shape = Disk(0.3, center=(0.5, 0.5)) if ndim == 2 else Sphere(0.3, center=(0.5,) * 3)
    ours = (shape.distance(grid.points()) - 0.4 / 40).astype(dtype)
    expected = ((0.31**ndim) - 0.3**ndim) / (ndim * 0.3 ** (ndim - 1))
    assert interface_error(ours, grid, shape) == pytest.approx(expected, rel=0.03)
    assert interface_error(shape.distance(grid.points()), grid, shape) < 0.02 / 40


def test_a_refined_level_set_keeps_the_nodes_and_lies_between_them():
    grid = Grid((41, 41), 1 / 40)
    shape = Disk(0.3, center=(0.5, 0.5))
    phi = np.clip(shape.distance(grid.points()), -0.1, 0.1)
    fine, finer = refined(phi, grid, 3)
    assert finer.shape == (121, 121)
    np.testing.assert_allclose(fine[::3, ::3], phi, atol=1e-12)
    near = np.abs(shape.distance(finer.points())) < 0.02
    np.testing.assert_allclose(fine[near], shape.distance(finer.points())[near], atol=1e-4)


def test_pieces_and_holes_of_known_bodies_are_counted():
    from levelset.shapes import Torus

    grid = Grid((41,) * 3, 1 / 40, (-0.5,) * 3)
    x = grid.points()
    ball = Sphere(0.12, center=(0.3, 0.3, 0.3)).distance(x)
    ring = Torus(0.25, 0.08).distance(x)
    assert topology(ball, grid) == (1, 0)
    assert topology(ring, grid) == (1, 1)
    assert topology(np.minimum(ring, ball), grid) == (2, 1)
    assert topology(np.ones(grid.shape), grid) == (0, 0)


def test_the_registry_leads_to_the_case():
    assert find("single-vortex") is SingleVortexCase
    assert CASES["single-vortex"].line


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"nodes": 8}, "nodes must be at least 16, got 8"),
        ({"radius": 0.3}, "radius must be at most 0.2"),
        ({"radius": 0.01}, "radius must be at least two cells"),
        ({"period": -1.0}, "period must be positive"),
        ({"courant": 0.0}, "courant must be positive"),
        ({"band": 0.01}, "band must be at least 2 cells"),
        ({"remeshing": 0}, "remeshing must be at least 1"),
        ({"substeps": -1}, "substeps must be at least 0"),
        ({"every": 0.0}, "every must be positive"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        SingleVortexCase(**options)
