"""Exact flows around a cylinder that shakes or twists in viscous fluid at rest, at any instant.

Unsteady Stokes flow (Stokes 1851): psi = U sin(theta) [A/r + B K1(k r)], k^2 = i omega/nu, inside
the cylinder the velocity of the cylinder. Per unit density; amplitudes must be small.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from scipy.special import kv


@dataclass(frozen=True)
class Shaking:
    """Velocity ``speed * cos(rate t)`` along x, radius 1, centred at the origin."""

    speed: float
    rate: float
    viscosity: float

    def _parts(self):
        k = cmath.sqrt(1j * self.rate / self.viscosity)
        b = -2 / (k * kv(0, k))
        return k, 1 - b * kv(1, k), b

    def _now(self, field, time):
        return np.real(self.speed * np.exp(1j * self.rate * time) * field)

    def velocity(self, points, time):
        k, a, b = self._parts()
        r = np.maximum(np.hypot(*points), 1.0)
        cos, sin = points / np.hypot(*points)
        radial = cos * (a / r**2 + b * kv(1, k * r) / r)
        slope = -kv(0, k * r) - kv(1, k * r) / (k * r)
        turning = -sin * (-a / r**2 + b * k * slope)
        flow = self._now(
            np.stack([radial * cos - turning * sin, radial * sin + turning * cos]), time
        )
        inside = np.hypot(*points) < 1
        flow[0][inside], flow[1][inside] = self._now(1.0, time), 0.0
        return flow

    def vorticity(self, points, time):
        k, _, b = self._parts()
        r = np.hypot(*points)
        sin = points[1] / r
        outside = -b * k**2 * kv(1, k * np.maximum(r, 1.0)) * sin
        return self._now(np.where(r < 1, 0.0, outside), time)

    def pressure(self, angle, time):
        """On the cylinder."""
        return self._now(1j * self.rate * self._parts()[1] * np.cos(angle), time)

    def shear(self, angle, time):
        """On the cylinder, along increasing angle: viscosity times the vorticity at the wall."""
        k, _, b = self._parts()
        return self._now(-self.viscosity * b * k**2 * kv(1, k) * np.sin(angle), time)

    def force(self, time):
        k, _, _ = self._parts()
        return self._now(-math.pi * 1j * self.rate * (1 + 4 * kv(1, k) / (k * kv(0, k))), time)

    def acceleration(self, time):
        return self._now(1j * self.rate, time)


@dataclass(frozen=True)
class Twisting:
    """Spin ``speed * cos(rate t)``, radius 1; rate 0 is steady rotation."""

    speed: float
    rate: float
    viscosity: float

    def _now(self, field, time):
        return np.real(self.speed * np.exp(1j * self.rate * time) * field)

    def _ratio(self, order, r):
        k = cmath.sqrt(1j * self.rate / self.viscosity)
        return kv(order, k * r) / kv(1, k)

    def velocity(self, points, time):
        r = np.hypot(*points)
        out = np.maximum(r, 1.0)
        swirl = self._now(1 / out if self.rate == 0 else self._ratio(1, out), time)
        swirl = np.where(r < 1, self._now(1.0, time) * r, swirl)
        return np.stack([-points[1], points[0]]) / r * swirl

    def vorticity(self, points, time):
        r = np.hypot(*points)
        k = cmath.sqrt(1j * self.rate / self.viscosity)
        outside = (
            0 * r if self.rate == 0 else self._now(-k * self._ratio(0, np.maximum(r, 1)), time)
        )
        return np.where(r < 1, 2 * self._now(1.0, time), outside)

    def torque(self, time):
        k = cmath.sqrt(1j * self.rate / self.viscosity)
        slope = 2 if self.rate == 0 else k * self._ratio(2, 1.0)
        return self._now(-2 * math.pi * self.viscosity * slope, time)

    def acceleration(self, time):
        return self._now(1j * self.rate, time)
