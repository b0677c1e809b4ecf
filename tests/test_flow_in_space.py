"""VortexFlow in space without bodies: orders, symmetries, handedness, what is kept, purity."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pmesh.run import checkpoint
from pmesh.vortex.exact import BeltramiFlow, GaussianRing, TorusKnot, VortexRing
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.errors import InputError
from remesh.grid import Grid

DRIFT = (0.5, -0.3, 0.2)
FORMS = ("conservative", "classical")


def period(nodes: int) -> Grid:
    return Grid((nodes,) * 3, 2 * math.pi / nodes, boundary="periodic")


def cube(nodes: int, side: float) -> Grid:
    """A cubic mesh about the origin."""
    return Grid((nodes,) * 3, side / nodes, (-0.5 * side * (1 - 1 / nodes),) * 3)


def advance(flow: VortexFlow, state: State, dt: float, steps: int) -> State:
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Relative L2 distance."""
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


def two_hands(points: np.ndarray) -> np.ndarray:
    """A Beltrami flow and the mirror image of one: together they are none, and change shape."""
    right = BeltramiFlow(strengths=(1.0, 0.7, 0.4)).vorticity(points)
    mirrored = points * np.array([-1.0, 1.0, 1.0])[:, None, None, None]
    left = BeltramiFlow(strengths=(0.4, -0.6, 0.5)).vorticity(mirrored)
    return right + left * np.array([1.0, -1.0, -1.0])[:, None, None, None]


def a_ring(axis: int = 2, center: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> GaussianRing:
    along = [0.0, 0.0, 0.0]
    along[axis] = 1.0
    return GaussianRing(radius=0.6, core=0.3, circulation=1.0, center=center, axis=tuple(along))


# Order


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("scheme", "viscosity", "order"), [("RK2", 0.0, 2), ("RK3", 0.0, 3), ("RK3", 0.1, 2)]
)
def test_the_order_in_time_is_the_schemes_and_two_with_viscosity(scheme, viscosity, order, form):
    flow = steady_mesh("RK4", viscosity, form)
    start = flow.start(vorticity=two_hands)
    flow = replace(flow, time_scheme=scheme)
    fine = reference(viscosity, form)
    errors = [apart(advance(flow, start, 0.4 / n, n).vorticity, fine) for n in (3, 6)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


def steady_mesh(scheme: str, viscosity: float, form: str) -> VortexFlow:
    """A kernel of nine moments hides its own errors."""
    return VortexFlow(
        grid=period(24), viscosity=viscosity, freestream=DRIFT, kernel="L8,4", stretching=form,
        time_scheme=scheme,
    )  # fmt: skip


@cache
def reference(viscosity: float, form: str) -> np.ndarray:
    """Vorticity at t = 0.4."""
    flow = steady_mesh("RK4", viscosity, form)
    return advance(flow, flow.start(vorticity=two_hands), 0.4 / 24, 24).vorticity


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("kernel", "order"), [("M4'", 2), ("M6'", 4)])
def test_the_order_in_space_is_the_kernels_number_of_moments_when_dt_follows_it(
    kernel, order, form
):
    """Of an exact unsteady flow, in which carrying and stretching cancel only together."""
    errors = [of_beltrami(kernel, form, nodes) for nodes in (16, 32)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@cache
def of_beltrami(kernel: str, form: str, nodes: int) -> float:
    """Error of the vorticity at t = 0.25; no particle passes half a cell in a step."""
    exact = BeltramiFlow(strengths=(1.0, 0.7, 0.43), viscosity=0.02, drift=DRIFT)
    flow = VortexFlow(
        grid=period(nodes), viscosity=0.02, freestream=DRIFT, kernel=kernel, time_scheme="RK4",
        stretching=form,
    )  # fmt: skip
    end = advance(flow, flow.start(vorticity=exact.vorticity), 0.8 / nodes, 5 * nodes // 16)
    return apart(end.vorticity, exact.vorticity(end.grid.points(), 0.25))


# Symmetry and handedness


@pytest.mark.parametrize("viscosity", [0.0, 0.002])
@pytest.mark.parametrize("boundary", ["unbounded", "periodic"])
def test_a_plane_flow_along_a_periodic_axis_is_the_flow_in_the_plane(boundary, viscosity):
    plane = Grid((32, 32), 0.1, (-1.6, -1.6), boundary)
    sides = (plane.boundary[0], plane.boundary[1], "periodic")
    space = Grid((32, 32, 8), 0.1, (-1.6, -1.6, 0.0), sides)

    def patches(x: np.ndarray) -> np.ndarray:
        return np.exp(-(4 * (x[0] - 0.2) ** 2 + x[1] ** 2) / 0.1) - np.exp(
            -((x[0] + 0.3) ** 2 + (x[1] - 0.1) ** 2) / 0.1
        )

    start = patches(plane.points())
    start -= start.mean() if boundary == "periodic" else 0.0
    told = {"viscosity": viscosity, "diffusion": "spectral", "domain": "fixed"}
    two = VortexFlow(grid=plane, freestream=(0.3, 0.1), **told)
    three = VortexFlow(grid=space, freestream=(0.3, 0.1, 0.0), **told)
    along = np.zeros((3, *space.shape))
    along[2] = start[:, :, None]
    flat = advance(two, two.start(vorticity=start), 0.1, 4)
    deep = advance(three, three.start(vorticity=along), 0.1, 4)
    assert np.abs(deep.vorticity[2] - flat.vorticity[:, :, None]).max() < 1e-10
    assert np.abs(deep.vorticity[:2]).max() < 1e-12
    assert deep.gradient == pytest.approx(flat.gradient, rel=1e-10)


@pytest.mark.parametrize("form", FORMS)
def test_a_ring_along_any_axis_is_the_same_run(form):
    flow = VortexFlow(grid=cube(24, 3.0), viscosity=0.01, stretching=form, domain="fixed")
    ends = []
    for axis in range(3):
        state = flow.start(vorticity=a_ring(axis).vorticity)
        w = advance(flow, state, 0.1, 3).vorticity
        turned = tuple((k + 2 - axis) % 3 + 1 for k in range(3))
        ends.append(np.roll(np.moveaxis(w, (1, 2, 3), turned), 2 - axis, axis=0))
    for end in ends[:2]:
        assert np.abs(end - ends[2]).max() < 1e-11 * np.abs(ends[2]).max()


def test_the_mirror_image_of_a_flow_is_the_flow_of_the_mirror_image():
    """Vorticity changes its sign in a mirror, but for the part across it."""
    flow = VortexFlow(grid=cube(24, 3.0), domain="fixed")
    ring = a_ring(2, (0.1, 0.2, -0.3)).vorticity(flow.lattice.points())
    ring += a_ring(0, (-0.2, 0.1, 0.3)).vorticity(flow.lattice.points())
    signs = np.array([1.0, -1.0, -1.0])[:, None, None, None]
    one = advance(flow, flow.start(vorticity=ring), 0.1, 3).vorticity
    other = advance(flow, flow.start(vorticity=signs * ring[:, ::-1]), 0.1, 3).vorticity
    assert np.abs(other - signs * one[:, ::-1]).max() < 1e-11 * np.abs(one).max()


def test_a_ring_moves_the_way_its_impulse_points_and_about_as_fast_as_it_should():
    """The closed speed of the centroid at the start; a wrong sign gives the opposite."""
    ring = VortexRing(radius=0.6, core=0.3)
    flow = VortexFlow(grid=cube(40, 3.2), domain="fixed")
    start = flow.start(vorticity=ring.vorticity)
    end = advance(flow, start, 0.1, 5)

    def place(state: State) -> float:
        x, y, z = state.grid.points()
        moment = x * state.vorticity[1] - y * state.vorticity[0]
        return float((moment * z).sum() / moment.sum())

    assert flow.ledger(start)["impulse_z"] > 0
    assert (place(end) - place(start)) / 0.5 == pytest.approx(ring.centroid_speed, rel=0.02)


def test_the_velocity_of_a_beltrami_flow_is_its_vorticity_over_the_wave_number():
    exact = BeltramiFlow(drift=DRIFT)
    flow = VortexFlow(grid=period(12), freestream=DRIFT)
    state = flow.start(vorticity=exact.vorticity)
    points = flow.lattice.points()
    np.testing.assert_allclose(flow.velocity(state), exact.velocity(points), atol=1e-12)


# What is kept


@pytest.mark.parametrize("viscosity", [0.0, 0.01])
def test_total_vorticity_and_impulse_are_kept(viscosity):
    """Total vorticity by the conservative form to round-off, impulse to the error in space."""
    flow = VortexFlow(grid=cube(32, 3.6), viscosity=viscosity, time_scheme="RK3", domain="fixed")
    start = flow.start(vorticity=a_ring().vorticity)
    end = advance(flow, start, 0.1, 3)
    before, after = flow.ledger(start), flow.ledger(end)
    total = end.vorticity.sum(axis=(1, 2, 3)) * end.grid.cell_volume
    first = start.vorticity.sum(axis=(1, 2, 3)) * start.grid.cell_volume
    np.testing.assert_allclose(total + end.lost_circulation, first, atol=1e-12)
    for name in ("impulse_x", "impulse_y", "impulse_z"):
        assert after[name] == pytest.approx(before[name], abs=1e-4 * before["impulse_z"])
    for name in ("angular_impulse_x", "angular_impulse_y", "angular_impulse_z", "helicity"):
        assert abs(after[name]) < 1e-10


def test_viscosity_takes_the_helicity_of_a_beltrami_flow_as_it_should():
    """curl u = u: H = 2 E, and both fall like exp(-2 nu t)."""
    flow, abc = VortexFlow(grid=period(24), viscosity=0.1), BeltramiFlow(strengths=(1.0, 0.7, 0.4))
    state = flow.start(vorticity=abc.vorticity)
    first = flow.ledger(state)
    for _ in range(5):
        state = flow.step(state, 0.1)
    last = flow.ledger(state)
    assert first["helicity"] == pytest.approx(2 * first["energy"], rel=1e-4)
    assert last["helicity"] / first["helicity"] == pytest.approx(np.exp(-0.1), rel=1e-3)


def test_a_knot_keeps_its_helicity():
    """A trefoil's is its writhe and more of the circulation squared; a ring has none."""
    knot = TorusKnot(turns=(2, 3), core=0.28)
    half = 20
    grid = Grid((2 * half,) * 3, 0.1, (-(half - 0.5) * 0.1,) * 3)
    flow = VortexFlow(grid=grid, domain="follow", kernel="M8'")
    state = flow.start(vorticity=knot.vorticity)
    first = flow.ledger(state)
    for _ in range(4):
        state = flow.step(state, flow.limit(state).dt)
    last = flow.ledger(state)
    assert abs(first["helicity"]) > 1.0
    assert last["helicity"] == pytest.approx(first["helicity"], rel=0.01)


@pytest.mark.parametrize("viscosity", [0.0, 0.05])
def test_energy_is_lost_to_viscosity_alone(viscosity):
    flow = VortexFlow(grid=period(24), viscosity=viscosity, kernel="L8,4", time_scheme="RK3")
    state = flow.start(vorticity=two_hands)
    rows = [flow.ledger(state)]
    for _ in range(6):
        state = flow.step(state, 0.05)
        rows.append(flow.ledger(state))
    lost = np.trapezoid([row["dissipation"] for row in rows], dx=0.05)
    assert rows[-1]["energy"] - rows[0]["energy"] == pytest.approx(
        -lost, abs=1e-4 * rows[0]["energy"]
    )
    if viscosity:
        assert lost > 0.02 * rows[0]["energy"]


def test_projected_vorticity_has_no_divergence():
    flow = VortexFlow(grid=period(16), viscosity=0.01, projection=1)
    end = advance(flow, flow.start(vorticity=two_hands), 0.1, 2)
    assert flow.ledger(end)["divergence"] < 1e-10


def test_projection_in_free_space_leaves_no_divergence_and_keeps_the_impulse():
    flow = VortexFlow(grid=cube(24, 3.0), projection=2)
    start = flow.start(vorticity=a_ring().vorticity)
    end = advance(flow, start, 0.1, 2)
    assert flow.ledger(end)["divergence"] < 1e-10  # 4e-4 without
    assert flow.ledger(end)["impulse_z"] == pytest.approx(flow.ledger(start)["impulse_z"], rel=1e-3)


# A step is a law


OPTIONS = [
    {},
    {"viscosity": 0.01, "stretching": "classical", "remeshing": "distorted"},
    {"viscosity": 0.01, "time_scheme": "RK3", "kernel": "L4,4", "domain": "follow"},
]


def arrays(state: State) -> dict[str, np.ndarray]:
    return {
        part.name: value
        for part in fields(state)
        if isinstance(value := getattr(state, part.name), np.ndarray)
    }


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_a_step_changes_nothing_and_repeats_to_the_bit_also_from_a_checkpoint(options, tmp_path):
    flow = VortexFlow(grid=cube(20, 3.0), freestream=(0.5, 0.0, 0.0), **options)
    state = advance(flow, flow.start(vorticity=a_ring().vorticity), 0.05, 1)
    before = {name: value.copy() for name, value in arrays(state).items()}
    path = Path(tmp_path) / "state.h5"
    checkpoint.save(path, state)
    once = advance(flow, state, 0.05, 2)
    again = advance(replace(flow), checkpoint.load(path, like=state), 0.05, 2)
    for name, value in before.items():
        np.testing.assert_array_equal(arrays(state)[name], value)
    for name, value in arrays(once).items():
        np.testing.assert_array_equal(arrays(again)[name], value)
    assert (once.gradient, once.speed) == (again.gradient, again.speed)


def test_one_thread_and_two_give_equal_bits():
    ends = []
    for threads in (1, 2):
        flow = VortexFlow(grid=cube(24, 3.0), viscosity=0.01, threads=threads)
        ends.append(advance(flow, flow.start(vorticity=a_ring().vorticity), 0.05, 2))
    np.testing.assert_array_equal(ends[0].vorticity, ends[1].vorticity)
    assert ends[0].gradient == ends[1].gradient


def test_single_precision_is_double_precision_to_its_digits():
    ends = []
    for dtype in ("float64", "float32"):
        flow = VortexFlow(grid=cube(24, 3.0), viscosity=0.01, dtype=dtype, domain="fixed")
        ends.append(advance(flow, flow.start(vorticity=a_ring().vorticity), 0.1, 3).vorticity)
    assert ends[1].dtype == np.float32
    assert apart(ends[1].astype(float), ends[0]) < 1e-5


def test_particles_remeshed_when_distorted_agree_with_those_remeshed_always():
    always = VortexFlow(grid=cube(24, 3.0), stretching="classical", domain="fixed")
    seldom = replace(always, remeshing="distorted", distortion=0.05)
    states = [always.start(vorticity=a_ring().vorticity)] * 2
    kept = []
    for _ in range(8):
        states = [flow.step(s, 0.02) for flow, s in zip((always, seldom), states, strict=True)]
        kept.append(states[1].strengths is not None)
    assert {True, False} <= set(kept), "some steps remesh and some do not"
    assert apart(states[1].vorticity, states[0].vorticity) < 5e-3


# Refusals


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"remeshing": "distorted"}, "classical"),
        ({"stretching": "other"}, "stretching must be one of"),
        ({"projection": -1}, "projection"),
        ({"freestream": (1.0, 0.0)}, "freestream"),
    ],
)
def test_what_makes_no_sense_in_space_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        VortexFlow(grid=cube(16, 2.0), **options)
