"""Vortex tubes: solenoidal fields, invariants by quadrature, helicity by linking."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import erfc, j1

import pmesh
from pmesh.vortex.exact import TorusKnot, VortexRing, VortexTubes
from remesh.errors import InputError
from remesh.grid import Grid

RIPPLED = VortexRing(
    core=0.3,
    circulation=1.5,
    center=(0.1, -0.1, 0.2),
    axis=(1.0, 2.0, 2.0),
    amplitude=0.05,
    modes=(3, 5),
    phases=(0.3, 1.0),
)
TUBES = {"ring": RIPPLED, "knot": TorusKnot(core=0.25), "both": RIPPLED + TorusKnot(core=0.25)}
GRID = Grid(shape=(56,) * 3, spacing=5.6 / 56, origin=(-2.75,) * 3, boundary="unbounded")
STEP = 2e-3


def slope(field, points, axis):
    """Sixth-order central difference of a field along one axis."""
    shift = np.zeros((3, 1))
    shift[axis] = STEP
    pairs = [field(points + n * shift) - field(points - n * shift) for n in (1, 2, 3)]
    return (45 * pairs[0] - 9 * pairs[1] + pairs[2]) / (60 * STEP)


def near(tubes, count=60):
    """Points inside the cores."""
    random = np.random.default_rng(1)
    nodes = np.concatenate([line.nodes for line in tubes.filaments()])
    return nodes[random.integers(0, len(nodes), count)].T + random.normal(0, 0.15, (3, count))


@pytest.mark.parametrize("name", TUBES)
def test_the_vorticity_has_no_divergence(name):
    tubes, points = TUBES[name], near(TUBES[name])
    slopes = [slope(tubes.vorticity, points, axis) for axis in range(3)]
    assert np.abs(sum(slopes[i][i] for i in range(3))).max() < 1e-9 * np.abs(slopes).max()


@pytest.mark.parametrize("name", TUBES)
def test_the_curl_of_the_velocity_is_the_vorticity(name):
    tubes, points = TUBES[name], near(TUBES[name])
    dx, dy, dz = (slope(tubes.velocity, points, axis) for axis in range(3))
    curl = np.stack([dy[2] - dz[1], dz[0] - dx[2], dx[1] - dy[0]])
    given = tubes.vorticity(points)
    assert np.abs(curl - given).max() < 1e-9 * np.abs(given).max()


@pytest.mark.parametrize("name", TUBES)
def test_impulses_and_enstrophy_are_the_integrals_of_the_vorticity(name):
    tubes, points, volume = TUBES[name], GRID.points(), GRID.spacing**3
    vorticity = tubes.vorticity(points)
    impulse = 0.5 * np.cross(points, vorticity, axis=0).sum(axis=(1, 2, 3)) * volume
    square = np.sum(points**2, axis=0)
    angular = -0.5 * np.sum(square * vorticity, axis=(1, 2, 3)) * volume
    assert tubes.impulse == pytest.approx(impulse, abs=1e-6)
    assert tubes.angular_impulse == pytest.approx(angular, abs=1e-6)
    assert tubes.enstrophy == pytest.approx(np.sum(vorticity**2) * volume, rel=1e-6)


def test_helicity_is_the_integral_of_velocity_times_vorticity():
    knot = TUBES["knot"]
    grid = Grid(shape=(34,) * 3, spacing=4.4 / 34, origin=(-2.135,) * 3, boundary="unbounded")
    points = grid.points()
    vorticity = knot.vorticity(points)
    inside = np.abs(vorticity).max(axis=0) > 1e-9
    velocity = knot.velocity(points[:, inside])
    total = np.sum(velocity * vorticity[:, inside]) * grid.spacing**3
    assert knot.helicity == pytest.approx(total, rel=1e-5)


@pytest.mark.parametrize("core", [0.05, 0.1, 0.4])
def test_the_energy_of_a_round_ring_is_its_integral_over_waves(core):
    """E = pi/2 (R Gamma)^2 int J_1(k R)^2 erfc(k a/sqrt 2) dk, from |w^|^2/k^2."""
    k = np.linspace(0.0, 10.0 / core, 40_001)
    values = j1(k) ** 2 * erfc(k * core / math.sqrt(2.0))
    weights = np.ones_like(k)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    whole = 0.5 * math.pi * np.sum(weights * values) * (k[1] - k[0]) / 3.0
    assert VortexRing(core=core).energy == pytest.approx(whole, rel=1e-9)


def test_the_energy_of_thin_rings_follows_the_logarithm():
    """Gamma^2 R/2 [ln(8R/a) - 2.0579658], Saffman 1992, up to (a/R)^2 ln(R/a)."""
    thin = 0.5 * (math.log(8.0 / 0.01) - 0.5579658 - 1.5)
    assert VortexRing(core=0.01).energy == pytest.approx(thin, rel=1e-4)


def test_linked_rings_have_twice_the_product_of_their_circulations_as_helicity():
    link = VortexRing(circulation=2.0) + VortexRing(
        circulation=1.5, center=(1.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0)
    )
    apart = VortexRing() + VortexRing(center=(3.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    assert link.helicity == pytest.approx(2.0 * 2.0 * 1.5, rel=1e-12)
    assert apart.helicity == pytest.approx(0.0, abs=1e-12)


def test_the_spectral_solver_finds_the_velocity_of_the_tubes():
    ring = VortexRing(core=0.6, axis=(0.0, 1.0, 1.0))
    grid = Grid(shape=(64,) * 3, spacing=0.1, origin=(-3.15,) * 3, boundary="unbounded")
    points = grid.points()
    solved = pmesh.velocity(ring.vorticity(points), grid, threads=1)
    some = (slice(None), slice(8, 56, 7), slice(8, 56, 7), slice(8, 56, 7))
    exact = ring.velocity(points[some])
    assert np.abs(solved[some] - exact).max() < 1e-3 * np.abs(exact).max()


def test_no_node_within_reach_is_passed_over():
    """The compiled sum against all nodes at all points."""
    knot, points = TUBES["knot"], np.random.default_rng(7).uniform(-2.5, 2.5, (3, 300))
    (line,) = knot.filaments()
    away = points[:, :, None] - line.nodes.T[:, None, :]
    bell = np.exp(-np.sum(away**2, axis=0) / 0.25**2) / (math.sqrt(math.pi) * 0.25) ** 3
    assert knot.vorticity(points) == pytest.approx((bell @ line.elements).T, abs=1e-14)


def test_both_laws_of_distance_are_smooth_where_their_series_begin():
    ring = VortexRing(core=0.3)
    node = ring.filaments()[0].nodes[0]
    out = np.linspace(0.04, 0.06, 41) * 0.3
    line = ring.velocity(node[:, None] + np.array([[0.0], [0.0], [1.0]]) * out)
    assert np.abs(np.diff(line, n=4)).max() < 1e-9


def test_single_precision_stays_single():
    points = GRID.points()[:, ::8, ::8, ::8]
    single = RIPPLED.vorticity(points.astype(np.float32))
    assert single.dtype == np.float32
    assert single == pytest.approx(RIPPLED.vorticity(points), abs=1e-5)


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="shape"):
        RIPPLED.vorticity(np.zeros((2, 5)))
    with pytest.raises(InputError, match="time 0 only"):
        RIPPLED.velocity(np.zeros((3, 5)), 1.0)
    with pytest.raises(InputError, match="nodes"):
        _ = VortexRing(core=1e-5).energy
    with pytest.raises(InputError, match="tubes"):
        VortexTubes(parts=(1.0,))
