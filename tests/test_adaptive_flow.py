"""Laws of motion by mean curvature on adaptive meshes."""

from dataclasses import replace

import numpy as np
import pytest

from levelset.adaptive_flow import AdaptiveCurvatureFlow
from levelset.curvature_flow import CurvatureFlow, extinction
from levelset.shapes import Disk, Sphere, Star
from pmesh.run.checkpoint import load, save
from pmesh.run.tree import same
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh


def mesh_of(ndim, cells, levels=2, tolerance=2e-3, boundary="unbounded", **settings):
    grid = Grid((cells,) * ndim, 1.0 / cells, (-0.5,) * ndim, boundary)
    return AdaptiveMesh(grid=grid, levels=levels, tolerance=tolerance, block=8, **settings)


def run(flow, state, until):
    states = [state]
    while states[-1].time < until:
        dt = min(flow.limit(states[-1]).dt, until - states[-1].time)
        states.append(flow.step(states[-1], dt))
    return states


def disk_star():
    return Star(0.24, amplitude=0.3, arms=5)  # two coarsest spacings from the ends


def test_a_curvature_flow_on_an_adaptive_mesh_is_the_adaptive_one():
    assert isinstance(CurvatureFlow(grid=mesh_of(2, 64)), AdaptiveCurvatureFlow)
    uniform = CurvatureFlow(grid=Grid((32, 32), 1 / 32))
    assert type(uniform) is CurvatureFlow


@pytest.mark.parametrize(("ndim", "cells"), [(2, 128), (3, 64)])
def test_a_ball_vanishes_within_a_percent_of_when_it_should(ndim, cells):
    radius = 0.3
    flow = CurvatureFlow(grid=mesh_of(ndim, cells))
    exact = radius**2 / (2 * (ndim - 1))
    states = run(flow, flow.start(Disk(radius) if ndim == 2 else Sphere(radius)), 0.9 * exact)
    volumes = [flow.ledger(state)["volume"] for state in states]
    times = [state.time for state in states]
    assert extinction(times, volumes, ndim) == pytest.approx(exact, rel=0.01)
    unit = np.pi if ndim == 2 else 4 / 3 * np.pi
    left = np.sqrt(radius**2 - 2 * (ndim - 1) * np.array(times))
    np.testing.assert_allclose(volumes, unit * left**ndim, atol=2e-3 * volumes[0])
    more = run(flow, states[-1], 1.2 * exact)
    lowest = [flow.ledger(state)["lowest"] for state in more]
    gone = np.interp(0.0, lowest, [state.time for state in more])
    assert gone == pytest.approx(exact, rel=0.01)
    assert flow.ledger(more[-1])["volume"] == 0.0


def test_every_simple_curve_loses_two_pi_of_area_per_time():  # Gage
    flow = CurvatureFlow(grid=mesh_of(2, 128), stretch=4.0)
    start = flow.start(disk_star())
    assert flow.ledger(start)["volume"] == pytest.approx(disk_star().area, rel=1e-4)
    for state in run(flow, start, 0.02)[1:]:
        lost = flow.ledger(start)["volume"] - flow.ledger(state)["volume"]
        assert lost == pytest.approx(2 * np.pi * state.time, rel=0.005, abs=4e-5)


def test_the_adaptive_level_set_is_the_uniform_one_with_fewer_nodes():
    mesh = mesh_of(2, 128)
    flow, until = CurvatureFlow(grid=mesh, stretch=4.0), 0.004
    end = run(flow, flow.start(disk_star()), until)[-1]
    uniform = CurvatureFlow(grid=mesh.grid, stretch=4.0)
    known = run(uniform, uniform.start(disk_star()), until)[-1]
    near = np.abs(known.phi) < 0.01
    found = flow.fields(end)["phi"]
    assert np.abs(found - known.phi)[near].max() < 0.02 * mesh.grid.spacing
    assert end.size < 0.45 * mesh.grid.size
    assert flow.ledger(end)["compression"] == mesh.grid.size / end.size


def test_a_smaller_tolerance_keeps_the_contour_closer():
    uniform, until = CurvatureFlow(grid=mesh_of(2, 128).grid, stretch=4.0), 0.004
    known = run(uniform, uniform.start(disk_star()), until)[-1].phi
    near = np.abs(known) < 0.01
    errors, sizes = [], []
    for tolerance in (1e-1, 1e-2, 1e-3):
        flow = CurvatureFlow(grid=mesh_of(2, 128, tolerance=tolerance), stretch=4.0)
        end = run(flow, flow.start(disk_star()), until)[-1]
        errors.append(np.abs(flow.fields(end)["phi"] - known)[near].max())
        sizes.append(end.size)
    assert errors[0] > errors[1] > errors[2]
    assert errors[0] > 3 * errors[2]
    assert sizes[0] < sizes[1] < sizes[2]


def test_the_mesh_follows_the_curve_and_is_coarse_once_it_is_round():
    flow = CurvatureFlow(grid=mesh_of(2, 128, levels=3, tolerance=2e-2))
    states = run(flow, flow.start(disk_star()), 0.012)
    assert states[0].finest == 3
    assert states[-1].finest < 3
    assert flow.limit(states[-1]).dt >= 4 * flow.limit(states[0]).dt
    for state in (states[0], states[len(states) // 2]):
        levels = flow.levels(state)
        finest = levels == state.finest
        phi = flow.fields(state)["phi"]
        assert np.abs(phi[finest]).max() < 16 * flow.mesh.grid.spacing
        assert finest.sum() == state.counts[state.finest] * 4 ** (3 - state.finest)


@pytest.mark.parametrize("shown", [0, 1, 2])
def test_levels_are_told_where_their_nodes_are_and_nowhere_else(shown):
    grid = Grid((128, 64), 1 / 64, (-1.0, -0.5))
    flow = CurvatureFlow(grid=AdaptiveMesh(grid=grid, levels=2, tolerance=1e-2, block=8))
    state = flow.start(Star(0.22, amplitude=0.4, arms=4, center=(0.4, 0.0)))
    told = flow.levels(state, shown)
    assert told.shape == flow.mesh.level_grid(shown).shape
    expected = np.zeros_like(told)
    for level, band in enumerate(flow.pyramid(state).bands):
        there = np.zeros(band.grid.shape, bool)
        there.reshape(-1)[band.nodes] = True
        part = 2 ** abs(shown - level)
        if level > shown:
            there = there.reshape(told.shape[0], part, told.shape[1], part).any(axis=(1, 3))
        else:
            there = np.kron(there, np.ones((part, part), bool))
        expected[there] = level
    assert expected.max() == 2
    np.testing.assert_array_equal(told, expected)


def test_order_in_time_is_two():
    flow = CurvatureFlow(grid=mesh_of(2, 64, levels=1, tolerance=1e-4))
    start = flow.start(Star(0.3, amplitude=0.1, arms=3))
    until, ends = 0.008, []
    for steps in (4, 8, 16, 128):
        state = start
        for _ in range(steps):
            state = flow.step(state, until / steps)
        ends.append(flow.ledger(state)["volume"])
    errors = np.abs(np.array(ends[:-1]) - ends[-1])
    assert np.log2(errors[0] / errors[2]) / 2 == pytest.approx(2.0, abs=0.5)


@pytest.mark.parametrize("boundary", ["periodic", ("periodic", "unbounded")])
def test_a_disk_across_a_seam_moves_as_one_in_the_middle(boundary):
    mesh = mesh_of(2, 64, boundary=boundary)
    flow = CurvatureFlow(grid=mesh)
    x, y = mesh.grid.points()
    radius = np.hypot(x, y)
    shift = 32 if boundary == "periodic" else 0
    ends = []
    for phi in (radius - 0.25, np.roll(radius - 0.25, (32, shift), (0, 1))):
        end = flow.step(flow.start(phi), 2e-3)
        ends.append(flow.ledger(end)["volume"])
    assert ends[0] == pytest.approx(np.pi * (0.25**2 - 2 * 2e-3), rel=1e-3)
    assert ends[1] == pytest.approx(ends[0], rel=1e-3)


@pytest.mark.parametrize("ndim", [2, 3])
def test_threads_do_not_change_a_bit_and_a_step_keeps_its_argument(ndim):
    shape = disk_star() if ndim == 2 else Sphere(0.2, center=(0.1, 0.0, 0.05))
    ends = []
    for threads in (1, 2):
        flow = CurvatureFlow(grid=mesh_of(ndim, 64), threads=threads)
        start = flow.start(shape)
        before = start.values.copy()
        ends.append(flow.step(start, flow.limit(start).dt))
        np.testing.assert_array_equal(start.values, before)
    assert same(*ends)


def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(tmp_path):
    flow = CurvatureFlow(grid=mesh_of(3, 64))
    state = flow.start(Sphere(0.2) | Sphere(0.15, center=(0.15, 0.0, 0.0)))
    for _ in range(2):
        state = flow.step(state, flow.limit(state).dt)
    save(tmp_path / "state.h5", state)
    again = load(tmp_path / "state.h5")
    assert same(again, state)
    for _ in range(2):
        state = flow.step(state, flow.limit(state).dt)
        again = flow.step(again, flow.limit(again).dt)
    assert same(again, state)


@pytest.mark.parametrize("ndim", [2, 3])
def test_single_precision_follows_double(ndim):
    flow = CurvatureFlow(grid=mesh_of(ndim, 64))
    shape = Disk(0.3) if ndim == 2 else Sphere(0.3)
    ends = [run(flow, flow.start(shape, dtype=name), 2e-3)[-1] for name in ("float32", "float64")]
    assert ends[0].values.dtype == np.float32
    volumes = [flow.ledger(end)["volume"] for end in ends]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-5)


def test_a_step_far_beyond_the_explicit_limit_makes_no_new_extremes():
    flow = CurvatureFlow(grid=mesh_of(2, 64))
    state = flow.start(disk_star())
    low, high = state.values.min(), state.values.max()
    for _ in range(5):
        state = flow.step(state, 3 * flow.limit(state).dt)
        assert low - 1e-3 <= state.values.min()
        assert state.values.max() <= high + 1e-3


def test_what_cannot_be_moved_is_refused():
    flow = CurvatureFlow(grid=mesh_of(2, 64))
    with pytest.raises(InputError, match="coarsest level"):
        flow.start(Disk(0.2, center=(9.0, 0.0)))
    with pytest.raises(InputError, match="must have shape"):
        flow.start(np.zeros((3, 3)))
    with pytest.raises(InputError, match="dt must be"):
        flow.step(flow.start(Disk(0.3)), -1.0)
    with pytest.raises(InputError, match="order 4"):
        CurvatureFlow(grid=mesh_of(2, 64, wavelet="2.2"))
    with pytest.raises(InputError, match="stretch must be positive"):
        CurvatureFlow(grid=mesh_of(2, 64), stretch=0.0)
    with pytest.raises(InputError, match="in bands, not in blocks, got most_blocks=400"):
        CurvatureFlow(grid=mesh_of(2, 64, most_blocks=400))


def test_a_surface_near_the_end_of_an_unbounded_axis_is_refused():
    with pytest.raises(InputError, match=r"within 2 spacings .* end of the box along axis 0"):
        CurvatureFlow(grid=mesh_of(2, 64)).start(Disk(0.45))
    CurvatureFlow(grid=mesh_of(2, 64)).start(Disk(0.3))
    hole = -Disk(0.3).distance(mesh_of(2, 64).grid.points())
    CurvatureFlow(grid=mesh_of(2, 64)).start(hole)
    CurvatureFlow(grid=mesh_of(2, 64, boundary="periodic")).start(Disk(0.45))


def test_a_state_of_another_kind_or_mesh_is_refused():
    adaptive = CurvatureFlow(grid=mesh_of(2, 64))
    uniform = CurvatureFlow(grid=mesh_of(2, 64).grid)
    state, told = adaptive.start(Disk(0.3)), uniform.start(Disk(0.3))
    other = CurvatureFlow(grid=mesh_of(2, 64, levels=1))
    finer = CurvatureFlow(grid=mesh_of(2, 128).grid)
    for flow, given, words in (
        (adaptive, told, "of kind AdaptiveCurvatureState, got CurvatureState"),
        (uniform, state, "of kind CurvatureState, got AdaptiveCurvatureState"),
        (other, state, "differs from the flow's in levels"),
        (finer, told, "differs from the flow's in shape, spacing"),
    ):
        for ask in (flow.limit, flow.ledger, lambda given, flow=flow: flow.step(given, 1e-4)):
            with pytest.raises(InputError, match=words):
                ask(given)


def test_the_adaptive_recipe_refuses_a_uniform_grid_and_levels_that_the_mesh_has_not():
    flow = CurvatureFlow(grid=mesh_of(2, 64))
    with pytest.raises(InputError, match=r"needs an AdaptiveMesh, got Grid\("):
        replace(flow, grid=Grid((64, 64), 1 / 64))
    state = flow.start(Disk(0.3))
    for level in (-1, 9):
        for ask in (flow.to_uniform, flow.levels):
            with pytest.raises(InputError, match="level must be a whole number"):
                ask(state, level)
