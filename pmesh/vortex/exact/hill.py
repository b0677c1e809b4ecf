"""Hill's spherical vortex, an exact travelling Euler flow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import Array, Triple, as_array, check, check_triple, frame, relative
from remesh.errors import InputError


@dataclass(frozen=True, kw_only=True)
class HillVortex:
    """Sphere of vorticity ``w_theta = 15/2 U r/a^2`` that moves at U along its axis, unchanged.

    r is the distance to the axis, s that to the centre; the fluid is at rest far away.
    Inside ``u_z = U [5/2 - 3/2 (s^2 + r^2)/a^2], u_r = 3/2 U r z/a^2``, outside the dipole
    ``u_z = U (a/s)^3 [1 - 3/2 r^2/s^2], u_r = 3/2 U a^3 r z/s^5``. The vorticity jumps at the edge:
    ``width`` smooths it by the Gaussian ``exp(-s^2/width^2)``, which keeps it divergence-free and
    keeps the impulse; circulation, energy and enstrophy below are those of the sharp edge.
    Source: M. J. M. Hill, Phil. Trans. R. Soc. A 185 (1894) 213.
    """

    radius: float = 1.0  # a [L]
    speed: float = 1.0  # U [L/T]
    center: Triple = (0.0, 0.0, 0.0)  # at t = 0 [L]
    axis: Triple = (0.0, 0.0, 1.0)  # direction of travel, any length
    width: float = 0.0  # of the edge [L], at most radius/2

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive and an edge as wide as the vortex."""
        check(self, positive=("radius",), not_negative=("width",))
        check_triple(self, "center", "axis")
        frame(self.axis)
        if self.width > 0.5 * self.radius:
            raise InputError(
                f"HillVortex: width = {self.width} is over half the radius {self.radius}",
                hint=f"width={0.1 * self.radius:.3g}",
            )

    @property
    def circulation(self) -> float:
        """5 U a through a half plane [L^2/T]."""
        return 5.0 * self.speed * self.radius

    @property
    def impulse(self) -> NDArray[np.float64]:
        """2 pi a^3 U along the axis, (3,) [L^4/T]; of any edge."""
        return np.asarray(2.0 * math.pi * self.radius**3 * self.speed * frame(self.axis)[2])

    @property
    def energy(self) -> float:
        """10 pi/7 a^3 U^2 [L^5/T^2]."""
        return 10.0 * math.pi / 7.0 * self.radius**3 * self.speed**2

    @property
    def enstrophy(self) -> float:
        """Int w^2 dV = 30 pi a U^2 [L^3/T^2]."""
        return 30.0 * math.pi * self.radius * self.speed**2

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity (3, ...) [1/T] at ``points`` (3, ...) [L]."""
        turn, (x, y, z) = self._local(points, time)
        rate = 7.5 * self.speed / self.radius**2 * self._filled(np.sqrt(x * x + y * y + z * z))
        local = np.stack([-y * rate, x * rate, np.zeros_like(x)])
        return as_array(np.tensordot(turn.T, local, axes=1))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity (3, ...) [L/T] at ``points`` (3, ...) [L]; refuses a smoothed edge."""
        if self.width:
            raise InputError(
                "HillVortex.velocity is known for the sharp edge", hint="HillVortex(width=0)"
            )
        turn, (x, y, z) = self._local(points, time)
        across = (x * x + y * y) / self.radius**2
        square = across + (z / self.radius) ** 2
        outside = np.maximum(square, 1.0)
        inner = square < 1.0
        dipole = outside**-1.5
        along = np.where(
            inner, 2.5 - 1.5 * (square + across), dipole * (1.0 - 1.5 * across / outside)
        )
        out_over_r = 1.5 * z / self.radius**2 * np.where(inner, 1.0, dipole / outside)
        local = self.speed * np.stack([x * out_over_r, y * out_over_r, along])
        return as_array(np.tensordot(turn.T, local, axes=1))

    def _local(self, points: Array, time: float) -> tuple[Array, Array]:
        """The vortex's own axes (rows) and the points in them, about the centre of the moment."""
        turn = frame(self.axis)
        x, y, z = (self.speed * turn[2]).tolist()
        local = relative(points, self.center, (x, y, z), time)
        own = turn.astype(local.dtype)
        return own, as_array(np.tensordot(own, local, axes=1))

    def _filled(self, s: Array) -> Array:
        """What the smoothing leaves of x inside the sphere, over x: 1 inside, 0 outside.

        With B the smoothed sphere that is ``B + width^2/(2 s) dB/ds``.
        """
        if not self.width:
            return as_array((s < self.radius).astype(s.dtype))
        from scipy.special import erf  # imported late: scipy is slow to load

        a, h, given = self.radius, self.width, s.dtype
        s = np.maximum(s.astype(np.float64), 2e-3 * h)  # flat below, where the terms cancel
        near, far = np.exp(-(((s - a) / h) ** 2)), np.exp(-(((s + a) / h) ** 2))
        root = math.sqrt(math.pi)
        ball = 0.5 * (erf((a + s) / h) + erf((a - s) / h)) - h / (2.0 * root * s) * (near - far)
        slope = (far - near) / (root * h) + h / (2.0 * root * s * s) * (near - far)
        slope += ((s - a) * near - (s + a) * far) / (root * h * s)
        return as_array((ball + 0.5 * h * h / s * slope).astype(given))
