"""Interfaces carried by particles: exact where they can be, conserving where they cannot."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pmesh
from levelset.interface import Interface
from levelset.laws import Deformation, Rotation, Shear, SingleVortex, Uniform
from levelset.lookup import places
from levelset.profile import profile
from levelset.quadrature import area, centroid, volume
from levelset.shapes import Box, Capsule, Disk, SlottedDisk, SlottedSphere, Sphere, Torus
from levelset.transport import ParticleLevelSet
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.limit import Limit

DISK = SlottedDisk(15.0, 5.0, 25.0, center=(50.0, 75.0))
BOX = Grid((101, 101), 1.0)
TURN = Rotation(center=(50.0, 50.0), rate=2 * math.pi / 628)
UNIT = Grid((65, 65), 1 / 64)
CIRCLE = Disk(0.15, center=(0.5, 0.75))


def carried(flow: ParticleLevelSet, state: Interface, until: float, steps: int) -> Interface:
    dt = (until - state.time) / steps
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def swirled(cells: int, **settings: Any) -> tuple[ParticleLevelSet, Interface, Interface]:
    """The single vortex of period 2 at the start and back there."""
    grid = Grid((cells + 1,) * 2, 1 / cells)
    flow = ParticleLevelSet(grid=grid, velocity=SingleVortex(period=2.0), **settings)
    start = flow.start(CIRCLE)
    return flow, start, carried(flow, start, 2.0, cells)


def mean_error(flow: ParticleLevelSet, state: Interface, shape: Any) -> float:
    """Mean distance [L] between the contour and an exact one, by its particles near it."""
    band = flow.distance(state)
    at = places(flow.grid, band.nodes)
    near = np.abs(band.values) < flow.grid.spacing
    return float(np.abs(band.values - shape.distance(at.T))[near].mean())


def test_zalesaks_disk_of_800_particles_is_exact_after_ten_turns():
    """No remeshing: what is left is the error of RK4, dt^4; its turn of 628 steps leaves 1e-7."""
    flow = ParticleLevelSet(grid=BOX, velocity=TURN, width=2.8, remeshing="never")
    start = flow.start(DISK)
    assert 700 < start.size < 850
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    points = np.stack([50 + 15 * np.sin(angles), 75 + 15 * np.cos(angles)], axis=1)
    before = flow.rebuild(start, points)
    state = start
    for turns, steps in ((1, 628), (10, 9 * 628)):
        state = carried(flow, state, 628.0 * turns, steps)
        assert np.abs(state.positions - start.positions).max() < 1e-6
        # the slope of a distance is 1: this is how far the interface is from where it began
        assert np.nanmax(np.abs(flow.rebuild(state, points) - before)) < 1e-6
    assert state.remeshings == 0


def test_zalesaks_sphere_is_exact_after_a_turn_about_any_axis():
    grid = Grid((51, 51, 51), 2.0)
    axis = np.array([0.4, -0.5, math.sqrt(1 - 0.41)]) * 2 * math.pi / 100
    law = Rotation(center=(50.0, 50.0, 50.0), rate=tuple(axis))
    flow = ParticleLevelSet(grid=grid, velocity=law, width=2.8, remeshing="never")
    start = flow.start(SlottedSphere(15.0, 8.0, 12.5, center=(50.0, 55.0, 60.0)))
    end = carried(flow, start, 100.0, 400)
    assert np.abs(end.positions - start.positions).max() < 1e-6


def test_the_rebuilt_shape_turns_with_its_particles():
    flow = ParticleLevelSet(grid=BOX, velocity=TURN, width=2.8, remeshing="never")
    start = flow.start(DISK)
    eighth = carried(flow, start, 78.5, 80)
    rng = np.random.default_rng(5)
    points = start.positions[rng.integers(0, start.size, 300)] + 0.3
    turned = TURN.flow(points, 0.0, 78.5)
    np.testing.assert_allclose(flow.rebuild(eighth, turned), flow.rebuild(start, points), atol=2e-6)


@pytest.mark.parametrize(("kernel", "bound"), [("M4'", 0.12), ("M6'", 0.05), ("L4,4", 0.05)])
def test_zalesaks_disk_remeshed_at_each_step_keeps_its_area_and_its_slot(kernel, bound):
    flow = ParticleLevelSet(grid=BOX, velocity=TURN, kernel=kernel)
    end = carried(flow, flow.start(DISK), 628.0, 63)
    assert end.remeshings == 63
    band = flow.band(end)
    assert volume(band.values, BOX, nodes=band.nodes) == pytest.approx(582.2070306, rel=0.01)
    assert mean_error(flow, end, DISK) < bound


def test_rigid_motion_never_asks_for_remeshing_and_shear_does():
    settings: dict[str, Any] = {"grid": BOX, "remeshing": "distorted", "distortion": 0.3}
    turning = ParticleLevelSet(velocity=TURN, **settings)
    assert carried(turning, turning.start(DISK), 628.0, 63).remeshings == 0
    shape = Disk(10.0, center=(50.0, 50.0))
    shearing = ParticleLevelSet(
        velocity=Shear(rate=0.1, center=(50.0, 50.0)), kernel="L6,4", **settings
    )
    end = carried(shearing, shearing.start(shape), 20.0, 40)
    assert end.remeshings == 3  # after each shear by 2 sinh(0.3) = 0.61 of the 2.0
    assert shearing.ledger(end)["volume"] == pytest.approx(100 * math.pi, rel=2e-3)


def test_a_number_of_steps_between_remeshings_is_kept():
    flow = ParticleLevelSet(grid=UNIT, velocity=Uniform(velocity=(0.1, 0.0)), remeshing=3)
    state = flow.start(CIRCLE)
    ages = []
    for _ in range(7):
        state = flow.step(state, 0.01)
        ages.append(state.age)
    assert ages == [1, 2, 0, 1, 2, 0, 1]
    assert state.remeshings == 2


@pytest.mark.parametrize("kernel", ["M4'", "M6'", "L6,4"])
def test_the_error_of_an_unsteady_deformation_falls_faster_than_the_second_power(kernel):
    errors = [
        mean_error(flow, end, CIRCLE)
        for cells in (64, 128)
        for flow, _, end in [swirled(cells, kernel=kernel, width=cells / 8)]
    ]
    assert math.log2(errors[0] / errors[1]) > 1.8


@pytest.mark.parametrize(("scheme", "order"), [("RK2", 2), ("RK3", 3), ("RK4", 4)])
def test_particles_go_with_the_order_of_their_scheme(scheme, order):
    flow = ParticleLevelSet(
        grid=UNIT, velocity=SingleVortex(period=8.0), time_scheme=scheme, remeshing="never"
    )
    start = flow.start(CIRCLE)
    fine = carried(flow, start, 0.5, 200).positions
    errors = [np.abs(carried(flow, start, 0.5, n).positions - fine).max() for n in (10, 20)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


def test_substeps_are_steps_of_the_scheme():
    law = SingleVortex(period=8.0)
    one = ParticleLevelSet(grid=UNIT, velocity=law, remeshing="never")
    four = replace(one, substeps=4)
    start = one.start(CIRCLE)
    np.testing.assert_array_equal(
        carried(four, start, 0.2, 1).positions, carried(one, start, 0.2, 4).positions
    )
    assert four.limit(start).dt == pytest.approx(4 * one.limit(start).dt)


def test_the_flow_turns_anticlockwise_where_its_law_does():
    """Handedness: a disk right of the centre of an anticlockwise rotation goes up."""
    law = Rotation(center=(0.5, 0.5), rate=1.0)
    flow = ParticleLevelSet(grid=UNIT, velocity=law)
    end = carried(flow, flow.start(Disk(0.1, center=(0.75, 0.5))), 0.4, 10)
    band = flow.band(end)
    where = centroid(band.values, UNIT, nodes=band.nodes)
    exact = 0.5 + 0.25 * np.array([math.cos(0.4), math.sin(0.4)])
    np.testing.assert_allclose(where, exact, atol=1e-4)


def pieces(flow: ParticleLevelSet, state: Interface) -> int:
    from scipy.ndimage import label

    return int(label(flow.fields(state)["level_set"] < 0)[1])


def test_two_drops_that_are_pressed_together_become_one_without_special_care():
    def press(time: float, at: np.ndarray) -> np.ndarray:
        along = -0.3 * np.tanh((at[:, 0] - middle) / 0.02)
        return np.stack([along, np.zeros(len(at))], axis=1)

    middle = 0.5 + 0.5 / 64  # between nodes: what stays between the drops is thinner than a cell
    drops = Disk(0.12, center=(0.3, 0.5)) | Disk(0.12, center=(0.7, 0.5))
    flow = ParticleLevelSet(grid=UNIT, velocity=press)
    start = flow.start(drops)
    assert pieces(flow, start) == 2
    assert pieces(flow, carried(flow, start, 0.5, 50)) == 1


def test_a_thread_that_is_drawn_thinner_than_the_mesh_breaks():
    def pinch(time: float, at: np.ndarray) -> np.ndarray:
        x, y = at[:, 0] - 0.5, at[:, 1] - middle
        return np.stack([np.zeros(len(at)), -8.0 * y * np.exp(-((x / 0.06) ** 2))], axis=1)

    middle = 0.5 + 0.5 / 64
    flow = ParticleLevelSet(grid=UNIT, velocity=pinch)
    start = flow.start(Capsule((0.3, middle), (0.7, middle), 0.08))
    assert pieces(flow, start) == 1
    assert pieces(flow, carried(flow, start, 0.6, 30)) == 2


def test_particles_follow_the_interface_and_their_number_its_length():
    flow, start, end = swirled(64)
    turning = carried(flow, start, 1.0, 64)
    lengths = [area(b.values, flow.grid, nodes=b.nodes) for b in map(flow.band, (start, turning))]
    assert turning.size / start.size == pytest.approx(lengths[1] / lengths[0], rel=0.35)
    assert end.size < 1.4 * start.size
    near = np.abs(CIRCLE.distance(start.positions.T))
    assert near.max() < 9 / 64


def test_it_runs_in_three_dimensions_and_comes_back():
    grid = Grid((41, 41, 41), 1 / 40)
    flow = ParticleLevelSet(grid=grid, velocity=Deformation(period=0.8), kernel="L6,4")
    start = flow.start(Sphere(0.15, center=(0.35, 0.35, 0.35)))
    exact = 4 / 3 * math.pi * 0.15**3
    assert flow.ledger(start)["volume"] == pytest.approx(exact, rel=1e-3)
    end = carried(flow, start, 0.8, 32)
    assert flow.ledger(end)["volume"] == pytest.approx(exact, rel=0.01)
    assert mean_error(flow, end, Sphere(0.15, center=(0.35, 0.35, 0.35))) < 0.1 * grid.spacing


def test_a_plane_flow_in_three_dimensions_is_that_of_two():
    """A capsule along a periodic axis, its section a disk."""

    def twist(time: float, at: np.ndarray) -> np.ndarray:
        flat = SingleVortex(period=8.0)(time, np.ascontiguousarray(at[:, :2]))
        return np.concatenate([flat, np.zeros((len(at), at.shape[1] - 2))], axis=1)

    space = Grid((33, 33, 8), 1 / 32, boundary=("unbounded", "unbounded", "periodic"))
    plane = Grid((33, 33), 1 / 32)
    tube = CIRCLE.distance(plane.points())
    deep = ParticleLevelSet(grid=space, velocity=twist, width=5.0)
    flat = ParticleLevelSet(grid=plane, velocity=twist, width=5.0)
    solid = carried(deep, deep.start(np.repeat(tube[..., None], 8, axis=2)), 0.5, 10)
    disk = carried(flat, flat.start(tube), 0.5, 10)
    found = deep.fields(solid)["level_set"]
    np.testing.assert_allclose(found[..., 3], flat.fields(disk)["level_set"], atol=2e-3 / 32)
    np.testing.assert_allclose(found[..., 0], found[..., 5], atol=1e-12)


def test_redistancing_now_and_then_keeps_the_slope_at_one():
    settings: dict[str, Any] = {"grid": UNIT, "velocity": SingleVortex(period=math.inf)}
    slopes = []
    for every in (None, 4):
        flow = ParticleLevelSet(redistancing=every, **settings)
        end = carried(flow, flow.start(CIRCLE), 0.6, 24)
        band = flow.band(end)
        field = band.filled(0.0)
        rise = np.hypot(*np.gradient(field, UNIT.spacing)).ravel()[band.nodes]
        slopes.append(rise[np.abs(band.values) < 0.5 * UNIT.spacing])
    far = [np.quantile(np.abs(slope - 1), 0.9) for slope in slopes]
    assert far[0] > 0.4
    assert far[1] < 0.1


def test_a_level_set_of_any_slope_starts_as_the_shape_does():
    x, y = UNIT.points()
    steep = CIRCLE.distance(UNIT.points()) * (3.0 + 2.0 * np.sin(8 * x) * y)
    flow = ParticleLevelSet(grid=UNIT, velocity=TURN)
    one, other = flow.start(steep), flow.start(CIRCLE)
    field, exact = (flow.fields(state)["level_set"] for state in (one, other))
    assert np.abs(field - exact).max() < 0.02 * UNIT.spacing


def test_the_step_follows_the_velocity_gradient_known_or_measured():
    law = SingleVortex(period=8.0)
    known = ParticleLevelSet(grid=UNIT, velocity=law)
    assert known.limit(known.start(CIRCLE)).dt == pytest.approx(0.25 / (2 * math.pi))
    measured = ParticleLevelSet(grid=UNIT, velocity=lambda time, at: law(time, at))
    start = measured.start(CIRCLE)
    x, y = start.positions.T
    parts = [  # du/dx = -dv/dy, du/dy and dv/dx where the particles are
        np.pi * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y),
        2 * np.pi * np.sin(np.pi * x) ** 2 * np.cos(2 * np.pi * y),
        2 * np.pi * np.sin(np.pi * y) ** 2 * np.cos(2 * np.pi * x),
    ]
    along, *across = np.abs(parts)
    exact = max((along + part).max() for part in across)
    assert start.gradient == pytest.approx(exact, rel=0.02)
    assert measured.limit(start).rule == "deformation"
    still = ParticleLevelSet(grid=UNIT, velocity=Uniform(velocity=(1.0, 0.0)))
    assert still.limit(still.start(CIRCLE)).dt == math.inf


def test_the_same_bits_for_any_number_of_threads():
    ends = [swirled(48, threads=threads)[2] for threads in (1, 3)]
    np.testing.assert_array_equal(ends[0].values, ends[1].values)
    np.testing.assert_array_equal(ends[0].nodes, ends[1].nodes)


def test_a_run_that_is_resumed_repeats_an_unbroken_one(tmp_path: Path):
    flow = ParticleLevelSet(grid=UNIT, velocity=SingleVortex(period=8.0), remeshing="distorted")
    start = flow.start(CIRCLE)
    ends = {}
    for name, stops in (("whole", [0.5]), ("parts", [0.25, 0.5])):
        for stop in stops:
            ends[name] = pmesh.run(
                flow, start, until=stop, dt=1 / 32, out=tmp_path / name, resume=stop != stops[0],
                watch=[pmesh.Ledger(), pmesh.Snapshots(every=0.125)],
            )  # fmt: skip
    np.testing.assert_array_equal(ends["whole"].positions, ends["parts"].positions)
    series = [(tmp_path / name / "series.csv").read_text() for name in ("whole", "parts")]
    assert series[0] == series[1]


def test_a_state_is_a_value_that_a_step_leaves_alone():
    flow = ParticleLevelSet(grid=UNIT, velocity=SingleVortex(period=8.0))
    start = flow.start(CIRCLE)
    kept = (start.nodes.copy(), start.positions.copy(), start.values.copy())
    flow.step(start, 0.05)
    for now, then in zip((start.nodes, start.positions, start.values), kept, strict=True):
        np.testing.assert_array_equal(now, then)


def test_it_is_a_shape_that_a_body_can_have():
    flow = ParticleLevelSet(grid=UNIT, velocity=TURN)
    shape = flow.shape(flow.start(CIRCLE))
    points = np.random.default_rng(1).uniform(0.3, 0.9, (2, 200))
    near = np.abs(CIRCLE.distance(points)) < 3 / 64
    np.testing.assert_allclose(
        shape.distance(points)[near], CIRCLE.distance(points)[near], atol=1e-5
    )
    assert pmesh.RigidBody(shape).measure.volume == pytest.approx(math.pi * 0.15**2, rel=1e-4)
    middle = np.array([[0.5], [0.75]])  # deeper than the band is wide
    assert shape.distance(middle)[0] == pytest.approx(-0.15, abs=1e-3)


SETTINGS: dict[str, Any] = {"grid": UNIT, "velocity": SingleVortex(period=8.0)}


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (
            {"velocity": 3.0},
            r"velocity must be a law u\(time, positions\) of 2 dimensions, got 3.0",
        ),
        ({"kernel": "M5"}, "kernel"),
        ({"time_scheme": "Euler"}, "time_scheme must be one of RK2, RK3, RK4"),
        ({"width": -1.0}, "width must be positive, got -1.0"),
        ({"width": 2.0}, "width must be at least 3 spacings, what the kernel reads, got 2.0"),
        ({"velocity": Deformation()}, r"of 2 dimensions, got Deformation"),
        ({"remeshing": "often"}, "remeshing must be one of"),
        ({"remeshing": 0}, "remeshing must be one of"),
        ({"substeps": 0}, "substeps must be a whole number >= 1, got 0"),
        ({"redistancing": 2.5}, "redistancing must be a whole number >= 1"),
        ({"deformation": math.nan}, "deformation must be positive"),
        ({"largest_step": 0.0}, "largest_step must be positive, got 0.0"),
        ({"grid": None}, "grid must be a Grid, got None"),
    ],
)
def test_settings_that_make_no_sense_are_refused(change, match):
    with pytest.raises(InputError, match=match):
        ParticleLevelSet(**{**SETTINGS, **change})


@pytest.mark.parametrize(
    ("shape", "match"),
    [
        (Disk(0.1, center=(3.0, 3.0)), "no node lies inside the shape: the interface is empty"),
        (Disk(0.001, center=(0.503, 0.503)), "the interface is empty"),
        (Disk(0.002, center=(0.5, 0.5)), "the shape is 0.26 spacings thick"),
        (
            Disk(0.2, center=(0.1, 0.5)),
            "the shape comes within 2 spacings .* of the end of the box along axis 0",
        ),
        (Box((0.5, 3.0), center=(0.5, 0.5)), "of the end of the box along axis 1"),
        (Sphere(0.2), "the shape has 3 dimensions, the grid 2"),
        (np.ones(UNIT.shape), "sign"),
        (np.full(UNIT.shape, np.nan), "finite"),
    ],
)
def test_interfaces_that_cannot_be_carried_are_refused(shape, match):
    with pytest.raises(InputError, match=match):
        ParticleLevelSet(**SETTINGS).start(shape)


def test_velocities_that_are_no_numbers_or_of_another_shape_are_refused_by_name():
    def holed(time: float, at: np.ndarray) -> np.ndarray:
        return np.where(at > 0.7, np.nan, 1.0)

    with pytest.raises(InputError, match="velocity is not finite at t = 0 for"):
        ParticleLevelSet(grid=UNIT, velocity=holed).start(CIRCLE)
    flat = ParticleLevelSet(grid=UNIT, velocity=lambda time, at: at[:, 0])
    with pytest.raises(InputError, match=r"velocity must return real numbers of shape \(\d+, 2\)"):
        flat.start(CIRCLE)
    with pytest.raises(InputError, match="got complex128"):
        ParticleLevelSet(grid=UNIT, velocity=lambda time, at: 1j * at).start(CIRCLE)
    whole = ParticleLevelSet(grid=UNIT, velocity=lambda time, at: np.ones(at.shape, int))
    assert whole.step(whole.start(Disk(0.1, center=(0.3, 0.3))), 0.1).positions.dtype == np.float64


def test_an_interface_that_leaves_the_box_is_told_and_the_last_good_state_kept():
    flow = ParticleLevelSet(grid=UNIT, velocity=Uniform(velocity=(0.0, 1.0)))
    with pytest.raises(BlowUpError, match="has reached the end of the box along axis 1") as told:
        pmesh.run(flow, flow.start(CIRCLE), until=1.0, dt=0.02)
    assert 0.05 < told.value.state.time < 0.12


def test_a_torus_and_a_capsule_are_carried_too():
    grid = Grid((41, 41, 41), 0.1, (-2.0, -2.0, -2.0))
    law = Rotation(center=(0.0, 0.0, 0.0), rate=(0.3, 0.5, -0.2))
    flow = ParticleLevelSet(grid=grid, velocity=law)
    for shape in (Torus(1.0, 0.4), Capsule((-0.8, 0.0, 0.0), (0.8, 0.3, 0.0), 0.5)):
        start = flow.start(shape)
        end = carried(flow, start, 1.0, 4)
        assert mean_error(flow, end, shape.moved(angle=(0.3, 0.5, -0.2))) < 0.03 * grid.spacing


def test_what_is_known_at_the_start_is_kept_to_the_last_digit():
    start = ParticleLevelSet(grid=UNIT, velocity=TURN).start(CIRCLE)
    exact = profile(CIRCLE.distance(start.positions.T), 6 / 64)
    np.testing.assert_array_equal(start.values, exact)


def test_a_law_that_comes_to_rest_for_an_instant_does_not_let_the_step_run_away():
    """The gradient of a reversed vortex is zero at half its period, and grows again."""
    flow = ParticleLevelSet(grid=UNIT, velocity=SingleVortex(period=8.0))
    start = flow.start(CIRCLE, time=4.0)
    step = flow.limit(start).dt
    most = max(SingleVortex(period=8.0).max_gradient(4.0 + s * step) for s in (0, 0.5, 0.9, 1))
    assert 0.005 < most * step <= 0.25 * (1 + 1e-6)
    end = pmesh.run(flow, start, until=5.0)
    assert end.step < 40


def test_the_largest_step_is_that_of_the_user():
    flow = ParticleLevelSet(grid=UNIT, velocity=TURN, largest_step=0.125)
    assert flow.limit(flow.start(CIRCLE)) == Limit(0.125, "largest_step")


@pytest.mark.parametrize("remeshing", ["never", "distorted", 30])
def test_an_interface_that_leaves_without_being_remeshed_is_told_as_well(remeshing):
    law = Uniform(velocity=(0.0, 1.0))
    flow = ParticleLevelSet(grid=UNIT, velocity=law, remeshing=remeshing)
    with pytest.raises(InputError, match="has reached the end of the box along axis 1"):
        carried(flow, flow.start(CIRCLE), 0.5, 25)


@pytest.mark.parametrize("center", [(0.05, 0.5), (0.0, 0.0), (0.5, 0.97)])
def test_a_shape_across_a_seam_is_whole(center):
    grid = Grid((64, 64), 1 / 64, boundary="periodic")
    law = Uniform(velocity=(1.0, -0.5))
    exact = math.pi * 0.2**2
    for remeshing in ("always", "never"):
        flow = ParticleLevelSet(grid=grid, velocity=law, remeshing=remeshing)
        start = flow.start(Disk(0.2, center=center))
        assert flow.ledger(start)["volume"] == pytest.approx(exact, rel=1e-4)
        end = carried(flow, start, 12.0, 24)
        assert flow.ledger(end)["volume"] == pytest.approx(exact, rel=1e-3)
        around = np.array([[0.2, 0.0], [0.0, 0.2], [-0.14, 0.14]]) + center
        assert np.abs(flow.rebuild(end, around)).max() < 0.2 / 64


def test_where_particles_have_lost_each_other_the_ledger_says_so_and_the_run_goes_on():
    flow = ParticleLevelSet(
        grid=UNIT, velocity=SingleVortex(period=math.inf), remeshing="never", width=2.8
    )
    ledger = pmesh.Ledger()
    end = pmesh.run(flow, flow.start(CIRCLE), until=3.0, watch=[ledger])
    assert end.time == 3.0
    assert math.isfinite(ledger.series["volume"][0])


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf, "a"])
def test_steps_that_are_none_are_refused(dt):
    flow = ParticleLevelSet(**SETTINGS)
    with pytest.raises(InputError, match="dt must be"):
        flow.step(flow.start(CIRCLE), dt)


def test_looking_at_a_state_does_not_lend_it_out():
    flow = ParticleLevelSet(**SETTINGS)
    start = flow.start(CIRCLE)
    flow.band(start).values[:] = 7.0
    assert start.values.max() < 1.0


@pytest.mark.parametrize("redistancing", [None, 2])
def test_an_interface_that_has_shrunk_to_nothing_is_carried_on_as_nothing(redistancing):
    def sink(time: float, at: np.ndarray) -> np.ndarray:  # between nodes: none stays inside
        return -2.0 * (at - np.array([0.5, 0.75]) - 0.5 / 64)

    flow = ParticleLevelSet(grid=UNIT, velocity=sink, redistancing=redistancing)
    end = carried(flow, flow.start(CIRCLE), 3.0, 60)
    assert flow.ledger(end)["volume"] == 0.0
    assert end.size == 0
    assert (flow.fields(end)["level_set"] > 0).all()


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
def test_a_drop_torn_by_taylor_green_vortices_keeps_its_area_where_it_is_thinner_than_a_cell(
    boundary,
):
    def cells(time: float, at: np.ndarray) -> np.ndarray:
        x, y = 2 * np.pi * at.T
        return np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)], axis=1)

    if boundary == "periodic":
        grid = Grid((64, 64), 1 / 64, boundary="periodic")
    else:
        grid = Grid((193, 193), 1 / 64, (-1.0, -1.0))
    flow = ParticleLevelSet(grid=grid, velocity=cells)
    ledger = pmesh.Ledger()
    pmesh.run(flow, flow.start(Disk(0.15, center=(0.3, 0.4))), until=1.0, watch=[ledger])
    areas = ledger.series["volume"] / (math.pi * 0.15**2)
    assert np.abs(areas - 1).max() < 0.15
