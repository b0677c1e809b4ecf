"""Periodic flows in space: their equations, invariants and spectral velocity."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmesh
from pmesh.vortex.exact import BeltramiFlow, TaylorGreenCube
from remesh.errors import InputError
from remesh.grid import Grid

BELTRAMI = BeltramiFlow(
    strengths=(1.0, 0.7, 0.4), length=3.0, viscosity=0.05, drift=(0.3, -0.2, 0.5)
)
FLOWS = {"beltrami": BELTRAMI, "taylor-green": TaylorGreenCube(length=3.0, speed=1.4)}
GRID = Grid(shape=(16,) * 3, spacing=3.0 / 16, boundary="periodic")
STEP = 1e-3


def slope(field, points, axis):
    """Fourth-order central difference of a field along one axis."""
    shift = np.zeros((3, 1))
    shift[axis] = STEP
    near = field(points + shift) - field(points - shift)
    far = field(points + 2 * shift) - field(points - 2 * shift)
    return (8 * near - far) / (12 * STEP)


@pytest.mark.parametrize("name", FLOWS)
def test_the_curl_of_the_velocity_is_the_vorticity(name):
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (3, 100))
    dx, dy, dz = (slope(FLOWS[name].velocity, points, axis) for axis in range(3))
    curl = np.stack([dy[2] - dz[1], dz[0] - dx[2], dx[1] - dy[0]])
    assert curl == pytest.approx(FLOWS[name].vorticity(points), abs=1e-9)
    assert dx[0] + dy[1] + dz[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", FLOWS)
def test_the_spectral_solver_finds_the_velocity(name):
    flow, points = FLOWS[name], GRID.points()
    drift = getattr(flow, "drift", (0.0, 0.0, 0.0))
    solved = pmesh.velocity(flow.vorticity(points), GRID, freestream=drift, threads=1)
    assert solved == pytest.approx(flow.velocity(points), abs=1e-12)


@pytest.mark.parametrize("name", FLOWS)
def test_energy_and_enstrophy_are_integrals_over_a_period(name):
    flow, points, volume = FLOWS[name], GRID.points(), GRID.spacing**3
    drift = np.reshape(getattr(flow, "drift", (0.0, 0.0, 0.0)), (3, 1, 1, 1))
    u, w = flow.velocity(points) - drift, flow.vorticity(points)
    energy, enstrophy, helicity = (np.sum(p) * volume for p in (0.5 * u * u, w * w, u * w))
    if name == "beltrami":
        assert flow.energy() == pytest.approx(energy)
        assert flow.enstrophy() == pytest.approx(enstrophy)
        assert flow.helicity() == pytest.approx(helicity)
    else:
        assert flow.energy == pytest.approx(energy)
        assert flow.enstrophy == pytest.approx(enstrophy)
        assert helicity == pytest.approx(0.0, abs=1e-12)


def test_the_beltrami_flow_obeys_the_navier_stokes_equations():
    """dw/dt + (u . grad) w = (w . grad) u + nu laplace(w), stretching and drift at work."""
    points, time = np.random.default_rng(0).uniform(-3.0, 3.0, (3, 100)), 0.4

    def w(x):
        return BELTRAMI.vorticity(x, time)

    def u(x):
        return BELTRAMI.velocity(x, time)

    rate = (BELTRAMI.vorticity(points, time + STEP) - BELTRAMI.vorticity(points, time - STEP)) / (
        2 * STEP
    )
    carried = sum(u(points)[i] * slope(w, points, i) for i in range(3))
    stretched = sum(w(points)[i] * slope(u, points, i) for i in range(3))
    bent = sum(slope(lambda x, i=i: slope(w, x, i), points, i) for i in range(3))
    assert rate + carried == pytest.approx(stretched + 0.05 * bent, abs=2e-5)
    assert np.abs(stretched).max() > 1.0
    assert np.abs(rate).max() > 1.0


def test_energy_decays_at_the_rate_that_the_enstrophy_says():
    rate = (BELTRAMI.energy(STEP) - BELTRAMI.energy(-STEP)) / (2 * STEP)
    assert rate == pytest.approx(-0.05 * BELTRAMI.enstrophy(), rel=1e-6)


def test_taylor_and_greens_start_is_that_of_the_published_runs():
    """Mean energy 1/8 and dissipation 3/4 nu in a cube of 2 pi with V = 1."""
    flow, volume = TaylorGreenCube(), (2.0 * math.pi) ** 3
    assert flow.energy / volume == pytest.approx(0.125)
    assert flow.enstrophy / volume == pytest.approx(0.75)
    with pytest.raises(InputError, match="time 0"):
        flow.vorticity(np.zeros((3, 4)), 1.0)
