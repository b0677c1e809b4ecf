"""Exact flows: their equations, their invariants and the published figures they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import (
    EllipticVortex,
    KirchhoffEllipse,
    LambOseen,
    PerlmanPatch,
    TaylorGreen,
)
from remesh.errors import InputError
from remesh.grid import Grid

FLOWS = {
    "taylor-green": TaylorGreen(viscosity=0.02, drift=(0.3, -0.2)),
    "lamb-oseen": LambOseen(circulation=1.5, core=0.3, viscosity=0.01, drift=(0.4, 0.1)),
    "perlman": PerlmanPatch(center=(0.1, -0.2), drift=(0.2, 0.5)),
    "kirchhoff": KirchhoffEllipse(axes=(0.9, 0.5), strength=2.0),
}
STEP = 1e-4


def stencil(field, points, axis):
    """Fourth-order central difference of a field along one axis."""
    shift = np.zeros((2,) + (1,) * (points.ndim - 1))
    shift[axis] = STEP
    near = field(points + shift) - field(points - shift)
    far = field(points + 2 * shift) - field(points - 2 * shift)
    return (8 * near - far) / (12 * STEP)


def scattered(flow, count=200):
    """Points spread over the flow, away from the patch's edge where its vorticity jumps."""
    points = np.random.default_rng(3).uniform(-1.3, 1.3, (2, count))
    if isinstance(flow, KirchhoffEllipse):
        level = (points[0] / flow.axes[0]) ** 2 + (points[1] / flow.axes[1]) ** 2
        points = points[:, np.abs(level - 1.0) > 0.05]
    return points


@pytest.mark.parametrize("name", FLOWS)
def test_the_curl_of_the_velocity_is_the_vorticity(name):
    flow = FLOWS[name]
    points = scattered(flow)
    time = 0.0 if name == "kirchhoff" else 0.7
    curl = stencil(lambda x: flow.velocity(x, time)[1], points, 0)
    curl -= stencil(lambda x: flow.velocity(x, time)[0], points, 1)
    assert curl == pytest.approx(flow.vorticity(points, time), abs=2e-7)


@pytest.mark.parametrize("name", FLOWS)
def test_the_velocity_has_no_divergence(name):
    flow = FLOWS[name]
    points = scattered(flow)
    divergence = sum(stencil(lambda x, i=i: flow.velocity(x)[i], points, i) for i in (0, 1))
    assert np.abs(divergence).max() < 2e-7


@pytest.mark.parametrize("name", ["taylor-green", "lamb-oseen", "perlman"])
def test_vorticity_obeys_the_transport_equation(name):
    flow = FLOWS[name]
    points, time = scattered(flow), 0.5
    nu = getattr(flow, "viscosity", 0.0)
    rate = (flow.vorticity(points, time + STEP) - flow.vorticity(points, time - STEP)) / (2 * STEP)
    gradient = np.stack([stencil(lambda x: flow.vorticity(x, time), points, i) for i in (0, 1)])
    h = 1e-3
    east, north = np.array([[h], [0.0]]), np.array([[0.0], [h]])
    laplacian = (
        sum(flow.vorticity(points + s, time) for s in (east, -east, north, -north))
        - 4 * flow.vorticity(points, time)
    ) / h**2
    left = rate + np.sum(flow.velocity(points, time) * gradient, axis=0)
    assert left == pytest.approx(nu * laplacian, abs=2e-4)


def test_a_turned_kirchhoff_ellipse_is_carried_by_its_own_velocity():
    flow = KirchhoffEllipse(axes=(2.0, 1.0), strength=1.0)
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    edge = np.stack([2.0 * np.cos(angle), np.sin(angle)])
    normal = np.stack([np.cos(angle) / 2.0, np.sin(angle)])
    turning = flow.angular_velocity * np.stack([-edge[1], edge[0]])
    assert flow.angular_velocity == pytest.approx(2.0 / 9.0, rel=1e-14)  # w0 ab/(a+b)^2
    assert np.sum((flow.velocity(edge) - turning) * normal, axis=0) == pytest.approx(0, abs=1e-12)
    quarter = 0.5 * np.pi / flow.angular_velocity
    assert flow.vorticity(np.array([[0.0, 1.9], [1.9, 0.0]]), quarter).tolist() == [1.0, 0.0]


def test_kirchhoff_velocity_is_continuous_across_the_edge():
    flow = KirchhoffEllipse(axes=(0.4, 1.1), strength=3.0)  # taller than wide as well
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    edge = np.stack([0.4 * np.cos(angle), 1.1 * np.sin(angle)])
    jump = flow.velocity(edge * (1 + 1e-9)) - flow.velocity(edge * (1 - 1e-9))
    assert np.abs(jump).max() < 1e-7


@pytest.mark.parametrize("name", ["lamb-oseen", "perlman"])
def test_positive_vorticity_turns_counterclockwise(name):
    flow = type(FLOWS[name])()
    east = flow.velocity(np.array([[0.5], [0.0]]))
    assert east[1, 0] > 0
    assert east[0, 0] == pytest.approx(0.0, abs=1e-15)


def test_lamb_oseen_peak_is_where_the_reference_says():
    """r_max = 2.2418128 sqrt(nu t), u_max = 0.05078417 Gamma/sqrt(nu t); core = sqrt(4 nu t)."""
    flow = LambOseen(core=2.0)  # nu t = 1
    assert flow.peak_radius() == pytest.approx(2.2418128, rel=3e-8)
    assert flow.peak_speed() == pytest.approx(0.05078417, rel=1e-7)
    radius = np.linspace(2.0, 2.5, 2001)
    speed = flow.velocity(np.stack([radius, 0 * radius]))[1]
    assert radius[speed.argmax()] == pytest.approx(2.2418128, abs=3e-4)
    assert speed.max() == pytest.approx(flow.peak_speed(), rel=1e-7)


def test_lamb_oseen_moments_are_those_of_the_field():
    flow = LambOseen(circulation=1.3, core=0.2, viscosity=0.01)
    grid = Grid(shape=(241, 241), spacing=0.0125, origin=(-1.5, -1.5))
    points, time = grid.points(), 0.4
    w = flow.vorticity(points, time)
    assert w.sum() * grid.cell_volume == pytest.approx(flow.circulation, rel=1e-10)
    moment = np.sum(w * np.sum(points**2, axis=0)) * grid.cell_volume
    assert moment == pytest.approx(flow.angular_moment(time), rel=1e-10)
    assert np.sum(w * w) * grid.cell_volume == pytest.approx(flow.enstrophy(time), rel=1e-10)
    rate = (flow.angular_moment(2.0) - flow.angular_moment(1.0)) / flow.circulation
    assert rate == pytest.approx(4 * 0.01, rel=1e-12)


def test_taylor_green_decays_as_the_reference_says():
    """exp(-8 pi^2 t/Re) in a unit box."""
    flow = TaylorGreen(viscosity=1 / 100)
    assert flow.decay(0.5) == pytest.approx(math.exp(-8 * math.pi**2 * 0.5 / 100), rel=1e-14)
    grid = Grid(shape=(32, 32), spacing=1 / 32, boundary="periodic")
    u, w = flow.velocity(grid.points(), 0.5), flow.vorticity(grid.points(), 0.5)
    assert 0.5 * np.sum(u * u) * grid.cell_volume == pytest.approx(flow.energy(0.5), rel=1e-12)
    assert np.sum(w * w) * grid.cell_volume == pytest.approx(flow.enstrophy(0.5), rel=1e-12)


def test_perlman_patch_equals_the_published_form():
    """u_theta = (1 - (1 - r^2)^8)/(16 r), Gamma = pi/8, peak 0.1175201 at r = 0.4010478."""
    flow = PerlmanPatch()
    radius = np.array([0.05, 0.3, 0.4010478, 0.75, 1.0, 1.4])
    speed = flow.velocity(np.stack([radius, 0 * radius]))[1]
    cited = [0.024782340338858, 0.110364056746843, 0.1175201, 0.083221481472719, 0.0625]
    assert speed == pytest.approx([*cited, 0.0446428571428571], rel=5e-7)
    assert flow.circulation == pytest.approx(math.pi / 8, rel=1e-15)


def test_perlman_invariants_are_those_of_the_field():
    flow = PerlmanPatch(p=3, strength=2.0, radius=0.7)
    grid = Grid(shape=(401, 401), spacing=0.004, origin=(-0.8, -0.8))
    points = grid.points()
    w = flow.vorticity(points)
    assert w.sum() * grid.cell_volume == pytest.approx(flow.circulation, rel=1e-8)
    moment = np.sum(w * np.sum(points**2, axis=0)) * grid.cell_volume
    assert moment == pytest.approx(flow.angular_moment, rel=1e-7)
    assert np.sum(w * w) * grid.cell_volume == pytest.approx(flow.enstrophy, rel=1e-8)


@pytest.mark.parametrize(
    ("kind", "circulation", "enstrophy", "moments", "rel"),
    [
        ("I", 5.5298756, 73.2513985, (0.08250878, 0.33003510), 1e-7),
        ("II", 13.4041287, 214.4660585, (0.4021239, 1.6084954), 2e-7),
    ],
)
def test_elliptic_vortex_has_the_invariants_of_koumoutsakos_1997(
    kind, circulation, enstrophy, moments, rel
):
    flow = EllipticVortex(kind=kind)
    assert flow.circulation == pytest.approx(circulation, rel=rel)
    assert flow.second_moments == pytest.approx(moments, rel=rel)
    assert flow.angular_moment == pytest.approx(sum(moments), rel=rel)
    grid = Grid(shape=(361, 681), spacing=0.0025, origin=(-0.45, -0.85))
    w = flow.vorticity(grid.points())
    assert np.sum(w * w) * grid.cell_volume == pytest.approx(enstrophy, rel=2e-5)


def test_elliptic_vortex_refuses_later_times():
    with pytest.raises(InputError, match="at time 0 only"):
        EllipticVortex().vorticity(np.zeros((2, 3)), time=1.0)


@pytest.mark.parametrize("name", FLOWS)
def test_single_precision_in_gives_single_precision_out(name):
    flow, points = FLOWS[name], scattered(FLOWS[name])
    for law in (flow.vorticity, flow.velocity):
        single, double = law(points.astype(np.float32), 0.3), law(points, 0.3)
        assert single.dtype == np.float32
        assert double.dtype == np.float64
        if name != "kirchhoff":  # its edge moves across points by round-off
            assert single == pytest.approx(double, abs=2e-5)


@pytest.mark.parametrize("name", FLOWS)
def test_points_that_are_not_plane_are_refused(name):
    with pytest.raises(InputError, match=r"must have shape \(2, ...\), got \(5, 2\)"):
        FLOWS[name].vorticity(np.zeros((5, 2)))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: TaylorGreen(viscosity=-1.0), "viscosity must be not negative, got -1.0"),
        (lambda: TaylorGreen(length=0.0), "length must be positive"),
        (lambda: LambOseen(core=math.nan), "core must be positive, got nan"),
        (lambda: PerlmanPatch(p=-1), "p must be not negative"),
        (lambda: EllipticVortex(kind="III"), "kind must be 'I' or 'II'"),
        (lambda: EllipticVortex(axes=(0.4, -0.8)), "two positive half axes"),
        (lambda: KirchhoffEllipse(axes=(1.0,)), "two positive half axes"),
    ],
)
def test_parameters_out_of_range_are_refused(make, said):
    with pytest.raises(InputError, match=said):
        make()
