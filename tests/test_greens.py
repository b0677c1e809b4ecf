"""Regularised Green's functions: centre values, derivatives, and their Fourier integrals."""

import math

import numpy as np
import pytest
from scipy import integrate, special

from pmesh.spectral.greens import HEJ_ORDERS, hej, hockney_eastwood

ZERO = np.zeros(())

# sigma G(0) in space; in the plane G(0) = (gamma/2 - ln(sqrt2 sigma) + Q(0)) / (2 pi)
# (Hejlesen et al., J. Comput. Phys. 252 (2013) 458, and their Gaussian moments)
SPACE_CENTRE = [0.0634936, 0.0952405, 0.1190506, 0.1388923, 0.1562539]
PLANE_Q = [0.0, 1 / 2, 3 / 4, 11 / 12, 25 / 24]


def regularised(s, order):
    """Transform of the blob, exp(-s^2/2) sum (s^2/2)^n / n!."""
    y = s**2 / 2
    return np.exp(-y) * sum(y**n / math.factorial(n) for n in range(order // 2))


@pytest.mark.parametrize("place", range(5))
def test_centre_values_are_the_published_ones(place):
    order, sigma = HEJ_ORDERS[place], 0.7
    G = hej(np.zeros(1), ZERO, 3, sigma=sigma, order=order)[0]
    assert abs(sigma * G[0] - SPACE_CENTRE[place]) <= 6e-8
    G = hej(np.zeros(1), ZERO, 2, sigma=sigma, order=order)[0]
    exact = np.euler_gamma / 2 - math.log(math.sqrt(2) * sigma) + PLANE_Q[place]
    assert abs(2 * math.pi * G[0] - exact) <= 1e-14


@pytest.mark.parametrize("order", HEJ_ORDERS)
@pytest.mark.parametrize("kappa", [0.0, 0.4, 3.0])
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_the_profiles_are_derivatives_of_one_another(order, kappa, axes):
    if axes == 3 and kappa:
        return
    r, step = np.linspace(0.3, 6.0, 9), 1e-4

    def profiles(r):
        return hej(r**2, np.full(() if axes == 2 else 1, kappa**2), axes, sigma=1.0, order=order)

    _, A, B = profiles(r)
    ahead, behind = profiles(r + step), profiles(r - step)
    assert np.abs((ahead[0] - behind[0]) / (2 * step) - r * A).max() <= 1e-7
    assert np.abs((ahead[1] - behind[1]) / (2 * step) - r * B).max() <= 1e-7
    middle = profiles(np.array([0.0, 1e-3]))
    assert abs(middle[1][0] - middle[1][1]) <= 1e-5


@pytest.mark.parametrize("order", [2, 6, 10])
@pytest.mark.parametrize("kappa", [0.3, 2.0])
def test_mixed_forms_are_the_fourier_integrals_of_the_blob(order, kappa):
    sigma = 0.8
    for r in (0.0, 0.5, 2.0):
        line = integrate.quad(
            lambda k, r=r: (
                regularised(sigma * math.hypot(k, kappa), order)
                * math.cos(k * r)
                / (math.pi * (k**2 + kappa**2))
            ),
            0,
            12 / sigma,
            epsabs=1e-12,
            limit=200,
        )[0]
        G = hej(np.array([r**2]), np.array([kappa**2]), 1, sigma=sigma, order=order)[0]
        assert abs(G[0] - line) <= 1e-10
        plane = integrate.quad(
            lambda k, r=r: (
                regularised(sigma * math.hypot(k, kappa), order)
                * special.j0(k * r)
                * k
                / (2 * math.pi * (k**2 + kappa**2))
            ),
            0,
            12 / sigma,
            epsabs=1e-12,
            limit=200,
        )[0]
        G = hej(np.array([r**2]), np.asarray(kappa**2), 2, sigma=sigma, order=order)[0]
        assert abs(G[0] - plane) <= 1e-10


@pytest.mark.parametrize("order", HEJ_ORDERS)
def test_far_away_the_blob_is_a_point(order):
    far = np.array([20.0**2])
    for axes, exact in ((1, -10.0), (2, -math.log(20) / (2 * math.pi)), (3, 1 / (80 * math.pi))):
        G, A, B = hej(far, ZERO if axes == 2 else np.zeros(1), axes, sigma=1.0, order=order)
        point = hockney_eastwood(far, ZERO, axes, spacing=1.0)
        assert abs(G[0] - exact) <= 1e-13
        for ours, bare in zip((G, A, B), point, strict=True):
            assert abs(ours[0] - bare[0]) <= 1e-13


def test_self_cells_are_the_means_over_one_cell():
    h = 0.25
    disc = hockney_eastwood(np.zeros(1), ZERO, 2, spacing=h)[0][0]
    assert disc == pytest.approx((1 - 2 * math.log(h / math.sqrt(math.pi))) / (4 * math.pi))
    unit = hockney_eastwood(np.zeros(1), ZERO, 2, spacing=1.0)[0][0]
    assert unit == pytest.approx(0.17067218146492422, abs=1e-15)
    cube = hockney_eastwood(np.zeros(1), ZERO, 3, spacing=h)[0][0]
    assert cube == pytest.approx(0.1894005 / h, abs=1e-6)
    k = 1.3
    radius = h / math.sqrt(math.pi)
    mean = integrate.quad(lambda r: r * special.k0(k * r), 0, radius)[0] / h**2
    screened = hockney_eastwood(np.zeros(1), np.asarray(k**2), 2, spacing=h)[0][0]
    assert screened == pytest.approx(mean, rel=1e-7)
