"""Bodies in a flow: the start, the forces by two routes, symmetry, and Stokes's exact law."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from levelset.shapes import Box, Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.penalise import Penalisation
from pmesh.cases.short_time_drag import linear_drag
from pmesh.vortex.constraint import SHEET, Wall
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.limits import thickness
from pmesh.vortex.state import State
from remesh.grid import Grid

DISK = RigidBody(Disk(radius=1.0))
TWO = (
    RigidBody(Disk(radius=0.5, center=(0.0, 1.0))),
    RigidBody(Disk(radius=0.5, center=(0.0, -1.0))),
)


def past(
    *bodies: RigidBody,
    diameter: int = 24,
    reynolds: float = 40.0,
    stream: tuple[float, float] = (1.0, 0.0),
    **options: object,
) -> VortexFlow:
    """Flow past bodies within two radii of the origin, whose centre lies between nodes."""
    h = 2 / diameter
    cells = math.ceil(1.75 / h)
    grid = Grid((2 * cells,) * 2, h, ((0.5 - cells) * h,) * 2)
    return VortexFlow(
        **{  # type: ignore[arg-type]
            "grid": grid,
            "viscosity": 2 / reynolds,
            "freestream": stream,
            "bodies": bodies or (DISK,),
            **options,
        }
    )


@cache
def after(flow: VortexFlow, dt: float, steps: int) -> list[State]:
    """The start and the states after each step."""
    states = [flow.start()]
    for _ in range(steps):
        states.append(flow.step(states[-1], dt))
    return states


def force(state: State, body: int = 0) -> np.ndarray:
    return np.array(state.loads[body].force)


# The start


@pytest.mark.parametrize("diameter", [24, 48])
@pytest.mark.parametrize("stream", [(1.0, 0.0), (-0.5, 0.5)])
def test_the_impulsive_start_takes_the_impulse_of_a_sheet_on_the_wall(diameter, stream):
    """-2 pi R^2 U: the displaced fluid's and the added mass; the sheet's place to 0.1 h."""
    flow = past(diameter=diameter, stream=stream)
    row = flow.ledger(flow.start())
    impulse = np.array([row["impulse_x"], row["impulse_y"]])
    along = -impulse @ stream / np.dot(stream, stream) / (2 * math.pi)
    radius = math.sqrt(along)
    assert 0 < radius - 1 < 0.1 * 2 / diameter
    across = impulse @ (-stream[1], stream[0])
    assert abs(across) < 1e-5
    assert abs(row["circulation"]) < 1e-12
    assert SHEET == 0.1


def test_the_start_stops_the_fluid_in_the_body_and_leaves_the_potential_flow_outside():
    flow = past(diameter=48)
    start = flow.start()
    u, v = flow.velocity(start)
    x, y = start.grid.points()
    r = np.hypot(x, y)
    assert np.hypot(u, v)[r < 0.85].max() < 1e-2
    z = x + 1j * y
    away = r > 1.4
    w = 1 - 1 / z[away] ** 2
    assert np.abs((u - 1j * v)[away] - w).max() < 0.012


def test_there_are_no_forces_before_the_first_step():
    flow = past()
    row = flow.forces(flow.start())
    assert math.isnan(row["body0_force_x"])
    assert math.isnan(row["impulse_force_y"])
    assert row["slip_residual"] <= flow.penalisation.tolerance
    assert row["slip_iterations"] > 0


def test_a_body_in_fluid_at_rest_changes_nothing():
    flow = past(stream=(0.0, 0.0))
    start, end = after(flow, 0.1, 1)
    assert not start.vorticity.any()
    assert not end.vorticity.any()
    np.testing.assert_array_equal(force(end), 0.0)


# Forces


def test_the_drag_is_along_the_stream_and_there_is_no_lift():
    for state in after(past(), 0.05, 4)[1:]:
        drag, lift = force(state)
        assert drag > 1.0
        assert abs(lift) < 1e-5 * drag


@pytest.mark.parametrize("stream", [(-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_another_direction_of_the_stream_turns_the_forces_with_it(stream):
    along = after(past(), 0.05, 3)
    turned = after(past(stream=stream), 0.05, 3)
    for a, b in zip(along[1:], turned[1:], strict=True):
        drag = force(a)[0]
        np.testing.assert_allclose(force(b), drag * np.array(stream), atol=1e-4 * drag)


def test_the_two_force_routes_agree():
    for state in after(past(), 0.05, 4)[1:]:
        np.testing.assert_allclose(state.impulse_force, force(state), atol=1e-6)


def test_both_routes_agree_with_vorticity_that_drifts_past():
    """A vortex with circulation: the stream moves its impulse, which is no force."""
    flow = past(stream=(0.8, 0.3))

    def vortex(points: np.ndarray) -> np.ndarray:
        x, y = points
        return 3 * np.exp(-((x + 1.5) ** 2 + (y - 1.4) ** 2) / 0.09)

    state = flow.start(vorticity=vortex)
    for _ in range(3):
        state = flow.step(state, 0.05)
        np.testing.assert_allclose(state.impulse_force, force(state), atol=2e-5)
    assert abs(force(state)[1]) > 0.1


def test_the_force_is_the_sum_of_the_force_density():
    for state in after(past(), 0.05, 2)[1:]:
        given = state.constraint.force.sum(axis=(1, 2)) * state.grid.cell_volume
        np.testing.assert_allclose(-given, force(state), rtol=1e-12, atol=1e-12)


def test_the_momentum_given_is_the_change_of_the_vorticitys_impulse():
    """What a force density creates has its impulse, spread or not, to round-off."""
    flow = past()
    state = after(flow, 0.05, 1)[-1]
    wall = flow.engine.wall(state)
    for spread in (0.0, 0.05 * flow.viscosity):
        created = wall.created(state.constraint.force, spread)
        row = flow.ledger(replace(state, vorticity=created))
        given = state.constraint.force.sum(axis=(1, 2)) * state.grid.cell_volume
        np.testing.assert_allclose((row["impulse_x"], row["impulse_y"]), given, atol=1e-10)
        assert abs(row["circulation"]) < 1e-11


def test_two_bodies_share_the_total_and_mirror_each_other():
    flow = past(*TWO)
    for state in after(flow, 0.05, 3)[1:]:
        upper, lower = force(state, 0), force(state, 1)
        np.testing.assert_allclose(upper, lower * (1, -1), atol=1e-4)
        assert abs(upper[1]) > 0.01, "they push each other"
        np.testing.assert_allclose(upper + lower, state.impulse_force, atol=1e-6)
    assert {"body0_force_x", "body1_force_y"} <= flow.forces(state).keys()


def test_particles_remeshed_when_distorted_feel_the_same_forces():
    always, seldom = past(), past(remeshing="distorted")
    kept = 0
    for a, b in zip(after(always, 0.02, 12)[5:], after(seldom, 0.02, 12)[5:], strict=True):
        kept += b.strengths is not None
        np.testing.assert_allclose(force(b), force(a), rtol=0.01, atol=1e-4)
        np.testing.assert_allclose(b.impulse_force, force(b), rtol=5e-3, atol=1e-4)
    assert kept > 0


def test_the_drag_of_a_short_time_is_the_exact_one_of_unsteady_stokes_flow():
    """Re = 40: inertia is not felt yet."""
    flow, dt = past(diameter=48), 0.01
    nodes, weights = np.polynomial.legendre.leggauss(5)
    for state in after(flow, dt, 20)[5:]:
        times = state.time - 0.5 * dt + 0.5 * dt * nodes
        exact = float(linear_drag(40, times) @ weights) / 2
        assert force(state)[0] == pytest.approx(exact, rel=0.05)


def test_the_drag_hardly_depends_on_the_step():
    """Its mean over 0.9 < T < 1 and the momentum taken since the start, at 10 and 40 steps."""
    means, sums = [], []
    for dt, last in ((0.1, 1), (0.025, 4)):
        drag = [force(state)[0] for state in after(past(), dt, round(1 / dt))[1:]]
        means.append(np.mean(drag[-last:]))
        sums.append(dt * sum(drag))
    assert means[0] == pytest.approx(means[1], rel=5e-3)
    assert sums[0] == pytest.approx(sums[1], rel=2e-3)


def test_a_flow_past_a_body_is_of_first_order_in_time():
    """From T = 0.5 to 1 in 10, 20 and 40 steps; the start's own error left out."""
    grid = Grid((96, 64), 1 / 12, (-2.5, -31.5 / 12))
    flow = past(grid=grid, domain="fixed", penalisation=Penalisation(tolerance=1e-6))
    start, ends = after(flow, 0.025, 20)[-1], []
    for steps in (10, 20, 40):
        state = start
        for _ in range(steps):
            state = flow.step(state, 0.5 / steps)
        ends.append(state.vorticity)
    coarse, fine = (np.linalg.norm(a - b) for a, b in itertools.pairwise(ends))
    assert math.log2(coarse / fine) == pytest.approx(1.0, abs=0.2)


# Slip


def test_the_residual_is_the_one_of_the_law_for_the_flow_that_is_left():
    """lambda chi (u_s - u) over the last half step is the impulse, with u of the new vorticity."""
    flow, dt = past(penalisation=Penalisation(tolerance=1e-6)), 0.05
    before, now = after(flow, dt, 3)[-2:]
    wall = flow.engine.wall(now)
    window, chi, root = wall.window(wall.near), wall.mask().chi, wall.mask().root
    u = flow.velocity(now)
    around = sum(np.roll(u, shift, axis) for shift in (-1, 1) for axis in (1, 2))
    felt = (u + wall.law(flow.penalisation).blur * (around - 4 * u))[(slice(None), *window.mesh)]
    u = u[(slice(None), *window.mesh)]
    given = 0.5 * dt * before.constraint.force
    imposed = now.constraint.force * dt - given
    rate = flow.penalisation.strength * flow.viscosity * 0.5 * dt / flow.grid.spacing**2
    wrong = np.where(chi > 0, -root * felt - imposed / np.where(chi > 0, root, 1) / rate, 0.0)
    rms = math.sqrt((wrong**2).sum() / chi.sum())
    assert now.constraint.residual <= 1e-6
    assert rms < 1e-5
    slip = np.hypot(*u)
    assert now.constraint.slip == pytest.approx(
        math.sqrt((chi * slip**2).sum() / chi.sum()), abs=1e-5
    )
    assert now.constraint.slip_max == pytest.approx(slip[chi > 0.5].max(), abs=1e-4)


def test_a_stronger_penalisation_slips_less():
    slips = [
        after(past(penalisation=Penalisation(strength=s)), 0.05, 2)[-1].constraint.slip
        for s in (30.0, 300.0, 3000.0)
    ]
    assert slips[0] > slips[1] > slips[2]
    assert slips[2] < 0.01


@pytest.mark.parametrize("remeshing", ["always", "distorted"])
def test_single_precision_gives_the_same_forces(remeshing):
    ends = []
    for dtype in ("float32", "float64"):
        flow = past(dtype=dtype, remeshing=remeshing)
        ends.append(after(flow, 0.05, 3)[-1])
    assert ends[0].vorticity.dtype == np.float32
    assert ends[0].constraint.force.dtype == np.float32
    np.testing.assert_allclose(force(ends[0]), force(ends[1]), atol=2e-3)


def test_one_thread_and_two_give_equal_forces():
    one, two = (after(past(threads=threads), 0.05, 2)[-1] for threads in (1, 2))
    np.testing.assert_array_equal(one.vorticity, two.vorticity)
    assert one.loads == two.loads
    assert one.impulse_force == two.impulse_force


def test_a_step_past_a_body_changes_nothing_it_is_given_and_repeats_to_the_bit():
    flow = past()
    state = after(flow, 0.05, 2)[-1]
    before = state.vorticity.copy(), state.constraint.force.copy()
    once, again = flow.step(state, 0.05), flow.step(state, 0.05)
    np.testing.assert_array_equal(state.vorticity, before[0])
    np.testing.assert_array_equal(state.constraint.force, before[1])
    np.testing.assert_array_equal(once.vorticity, again.vorticity)
    assert once.loads == again.loads


def test_a_body_near_a_fixed_edge_loses_no_circulation_uncounted():
    """The mesh ends one radius behind the body; its vorticity leaves and is counted."""
    flow = past(domain="fixed")
    for state in after(flow, 0.2, 15):
        row = flow.ledger(state)
        assert row["circulation"] + row["lost_circulation"] == pytest.approx(0.0, abs=1e-10)


def test_the_wall_of_a_body_beside_a_periodic_axis_is_whole():
    """A row of cylinders: each feels the drag of its neighbours' blockage, and no lift."""
    h = 1 / 12
    grid = Grid((64, 48), h, (-2.0 + h / 2, (0.5 - 24) * h), ("unbounded", "periodic"))
    flow = VortexFlow(
        grid=grid, viscosity=0.05, freestream=(1.0, 0.0), bodies=[RigidBody(Disk(radius=1.0))]
    )
    alone = past()
    row, single = after(flow, 0.05, 3)[-1], after(alone, 0.05, 3)[-1]
    assert row.grid.shape[1] == 48
    assert force(row)[0] > 1.2 * force(single)[0]
    assert abs(force(row)[1]) < 1e-4


def test_the_window_of_a_box_that_sticks_out_is_what_lies_on_the_mesh():
    flow = past()
    wall = flow.engine.wall(flow.start())
    assert isinstance(wall, Wall)
    box = Grid((20, 10), wall.grid.spacing, np.array(wall.grid.origin) - 5 * wall.grid.spacing)
    window = wall.window(box)
    assert window.mesh == (slice(0, 15), slice(0, 5))
    assert window.box == (slice(5, 20), slice(5, 10))


# Limits


def test_the_body_and_the_diffusion_bound_the_step_and_are_named():
    thin = RigidBody(Box(size=(2.0, 0.8)))
    start = past(thin).start()
    slack = {"deformation": 1e9}
    limit = past(thin, **slack).limit(start)
    assert limit.rule == "body"
    size = thickness(thin)  # of the ellipse that weighs and turns alike
    assert 0.8 < size < 0.9
    assert limit.dt == pytest.approx(0.1 * size / start.speed)
    slow = past(thin, stream=(1e-3, 0.0), **slack)
    limit = slow.limit(slow.start())
    assert limit.rule == "diffusion"
    assert limit.dt == pytest.approx(0.01 * size**2 / slow.viscosity)


def test_the_indicator_is_among_the_fields():
    flow = past()
    state = after(flow, 0.05, 1)[-1]
    chi = flow.fields(state)["chi"]
    assert chi.shape == state.grid.shape
    assert chi.min() == 0.0
    assert chi.max() == 1.0
    area = chi.sum() * state.grid.cell_volume
    inner = math.sqrt(area / math.pi)
    drawn_in = (1 - inner) / state.grid.spacing
    assert drawn_in == pytest.approx(flow.engine.wall(state).offset(), abs=0.1)


def test_the_impulse_tells_no_force_while_vorticity_leaves_a_fixed_mesh():
    grown, state = after(past(), 0.1, 6)[-1], after(past(domain="fixed"), 0.1, 6)[-1]
    assert math.isfinite(grown.impulse_force[0])
    assert math.isnan(state.impulse_force[0])
    assert math.isfinite(state.loads[0].force[0])
