"""VortexFlow on adaptive meshes: accuracy for a tolerance, what is kept, and pure steps."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pmesh.run.checkpoint import load
from pmesh.run.loop import run
from pmesh.run.snapshots import Snapshots
from pmesh.run.tree import same
from pmesh.run.watchers import Ledger
from pmesh.vortex.carrier import Carrier
from pmesh.vortex.exact.patches import EllipticVortex
from pmesh.vortex.exact.viscous import LambOseen
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.window import Window
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.uniform import to_uniform

CFL = (1.0, 20.0)
CORE = 0.06  # of a vortex that a stream carries [L]
WAY = 0.625  # that it goes: 80 spacings


def square(nodes, side, **boundary):
    return Grid((nodes, nodes), side / nodes, (-side / 2, -side / 2), **boundary)


def mesh_of(nodes, side, levels=2, tolerance=1e-3, **settings):
    grid = square(nodes, side)
    return AdaptiveMesh(grid=grid, levels=levels, tolerance=tolerance, **settings)


def two_vortices(points):
    """Two Gaussian vortices that turn about each other."""
    x, y = points
    return sum(4 * np.exp(-((x - s) ** 2 + y**2) / 0.25) for s in (0.6, -0.6))


def waves(points):
    """Vorticity that fills a periodic unit square."""
    x, y = (2 * np.pi * p for p in points)
    return np.sin(x) * np.sin(y) + 0.3 * np.cos(2 * x + y) + 0.2 * np.cos(3 * y)


def advance(flow, state, dt, steps):
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def flat(state):
    """The vorticity on the finest grid."""
    return to_uniform(state.vorticity, state.blocks)


def largest(a, b):
    """Largest difference relative to the largest value."""
    return float(np.abs(a - b).max() / np.abs(b).max())


# Beside uniform meshes


@pytest.mark.parametrize("viscosity", [0.0, 0.002])
def test_a_step_on_a_complete_fine_mesh_is_the_uniform_one(viscosity):
    """To what the reach of 12 nodes leaves of the velocity's corrections."""
    grid = Grid((128, 128), 1 / 128, boundary="periodic")
    mesh = AdaptiveMesh(grid=grid, levels=2, tolerance=1e-7)
    how = {"viscosity": viscosity, "freestream": (0.3, 0.2)}
    flow, uniform = VortexFlow(grid=mesh, **how), VortexFlow(grid=grid, **how)
    end = flow.step(flow.start(vorticity=waves), 0.05)
    known = uniform.step(uniform.start(vorticity=waves), 0.05)
    assert end.blocks.active == grid.size
    assert largest(flat(end), known.vorticity) < 3e-7
    velocity = to_uniform(flow.velocity(end), end.blocks)
    assert largest(velocity, uniform.velocity(known)) < 3e-7
    assert (end.time, end.step) == (known.time, known.step)
    assert end.speed == pytest.approx(known.speed, rel=1e-6)
    assert end.gradient == pytest.approx(known.gradient, rel=5e-3)  # differences of another order


@cache
def elliptic_uniform():
    """The elliptical vortex after 20 steps on the finest grid, and the steps."""
    grid = square(256, 3.2)
    flow = VortexFlow(grid=grid, kernel="L6,4", domain="fixed")
    state, steps = flow.start(vorticity=EllipticVortex().vorticity), []
    for _ in range(20):
        steps.append(0.4 * flow.limit(state).dt)
        state = flow.step(state, steps[-1])
    return state, steps


def test_the_elliptical_vortex_is_off_by_its_tolerance_and_pays_for_active_nodes_only():
    known, steps = elliptic_uniform()
    errors, shares, tolerances = [], [], (1e-2, 1e-3, 1e-4)
    for tolerance in tolerances:
        mesh = mesh_of(256, 3.2, levels=3, tolerance=tolerance)
        flow = VortexFlow(grid=mesh, kernel="L6,4")
        state = flow.start(vorticity=EllipticVortex().vorticity)
        for dt in steps:
            state = flow.step(state, dt)
        errors.append(largest(flat(state), known.vorticity))
        shares.append(state.size / mesh.grid.size)
        assert flow.ledger(state)["compression"] == pytest.approx(1 / shares[-1])
        assert state.tolerance == tolerance
    np.testing.assert_array_less(errors, 4 * np.array(tolerances))
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.3)
    assert shares[0] < 0.06
    assert shares[1] < 0.2
    assert sorted(shares) == shares


# The mesh follows


@cache
def carried(tolerance):
    """A vortex 80 spacings downstream by short and by long steps: errors, active nodes."""
    grid = Grid((192, 128), 1 / 128, (-0.5, -0.5))
    mesh = AdaptiveMesh(grid=grid, levels=2, tolerance=tolerance)

    def law(points, way=0.0):
        return np.exp(-0.5 * ((points[0] - way) ** 2 + points[1] ** 2) / CORE**2)

    ends = []
    for cfl in CFL:
        flow = VortexFlow(grid=mesh, freestream=(1.0, 0.0), kernel="L6,4")
        state = flow.start(vorticity=law)
        steps, active = round(WAY / cfl / grid.spacing), [state.blocks.active]
        for _ in range(steps):
            state = flow.step(state, WAY / steps)
            active.append(state.blocks.active)
        finest = state.blocks.places[state.blocks.of(state.blocks.finest)]
        middle = (finest + 0.5).mean(axis=0) * mesh.block / 2 ** (2 - state.blocks.finest)
        ends.append((largest(flat(state), law(grid.points(), WAY)), active, middle))
    return ends


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_steps_of_cfl_20_lose_no_accuracy_against_steps_of_cfl_1(tolerance):
    (short, _, _), (long, _, _) = carried(tolerance)
    assert long < 1.5 * short
    assert short < 4 * tolerance


@pytest.mark.parametrize("cfl", CFL)
def test_the_refined_region_travels_with_the_vortex_and_keeps_its_size(cfl):
    _, active, middle = carried(1e-4)[CFL.index(cfl)]
    np.testing.assert_allclose(active, active[0], rtol=0.2)
    np.testing.assert_allclose(middle, [64 + 80, 64], atol=12)  # spacings


def test_a_vortex_across_a_seam_is_the_one_in_the_middle():
    grid = Grid((128, 128), 1 / 32, (-2.0, -2.0), "periodic")
    flow = VortexFlow(grid=AdaptiveMesh(grid=grid, levels=2, tolerance=1e-3), freestream=(1, 0.5))

    def law(points):  # mean zero
        waves = np.cos(0.5 * np.pi * points[0]) + np.cos(0.5 * np.pi * points[1])
        return np.exp(8 * (waves - 2)) - np.exp(8 * (-waves - 2))

    here = law(grid.points())
    ends = [advance(flow, flow.start(vorticity=field), 0.5, 2) for field in
            (here, np.roll(here, (64, 64), (0, 1)))]  # fmt: skip
    np.testing.assert_allclose(
        np.roll(flat(ends[1]), (-64, -64), (0, 1)), flat(ends[0]), atol=1e-12
    )
    assert ends[0].blocks.active == ends[1].blocks.active < 0.7 * grid.size


# Order and viscosity


@cache
def in_time(scheme, steps):
    """Vorticity at t = 0.5; a kernel of nine moments and a small tolerance hide their errors."""
    mesh = mesh_of(128, 8.0, tolerance=1e-6)
    flow = VortexFlow(grid=mesh, kernel="L8,4", time_scheme=scheme, freestream=(0.3, 0.0))
    return flat(advance(flow, flow.start(vorticity=two_vortices), 0.5 / steps, steps))


@pytest.mark.parametrize(("scheme", "order"), [("RK2", 2), ("RK3", 3), ("RK4", 4)])
def test_order_in_time_is_that_of_the_scheme(scheme, order):
    steps = (6, 12) if order < 4 else (4, 6)
    exact = in_time("RK4", 24)
    errors = [np.linalg.norm(in_time(scheme, n) - exact) for n in steps]
    found = math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0])
    if order < 4:
        assert found == pytest.approx(order, abs=0.2)
    else:
        assert found > 3.8
        assert errors[1] < 0.3 * np.linalg.norm(in_time("RK3", 6) - exact)


@pytest.mark.parametrize("dt", [0.5, 0.1])
@pytest.mark.parametrize(("tolerance", "finest"), [(1e-3, 1), (1e-4, 2)])
def test_a_lamb_oseen_core_grows_by_four_nu_t_for_any_step(dt, tolerance, finest):
    exact = LambOseen(core=0.3, viscosity=0.02, drift=(0.2, 0.0))
    mesh = mesh_of(192, 6.0, tolerance=tolerance)
    flow = VortexFlow(grid=mesh, viscosity=0.02, freestream=(0.2, 0.0))
    end = advance(flow, flow.start(vorticity=exact.vorticity), dt, round(1.0 / dt))
    assert largest(flat(end), exact.vorticity(mesh.grid.points(), 1.0)) < tolerance
    peak = 1 / (math.pi * end.vorticity.max())
    assert (peak - 0.09) / 1.0 == pytest.approx(4 * 0.02, rel=5e-3)
    assert end.blocks.finest == finest
    assert end.size < 0.25 * mesh.grid.size


def test_a_core_that_has_spread_is_held_by_coarser_blocks():
    exact = LambOseen(core=0.12, viscosity=0.02)
    flow = VortexFlow(grid=mesh_of(256, 6.4, levels=3, tolerance=1e-3), viscosity=0.02)
    start = flow.start(vorticity=exact.vorticity)
    end = advance(flow, start, 0.25, 8)
    assert start.blocks.finest == 3
    assert end.blocks.finest < 3
    assert largest(flat(end), exact.vorticity(flow.lattice.points(), 2.0)) < 2e-3


# What is kept


@pytest.mark.parametrize("viscosity", [0.0, 0.01])
@pytest.mark.parametrize(("tolerance", "kept"), [(1e-3, 1e-4), (1e-5, 1e-6)])
def test_moments_are_kept_to_a_tenth_of_the_tolerance(viscosity, tolerance, kept):
    """Circulation, impulse in a stream, and the angular moment, which grows by 4 nu Gamma."""
    stream, steps, dt = np.array((0.4, -0.3)), 8, 0.05
    mesh = mesh_of(192, 10.0, tolerance=tolerance)
    flow = VortexFlow(grid=mesh, viscosity=viscosity, freestream=tuple(stream))
    start = flow.start(vorticity=lambda p: two_vortices(p - 0.2))
    before, after = flow.ledger(start), flow.ledger(advance(flow, start, dt, steps))
    gamma, time = before["circulation"], steps * dt
    assert gamma == pytest.approx(2 * math.pi, rel=kept)
    assert after["circulation"] + after["lost_circulation"] == pytest.approx(gamma, rel=kept)
    assert abs(after["lost_circulation"]) < 1e-9 * gamma
    moved = np.array((after["impulse_x"], after["impulse_y"]))
    moved -= (before["impulse_x"], before["impulse_y"])
    np.testing.assert_allclose(
        moved, gamma * time * np.array((stream[1], -stream[0])), atol=kept * gamma
    )
    own = [
        row["angular_moment"] - (row["impulse_x"] ** 2 + row["impulse_y"] ** 2) / row["circulation"]
        for row in (before, after)
    ]
    assert own[1] - own[0] == pytest.approx(4 * viscosity * gamma * time, abs=2 * kept * own[0])


def test_what_crosses_a_fixed_end_is_counted_where_the_mesh_is_coarse_there():
    flow = VortexFlow(
        grid=mesh_of(128, 4.0, levels=1), viscosity=0.01, freestream=(1.0, 0.5), domain="fixed"
    )
    state = flow.start(vorticity=lambda points: 1e-3 * two_vortices(points))
    total = flow.ledger(state)["circulation"]
    for _ in range(20):
        state = flow.step(state, 0.1)
        row = flow.ledger(state)
        assert row["circulation"] + row["lost_circulation"] == pytest.approx(total, rel=1e-12)
    assert state.blocks.finest == 0
    assert row["lost_circulation"] > 0.3 * total


def test_vorticity_leaves_through_a_fixed_end_as_on_a_uniform_mesh():
    """Within what the subdivision makes of the last few nodes of a level."""
    mesh, states = mesh_of(128, 4.0, tolerance=1e-4), []
    for grid in (mesh, mesh.grid):
        flow = VortexFlow(grid=grid, viscosity=0.01, freestream=(1.0, 0.5), domain="fixed")
        start = flow.start(vorticity=lambda points: 1e-3 * two_vortices(points))
        states.append(advance(flow, start, 0.1, 15))
    assert np.abs(flat(states[0]) - states[1].vorticity).max() < 4e-3 * 4e-3
    assert states[0].blocks.finest == 2


@pytest.mark.parametrize("stream", [(1.0, 0.5), (-1.0, -0.5)])
def test_what_crosses_a_fixed_end_is_counted_where_the_mesh_is_fine_there(stream):
    flow = VortexFlow(
        grid=mesh_of(128, 4.0, tolerance=1e-4), viscosity=0.01, freestream=stream, domain="fixed"
    )
    state = flow.start(vorticity=lambda points: 1e-3 * two_vortices(points))
    total = flow.ledger(state)["circulation"]
    for _ in range(20):
        state = flow.step(state, 0.1)
        row = flow.ledger(state)
        assert row["circulation"] + row["lost_circulation"] == pytest.approx(total, rel=1e-4)
    assert state.blocks.finest == 2
    assert row["lost_circulation"] > 0.3 * total


# The cap


def test_most_blocks_raises_the_tolerance_and_the_ledger_says_so():
    law = EllipticVortex().vorticity
    mesh = mesh_of(256, 3.2, levels=3, tolerance=1e-4)
    free = VortexFlow(grid=mesh, kernel="L6,4")
    capped = replace(free, grid=replace(mesh, most_blocks=40))
    ends = [advance(flow, flow.start(vorticity=law), 0.005, 4) for flow in (free, capped)]
    rows = [flow.ledger(end) for flow, end in zip((free, capped), ends, strict=True)]
    assert rows[0]["blocks"] > 80
    assert rows[1]["blocks"] <= 40
    assert rows[0]["tolerance"] == 1e-4 < rows[1]["tolerance"]
    assert largest(flat(ends[1]), flat(ends[0])) < 10 * rows[1]["tolerance"]


# A step is a law


def test_a_start_from_an_array_is_the_start_from_the_law():
    law = EllipticVortex().vorticity
    flow = VortexFlow(grid=mesh_of(128, 3.2))
    one = flow.start(vorticity=law)
    two = flow.start(vorticity=law(flow.lattice.points()))
    assert same(one, two)


def test_an_array_given_to_start_may_change_afterwards():
    flow = VortexFlow(grid=mesh_of(64, 3.2, levels=1))
    values = two_vortices(4 * flow.lattice.points())
    state = flow.start(vorticity=values)
    once = state.vorticity.copy()
    values[:] = 7
    np.testing.assert_array_equal(state.vorticity, once)


def test_nothing_stays_nothing_and_takes_the_coarsest_blocks_only():
    flow = VortexFlow(grid=mesh_of(128, 3.2), viscosity=0.01, freestream=(1.0, 0.0))
    start = flow.start()
    assert flow.limit(start).dt == math.inf
    end = flow.step(start, 0.1)
    assert end.blocks.finest == 0
    assert not end.vorticity.any()
    np.testing.assert_allclose(flow.velocity(end)[0], 1.0, atol=1e-14)


def test_a_step_changes_nothing_it_is_given_and_threads_do_not_change_a_bit():
    ends = []
    for threads in (1, 2):
        flow = VortexFlow(grid=mesh_of(128, 8.0), viscosity=0.01, threads=threads)
        state = advance(flow, flow.start(vorticity=two_vortices), 0.05, 1)
        before = state.vorticity.copy(), state.busy.copy(), state.blocks.places.copy()
        ends.append(flow.step(state, 0.05))
        for old, now in zip(
            before, (state.vorticity, state.busy, state.blocks.places), strict=True
        ):
            np.testing.assert_array_equal(old, now)
        assert same(flow.step(state, 0.05), ends[-1])
    assert same(*ends)


def test_float32_agrees_with_float64_to_its_own_accuracy():
    ends = []
    for dtype in ("float32", "float64"):
        flow = VortexFlow(grid=mesh_of(128, 8.0), viscosity=0.01, dtype=dtype)
        ends.append(advance(flow, flow.start(vorticity=two_vortices), 0.05, 4))
    assert ends[0].vorticity.dtype == np.float32
    assert flow.velocity(ends[0]).dtype == np.float32
    assert largest(flat(ends[0]), flat(ends[1])) < 1e-5


def test_a_resumed_run_is_the_unbroken_one_to_the_bit(tmp_path):
    flow = VortexFlow(grid=mesh_of(128, 8.0), viscosity=0.01, freestream=(0.5, 0.0))

    def watch():
        return [Ledger(), Snapshots(every=0.1, fields=["vorticity"])]

    start = flow.start(vorticity=two_vortices)
    whole = run(flow, start, until=0.4, watch=watch(), out=tmp_path / "a")
    run(flow, start, until=0.2, watch=watch(), out=tmp_path / "b")
    end = run(flow, start, until=0.4, watch=watch(), out=tmp_path / "b", resume=True)
    assert same(end, whole)
    assert same(load(tmp_path / "b/checkpoint.h5", like=end), whole)
    read = [(tmp_path / name / "series.csv").read_text() for name in "ab"]
    assert read[0] == read[1]


# Refusals

MESH = mesh_of(64, 3.2, levels=1)
IN_SPACE = AdaptiveMesh(grid=Grid((32,) * 3, 0.1), levels=1)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"grid": IN_SPACE}, "on adaptive meshes are plane"),
        ({"remeshing": "distorted"}, "remeshed at every step"),
        ({"domain": "follow"}, "does not follow the vorticity"),
        ({"window": Window(lower=(3, 3), upper=(9, 3))}, "lies around bodies"),
    ],
)
def test_what_an_adaptive_mesh_cannot_do_is_refused_with_advice(options, text):
    with pytest.raises(InputError, match=text) as caught:
        VortexFlow(**({"grid": MESH} | options))
    assert caught.value.hint


@pytest.mark.parametrize(
    ("vorticity", "text"),
    [
        (np.ones((3, 4)), r"must have the shape \(64, 64\) on this grid, got \(3, 4\)"),
        (np.ones((2, 64, 64)), "must have the shape"),
        (np.full((64, 64), np.nan), "must be finite, 4096 values"),
        (np.ones((64, 64), complex), "must hold real numbers"),
        (lambda points: points[0] * np.nan, "must be finite"),
        (lambda points: points, "one field, the law gives 2 components"),
        (lambda points: 1.0, "the law must give values"),
    ],
)
def test_a_start_that_cannot_be_meant_is_refused(vorticity, text):
    with pytest.raises(InputError, match=text) as caught:
        VortexFlow(grid=MESH).start(vorticity=vorticity)
    assert caught.value.hint


def test_vorticity_that_reaches_the_end_breaks_the_run_with_advice():
    flow = VortexFlow(grid=mesh_of(128, 3.2), freestream=(1.0, 0.0))
    state = flow.start(vorticity=lambda p: np.exp(-((p[0] - 0.9) ** 2 + p[1] ** 2) / 0.01))
    with pytest.raises(BlowUpError, match="end of the adaptive mesh along axis 0") as caught:
        advance(flow, state, 0.1, 10)
    assert "domain='fixed'" in caught.value.hint


def test_steps_that_tear_the_particles_apart_are_refused():
    flow = VortexFlow(grid=MESH)
    state = flow.start(vorticity=lambda p: np.exp(-(p**2).sum(axis=0) / 0.05))
    for dt, text in ((1e3, "tears neighbouring particles apart"), (1e12, "finite and below")):
        with pytest.raises(InputError, match=text):
            flow.step(state, dt)
    for dt in (0.0, -1.0, math.nan):
        with pytest.raises(InputError, match="dt must be"):
            flow.step(state, dt)


def test_interfaces_go_with_uniform_flows_only():
    with pytest.raises(InputError, match="this one is adaptive"):
        Carrier(flow=VortexFlow(grid=MESH))


def test_a_state_of_another_mesh_is_refused():
    grid = square(128, 8.0)
    mesh = AdaptiveMesh(grid=grid, levels=2)
    flows = VortexFlow(grid=grid), VortexFlow(grid=mesh)
    states = [flow.start(vorticity=two_vortices) for flow in flows]
    with pytest.raises(InputError, match="steps a State, got a AdaptiveState"):
        flows[0].step(states[1], 0.01)
    with pytest.raises(InputError, match="steps a AdaptiveState, got a State"):
        flows[1].limit(states[0])
    other = VortexFlow(grid=replace(mesh, tolerance=1e-2))
    with pytest.raises(InputError, match="differs from the flow's in tolerance"):
        other.step(states[1], 0.01)


def test_vorticity_that_begins_at_the_end_of_the_mesh_is_refused_at_once():
    grid = square(128, 8.0)
    flow = VortexFlow(grid=AdaptiveMesh(grid=grid, levels=2))
    with pytest.raises(InputError, match="within 3 nodes of the coarsest level") as told:
        flow.start(vorticity=lambda x: two_vortices([x[0] - 2.8, x[1]]))
    assert "fewer levels" in str(told.value)


def test_costly_force_routes_are_refused_on_adaptive_meshes():
    grid = square(128, 8.0)
    flow = VortexFlow(grid=AdaptiveMesh(grid=grid, levels=2))
    state = flow.start(vorticity=two_vortices)
    with pytest.raises(InputError, match="need a uniform grid"):
        flow.routes(state, state)
