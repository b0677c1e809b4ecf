"""VortexFlow without bodies: orders, handedness, viscosity, invariants, and that a step is pure."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from pmesh.vortex.exact.patches import EllipticVortex, PerlmanPatch
from pmesh.vortex.exact.viscous import LambOseen, TaylorGreen
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.errors import BlowUpError, InputError, PmeshError
from remesh.grid import Grid


def square(nodes: int, side: float, **boundary: object) -> Grid:
    """A square mesh about the origin, whose nodes lie where those of a finer one do."""
    return Grid((nodes, nodes), side / nodes, (-side / 2, -side / 2), **boundary)  # type: ignore[arg-type]


def two_vortices(points: np.ndarray) -> np.ndarray:
    """Two Gaussian vortices that turn about each other."""
    x, y = points
    return sum(4 * np.exp(-((x - s) ** 2 + y**2) / 0.25) for s in (0.6, -0.6))


def advance(flow: VortexFlow, state: State, dt: float, steps: int) -> State:
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Relative L2 distance."""
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


def orders(errors: list[float]) -> float:
    """Order from the two finest of a list of errors, each at half the step of the one before."""
    return math.log2(errors[-2] / errors[-1])


def centre(state: State, part: slice = slice(None)) -> tuple[float, float]:
    """Centre of vorticity, of the rows ``part``."""
    x, y = (p[:, part] for p in state.grid.points())
    w = state.vorticity[:, part]
    return float((x * w).sum() / w.sum()), float((y * w).sum() / w.sum())


# Order


@pytest.mark.parametrize("remeshing", ["always", "distorted"])
@pytest.mark.parametrize(("scheme", "order"), [("RK2", 2), ("RK3", 3)])
def test_inviscid_flow_has_the_order_of_its_scheme_in_time(scheme, order, remeshing):
    errors = in_time(scheme, 0.0, remeshing)
    assert orders(errors) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("scheme", ["RK2", "RK3"])
def test_viscous_flow_is_of_second_order_in_time(scheme):
    assert orders(in_time(scheme, 0.1, "always")) == pytest.approx(2, abs=0.2)


def in_time(scheme: str, viscosity: float, remeshing: str) -> list[float]:
    """Errors at t = 0.5 for three steps; a kernel of nine moments hides its own errors."""
    flow = VortexFlow(
        grid=square(96, 6.0), viscosity=viscosity, freestream=(0.3, 0.0), kernel="L8,4",
        time_scheme=scheme, remeshing=remeshing, distortion=9.0, domain="fixed",
    )  # fmt: skip
    start = flow.start(vorticity=two_vortices)
    exact = advance(replace(flow, time_scheme="RK3"), start, 0.5 / 96, 96).vorticity
    return [apart(advance(flow, start, 0.5 / n, n).vorticity, exact) for n in (3, 6, 12)]


@pytest.mark.parametrize(("kernel", "order"), [("M4'", 2), ("M6'", 4)])
def test_the_order_in_space_is_the_kernels_number_of_moments_when_dt_follows_it(kernel, order):
    exact = in_space("L8,4", 192, 48)[::8, ::8]
    errors = [apart(in_space(kernel, n, n // 4)[:: n // 24, :: n // 24], exact) for n in (48, 96)]
    assert orders(errors) == pytest.approx(order, abs=0.2)


@cache
def in_space(kernel: str, nodes: int, steps: int) -> np.ndarray:
    """Vorticity at t = 0.3; RK3 hides the error in time."""
    flow = VortexFlow(grid=square(nodes, 6.0), kernel=kernel, time_scheme="RK3", domain="fixed")
    start = flow.start(vorticity=two_vortices)
    return advance(flow, start, 0.3 / steps, steps).vorticity


# Handedness


def test_positive_vortices_turn_about_each_other_counter_clockwise():
    flow = VortexFlow(grid=square(64, 4.0))
    start = flow.start(vorticity=two_vortices)
    end = advance(flow, start, 0.05, 4)
    x, y = end.grid.points()
    right = end.vorticity * (x > 0)
    assert (right * y).sum() / right.sum() > 0.05
    u, v = flow.velocity(start)
    assert v[-8, 32] > 0 > v[8, 32]
    assert u[32, 8] > 0 > u[32, -8]


def test_a_vortex_pair_moves_by_gamma_over_two_pi_b():
    gamma, b, core, time = 2.0, 1.0, 0.1, 0.5
    upper = LambOseen(circulation=gamma, core=core, center=(0.0, b / 2))
    lower = LambOseen(circulation=-gamma, core=core, center=(0.0, -b / 2))
    flow = VortexFlow(grid=Grid((80, 96), 1 / 40, (-0.9, -1.2)))
    start = flow.start(vorticity=lambda p: upper.vorticity(p) + lower.vorticity(p))
    end = advance(flow, start, time / 20, 20)
    half = slice(end.grid.shape[1] // 2, None)
    (x, y), (x0, y0) = centre(end, half), centre(start, slice(48, None))
    assert x - x0 == pytest.approx(gamma / (2 * math.pi * b) * time, rel=2e-3)
    assert y - y0 == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("scheme", ["RK2", "RK3"])
def test_a_free_stream_carries_the_centre_of_vorticity_exactly(scheme):
    flow = VortexFlow(
        grid=square(64, 4.0), freestream=(0.7, -0.4), viscosity=0.01, time_scheme=scheme
    )
    start = flow.start(vorticity=two_vortices)
    end = advance(flow, start, 0.1, 10)
    moved = np.subtract(centre(end), centre(start))
    np.testing.assert_allclose(moved, (0.7, -0.4), atol=1e-9)


def test_perlmans_patch_keeps_its_form_in_a_free_stream():
    patch = PerlmanPatch(p=7, drift=(0.5, 0.25))
    flow = VortexFlow(grid=square(128, 4.0), freestream=patch.drift)
    end = advance(flow, flow.start(vorticity=patch.vorticity), 0.1, 10)
    points = end.grid.points()
    assert apart(end.vorticity, patch.vorticity(points, 1.0)) < 2e-4
    assert apart(flow.velocity(end), patch.velocity(points, 1.0)) < 1e-4


# Viscosity


@pytest.mark.parametrize("dt", [0.5, 0.1])
def test_a_lamb_oseen_core_grows_by_four_nu_t_for_any_step(dt):
    exact = LambOseen(core=0.3, viscosity=0.02, drift=(0.2, 0.0))
    flow = VortexFlow(grid=square(80, 4.0), viscosity=0.02, freestream=(0.2, 0.0))
    end = advance(flow, flow.start(vorticity=exact.vorticity), dt, round(1.0 / dt))
    assert apart(end.vorticity, exact.vorticity(end.grid.points(), 1.0)) < 5e-4
    peak = 1 / (math.pi * end.vorticity.max())
    assert (peak - 0.09) / 1.0 == pytest.approx(4 * 0.02, rel=5e-3)


def test_taylor_green_decays_exactly_and_the_stream_carries_it():
    exact = TaylorGreen(viscosity=0.05, drift=(0.3, 0.7))
    grid = Grid((32, 32), 1 / 32, boundary="periodic")
    flow = VortexFlow(grid=grid, viscosity=0.05, freestream=exact.drift)
    end = advance(flow, flow.start(vorticity=exact.vorticity), 0.05, 10)
    assert end.grid == grid
    assert apart(end.vorticity, exact.vorticity(grid.points(), 0.5)) < 2e-3
    assert end.vorticity.std() / exact.vorticity(grid.points()).std() == pytest.approx(
        exact.decay(0.5), rel=1e-3
    )


@pytest.mark.parametrize("boundary", ["periodic", ("periodic", "unbounded")])
def test_a_parallel_flow_only_spreads(boundary):
    """It is steady for Euler; its profile obeys the heat equation."""
    nu, t, core = 0.02, 0.5, 0.3
    grid = Grid((16, 80), 1 / 16, (0.0, -2.5), boundary)

    def layer(y: np.ndarray, time: float) -> np.ndarray:
        a2 = core**2 + 4 * nu * time
        return np.exp(-((y - 0.9) ** 2) / a2) / a2**0.5 - np.exp(-((y + 0.9) ** 2) / a2) / a2**0.5

    flow = VortexFlow(grid=grid, viscosity=nu)
    end = advance(flow, flow.start(vorticity=lambda p: layer(p[1], 0.0)), 0.1, 5)
    assert apart(end.vorticity, layer(end.grid.points()[1], t)) < 1e-5
    assert end.grid.shape[0] == 16


# What is kept


@pytest.mark.parametrize("viscosity", [0.0, 0.01])
def test_circulation_and_impulse_are_kept_and_the_angular_moment_grows_by_four_nu_gamma(viscosity):
    stream, steps, dt = np.array((0.4, -0.3)), 8, 0.05
    flow = VortexFlow(grid=square(80, 5.0), viscosity=viscosity, freestream=tuple(stream))
    start = flow.start(vorticity=lambda p: two_vortices(p - 0.2))
    end = advance(flow, start, dt, steps)
    before, after = flow.ledger(start), flow.ledger(end)
    gamma = before["circulation"]
    kept = after["circulation"] + after["lost_circulation"]
    assert kept == pytest.approx(gamma, rel=1e-12)
    assert abs(after["lost_circulation"]) < 1e-7 * gamma
    time = steps * dt
    assert after["impulse_x"] == pytest.approx(
        before["impulse_x"] + stream[1] * gamma * time, abs=1e-7
    )
    assert after["impulse_y"] == pytest.approx(
        before["impulse_y"] - stream[0] * gamma * time, abs=1e-7
    )
    x0, y0 = centre(start)
    x1, y1 = centre(end)
    own0 = before["angular_moment"] - gamma * (x0**2 + y0**2)
    own1 = after["angular_moment"] - gamma * (x1**2 + y1**2)
    assert own1 - own0 == pytest.approx(4 * viscosity * gamma * time, abs=2e-4 * own0)


def test_the_elliptical_vortex_keeps_circulation_and_second_moments():
    exact = EllipticVortex()
    flow = VortexFlow(grid=square(80, 2.0), time_scheme="RK3")
    start = flow.start(vorticity=exact.vorticity)
    end = advance(flow, start, 0.025, 20)
    before, after = flow.ledger(start), flow.ledger(end)
    assert after["circulation"] == pytest.approx(before["circulation"], rel=1e-10)
    assert after["angular_moment"] == pytest.approx(before["angular_moment"], rel=1e-3)


@pytest.mark.parametrize("viscosity", [0.0, 0.02])
@pytest.mark.parametrize("remeshing", ["always", "distorted"])
def test_what_crosses_a_fixed_edge_is_counted(viscosity, remeshing):
    """Of vortices so weak that distorted particles are never remeshed on their way out."""
    flow = VortexFlow(
        grid=square(48, 3.0), viscosity=viscosity, freestream=(1.0, 0.5), domain="fixed",
        remeshing=remeshing, distortion=9.0,
    )  # fmt: skip
    state = flow.start(vorticity=lambda points: 1e-3 * two_vortices(points))
    total = flow.ledger(state)["circulation"]
    sampled = remeshing == "distorted" and viscosity > 0
    for _ in range(15):
        state = flow.step(state, 0.1)
        row = flow.ledger(state)
        kept = row["circulation"] + row["lost_circulation"]
        assert kept == pytest.approx(total, rel=3e-3 if sampled else 1e-12)
    assert row["lost_circulation"] > 0.3 * total
    assert (state.strengths is None) == (remeshing == "always")


def test_a_flow_with_a_periodic_axis_loses_nothing_through_it():
    grid = Grid((48, 48), 3 / 48, (-1.5, -1.5), ("periodic", "unbounded"))
    flow = VortexFlow(grid=grid, viscosity=0.01, freestream=(1.0, 0.0))
    start = flow.start(vorticity=two_vortices)
    end = advance(flow, start, 0.1, 30)
    assert end.grid.shape[0] == 48
    assert flow.ledger(end)["circulation"] == pytest.approx(
        flow.ledger(start)["circulation"], rel=1e-12
    )


# Remeshing when distorted


def test_particles_that_only_drift_are_never_remeshed():
    """A vortex so weak that it strains nothing, carried over 4 lengths of itself."""
    weak = LambOseen(circulation=1e-3, core=0.25, drift=(1.0, 0.3))
    flow = VortexFlow(grid=square(48, 3.0), freestream=weak.drift, remeshing="distorted")
    state = flow.start(vorticity=weak.vorticity)
    for _ in range(10):
        state = flow.step(state, 0.1)
        assert state.strengths is not None
    home = np.unravel_index(np.argmax(np.abs(state.strengths)), state.grid.shape)
    np.testing.assert_allclose(state.displacement[:, *home], weak.drift, atol=1e-3)
    points = state.grid.points()
    assert apart(state.vorticity, weak.vorticity(points, 1.0)) < 2e-3
    once = VortexFlow(grid=square(48, 3.0), freestream=weak.drift)
    often = advance(once, once.start(vorticity=weak.vorticity), 0.1, 10)
    assert apart(often.vorticity, weak.vorticity(often.grid.points(), 1.0)) > 2 * apart(
        state.vorticity, weak.vorticity(points, 1.0)
    )


@pytest.mark.parametrize("viscosity", [0.0, 0.02])
def test_strained_particles_are_remeshed_and_agree_with_those_remeshed_always(viscosity):
    always = VortexFlow(grid=square(96, 6.0), viscosity=viscosity, domain="fixed")
    seldom = replace(always, remeshing="distorted")
    states = [always.start(vorticity=two_vortices)] * 2
    kept = []
    for _ in range(20):
        states = [flow.step(s, 0.025) for flow, s in zip((always, seldom), states, strict=True)]
        kept.append(states[1].strengths is not None)
    assert {True, False} <= set(kept), "some steps remesh and some do not"
    assert apart(states[1].vorticity, states[0].vorticity) < 1e-3
    sums = [flow.ledger(s)["circulation"] for flow, s in zip((always, seldom), states, strict=True)]
    assert sums[1] == pytest.approx(sums[0], rel=1e-6)


# A step is a law


OPTIONS = [
    {},
    {"viscosity": 0.01},
    {"viscosity": 0.01, "remeshing": "distorted", "domain": "follow"},
    {"time_scheme": "RK3", "kernel": "M4'"},
]


def arrays(state: State) -> dict[str, np.ndarray]:
    return {
        f.name: value
        for f in fields(state)
        if isinstance(value := getattr(state, f.name), np.ndarray)
    }


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_a_step_changes_nothing_it_is_given_and_repeats_to_the_bit(options):
    flow = VortexFlow(grid=square(48, 4.0), freestream=(0.5, 0.0), **options)
    state = advance(flow, flow.start(vorticity=two_vortices), 0.05, 1)
    before = {name: value.copy() for name, value in arrays(state).items()}
    once, again = flow.step(state, 0.05), flow.step(state, 0.05)
    for name, value in before.items():
        np.testing.assert_array_equal(arrays(state)[name], value)
    for name, value in arrays(once).items():
        np.testing.assert_array_equal(arrays(again)[name], value)
    assert (once.time, once.step) == (pytest.approx(0.1), 2)


def test_one_thread_and_two_give_equal_bits():
    ends = []
    for threads in (1, 2):
        flow = VortexFlow(grid=square(64, 4.0), viscosity=0.01, threads=threads)
        ends.append(advance(flow, flow.start(vorticity=two_vortices), 0.05, 3))
    np.testing.assert_array_equal(ends[0].vorticity, ends[1].vorticity)
    assert ends[0].gradient == ends[1].gradient


@pytest.mark.parametrize("viscosity", [0.0, 0.01])
@pytest.mark.parametrize("remeshing", ["always", "distorted"])
def test_float32_agrees_with_float64_to_its_own_accuracy(viscosity, remeshing):
    ends = []
    for dtype in ("float32", "float64"):
        flow = VortexFlow(
            grid=square(64, 4.0), viscosity=viscosity, freestream=(0.3, 0.0), dtype=dtype,
            remeshing=remeshing,
        )  # fmt: skip
        ends.append(advance(flow, flow.start(vorticity=two_vortices), 0.05, 6))
    assert ends[0].vorticity.dtype == np.float32
    assert {value.dtype for value in arrays(ends[0]).values()} == {np.dtype(np.float32)}
    assert ends[0].grid.shape == ends[1].grid.shape
    assert apart(ends[0].vorticity, ends[1].vorticity) < 2e-6


def test_a_run_shifted_by_whole_cells_is_the_same_run():
    here, there = square(48, 4.0), Grid((48, 48), 4 / 48, (10.0, -30.0))
    ends = []
    for grid in (here, there):
        flow = VortexFlow(grid=grid, viscosity=0.01)
        state = flow.start(vorticity=two_vortices(here.points()))
        ends.append(advance(flow, state, 0.05, 3).vorticity)
    np.testing.assert_array_equal(ends[0], ends[1])


# The limit of the step


def test_the_deformation_rule_bounds_dt_times_the_largest_gradient():
    vortex = LambOseen(circulation=1.0, core=0.3)
    flow = VortexFlow(grid=square(96, 3.0), deformation=0.2)
    state = flow.start(vorticity=vortex.vorticity)
    limit = flow.limit(state)
    assert limit.rule == "deformation"
    assert limit.dt == pytest.approx(0.2 / state.gradient)
    peak = vortex.circulation / (math.pi * vortex.core**2)  # turning at w/2
    assert state.gradient == pytest.approx(peak / 2, rel=0.02)


def test_largest_step_binds_and_is_named():
    flow = VortexFlow(grid=square(32, 4.0), largest_step=1e-3)
    assert flow.limit(flow.start(vorticity=two_vortices)) == (flow.limit(flow.start()))
    assert flow.limit(flow.start()).rule == "largest_step"
    assert flow.limit(flow.start()).dt == 1e-3


def test_nothing_at_rest_limits_nothing():
    flow = VortexFlow(grid=square(32, 4.0), viscosity=0.01)
    state = flow.start()
    assert flow.limit(state).dt == math.inf
    end = flow.step(state, 1.0)
    assert not end.vorticity.any()
    assert flow.forces(end) == {}


def test_a_velocity_that_is_not_finite_is_a_blow_up():
    flow = VortexFlow(grid=square(32, 4.0))
    state = flow.start(vorticity=two_vortices)
    for bad in (np.nan, np.inf):
        with np.errstate(all="ignore"), pytest.raises(PmeshError, match="not finite") as caught:
            flow.step(replace(state, vorticity=np.where(state.vorticity > 1, bad, 0.0)), 0.1)
        assert caught.value.hint


def test_the_fields_of_a_flow_are_its_vorticity_and_velocity():
    flow = VortexFlow(grid=square(32, 4.0), freestream=(0.3, 0.1))
    state = flow.start(vorticity=two_vortices)
    found = flow.fields(state)
    assert set(found) == {"vorticity", "velocity"}
    assert found["velocity"].shape == (2, 32, 32)
    np.testing.assert_array_equal(found["velocity"], flow.velocity(state))


@pytest.mark.parametrize("dt", [0.0, -0.1, math.nan, math.inf])
def test_a_step_of_no_time_or_no_number_is_refused(dt):
    grid = Grid((32, 32), 1 / 16, (-1.0, -1.0))
    flow = VortexFlow(grid=grid)
    with pytest.raises(InputError, match="dt must be positive and finite"):
        flow.step(flow.start(), dt)


def test_a_step_that_would_leave_the_mesh_far_behind_is_a_blow_up():
    grid = Grid((32, 32), 1 / 16, (-1.0, -1.0))
    flow = VortexFlow(grid=grid, freestream=(1.0, 0.0))
    state = flow.start(vorticity=LambOseen(circulation=1.0, core=0.3).vorticity)
    with pytest.raises(BlowUpError, match="times the mesh"):
        flow.step(state, 1e6)
