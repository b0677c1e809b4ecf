"""Integrals of a vorticity field in space."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.budget import Moments, dot, drag_along, energy, potential_energy
from pmesh.vortex.exact import BeltramiFlow, VortexRing
from remesh.grid import Grid

RING = VortexRing(radius=1.0, core=0.5, circulation=2.0, center=(0.1, -0.2, 0.3), axis=(1, 2, 2))
BOX = Grid((44, 44, 44), 0.125, (-2.7, -2.7, -2.5))
VORTICITY = RING.vorticity(BOX.points())


def test_the_impulse_of_a_ring_is_that_of_its_disk():
    moments = Moments(VORTICITY, BOX)
    np.testing.assert_allclose(moments.total, 0.0, atol=1e-6)
    np.testing.assert_allclose(moments.impulse, 2 * math.pi * np.array([1, 2, 2]) / 3, rtol=1e-5)
    np.testing.assert_allclose(moments.impulse, RING.impulse, rtol=1e-5)


def test_the_angular_impulse_is_that_of_the_impulse_at_the_centre():
    """A ring has none of its own: it is centre cross impulse."""
    expected = np.cross(RING.center, RING.impulse)
    np.testing.assert_allclose(Moments(VORTICITY, BOX).angular_impulse, expected, rtol=2e-5)


def test_levers_along_periodic_axes_are_not_numbers():
    grid = Grid((8, 8, 8), 1.0, None, ("periodic", "unbounded", "unbounded"))
    found = Moments(np.ones((3, 8, 8, 8)), grid)
    assert math.isnan(found.impulse[1])
    assert not math.isnan(found.impulse[0])


def test_the_energy_of_a_ring_is_lambs_integral_and_that_of_its_stream_function():
    solver = VelocitySolver(BOX, order=10)
    velocity, stream = solver.velocity(VORTICITY), solver.stream(VORTICITY)
    assert energy(velocity, VORTICITY, BOX) == pytest.approx(RING.energy, rel=1e-3)
    assert potential_energy(stream, VORTICITY, BOX) == pytest.approx(RING.energy, rel=1e-3)


def test_the_energy_and_helicity_of_a_periodic_flow_are_sums_over_the_box():
    flow = BeltramiFlow(strengths=(1.0, 0.7, 0.4))
    grid = Grid((16, 16, 16), math.pi / 8, None, "periodic")
    velocity, vorticity = (law(grid.points()) for law in (flow.velocity, flow.vorticity))
    held = energy(velocity, vorticity, grid)
    assert held == pytest.approx(flow.energy(0.0), rel=1e-12)
    assert dot(velocity, vorticity) * grid.cell_volume == pytest.approx(flow.helicity(0.0))
    stream = VelocitySolver(grid).stream(vorticity)
    assert potential_energy(stream, vorticity, grid) == pytest.approx(held, rel=1e-12)


def test_the_energy_with_mixed_axes_is_left_to_the_stream_function():
    grid = Grid((8, 8, 8), 1.0, None, ("periodic", "unbounded", "unbounded"))
    assert math.isnan(energy(np.ones((3, 8, 8, 8)), np.ones((3, 8, 8, 8)), grid))


def test_a_stream_carries_angular_impulse_at_the_rate_stream_cross_impulse():
    """Moved by U t, a ring's angular impulse has gained U t cross I."""
    stream = np.array([0.3, -0.2, 0.5])
    linear, turning = drag_along(VORTICITY, Moments(VORTICITY, BOX), stream, None, BOX)
    later = VortexRing(radius=1.0, core=0.5, circulation=2.0, axis=(1, 2, 2),
                       center=tuple(np.array(RING.center) + 0.1 * stream))  # fmt: skip
    moved = later.vorticity(BOX.points())
    gained = Moments(moved, BOX).angular_impulse - Moments(VORTICITY, BOX).angular_impulse
    np.testing.assert_allclose(turning, gained / 0.1, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(linear, 0.0, atol=1e-6)


def test_an_outer_velocity_on_the_nodes_counts_as_a_stream_of_its_size():
    stream = np.array([0.3, -0.2, 0.5])
    field = np.ones_like(VORTICITY) * stream[:, None, None, None]
    moments = Moments(VORTICITY, BOX)
    known = drag_along(VORTICITY, moments, stream, None, BOX)
    found = drag_along(VORTICITY, moments, np.zeros(3), field, BOX)
    np.testing.assert_allclose(found, known, atol=1e-4)
