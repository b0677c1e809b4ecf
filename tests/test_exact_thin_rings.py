"""Thin coaxial rings: filament laws, invariants of the motion, leapfrogging."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import CoaxialRings, thin_ring_speed
from pmesh.vortex.exact.thin_rings import UNIFORM_CORE, filament_stream, filament_velocity
from remesh.errors import InputError

THREE = CoaxialRings(
    radii=(1.0, 1.3, 0.7),
    heights=(0.0, 0.6, 1.1),
    circulations=(1.0, 0.8, 1.2),
    cores=(0.1, 0.05, 0.08),
)


@pytest.mark.parametrize("place", [(0.4, 0.3), (1.5, -0.2), (1.0, 0.5), (0.05, -1.0)])
def test_the_filament_induces_what_biot_and_savart_say(place):
    r, z = place
    angle = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
    nodes = 1.2 * np.stack([np.cos(angle), np.sin(angle), 0 * angle])
    tangent = 1.2 * np.stack([-np.sin(angle), np.cos(angle), 0 * angle])
    away = np.array([r, 0.0, z])[:, None] - nodes
    pull = np.cross(tangent, away, axis=0) / np.sum(away**2, axis=0) ** 1.5
    direct = pull.sum(axis=1) * 2.0 * math.pi / 400 / (4.0 * math.pi)
    out, along = filament_velocity(np.float64(r), np.float64(z), np.float64(1.2))
    assert (out, along) == pytest.approx((direct[0], direct[2]), rel=1e-12)


def test_the_stream_function_gives_the_velocity():
    r, z, h = np.array([0.4, 1.5, 1.0]), np.array([0.3, -0.2, 0.5]), 1e-4
    ring = np.full(3, 1.2)
    out, along = filament_velocity(r, z, ring)
    dr = (filament_stream(r + h, z, ring) - filament_stream(r - h, z, ring)) / (2 * h)
    dz = (filament_stream(r, z + h, ring) - filament_stream(r, z - h, ring)) / (2 * h)
    assert along == pytest.approx(dr / r, rel=1e-6)
    assert out == pytest.approx(-dz / r, rel=1e-6)


def test_the_motion_is_hamiltonian():
    radii, heights = np.array(THREE.radii), np.array(THREE.heights)
    strength, h = np.array(THREE.circulations), 1e-5
    out, along = THREE.rates(radii, heights)
    for i in range(3):
        shift = h * np.eye(3)[i]
        up = THREE.energy(radii + shift, heights) - THREE.energy(radii - shift, heights)
        side = THREE.energy(radii, heights + shift) - THREE.energy(radii, heights - shift)
        mass = 2.0 * math.pi * strength[i] * radii[i]
        assert mass * along[i] == pytest.approx(up / (2 * h), rel=1e-7)
        assert mass * out[i] == pytest.approx(-side / (2 * h), rel=1e-7)


def test_impulse_and_energy_are_kept():
    path = THREE.trajectory(np.linspace(0.0, 20.0, 41))
    impulse = [THREE.impulse(radii) for radii in path.radii.T]
    energy = [THREE.energy(*pair) for pair in zip(path.radii.T, path.heights.T, strict=True)]
    assert impulse == pytest.approx(np.full(41, THREE.impulse()), rel=1e-8)
    assert energy == pytest.approx(np.full(41, THREE.energy()), rel=1e-8)
    assert np.ptp(path.radii[0]) > 0.1  # they do play with each other


def test_one_ring_travels_at_the_speed_of_thin_rings():
    one = CoaxialRings(
        radii=(2.0,), heights=(1.0,), circulations=(3.0,), cores=(0.2,), constant=UNIFORM_CORE
    )
    path = one.trajectory(np.array([0.0, 5.0]))
    speed = thin_ring_speed(2.0, 0.2, 3.0, UNIFORM_CORE)
    assert path.heights[0, 1] == pytest.approx(1.0 + 5.0 * speed)
    assert speed == pytest.approx(3.0 / (8.0 * math.pi) * (math.log(80.0) - 0.25))


@pytest.mark.parametrize("strengths", [(1.0, 1.0), (1.0, 3.0)])
def test_large_rings_leapfrog_as_point_vortices_turn(strengths):
    """4 pi^2 d^2/(Gamma_1 + Gamma_2), reached as (d/R)^2 times a line in ln(R/d)."""
    point, sizes = 4.0 * math.pi**2 / sum(strengths), np.array([30.0, 100.0, 300.0])
    pairs = [CoaxialRings(radii=(size, size), circulations=strengths) for size in sizes]
    rests = np.array([pair.leapfrog_period(tolerance=1e-12) / point - 1.0 for pair in pairs])
    assert abs(rests[-1]) < 1e-4
    slopes = np.diff(rests * sizes**2) / np.diff(np.log(sizes))
    assert slopes[1] == pytest.approx(slopes[0], rel=0.05)


def test_after_a_period_the_rings_stand_as_before():
    pair = CoaxialRings()
    period = pair.leapfrog_period()
    path = pair.trajectory(np.array([0.0, 0.5 * period, period]))
    assert path.radii[:, 2] == pytest.approx(path.radii[:, 0], rel=1e-7)
    assert np.ptp(path.heights[:, 2]) == pytest.approx(1.0, rel=1e-7)
    assert path.heights[0, 1] - path.heights[1, 1] == pytest.approx(1.0, rel=1e-7)  # changed places
    assert path.heights[:, 2].mean() > 1.0


def test_a_period_does_not_depend_on_where_it_starts():
    pair = CoaxialRings()
    path = pair.trajectory(np.array([0.0, 2.0]))
    cores = 0.1 * path.radii[:, 1] ** -0.5
    later = CoaxialRings(
        radii=tuple(path.radii[:, 1]), heights=tuple(path.heights[:, 1]), cores=tuple(cores)
    )
    assert later.leapfrog_period() == pytest.approx(pair.leapfrog_period(), rel=1e-7)


def test_rings_far_apart_never_come_back():
    assert CoaxialRings(radii=(0.5, 1.0), heights=(3.0, -3.0)).leapfrog_period() == math.inf


@pytest.mark.parametrize(
    "bad",
    [{"radii": (1.0,)}, {"cores": (0.1, 0.0)}, {"heights": (0.5, 0.5)}, {"radii": (1.0, math.nan)}],
)
def test_rings_that_cannot_be_are_refused(bad):
    with pytest.raises(InputError):
        CoaxialRings(**bad)


def test_three_rings_have_no_leapfrogging_period():
    with pytest.raises(InputError, match="two rings"):
        THREE.leapfrog_period()
