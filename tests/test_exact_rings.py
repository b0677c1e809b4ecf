"""Vortex rings: closed forms, handedness, speed, and pairs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ive

from pmesh.vortex.exact import (
    GaussianRing,
    VortexRing,
    head_on,
    leapfrogging,
    oblique,
    thin_ring_speed,
)
from remesh.errors import InputError


def meridian(core, half=90):
    """Points (3, r, z) of a half plane about a ring of radius one, and their weights."""
    node, weight = np.polynomial.legendre.leggauss(half)
    low, high = max(0.0, 1.0 - 6.5 * core), 1.0 + 6.5 * core
    r = low + 0.5 * (high - low) * (node + 1.0)
    z = 6.5 * core * node
    plane = np.stack(np.meshgrid(r, z, indexing="ij"))
    points = np.stack([plane[0], np.zeros_like(plane[0]), plane[1]])
    return points, np.outer(weight * 0.5 * (high - low), weight * 6.5 * core)


def test_the_round_ring_is_the_smoothed_filament_in_closed_form():
    ring, a = VortexRing(core=0.3, circulation=2.0), 0.3
    points, _ = meridian(a)
    r, _, z = points
    given = ring.vorticity(points)
    closed = 4.0 / (math.sqrt(math.pi) * a**3) * ive(1, 2.0 * r / a**2)
    closed *= np.exp(-((r - 1.0) ** 2 + z**2) / a**2)
    assert given[1] == pytest.approx(closed, abs=1e-12 * closed.max())
    assert np.abs(given[[0, 2]]).max() < 1e-12 * closed.max()


@pytest.mark.parametrize("core", [0.2, 0.6])
def test_the_flux_through_a_half_plane_is_the_circulation(core):
    points, weight = meridian(core)
    filament = np.sum(VortexRing(core=core).vorticity(points)[1] * weight)
    gaussian = np.sum(GaussianRing(core=core).vorticity(points)[1] * weight)
    assert filament == pytest.approx(1.0 - math.exp(-1.0 / core**2), rel=1e-10)
    assert gaussian == pytest.approx(1.0, rel=1e-10)


def test_the_two_rings_agree_as_cores_get_thin():
    """They differ by sqrt(R/r) - 1, of first order in a/R."""
    gaps = []
    for core in (0.1, 0.05):
        points, _ = meridian(core)
        one = VortexRing(core=core).vorticity(points)[1]
        other = GaussianRing(core=core).vorticity(points)[1]
        gaps.append(np.abs(one - other).max() / other.max())
    assert gaps[0] / gaps[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.0, -3.0), (1.0, 0.0, 0.0), (1, 2, -2)])
def test_a_ring_of_positive_circulation_moves_along_its_axis(axis):
    along = np.asarray(axis) / np.linalg.norm(axis)
    for ring in (VortexRing(axis=axis), GaussianRing(axis=axis)):
        impulse = ring.impulse
        assert impulse / np.linalg.norm(impulse) == pytest.approx(along)
    points = along[:, None] + np.zeros((3, 1))
    axial = VortexRing(axis=axis, core=0.2).velocity(points)[:, 0]
    assert axial == pytest.approx(0.5 * 2.0**-1.5 * along, rel=1e-6)  # R^2/2/(R^2 + z^2)^(3/2)


def test_both_rings_turn_the_same_way():
    points = np.random.default_rng(2).normal(0.0, 0.7, (3, 300))
    one = VortexRing(core=0.4, axis=(1, 2, 2)).vorticity(points)
    other = GaussianRing(core=0.4, axis=(1, 2, 2)).vorticity(points)
    assert np.sum(one * other) > 0.95 * np.sqrt(np.sum(one**2) * np.sum(other**2))


@pytest.mark.parametrize("core", [0.1, 0.3, 0.7])
def test_the_impulse_of_the_gaussian_ring_is_its_integral(core):
    points, weight = meridian(core)
    whole = math.pi * np.sum(GaussianRing(core=core).vorticity(points)[1] * points[0] ** 2 * weight)
    assert GaussianRing(core=core).impulse[2] == pytest.approx(whole, rel=1e-10)


def test_the_published_impulse_of_a_thick_ring():
    """3.268152 Gamma R^2 at a/R = 1/3.523: the start of computed rings at Re = 7500."""
    assert GaussianRing(core=1.0 / 3.523).impulse[2] == pytest.approx(3.268152, rel=1e-5)


@pytest.mark.parametrize("core", [0.1, 0.4])
def test_the_centroid_moves_as_the_velocity_carries_the_vorticity(core):
    """dZ/dt = int (2 r z u_r + r^2 u_z) w dr dz / int r^2 w dr dz."""
    ring = VortexRing(core=core)
    points, weight = meridian(core, half=60)
    r, _, z = points
    w, u = ring.vorticity(points)[1], ring.velocity(points)
    carried = np.sum((2.0 * r * z * u[0] + r * r * u[2]) * w * weight)
    assert ring.centroid_speed == pytest.approx(carried / np.sum(r * r * w * weight), rel=1e-12)


def test_the_centroid_speed_of_thin_cores_is_the_thin_ring_law():
    """Saffman 1970; the rest falls as (a/R)^2 ln(R/a)."""
    rest = [
        VortexRing(core=a).centroid_speed / thin_ring_speed(1.0, a, 1.0) - 1 for a in (0.1, 0.01)
    ]
    assert abs(rest[0]) < 0.01
    assert abs(rest[1]) < 1.1e-4
    assert thin_ring_speed(1.0, 0.1, 4.0 * math.pi) == pytest.approx(math.log(80.0) - 0.5579658)


def test_a_ripple_displaces_the_core():
    ring = VortexRing(core=0.1, amplitude=0.1, modes=(2,), phases=(0.5 * math.pi,))
    reach = np.linspace(0.7, 1.3, 601)
    zero = np.zeros_like(reach)
    east = ring.vorticity(np.stack([reach, zero, zero]))[1]
    north = ring.vorticity(np.stack([zero, reach, zero]))[0]
    assert reach[np.argmax(east)] == pytest.approx(1.1, abs=0.006)
    assert reach[np.argmin(north)] == pytest.approx(0.9, abs=0.006)


def test_leapfrogging_rings_move_the_same_way():
    pair = leapfrogging(gap=0.8, circulation=2.0)
    assert pair.impulse == pytest.approx([0.0, 0.0, 4.0 * math.pi])
    heights = sorted(line.nodes[0, 2] for line in pair.filaments())
    assert heights == pytest.approx([-0.4, 0.4])


def test_head_on_rings_are_mirror_images_that_meet():
    pair = head_on(core=0.3, gap=1.0, amplitude=0.1, modes=(3,), phases=(0.4,))
    points = np.random.default_rng(5).normal(0.0, 0.8, (3, 200))
    flip = np.array([[1.0], [1.0], [-1.0]])
    u, w = pair.velocity(points), pair.vorticity(points)
    assert pair.velocity(flip * points) == pytest.approx(flip * u, abs=1e-13)
    assert pair.vorticity(flip * points) == pytest.approx(-flip * w, abs=1e-13)
    assert pair.impulse == pytest.approx([0.0] * 3, abs=1e-14)
    assert pair.velocity(np.array([[0.0], [0.0], [-0.5]]))[2, 0] > 0.0


def test_oblique_rings_are_mirror_images_that_meet():
    pair = oblique(angle=0.3)
    assert pair.impulse == pytest.approx([0.0, 0.0, 2.0 * math.pi * math.cos(0.3)])
    left, right = pair.parts
    assert left.center[0] < 0.0 < left.axis[0]
    assert right.axis[0] < 0.0 < right.center[0]
    points = np.random.default_rng(5).normal(0.0, 0.8, (3, 100))
    flip = np.array([[-1.0], [1.0], [1.0]])
    assert pair.velocity(flip * points) == pytest.approx(flip * pair.velocity(points), abs=1e-13)


@pytest.mark.parametrize(
    "bad",
    [
        {"core": 0.0},
        {"axis": (0.0, 0.0, 0.0)},
        {"center": (0.0, 0.0)},
        {"amplitude": 0.5, "modes": (1, 2)},
        {"modes": (1, 2), "phases": (0.0,)},
        {"amplitude": 0.1, "modes": (1.5,)},
        {"amplitude": 0.1},
    ],
)
def test_rings_that_cannot_be_are_refused(bad):
    with pytest.raises(InputError):
        VortexRing(**bad)


def test_questions_without_an_answer_are_refused():
    with pytest.raises(InputError, match="round"):
        _ = VortexRing(amplitude=0.1, modes=(2,)).centroid_speed
    with pytest.raises(InputError, match="time 0"):
        GaussianRing().vorticity(np.zeros((3, 4)), 2.0)
    with pytest.raises(InputError, match="overlap"):
        oblique(distance=1.0)
