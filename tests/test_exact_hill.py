"""Hill's vortex: its fields, its travel, its invariants, its smoothed edge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import HillVortex
from remesh.errors import InputError

VORTEX = HillVortex(radius=1.3, speed=0.8, center=(0.2, -0.1, 0.3), axis=(1.0, -2.0, 2.0))
AXIS = np.array([1.0, -2.0, 2.0]) / 3.0
STEP = 1e-3


def slope(field, points, axis):
    """Fourth-order central difference of a field along one axis."""
    shift = np.zeros((3, 1))
    shift[axis] = STEP
    near = field(points + shift) - field(points - shift)
    far = field(points + 2 * shift) - field(points - 2 * shift)
    return (8 * near - far) / (12 * STEP)


def scattered():
    """Points inside and outside, off the edge."""
    points = np.random.default_rng(4).normal(0.0, 1.0, (3, 400))
    reach = np.linalg.norm(points - np.array(VORTEX.center)[:, None], axis=0)
    return points[:, np.abs(reach - 1.3) > 0.01]


def ball(radius, low=0.0, count=40):
    """Points (3, n) in a shell about the origin, and their weights, by Gauss's rule."""
    node, weight = np.polynomial.legendre.leggauss(count)
    s = low + 0.5 * (radius - low) * (node + 1.0)
    s, c, angle = np.meshgrid(s, node, np.arange(8) * math.pi / 4.0, indexing="ij")
    across = s * np.sqrt(1.0 - c * c)
    points = np.stack([across * np.cos(angle), across * np.sin(angle), s * c])
    weights = np.einsum("i,j->ij", weight * 0.5 * (radius - low), weight)[:, :, None] * s * s
    return points, weights * math.pi / 4.0


def test_the_curl_of_the_velocity_is_the_vorticity():
    points = scattered()
    dx, dy, dz = (slope(VORTEX.velocity, points, axis) for axis in range(3))
    curl = np.stack([dy[2] - dz[1], dz[0] - dx[2], dx[1] - dy[0]])
    assert curl == pytest.approx(VORTEX.vorticity(points), abs=1e-9)
    assert dx[0] + dy[1] + dz[2] == pytest.approx(0.0, abs=1e-9)


def test_the_velocity_is_continuous_and_the_sphere_moves_as_one():
    """On the edge the normal velocity is that of a sphere that moves at U along the axis."""
    normal = np.random.default_rng(1).normal(size=(3, 50))
    normal /= np.linalg.norm(normal, axis=0)
    edge = np.array(VORTEX.center)[:, None] + 1.3 * normal
    inner = VORTEX.velocity(edge - 1e-12 * normal)
    assert inner == pytest.approx(VORTEX.velocity(edge + 1e-12 * normal), abs=1e-10)
    assert np.sum(inner * normal, axis=0) == pytest.approx(0.8 * AXIS @ normal)


def test_the_fluid_at_the_centre_moves_ahead_at_five_halves_of_the_speed():
    center = np.array(VORTEX.center)[:, None]
    assert VORTEX.velocity(center)[:, 0] == pytest.approx(2.5 * 0.8 * AXIS)
    moved = center + 3.0 * 0.8 * AXIS[:, None]
    assert VORTEX.velocity(moved, 3.0)[:, 0] == pytest.approx(2.5 * 0.8 * AXIS)


def test_the_vortex_obeys_eulers_equation():
    """dw/dt + (u . grad) w = (w . grad) u inside, the travel included."""
    points = scattered()
    reach = np.linalg.norm(points - np.array(VORTEX.center)[:, None], axis=0)
    points = points[:, reach < 1.2]
    w, u = VORTEX.vorticity(points), VORTEX.velocity(points)
    rate = (VORTEX.vorticity(points, STEP) - VORTEX.vorticity(points, -STEP)) / (2 * STEP)
    carried = sum(u[i] * slope(VORTEX.vorticity, points, i) for i in range(3))
    stretched = sum(w[i] * slope(VORTEX.velocity, points, i) for i in range(3))
    assert rate + carried == pytest.approx(stretched, abs=1e-8)


def test_invariants_are_integrals():
    vortex = HillVortex(radius=1.3, speed=0.8)
    points, weights = ball(1.3)
    w, u = vortex.vorticity(points), vortex.velocity(points)
    impulse = 0.5 * np.sum(np.cross(points, w, axis=0) * weights, axis=(1, 2, 3))
    assert vortex.impulse == pytest.approx(impulse, abs=1e-12)
    assert vortex.enstrophy == pytest.approx(np.sum(w * w * weights))
    # of a fluid at rest far away, 1/2 int u^2 = int u . (x cross w): Lamb, art. 153
    lamb = np.sum(u * np.cross(points, w, axis=0) * weights)
    assert vortex.energy == pytest.approx(lamb)
    outer, shell = ball(200.0, low=1.3, count=300)
    whole = 0.5 * (np.sum(u * u * weights) + np.sum(vortex.velocity(outer) ** 2 * shell))
    assert vortex.energy == pytest.approx(whole, rel=1e-5)


def test_the_circulation_is_the_flux_through_a_half_plane():
    node, weight = np.polynomial.legendre.leggauss(40)
    r, angle = 0.5 * 1.3 * (node + 1.0), 0.5 * math.pi * node
    points = np.stack([np.outer(r, np.cos(angle)), np.zeros((40, 40)), np.outer(r, np.sin(angle))])
    flux = HillVortex(radius=1.3, speed=0.8).vorticity(points)[1]
    area = np.outer(weight * 0.65 * r, weight * 0.5 * math.pi)
    assert HillVortex(radius=1.3, speed=0.8).circulation == pytest.approx(np.sum(flux * area))


@pytest.mark.parametrize("width", [0.2, 0.5])
def test_a_smoothed_edge_is_the_gaussian_average_of_the_sharp_one(width):
    smooth = HillVortex(width=width)
    for place in ([0.0, 0.3, 0.2], [0.9, 0.0, 0.3], [1e-4, 0.0, 0.0], [0.0, -1.1, 0.2]):
        given = smooth.vorticity(np.reshape(place, (3, 1)))[:, 0]
        assert given == pytest.approx(averaged(place, width), abs=2e-6)


def averaged(place, width):
    """Sharp vorticity times the Gaussian, by Gauss's rule over the sphere with many angles."""
    node, weight = np.polynomial.legendre.leggauss(80)
    angles = np.arange(64) * math.pi / 32.0
    s, c, angle = np.meshgrid(0.5 * (node + 1.0), node, angles, indexing="ij")
    across = s * np.sqrt(1.0 - c * c)
    points = np.stack([across * np.cos(angle), across * np.sin(angle), s * c])
    weights = np.einsum("i,j->ij", 0.5 * weight, weight)[:, :, None] * s * s * math.pi / 32.0
    distance = np.sum((points - np.reshape(place, (3, 1, 1, 1))) ** 2, axis=0)
    bell = np.exp(-distance / width**2) / (math.sqrt(math.pi) * width) ** 3
    return np.sum(HillVortex().vorticity(points) * bell * weights, axis=(1, 2, 3))


def test_a_smoothed_edge_keeps_the_impulse_and_stays_solenoidal():
    smooth = HillVortex(width=0.3)
    points, weights = ball(3.0, count=60)
    whole = np.cross(points, smooth.vorticity(points), axis=0) * weights
    assert 0.5 * whole.sum(axis=(1, 2, 3)) == pytest.approx(smooth.impulse, abs=1e-9)
    some = np.random.default_rng(3).normal(0.0, 0.7, (3, 200))
    divergence = sum(slope(smooth.vorticity, some, i)[i] for i in range(3))
    assert np.abs(divergence).max() < 1e-7


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="half the radius"):
        HillVortex(width=0.6)
    with pytest.raises(InputError, match="sharp edge"):
        HillVortex(width=0.1).velocity(np.zeros((3, 4)))
