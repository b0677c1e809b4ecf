"""Laws of motion by mean curvature."""

import numpy as np
import pytest

from levelset.curvature_flow import CurvatureFlow, curvature_step, extinction, normal_bend
from levelset.profile import profile
from levelset.shapes import Box, Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid


def box(ndim, cells, half=1.5, boundary="unbounded"):
    """A mesh of so many cells per unit length with a node in its middle."""
    n = round(half * cells)
    count = 2 * n + (boundary == "unbounded")
    return Grid((count,) * ndim, 1 / cells, (-n / cells,) * ndim, boundary)


def shrunk(grid, until, stretch, phi):
    flow = CurvatureFlow(grid=grid, stretch=stretch)
    state = flow.start(phi)
    steps = round(until / flow.limit(state).dt)
    for _ in range(steps):
        state = flow.step(state, until / steps)
    return state


@pytest.mark.parametrize(("ndim", "cells"), [(2, 16), (2, 32), (3, 16), (3, 32)])
def test_a_ball_vanishes_when_it_should_at_ten_times_the_explicit_step(ndim, cells):
    grid = Grid((3 * cells // 2 + 1,) * ndim, 1 / cells)  # a quarter, an eighth: edges are mirrors
    flow = CurvatureFlow(grid=grid)
    states = [flow.start(Disk(1.0) if ndim == 2 else Sphere(1.0))]
    while states[-1].phi.min() < 0:
        states.append(flow.step(states[-1], flow.limit(states[-1]).dt))
    exact = 1 / (2 * (ndim - 1))
    last, gone = (flow.ledger(state)["lowest"] for state in states[-2:])
    vanished = states[-1].time - gone * (states[-1].time - states[-2].time) / (gone - last)
    assert vanished == pytest.approx(exact, rel=0.005)
    unit = np.pi if ndim == 2 else 4 / 3 * np.pi
    seen = [s for s in states if s.time < exact * (1 - (4 / cells) ** 2)][-2:]
    time = [s.time for s in seen]
    volumes = [2**ndim * flow.ledger(s)["volume"] for s in seen]
    assert extinction(time, volumes, ndim) == pytest.approx(exact, rel=0.005)
    radius = np.sqrt(1 - 2 * (ndim - 1) * np.array(time))
    np.testing.assert_allclose(volumes, unit * radius**ndim, rtol=0.05)


def test_circles_of_a_paraboloid_shrink_exactly():
    grid = box(2, 16)
    x, y = grid.points()
    phi = x * x + y * y - 1
    inner = slice(12, -12)  # the mirrors bend phi at the edges
    found = curvature_step(phi, grid, 0.005)
    np.testing.assert_allclose(found[inner, inner], (phi + 0.01)[inner, inner], atol=1e-4)


def test_order_in_time_is_two():
    grid = Grid((32, 65), 1 / 32, (0.0, -1.0), ("periodic", "unbounded"))
    x, y = grid.points()
    phi = y - 0.15 * np.cos(2 * np.pi * x)  # its level surfaces are one curve, shifted
    until, ends = 0.02, []
    for steps in (16, 32, 64, 512):
        found = phi
        for _ in range(steps):
            found = curvature_step(found, grid, until / steps)
        ends.append(found[np.abs(y) < 0.25])
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def test_the_error_at_ten_explicit_steps_falls_faster_than_h_squared():
    errors = []
    for cells in (16, 32):
        state = shrunk(box(2, cells), 0.25, 10.0, Disk(1.0).distance(box(2, cells).points()))
        area = CurvatureFlow(grid=state.grid).ledger(state)["volume"]
        errors.append(abs(area - 0.5 * np.pi))
    assert np.log2(errors[0] / errors[1]) > 2.0


def test_an_ellipse_loses_two_pi_of_area_per_time():
    # Gage: every simple closed curve does
    grid = box(2, 32)
    x, y = grid.points()
    phi = np.hypot(x / 1.2, y / 0.7) - 1
    flow = CurvatureFlow(grid=grid)
    before = flow.ledger(flow.start(phi))["volume"]
    after = flow.ledger(shrunk(grid, 0.1, 10.0, phi))["volume"]
    assert before - after == pytest.approx(0.2 * np.pi, rel=2e-3)


def test_a_grim_reaper_moves_without_change_of_shape():
    # y = -log cos x + t: phi of one sign off the curve; its speed is one
    grid = Grid((97, 161), np.pi / 96 * 0.8, (-0.4 * np.pi, -1.0))
    x, y = grid.points()
    phi = y + np.log(np.cos(x))
    found = phi
    for _ in range(20):
        found = curvature_step(found, grid, 0.002)
    inside = (np.abs(x) < 0.4) & (np.abs(y) < 0.3)
    np.testing.assert_allclose(found[inside], phi[inside] - 0.04, atol=2e-4)


def test_the_motion_belongs_to_the_surface_not_to_phi():
    grid = box(2, 24)
    radius = np.sqrt((grid.points() ** 2).sum(axis=0))
    areas = []
    for phi in (radius - 1, 5 * (radius - 1), np.exp(radius) - np.e):
        state = shrunk(grid, 0.2, 10.0, phi)
        areas.append(CurvatureFlow(grid=grid).ledger(state)["volume"])
    np.testing.assert_allclose(areas, np.pi * 0.6, rtol=2e-3)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_phi_whose_slope_dies_moves_as_its_distance_does(ndim):
    # what particles carry: the slope falls to zero six spacings off
    grid = box(ndim, 16)
    h, radius = grid.spacing, np.sqrt((grid.points() ** 2).sum(axis=0))
    until = 0.25 / (ndim - 1)  # half the area of a disk
    ends = [
        CurvatureFlow(grid=grid).ledger(shrunk(grid, until, 10.0, phi))["volume"]
        for phi in (profile(radius - 1, 6 * h), radius - 1, np.clip(radius - 1, -2 * h, 2 * h))
    ]
    np.testing.assert_allclose(ends, ends[1], rtol=1e-3)


def test_a_hole_closes_as_a_disk_does():
    grid = box(2, 24)
    phi = Disk(1.0).distance(grid.points())
    step = curvature_step(phi, grid, 0.01)
    np.testing.assert_allclose(curvature_step(-phi, grid, 0.01), -step, atol=1e-14)


def test_a_periodic_stripe_stays_and_mirrors_hold_a_quarter_of_a_disk():
    grid = Grid((32, 20), 1 / 32, boundary="periodic")
    x, _ = grid.points()
    wave = np.cos(2 * np.pi * x)
    kept = curvature_step(wave, grid, 10 / 4 / 32**2)
    np.testing.assert_allclose(kept, wave, atol=2e-3)  # straight lines do not move
    whole, quarter = box(2, 16), Grid((25, 25), 1 / 16)
    full = curvature_step(Disk(1.0).distance(whole.points()), whole, 0.01)
    part = curvature_step(Disk(1.0).distance(quarter.points()), quarter, 0.01)
    np.testing.assert_allclose(part, full[24:, 24:], atol=1e-13)


def test_a_hundred_explicit_steps_at_once_make_no_new_extremes():
    grid = box(3, 8, half=1.0)
    phi = Box((1.0, 0.7, 0.9)).distance(grid.points())
    found = phi
    for _ in range(20):
        found = curvature_step(found, grid, 100 * grid.spacing**2 / 6)
        assert phi.min() <= found.min()
        assert found.max() <= phi.max()


@pytest.mark.parametrize("boundary", ["unbounded", "periodic", ("periodic", "unbounded")])
def test_the_normal_part_of_a_plane_wave_is_its_whole_laplacian(boundary):
    grid = Grid((32, 33), 1 / 32, boundary=boundary)
    x, y = grid.points()
    for phase, wraps in ((x, grid.periodic[0]), (y, grid.periodic[1])):
        length = grid.shape[0 if phase is x else 1] / 32 if wraps else 1.0
        wave = np.cos(2 * np.pi * phase / length)
        steep = np.abs(wave) < 0.7
        found = normal_bend(wave, grid)
        expected = -((2 * np.pi / length) ** 2) * wave
        np.testing.assert_allclose(found[steep], expected[steep], atol=2e-2)


def test_a_symmetric_surface_stays_symmetric_to_round_off():
    grid = Grid((65, 33, 33), 1 / 32, (-1.0, -0.5, -0.5))
    ends = Sphere(0.3, center=(0.5, 0.0, 0.0)) | Sphere(0.3, center=(-0.5, 0.0, 0.0))
    state = CurvatureFlow(grid=grid).start(ends | Box((1.0, 0.2, 0.2)))
    flow = CurvatureFlow(grid=grid)
    for _ in range(8):
        state = flow.step(state, flow.limit(state).dt)
    for axis in range(3):
        apart = np.abs(state.phi - np.flip(state.phi, axis)).max()
        assert apart <= 1e-13 * np.abs(state.phi).max()


@pytest.mark.parametrize("ndim", [2, 3])
def test_single_precision_follows_double(ndim):
    grid = box(ndim, 8)
    phi = Disk(1.0).distance(grid.points()) if ndim == 2 else Sphere(1.0).distance(grid.points())
    single = curvature_step(phi.astype(np.float32), grid, 0.01)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, curvature_step(phi, grid, 0.01), atol=2e-6)


def test_threads_do_not_change_a_bit_and_a_step_keeps_its_argument():
    grid = box(3, 8)
    phi = Sphere(1.0).distance(grid.points())
    before = phi.copy()
    one = curvature_step(phi, grid, 0.01, threads=1)
    np.testing.assert_array_equal(one, curvature_step(phi, grid, 0.01, threads=2))
    np.testing.assert_array_equal(phi, before)


def test_starts_that_hold_no_surface_are_refused():
    grid = box(2, 8)
    flow = CurvatureFlow(grid=grid)
    with pytest.raises(InputError, match="does not pass through the grid"):
        flow.start(Disk(0.3, center=(9.0, 0.0)))
    with pytest.raises(InputError, match="finite"):
        flow.start(np.full(grid.shape, np.nan))
    with pytest.raises(InputError, match="must have shape"):
        flow.start(np.zeros((3, 3)))
    with pytest.raises(InputError, match="a shape or numbers"):
        flow.start("a")
    with pytest.raises(InputError, match="dtype must be"):
        flow.start(Disk(1.0), dtype="a")
    with pytest.raises(InputError, match="stretch must be positive"):
        CurvatureFlow(grid=grid, stretch=0.0)
    with pytest.raises(InputError, match="stretch must be a number"):
        CurvatureFlow(grid=grid, stretch="a")
    with pytest.raises(InputError, match="grid must be a Grid"):
        CurvatureFlow(grid=None)
    with pytest.raises(InputError, match="volumes that fall"):
        extinction([0.0, 1.0], [1.0, 1.0], 2)


@pytest.mark.parametrize("dt", [0.0, -0.1, np.nan, np.inf, "a"])
def test_steps_that_are_no_time_are_refused(dt):
    flow = CurvatureFlow(grid=box(2, 8))
    with pytest.raises(InputError, match="dt must be"):
        flow.step(flow.start(Disk(1.0)), dt)
