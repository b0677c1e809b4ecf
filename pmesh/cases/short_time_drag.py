"""Drag of an impulsively started cylinder at short times: exact linear law and its extension."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Times = float | NDArray[np.floating[Any]]
_EULER = 0.5772156649015329


def linear_drag(reynolds: float, time: Times) -> NDArray[np.float64]:
    """Exact drag coefficient of linear unsteady Stokes flow at T = U t/R > 0, with Re = U D/nu.

    The force is the Laplace inversion of ``pi rho a^2 U [1 + 4 K1(z)/(z K0(z))]``,
    ``z = a sqrt(s/nu)``; its first term, the added mass, is an impulse at T = 0 and left out.
    Folding the inversion around the branch cut gives, with ``tau = 2 T/Re``,
    ``Cd = (2 pi/Re) (16/pi^2) int_0^inf exp(-tau u^2) / (u [J0(u)^2 + Y0(u)^2]) du``.
    Relative error below 1e-8; starts as ``4 sqrt(2 pi/(Re T))``, half friction and half pressure.
    Source: Carslaw & Jaeger, Conduction of Heat in Solids, 13.5, for the inversion.
    """
    when, tau = _checked(reynolds, time)
    flux = np.array([_step_flux(2.0 * t / reynolds) for t in when])
    return np.reshape(8.0 * math.pi / reynolds * flux, tau.shape)


def short_time_drag(reynolds: float, time: Times) -> NDArray[np.float64]:
    """Drag coefficient at T = U t/R > 0 with the first inertial terms; NaN beyond T = 0.5.

    The exact linear law plus, with ``t = T/2`` (in diameters) and ``k = 4 sqrt(t/Re)``,
    ``pi/sqrt(Re t) [(8.996 - 41 k + 143.8 k^2 + 45.4 k^3) t^2
    + (20.848 - 314.08 k - 1851.36 k^2 - 194.8 k^3) t^4 + (28.864 + 6.272 k) t^6]``.
    Meant for Re >= 550. Source of the inertial terms (grade B): M. Bar-Lev, H. T. Yang,
    J. Fluid Mech. 72 (1975) 625, as quoted in secondary sources.
    """
    _, when = _checked(reynolds, time)
    t = 0.5 * np.minimum(when, 0.5)
    k = 4.0 * np.sqrt(t / reynolds)
    inertial = (
        (8.996 - 41.0 * k + 143.8 * k**2 + 45.4 * k**3) * t**2
        + (20.848 - 314.08 * k - 1851.36 * k**2 - 194.8 * k**3) * t**4
        + (28.864 + 6.272 * k) * t**6
    )
    drag = linear_drag(reynolds, when) + math.pi / np.sqrt(reynolds * t) * inertial
    return np.where(when <= 0.5, drag, np.nan)


def _step_flux(tau: float) -> float:
    """(4/pi^2) int exp(-tau u^2)/(u (J0^2 + Y0^2)) du: flux out of a cylinder held at 1.

    On ``s = ln u`` by Gauss's rule in panels; below ``u = 1e-6`` the integrand is
    ``1/(1 + v^2)`` with ``v = (2/pi)(s - ln 2 + gamma)``, whose integral is an arctangent.
    """
    from scipy.special import j0, y0  # imported late: scipy is slow to load

    first, last = math.log(1e-6), 0.5 * math.log(40.0 / tau)
    slope = 2.0 / math.pi
    tail = (math.atan(slope * (first - math.log(2.0) + _EULER)) + 0.5 * math.pi) / slope
    node, weight = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(first, last, 60)
    half = 0.5 * np.diff(edges)[:, None]
    u = np.exp(edges[:-1, None] + half * (node + 1.0))
    smooth = np.exp(-tau * u * u) / (j0(u) ** 2 + y0(u) ** 2)
    return 4.0 / math.pi**2 * (tail + float(np.sum(half * weight * smooth)))


def _checked(reynolds: float, time: Times) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times as a list and in their own shape; refuses times and Reynolds numbers not above zero."""
    if not (math.isfinite(reynolds) and reynolds > 0):
        raise InputError(f"reynolds must be positive, got {reynolds}", hint="reynolds=550")
    when = np.asarray(time, np.float64)
    if not np.all(when > 0):
        raise InputError(
            "the short-time drag is infinite at T = 0 and unknown before", hint="times above zero"
        )
    return when.ravel(), when
