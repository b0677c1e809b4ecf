"""Exact inviscid patches: Perlman's, the elliptical vortex and Kirchhoff's ellipse."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import Array, Pair, as_array, check, check_axes, column, relative
from remesh.errors import InputError

_KOUMOUTSAKOS_Q = 2.56085  # as printed; it stands for e^2 ln(2)/2


@dataclass(frozen=True, kw_only=True)
class PerlmanPatch:
    """Steady axisymmetric patch ``w = w0 (1 - r^2/R^2)^p`` inside R, nothing outside; C^(p-1) at R.

    ``u_theta = Gamma/(2 pi r) (1 - (1 - r^2/R^2)^(p+1))`` and ``Gamma = pi w0 R^2/(p + 1)``.
    An Euler flow: it keeps its form for all time while a uniform ``drift`` carries it along.
    Source: M. Perlman, J. Comput. Phys. 59 (1985) 200, with p = 3 and 7.
    """

    p: int = 7
    strength: float = 1.0  # w0 [1/T]
    radius: float = 1.0  # R [L]
    center: Pair = (0.0, 0.0)  # at t = 0 [L]
    drift: Pair = (0.0, 0.0)  # [L/T]

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive and a negative power."""
        check(self, positive=("radius",), not_negative=("p",))

    @property
    def circulation(self) -> float:
        """Gamma = pi w0 R^2/(p + 1) [L^2/T]; pi/8 for p = 7."""
        return math.pi * self.strength * self.radius**2 / (self.p + 1)

    @property
    def angular_moment(self) -> float:
        """Integral of w r^2 about the centre, Gamma R^2/(p + 2) [L^4/T]."""
        return self.circulation * self.radius**2 / (self.p + 2)

    @property
    def enstrophy(self) -> float:
        """Integral of the squared vorticity, pi w0^2 R^2/(2p + 1) [L^2/T^2]."""
        return math.pi * (self.strength * self.radius) ** 2 / (2 * self.p + 1)

    def _inside(self, points: Array, time: float) -> tuple[Array, Array]:
        """Points about the centre, and 1 - r^2/R^2 cut at zero."""
        local = relative(points, self.center, self.drift, time)
        x, y = local
        return local, np.maximum(1.0 - (x * x + y * y) / self.radius**2, 0.0)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` (2, ...) [L]."""
        _, depth = self._inside(points, time)
        return as_array(self.strength * depth**self.p)

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T], drift included, at ``points`` (2, ...) [L]."""
        (x, y), depth = self._inside(points, time)
        scaled = (x * x + y * y) / self.radius**2
        # (1 - q^(p+1))/(1 - q) = 1 + q + ... + q^p: no cancellation at the centre
        series = sum((depth**n for n in range(self.p + 1)), np.zeros_like(depth))
        rate = np.where(depth > 0.0, series, 1.0 / np.maximum(scaled, 1.0))
        turning = self.circulation / (2.0 * math.pi * self.radius**2) * rate * np.stack([-y, x])
        return as_array(turning + column(self.drift, turning))


@dataclass(frozen=True, kw_only=True)
class EllipticVortex:
    """Elliptical vortex that sheds filaments and turns axisymmetric; exact at t = 0 only.

    ``z^2 = (x/0.4)^2 + (y/0.8)^2``; inside z = 1, ``w = 20 [1 - exp(-(q/z) exp(1/(z-1)))]`` with
    ``q = 2.56085`` (e^2 ln(2)/2) for kind I, ``w = 20 (1 - z^4)`` for kind II. Without
    viscosity its circulation, angular moment and enstrophy stay; with viscosity nu the
    angular moment grows at 4 nu Gamma.
    Source: P. Koumoutsakos, J. Comput. Phys. 138 (1997) 821.
    """

    kind: Literal["I", "II"] = "I"
    strength: float = 20.0  # w at the centre [1/T]
    axes: Pair = (0.4, 0.8)  # half axes of the patch's edge [L]

    def __post_init__(self) -> None:
        """Refuse an unknown kind and half axes that are not positive."""
        if self.kind not in ("I", "II"):
            raise InputError(
                f"kind must be 'I' or 'II', got {self.kind!r}", hint="EllipticVortex(kind='I')"
            )
        check_axes(self.axes)

    def _profile(self, z: Array) -> Array:
        """Vorticity over its value at the centre, from the elliptic radius z."""
        inner = np.clip(z, 1e-6, 1.0 - 1e-3)  # w is 1, or below 1e-300, to round-off beyond
        if self.kind == "II":
            return np.where(z < 1.0, 1.0 - z**4, 0.0)
        shape = -np.expm1(-_KOUMOUTSAKOS_Q / inner * np.exp(1.0 / (inner - 1.0)))
        return np.where(z < 1.0, shape, 0.0)

    def _radial(self, power: int) -> float:
        """Integral of profile(z) z^power from 0 to 1, by Gauss's rule."""
        node, weight = np.polynomial.legendre.leggauss(200)
        z = 0.5 * (node + 1.0)
        return float(0.5 * np.sum(weight * self._profile(z) * z**power))

    @property
    def circulation(self) -> float:
        """Gamma [L^2/T]: 5.5298756 for kind I, 13.4041287 for kind II."""
        a, b = self.axes
        return 2.0 * math.pi * a * b * self.strength * self._radial(1)

    @property
    def second_moments(self) -> Pair:
        """Integrals of w x^2 and w y^2 at t = 0 [L^4/T]: 0.0825088 and 0.3300351 for kind I."""
        a, b = self.axes
        both = math.pi * a * b * self.strength * self._radial(3)
        return both * a * a, both * b * b

    @property
    def angular_moment(self) -> float:
        """Integral of w r^2, the sum of the second moments [L^4/T]; kept by Euler flow."""
        return sum(self.second_moments)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Initial vorticity [1/T] at ``points`` (2, ...) [L]; refuses any time but zero."""
        if time != 0.0:
            raise InputError(
                f"the elliptical vortex is known exactly at time 0 only, got {time}",
                hint="start a VortexFlow from vorticity(points) and run it",
            )
        a, b = self.axes
        x, y = relative(points, (0.0, 0.0), (0.0, 0.0), 0.0)
        return as_array(self.strength * self._profile(np.hypot(x / a, y / b)))


@dataclass(frozen=True, kw_only=True)
class KirchhoffEllipse:
    """Uniform elliptical patch that turns without change of form at ``W = w0 ab/(a + b)^2``.

    Inside, in the patch's own axes, ``u = -w0 a y/(a + b), v = w0 b x/(a + b)``;
    outside ``u - iv = -i w0 ab/(z + sqrt(z^2 - a^2 + b^2))`` with ``z = x + iy``.
    Source: H. Lamb, Hydrodynamics, art. 159.
    """

    strength: float = 1.0  # w0 [1/T]
    axes: Pair = (2.0, 1.0)  # half axes a and b, along x and y at t = 0 [L]

    def __post_init__(self) -> None:
        """Refuse half axes that are not positive."""
        check_axes(self.axes)

    @property
    def circulation(self) -> float:
        """Gamma = pi a b w0 [L^2/T]."""
        return math.pi * self.axes[0] * self.axes[1] * self.strength

    @property
    def angular_velocity(self) -> float:
        """Rate W = w0 ab/(a + b)^2 at which the patch turns [1/T]."""
        a, b = self.axes
        return self.strength * a * b / (a + b) ** 2

    @property
    def angular_moment(self) -> float:
        """Integral of w r^2, Gamma (a^2 + b^2)/4 [L^4/T]."""
        a, b = self.axes
        return 0.25 * self.circulation * (a * a + b * b)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` (2, ...) [L]."""
        z = self._turned(points, time)
        return as_array(self.strength * (self._level(z) <= 1.0).astype(z.real.dtype))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T] at ``points`` (2, ...) [L]."""
        a, b = self.axes
        z = self._turned(points, time)
        inside = self._level(z) <= 1.0
        far = np.where(inside, 1.0, z)  # the root below is cut between the foci only
        outer = far * (1.0 + np.sqrt(1.0 - (a * a - b * b) / (far * far)))
        outside = -1j * self.strength * a * b / outer
        within = -self.strength * (a * z.imag + 1j * b * z.real) / (a + b)
        turned = np.where(inside, within, outside).conj() * cmath.exp(
            1j * self.angular_velocity * time
        )
        return as_array(np.stack([turned.real, turned.imag]))

    def _turned(self, points: Array, time: float) -> NDArray[np.complexfloating[Any, Any]]:
        """Points as x + iy in the patch's own axes."""
        x, y = relative(points, (0.0, 0.0), (0.0, 0.0), 0.0)
        return np.asarray(x + 1j * y) * cmath.exp(-1j * self.angular_velocity * time)

    def _level(self, z: NDArray[np.complexfloating[Any, Any]]) -> Array:
        """(x/a)^2 + (y/b)^2, which is 1 on the patch's edge."""
        return (z.real / self.axes[0]) ** 2 + (z.imag / self.axes[1]) ** 2
