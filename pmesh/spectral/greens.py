"""Green's functions of -laplace, in free space or for one wavenumber of the periodic axes.

Each function returns three radial profiles on the unbounded axes, G, A = G'/r and B = A'/r,
so that grad G = A x and d_i d_j G = A delta_ij + B x_i x_j.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from pmesh.spectral.sweeps import screened_integrals

Array = NDArray[Any]
Profiles = tuple[Array, Array, Array]

HEJ_ORDERS = (2, 4, 6, 8, 10)


def hej(r2: Array, kappa2: Array, axes: int, *, sigma: float, order: int) -> Profiles:
    """Gaussian-regularised Green's function on ``axes`` unbounded axes, transformed along others.

    ``r2``: squared distance [L^2] and ``kappa2``: squared wavenumber of the periodic axes [1/L^2];
    they broadcast, except for two unbounded axes, where ``kappa2`` is one number.
    Its regularisation exp(-s^2/2) sum_{n < order/2} (s^2/2)^n / n!, s = |k| sigma, has
    ``order - 1`` vanishing moments, so that smooth sources are solved to O(sigma^order).
    Source: Hejlesen, Rasmussen, Chatelain & Walther, J. Comput. Phys. 252 (2013) 458;
    the mixed forms follow from 1/k^2 = int exp(-t k^2) dt.
    """
    x = r2 / (2 * sigma**2)
    a = kappa2 * (sigma**2 / 2)
    G, A = (_gauss_line, _gauss_plane, _gauss_space)[axes - 1](r2, kappa2, sigma)
    blob = np.exp(-x - a) / (2 * math.pi * sigma**2) ** (axes / 2)
    terms = order // 2
    value = np.zeros(np.broadcast_shapes(x.shape, a.shape))
    slope = np.zeros_like(value)
    zeta = np.zeros_like(value)
    for n in range(terms):
        for j in range(n + 1):
            part = a ** (n - j) / math.factorial(n - j)
            even = part * special.eval_genlaguerre(j, axes / 2 - 1, x)
            zeta += even
            if n < terms - 1:
                value += even / (n + 1)
                slope += part * special.eval_genlaguerre(j, axes / 2, x) / (n + 1)
    G = G + sigma**2 / 2 * blob * value
    A = A - blob * slope / 2
    return G, A, _curvature(G, A, blob * zeta, r2, kappa2, axes)


def _curvature(G: Array, A: Array, zeta: Array, r2: Array, kappa2: Array, axes: int) -> Array:
    """B from laplace G = kappa^2 G - zeta; at r = 0 it is never needed and set to 0."""
    apart = r2 > 0
    B: Array = np.where(apart, (kappa2 * G - zeta - axes * A) / np.where(apart, r2, 1.0), 0.0)
    return B


def _gauss_space(r2: Array, kappa2: Array, sigma: float) -> tuple[Array, Array]:
    r = np.sqrt(np.where(r2 > 0, r2, 1.0))
    rho = r / sigma
    inside = special.erf(rho / math.sqrt(2))
    peak = 1 / (sigma * (2 * math.pi) ** 1.5)
    G = np.where(r2 > 0, inside / (4 * math.pi * r), peak)
    mass = inside - math.sqrt(2 / math.pi) * rho * np.exp(-(rho**2) / 2)
    A = np.where(r2 > 0, -mass / (4 * math.pi * r**3), -peak / (3 * sigma**2))
    return G, A


def _gauss_plane(r2: Array, kappa2: Array, sigma: float) -> tuple[Array, Array]:
    screening = np.asarray(kappa2).item()
    x = r2 / (2 * sigma**2)
    if screening > 0:
        nodes, weights = np.polynomial.legendre.leggauss(12)
        distinct, where = np.unique(x, return_inverse=True)
        first, second = screened_integrals(
            distinct, screening * sigma**2 / 2, (nodes + 1) / 2, weights / 2
        )
        where = where.reshape(x.shape)
        return first[where] / (4 * math.pi), -second[where] / (4 * math.pi * sigma**2)
    apart = x > 0
    safe = np.where(apart, x, 1.0)
    middle = np.euler_gamma / 2 - math.log(math.sqrt(2) * sigma)
    far = -(np.log(safe) / 2 + math.log(math.sqrt(2) * sigma) + special.exp1(safe) / 2)
    G = np.where(apart, far, middle) / (2 * math.pi)
    A = np.where(apart, np.expm1(-safe) / safe, -1.0) / (4 * math.pi * sigma**2)
    return G, A


def _gauss_line(r2: Array, kappa2: Array, sigma: float) -> tuple[Array, Array]:
    r, kappa2 = np.broadcast_arrays(np.sqrt(r2), kappa2)
    still = kappa2 == 0
    k = np.sqrt(np.where(still, 1.0, kappa2))
    bell = np.exp(-((r / sigma) ** 2 + (k * sigma) ** 2) / 2)
    lower = (k * sigma - r / sigma) / math.sqrt(2)
    ahead = bell * special.erfcx((k * sigma + r / sigma) / math.sqrt(2))
    near = bell * special.erfcx(np.maximum(lower, 0.0))
    behind = np.where(lower > 0, near, np.exp(-k * r) * special.erfc(lower))
    inside = special.erf(r / (sigma * math.sqrt(2)))
    free = -(r * inside + sigma * math.sqrt(2 / math.pi) * np.exp(-((r / sigma) ** 2) / 2)) / 2
    G = np.where(still, free, (ahead + behind) / (4 * k))
    slope = np.where(still, -inside / 2, (ahead - behind) / 4)
    middle = special.erfc(k * sigma / math.sqrt(2)) * kappa2 / (2 * k)
    peak = np.exp(-((np.where(still, 0.0, k) * sigma) ** 2) / 2) / (sigma * math.sqrt(2 * math.pi))
    A = np.where(r > 0, slope / np.where(r > 0, r, 1.0), middle - peak)
    return G, A


def hockney_eastwood(r2: Array, kappa2: Array, axes: int, *, spacing: float) -> Profiles:
    """The point Green's function itself, with the mean over one cell at r = 0. Second order.

    Arguments as for :func:`hej`. Source: Hockney & Eastwood, Computer Simulation Using Particles
    (1988), and the means over the disc and the cube of one cell.
    """
    apart = r2 > 0
    r = np.sqrt(np.where(apart, r2, 1.0))
    if axes == 3:
        G = np.where(apart, 1 / (4 * math.pi * r), _CUBE_MEAN / spacing)
        A = -1 / (4 * math.pi * r**3)
    elif axes == 2:
        G, A = _point_plane(r, apart, np.asarray(kappa2).item(), spacing)
    else:
        r, k2 = np.broadcast_arrays(np.where(apart, r, 0.0), kappa2)
        k = np.sqrt(np.where(k2 > 0, k2, 1.0))
        G = np.where(k2 > 0, np.exp(-k * r) / (2 * k), -r / 2)
        slope = np.where(k2 > 0, -np.exp(-k * r) / 2, -0.5)
        A = slope / np.where(r > 0, r, 1.0)
    zero = np.zeros(())
    B = _curvature(G, A, zero, r2, kappa2, axes)
    self_cell = (kappa2 * G - spacing**-axes) / axes
    return G, np.where(apart, A, self_cell), B


_CUBE_MEAN = 0.18940053839255425  # mean of 1/(4 pi r) over a unit cube about its centre


def _point_plane(r: Array, apart: Any, screening: float, spacing: float) -> tuple[Array, Array]:
    disc = spacing / math.sqrt(math.pi)
    if screening > 0:
        k = math.sqrt(screening)
        mean = (1 - k * disc * special.k1(k * disc)) / (math.pi * (k * disc) ** 2)
        return np.where(apart, special.k0(k * r) / (2 * math.pi), mean), -k * special.k1(k * r) / (
            2 * math.pi * r
        )
    mean = (1 - 2 * math.log(disc)) / (4 * math.pi)
    return np.where(apart, -np.log(r) / (2 * math.pi), mean), -1 / (2 * math.pi * r**2)
