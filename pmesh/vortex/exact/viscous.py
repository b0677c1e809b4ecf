"""Exact viscous flows: Taylor and Green's vortices and the Lamb-Oseen vortex."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pmesh.vortex.exact.flow import Array, Pair, as_array, check, column, relative

_LAMB_PEAK = 1.2564312086261697  # root of (1 + 2x) exp(-x) = 1


@dataclass(frozen=True, kw_only=True)
class TaylorGreen:
    """Periodic array of decaying vortices, carried along by a uniform ``drift``.

    ``u = U sin(kx) cos(ky) F, v = -U cos(kx) sin(ky) F`` with ``k = 2 pi/length`` and
    ``F = exp(-2 nu k^2 t)``; in a unit box with U = 1 and Re = 1/nu that is exp(-8 pi^2 t/Re).
    Source: G. I. Taylor, A. E. Green, Proc. R. Soc. A 158 (1937) 499, in two dimensions.
    """

    length: float = 1.0  # of one period [L]
    speed: float = 1.0  # U [L/T]
    viscosity: float = 0.0  # nu [L^2/T]
    drift: Pair = (0.0, 0.0)  # [L/T]
    circulation: float = 0.0  # over a period

    def __post_init__(self) -> None:
        """Refuse a length that is not positive and a negative viscosity."""
        check(self, positive=("length",), not_negative=("viscosity",))

    @property
    def wavenumber(self) -> float:
        """k [1/L]."""
        return 2.0 * math.pi / self.length

    def decay(self, time: float) -> float:
        """Factor F on velocity and vorticity; energy and enstrophy decay with its square."""
        return math.exp(-2.0 * self.viscosity * self.wavenumber**2 * time)

    def energy(self, time: float = 0.0) -> float:
        """Integral over a period of half the squared velocity, drift left out [L^4/T^2]."""
        return (0.5 * self.speed * self.length * self.decay(time)) ** 2

    def enstrophy(self, time: float = 0.0) -> float:
        """Integral of the squared vorticity over a period [L^2/T^2]."""
        return (self.speed * self.wavenumber * self.length * self.decay(time)) ** 2

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity 2 U k sin(kx) sin(ky) F [1/T] at ``points`` (2, ...) [L]."""
        x, y = relative(points, (0.0, 0.0), self.drift, time) * self.wavenumber
        amplitude = 2.0 * self.speed * self.wavenumber * self.decay(time)
        return as_array(amplitude * np.sin(x) * np.sin(y))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T], drift included, at ``points`` (2, ...) [L]."""
        x, y = relative(points, (0.0, 0.0), self.drift, time) * self.wavenumber
        amplitude = self.speed * self.decay(time)
        turning = amplitude * np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)])
        return as_array(turning + column(self.drift, turning))


@dataclass(frozen=True, kw_only=True)
class LambOseen:
    """Gaussian vortex that spreads by viscosity while a uniform ``drift`` carries it along.

    ``w = Gamma/(pi a^2) exp(-r^2/a^2)`` with the core ``a^2 = core^2 + 4 nu t``;
    ``u_theta = Gamma/(2 pi r) (1 - exp(-r^2/a^2))``.
    Source: C. W. Oseen (1911); H. Lamb, Hydrodynamics, art. 334a.
    """

    circulation: float = 1.0  # Gamma [L^2/T]
    core: float = 1.0  # a at t = 0 [L]
    viscosity: float = 0.0  # nu [L^2/T]
    center: Pair = (0.0, 0.0)  # at t = 0 [L]
    drift: Pair = (0.0, 0.0)  # [L/T]

    def __post_init__(self) -> None:
        """Refuse a core that is not positive and a negative viscosity."""
        check(self, positive=("core",), not_negative=("viscosity",))

    def radius(self, time: float = 0.0) -> float:
        """Core radius a = sqrt(core^2 + 4 nu t) [L]."""
        return math.sqrt(self.core**2 + 4.0 * self.viscosity * time)

    def peak_radius(self, time: float = 0.0) -> float:
        """Radius of the largest velocity, 1.1209064 a [L]."""
        return math.sqrt(_LAMB_PEAK) * self.radius(time)

    def peak_speed(self, time: float = 0.0) -> float:
        """Largest velocity, 0.6381727 Gamma/(2 pi a) [L/T]."""
        turned = self.circulation * -math.expm1(-_LAMB_PEAK)
        return turned / (2.0 * math.pi * self.peak_radius(time))

    def angular_moment(self, time: float = 0.0) -> float:
        """Integral of w r^2 about the moving centre, Gamma a^2; grows at 4 nu Gamma [L^4/T]."""
        return self.circulation * self.radius(time) ** 2

    def enstrophy(self, time: float = 0.0) -> float:
        """Integral of the squared vorticity, Gamma^2/(2 pi a^2) [L^2/T^2]."""
        return self.circulation**2 / (2.0 * math.pi * self.radius(time) ** 2)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` (2, ...) [L]."""
        x, y = relative(points, self.center, self.drift, time)
        square = self.radius(time) ** 2
        return as_array(self.circulation / (math.pi * square) * np.exp((x * x + y * y) / -square))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T], drift included, at ``points`` (2, ...) [L]."""
        x, y = relative(points, self.center, self.drift, time)
        scaled = (x * x + y * y) / self.radius(time) ** 2
        scaled = np.maximum(scaled, np.finfo(scaled.dtype).tiny)
        rate = self.circulation / (2.0 * math.pi * self.radius(time) ** 2)
        turning = rate * -np.expm1(-scaled) / scaled * np.stack([-y, x])
        return as_array(turning + column(self.drift, turning))
