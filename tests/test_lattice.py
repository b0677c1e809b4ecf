"""Lattice Green's functions: known values, and the lattice Laplace equation itself."""

import math

import numpy as np
import pytest

from pmesh.spectral.lattice import PLANE_CONSTANT, lattice_greens

# potential kernel a(n, m) of the square lattice, and G of the cubic one (Watson's integrals; exact
# a(1,0) = 1/4, a(1,1) = 1/pi, a(2,0) = 1 - 2/pi, a(2,1) = 2/pi - 1/4)
PLANE = {
    (0, 0): 0.0,
    (1, 0): 0.25,
    (1, 1): 1 / math.pi,
    (2, 0): 1 - 2 / math.pi,
    (2, 1): 2 / math.pi - 0.25,
    (2, 2): 4 / (3 * math.pi),
    (3, 0): 0.4302813657945119,
    (5, 5): 0.5689157648300767,
    (10, 0): 0.6236755712157085,
    (10, 10): 0.67903632500603,
}
SPACE = {
    (0, 0, 0): 0.25273100985585695,
    (1, 0, 0): 0.08606434319293169,
    (1, 1, 0): 0.05519143369241407,
    (1, 1, 1): 0.04357835440614367,
    (2, 0, 0): 0.042889314554525285,
    (3, 0, 0): 0.02754513019910431,
    (5, 0, 0): 0.016101075424668588,
}


def residual(G, screening, centre):
    """(-laplace_h + screening) G - delta at the inner nodes; even extension at the origin."""
    total = (2 * G.ndim + screening) * G
    for axis in range(G.ndim):
        moved = np.moveaxis(G, axis, 0)
        sides = np.zeros_like(moved)
        sides[1:-1] = moved[2:] + moved[:-2]
        sides[0] = 2 * moved[1]
        total = total - np.moveaxis(sides, 0, axis)
    total[(0,) * G.ndim] -= centre
    return total[(slice(0, -1),) * G.ndim]


def test_plane_values_are_the_known_ones():
    G = lattice_greens((12, 12), np.zeros(()))
    for (n, m), value in PLANE.items():
        assert abs(PLANE_CONSTANT - G[n, m] - value) <= 1e-13
        assert G[n, m] == pytest.approx(G[m, n], abs=1e-15)


def test_space_values_are_the_known_ones():
    G = lattice_greens((6, 6, 6), np.zeros(()))
    for place, value in SPACE.items():
        assert abs(G[place] - value) <= 1e-10


@pytest.mark.parametrize(
    ("shape", "screening", "tolerance"),
    [
        ((90,), 0.0, 1e-13),
        ((90,), 0.3, 1e-13),
        ((90, 80), 0.0, 1e-10),
        ((60, 50), 1e-3, 1e-12),
        ((30, 20), 6.0, 1e-14),
        ((72, 70, 9), 0.0, 1e-7),
    ],
)
def test_it_inverts_the_lattice_laplacian_near_and_far(shape, screening, tolerance):
    G = lattice_greens(shape, np.asarray(screening))
    assert np.abs(residual(G, screening, 1.0)).max() <= tolerance


def test_the_plane_approaches_the_logarithm_and_space_the_coulomb_law():
    G = lattice_greens((200, 200), np.zeros(()))
    assert abs(G[199, 120] + math.log(math.hypot(199, 120)) / (2 * math.pi)) <= 1e-6
    G = lattice_greens((100, 3, 3), np.zeros(()))
    assert G[99, 2, 1] * 4 * math.pi * math.sqrt(99**2 + 5) == pytest.approx(1, abs=1e-4)
