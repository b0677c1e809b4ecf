"""Periodic flows in space: Taylor and Green's start and the Beltrami flow A, B, C."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pmesh.vortex.exact.flow import (
    Array,
    Triple,
    as_array,
    check,
    check_start,
    check_triple,
    column,
    relative,
)


@dataclass(frozen=True, kw_only=True)
class TaylorGreenCube:
    """Taylor and Green's start of turbulence; exact at t = 0 only.

    ``u = V (sin kx cos ky cos kz, -cos kx sin ky cos kz, 0)``, ``k = 2 pi/length``. Reynolds's
    number is ``V/(k nu)`` and the time unit ``1/(k V)``. Mean kinetic energy V^2/8, mean squared
    vorticity 3/4 k^2 V^2, dissipation 3/4 nu k^2 V^2 at t = 0; no impulse, no helicity.
    Source: G. I. Taylor, A. E. Green, Proc. R. Soc. A 158 (1937) 499.
    """

    length: float = 2.0 * math.pi  # of one period [L]
    speed: float = 1.0  # V [L/T]

    def __post_init__(self) -> None:
        """Refuse a length that is not positive."""
        check(self, positive=("length",), not_negative=())

    @property
    def wavenumber(self) -> float:
        """k [1/L]."""
        return 2.0 * math.pi / self.length

    @property
    def energy(self) -> float:
        """1/2 int u^2 dV over a period, V^2/8 length^3 [L^5/T^2]."""
        return self.speed**2 / 8.0 * self.length**3

    @property
    def enstrophy(self) -> float:
        """Int w^2 dV over a period, 3/4 k^2 V^2 length^3 [L^3/T^2]."""
        return 0.75 * (self.wavenumber * self.speed) ** 2 * self.length**3

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """kV (-cos sin sin, -sin cos sin, 2 sin sin cos), (3, ...) [1/T]; refuses other times."""
        (sx, sy, sz), (cx, cy, cz) = self._waves(points, time)
        parts = np.stack([-cx * sy * sz, -sx * cy * sz, 2.0 * sx * sy * cz])
        return as_array(self.wavenumber * self.speed * parts)

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity (3, ...) [L/T] at ``points`` (3, ...) [L]; refuses any time but zero."""
        (sx, sy, _), (cx, cy, cz) = self._waves(points, time)
        parts = np.stack([sx * cy * cz, -cx * sy * cz, np.zeros_like(sx)])
        return as_array(self.speed * parts)

    def _waves(self, points: Array, time: float) -> tuple[Array, Array]:
        """Sines and cosines of k x, k y, k z."""
        check_start(self, time)
        phase = relative(points, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0) * self.wavenumber
        return np.sin(phase), np.cos(phase)


@dataclass(frozen=True, kw_only=True)
class BeltramiFlow:
    """Arnold, Beltrami and Childress's viscous flow, exact, carried along by a ``drift``.

    ``u = (A sin kz + C cos ky, B sin kx + A cos kz, C sin ky + B cos kx) F`` in drifting
    coordinates, ``k = 2 pi/length``, ``F = exp(-nu k^2 t)``. ``w = k u``, so that ``u x w = 0``: a
    solution of the Navier-Stokes equations for all time. Stretching and advection each are at
    work and cancel but for the drift: a flow to measure orders of accuracy on.
    Source: V. I. Arnold, C. R. Acad. Sci. Paris 261 (1965) 17; decay: V. Trkal (1919).
    """

    strengths: Triple = (1.0, 1.0, 1.0)  # A, B, C [L/T]
    length: float = 2.0 * math.pi  # of one period [L]
    viscosity: float = 0.0  # nu [L^2/T]
    drift: Triple = (0.0, 0.0, 0.0)  # [L/T]

    def __post_init__(self) -> None:
        """Refuse a length that is not positive and a negative viscosity."""
        check(self, positive=("length",), not_negative=("viscosity",))
        check_triple(self, "strengths", "drift")

    @property
    def wavenumber(self) -> float:
        """k [1/L]."""
        return 2.0 * math.pi / self.length

    def decay(self, time: float) -> float:
        """Factor F on velocity and vorticity; energy and enstrophy decay with its square."""
        return math.exp(-self.viscosity * self.wavenumber**2 * time)

    def energy(self, time: float = 0.0) -> float:
        """1/2 int u^2 dV over a period, (A^2 + B^2 + C^2)/2 length^3 F^2, drift left out."""
        square = sum(s * s for s in self.strengths)
        return 0.5 * square * self.length**3 * self.decay(time) ** 2

    def enstrophy(self, time: float = 0.0) -> float:
        """Int w^2 dV over a period, 2 k^2 energy [L^3/T^2]."""
        return 2.0 * self.wavenumber**2 * self.energy(time)

    def helicity(self, time: float = 0.0) -> float:
        """Int u . w dV over a period, 2 k energy [L^4/T^2], drift left out."""
        return 2.0 * self.wavenumber * self.energy(time)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity (3, ...) [1/T] at ``points`` (3, ...) [L]."""
        return as_array(self.wavenumber * self._wave(points, time))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity (3, ...) [L/T], drift included, at ``points`` (3, ...) [L]."""
        wave = self._wave(points, time)
        return as_array(wave + column(self.drift, wave))

    def _wave(self, points: Array, time: float) -> Array:
        """Velocity as the drifting observer sees it."""
        phase = relative(points, (0.0, 0.0, 0.0), self.drift, time) * self.wavenumber
        (sx, sy, sz), (cx, cy, cz) = np.sin(phase), np.cos(phase)
        a, b, c = (s * self.decay(time) for s in self.strengths)
        return as_array(np.stack([a * sz + c * cy, b * sx + a * cz, c * sy + b * cx]))
