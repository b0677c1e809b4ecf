"""The strained ring: its equation, its invariants, and where the impulse law ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import StrainedRing
from remesh.errors import InputError

SYMMETRIC = ((0.5, 0.2, -0.1), (0.2, -0.9, 0.3), (-0.1, 0.3, 0.4))
TURNING = ((0.5, 0.6, -0.3), (-0.2, -0.9, 0.1), (0.3, 0.5, 0.4))
RINGS = {
    name: StrainedRing(
        strain=strain,
        amplitude=(0.3, -0.5, 1.0),
        width=0.8,
        center=(0.2, 0.1, -0.3),
        viscosity=nu,
    )
    for name, strain, nu in (
        ("inviscid", SYMMETRIC, 0.0),
        ("viscous", SYMMETRIC, 0.1),
        ("turning", TURNING, 0.1),
    )
}
STEP = 1e-3


def slope(field, points, axis, step=STEP):
    """Fourth-order central difference of a field along one axis."""
    shift = np.zeros((3, 1))
    shift[axis] = step
    near = field(points + shift) - field(points - shift)
    far = field(points + 2 * shift) - field(points - 2 * shift)
    return (8 * near - far) / (12 * step)


def box(ring, time, count=48):
    """Points (3, n, n, n) of a box that follows the Gaussian, and the volume of each."""
    axes, vectors = np.linalg.eigh(ring.shape(time))
    line = np.linspace(-6.0, 6.0, count)
    local = np.stack(np.meshgrid(line, line, line, indexing="ij"))
    local *= np.sqrt(axes)[:, None, None, None]
    center = ring.deformation(time) @ np.array(ring.center)
    points = np.tensordot(vectors, local, axes=1) + center[:, None, None, None]
    return points, (line[1] - line[0]) ** 3 * math.sqrt(np.prod(axes))


@pytest.mark.parametrize("name", RINGS)
def test_the_vorticity_obeys_the_linear_equation(name):
    ring, time = RINGS[name], 0.7
    points = np.random.default_rng(0).normal(0.0, 0.7, (3, 100))

    def w(x):
        return ring.vorticity(x, time)

    rate = (ring.vorticity(points, time + STEP) - ring.vorticity(points, time - STEP)) / (2 * STEP)
    base = ring.base_velocity(points)
    carried = sum(base[i] * slope(w, points, i) for i in range(3))
    stretched = np.array(ring.strain) @ w(points)
    bent = sum(slope(lambda x, i=i: slope(w, x, i), points, i) for i in range(3))
    assert rate + carried == pytest.approx(stretched + ring.viscosity * bent, abs=1e-5)
    assert sum(slope(w, points, i)[i] for i in range(3)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("time", [0.0, 1.5])
def test_impulse_and_enstrophy_are_integrals(name, time):
    ring = RINGS[name]
    points, volume = box(ring, time)
    w = ring.vorticity(points, time)
    impulse = 0.5 * np.cross(points, w, axis=0).sum(axis=(1, 2, 3)) * volume
    assert ring.impulse(time) == pytest.approx(impulse, abs=1e-9)
    assert ring.enstrophy(time) == pytest.approx(np.sum(w * w) * volume, rel=1e-9)


@pytest.mark.parametrize("name", RINGS)
def test_the_impulse_follows_a_covector(name):
    """dI/dt = -A^T I, whatever the viscosity."""
    ring, time = RINGS[name], 0.9
    rate = (ring.impulse(time + STEP) - ring.impulse(time - STEP)) / (2 * STEP)
    assert rate == pytest.approx(-np.array(ring.strain).T @ ring.impulse(time), abs=1e-5)


def test_the_start_has_the_constants_of_the_sphere():
    ring = StrainedRing(amplitude=(0.0, 0.0, 2.0), width=0.5)
    assert ring.impulse() == pytest.approx([0.0, 0.0, math.pi**1.5 * 0.125 * 2.0])
    assert ring.energy() == pytest.approx((2.0 * math.pi) ** 1.5 / 24.0 * 0.125 * 4.0)
    assert ring.enstrophy() == pytest.approx((2.0 * math.pi) ** 1.5 / 4.0 * 0.5 * 4.0)


@pytest.mark.parametrize("name", RINGS)
def test_the_energy_is_the_integral_over_waves(name):
    """1/2 (2 pi)^-3 int |w^|^2/k^2, the length of k done by hand, its direction by Gauss's rule."""
    ring, time = RINGS[name], 1.2
    node, weight = np.polynomial.legendre.leggauss(100)
    c, angle = np.meshgrid(node, np.arange(200) * math.pi / 100.0, indexing="ij")
    s = np.sqrt(1.0 - c * c)
    n = np.stack([s * np.cos(angle), s * np.sin(angle), c])
    q = np.einsum("iab,ij,jab->ab", n, ring.shape(time), n)
    a = ring.covector(time)
    across = a @ a - np.tensordot(a, n, axes=1) ** 2
    whole = np.sum(across * q**-1.5 * weight[:, None]) * math.pi / 100.0
    whole *= ring.width**6 / 16.0 * math.sqrt(0.5 * math.pi)
    assert ring.energy(time) == pytest.approx(whole, rel=1e-10)


def test_viscosity_spreads_a_ring_at_rest_as_heat():
    still = StrainedRing(width=0.5, viscosity=0.2)
    assert still.shape(2.0) == pytest.approx((0.25 + 4.0 * 0.2 * 2.0) * np.eye(3))
    assert still.impulse(2.0) == pytest.approx(still.impulse())
    rate = (still.energy(STEP) - still.energy(0.0)) / STEP
    assert rate == pytest.approx(-0.2 * still.enstrophy(), rel=0.02)


@pytest.mark.parametrize(("strain", "closes"), [(SYMMETRIC, True), (TURNING, False)])
def test_the_linearised_equations_keep_an_impulse_only_without_base_vorticity(strain, closes):
    """v = I - k (k . I)/k^2 as k -> 0: is there one dI/dt that suits all directions of k?"""
    matrix, impulse = np.array(strain), np.array([0.3, -0.5, 1.0])
    k = np.random.default_rng(1).normal(size=(200, 3))
    k /= np.linalg.norm(k, axis=1, keepdims=True)
    turned = -k @ matrix  # dk/dt = -A^T k
    v = impulse - k * (k @ impulse)[:, None]
    moved = v @ matrix.T
    whole = -moved + 2.0 * k * np.sum(k * moved, axis=1)[:, None]
    # d/dt of k k^T/k^2 at fixed I
    stretch = np.sum(k * turned, axis=1)[:, None]
    along = (k @ impulse)[:, None]
    frame = turned * along + k * (turned @ impulse)[:, None] - 2.0 * k * along * stretch
    rest = (whole + frame).ravel()  # = (1 - k k^T) dI/dt
    across = (np.eye(3) - k[:, :, None] * k[:, None, :]).reshape(-1, 3)
    rate, *_ = np.linalg.lstsq(across, rest, rcond=None)
    misfit = np.abs(across @ rate - rest).max()
    assert StrainedRing(strain=strain).irrotational is closes
    if closes:
        assert misfit < 1e-13
        assert rate == pytest.approx(-matrix.T @ impulse)
    else:
        assert misfit > 0.1


@pytest.mark.parametrize(
    "bad", [{"strain": ((1.0, 0, 0),) * 3}, {"strain": ((1.0, 0.0),)}, {"width": 0.0}]
)
def test_rings_that_cannot_be_are_refused(bad):
    with pytest.raises(InputError):
        StrainedRing(**bad)
