"""Thin-ring theory: the differential equations of coaxial rings whose cores keep their volume."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Vector = NDArray[np.float64]

# speed constants C of thin rings by their core; Saffman, Vortex Dynamics (1992), ch. 10
GAUSSIAN_CORE = 0.5 - 0.5 * (float(np.euler_gamma) - math.log(2.0))  # 0.5579658
UNIFORM_CORE = 0.25
HOLLOW_CORE = 0.5


def thin_ring_speed(
    radius: float, core: float, circulation: float, constant: float = GAUSSIAN_CORE
) -> float:
    """``Gamma/(4 pi R) [ln(8R/a) - C]`` [L/T], up to relative order (a/R)^2 ln(R/a).

    The Gaussian core is ``exp(-s^2/a^2)``. Source: P. G. Saffman, Stud. Appl. Math. 49 (1970) 371.
    """
    return circulation / (4.0 * math.pi * radius) * (math.log(8.0 * radius / core) - constant)


def filament_stream(r: Vector, z: Vector, radius: Vector) -> Vector:
    """Stream function of a circular filament of unit circulation at z = 0 [L^3/T over Gamma].

    ``psi = sqrt(rR)/(2 pi) [(2/k - k) K - 2/k E]``, ``k^2 = 4rR/((r + R)^2 + z^2)``;
    ``u_z = dpsi/dr / r, u_r = -dpsi/dz / r``. Source: H. Lamb, Hydrodynamics, art. 161.
    """
    from scipy.special import ellipe, ellipk  # imported late: scipy is slow to load

    m = 4.0 * r * radius / ((r + radius) ** 2 + z * z)
    k = np.sqrt(m)
    whole = (2.0 / k - k) * ellipk(m) - 2.0 / k * ellipe(m)
    return np.asarray(np.sqrt(r * radius) / (2.0 * math.pi) * whole)


def filament_velocity(r: Vector, z: Vector, radius: Vector) -> tuple[Vector, Vector]:
    """(u_r, u_z) of a circular filament of unit circulation at z = 0, off the filament, r > 0."""
    from scipy.special import ellipe, ellipkm1

    far = (r + radius) ** 2 + z * z
    near = (r - radius) ** 2 + z * z
    first, second = ellipkm1(near / far), ellipe(4.0 * r * radius / far)
    scale = 1.0 / (2.0 * math.pi * np.sqrt(far))
    along = scale * (first + (radius**2 - r * r - z * z) / near * second)
    out = scale * z / r * (-first + (radius**2 + r * r + z * z) / near * second)
    return np.asarray(out), np.asarray(along)


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """What rings did: one row per ring."""

    times: Vector  # (t,) [T]
    radii: Vector  # (rings, t) [L]
    heights: Vector  # (rings, t) [L]


@dataclass(frozen=True, kw_only=True)
class CoaxialRings:
    """Thin coaxial rings, each with a core that keeps its volume, ``a^2 R`` constant.

    ``dR_i/dt = sum_j u_r``, ``dZ_i/dt = Gamma_i/(4 pi R_i) [ln(8 R_i/a_i) - C] + sum_j u_z``, the
    velocities those of circular filaments. Hamiltonian: ``2 pi Gamma_i R_i dZ_i/dt = dE/dR_i``,
    ``2 pi Gamma_i R_i dR_i/dt = -dE/dZ_i``; impulse and energy are kept. Cores must stay small
    against radii and distances. Sources: F. W. Dyson, Phil. Trans. R. Soc. A 184 (1893) 1041;
    A. V. Borisov, A. A. Kilin, I. S. Mamaev, Regul. Chaotic Dyn. 18 (2013) 33.
    """

    radii: tuple[float, ...] = (1.0, 1.0)  # R at t = 0 [L]
    heights: tuple[float, ...] = (-0.5, 0.5)  # Z at t = 0 [L]
    circulations: tuple[float, ...] = (1.0, 1.0)  # Gamma [L^2/T]
    cores: tuple[float, ...] = (0.1, 0.1)  # a at t = 0 [L]
    constant: float = GAUSSIAN_CORE  # C, the same for all

    def __post_init__(self) -> None:
        """Refuse lists of unequal length, sizes that are not positive, two rings in one place."""
        lengths = {len(self.radii), len(self.heights), len(self.circulations), len(self.cores)}
        if len(lengths) != 1 or 0 in lengths:
            raise InputError(
                "CoaxialRings: radii, heights, circulations and cores must be as many, got "
                f"{len(self.radii)}, {len(self.heights)}, {len(self.circulations)}, "
                f"{len(self.cores)}",
                hint="one number per ring in each",
            )
        if not all(math.isfinite(v) and v > 0.0 for v in self.radii + self.cores):
            raise InputError(
                f"CoaxialRings: radii and cores must be positive, got {self.radii}, {self.cores}",
                hint="CoaxialRings(radii=(1, 1), cores=(0.1, 0.1))",
            )
        if len(set(zip(self.radii, self.heights, strict=True))) < len(self.radii):
            raise InputError("CoaxialRings: two rings in one place", hint="heights=(-0.5, 0.5)")

    def _arrays(self) -> tuple[Vector, Vector, Vector, Vector]:
        """Radii, heights, circulations, and the kept a^2 R."""
        radii, cores = np.asarray(self.radii, float), np.asarray(self.cores, float)
        return (
            radii,
            np.asarray(self.heights, float),
            np.asarray(self.circulations, float),
            cores**2 * radii,
        )

    def _logarithms(self, radii: Vector) -> Vector:
        """ln(8R/a), the cores thinned or thickened by the radii."""
        volume = self._arrays()[3]
        return np.log(8.0 * radii * np.sqrt(radii / volume))

    def rates(self, radii: Vector, heights: Vector) -> tuple[Vector, Vector]:
        """dR/dt and dZ/dt [L/T] of rings that are now at ``radii`` and ``heights`` [L]."""
        strength = self._arrays()[2]
        out = np.zeros_like(radii)
        along = strength / (4.0 * math.pi * radii) * (self._logarithms(radii) - self.constant)
        for i, j in self._pairs():
            u_r, u_z = filament_velocity(radii[i], heights[i] - heights[j], radii[j])
            out[i] += strength[j] * u_r
            along[i] += strength[j] * u_z
        return out, along

    def _pairs(self) -> list[tuple[int, int]]:
        """All ordered pairs of two different rings."""
        count = len(self.radii)
        return [(i, j) for i in range(count) for j in range(count) if i != j]

    def impulse(self, radii: Vector | None = None) -> float:
        """Sum of pi Gamma R^2 [L^4/T], along the axis; now or at ``radii``."""
        start, _, strength, _ = self._arrays()
        now = start if radii is None else np.asarray(radii, float)
        return float(math.pi * np.sum(strength * now**2))

    def energy(self, radii: Vector | None = None, heights: Vector | None = None) -> float:
        """Sum of ``Gamma^2 R/2 [ln(8R/a) - C - 3/2]`` and of 2 pi Gamma_i psi_j [L^5/T^2]."""
        start, level, strength, _ = self._arrays()
        now = start if radii is None else np.asarray(radii, float)
        z = level if heights is None else np.asarray(heights, float)
        own = 0.5 * strength**2 * now * (self._logarithms(now) - self.constant - 1.5)
        total = float(np.sum(own))
        for i, j in self._pairs():
            if i < j:
                psi = filament_stream(now[i], z[i] - z[j], now[j])
                total += 2.0 * math.pi * float(strength[i] * strength[j] * psi)
        return total

    def trajectory(self, times: Vector, *, tolerance: float = 1e-10) -> Trajectory:
        """Radii and heights at ``times`` [T], the first being the start; error near tolerance."""
        times = np.asarray(times, float)
        answer = self._solve((times[0], times[-1]), tolerance, t_eval=times)
        count = len(self.radii)
        return Trajectory(times=times, radii=answer.y[:count], heights=answer.y[count:])

    def leapfrog_period(self, *, longest: float = math.inf, tolerance: float = 1e-10) -> float:
        """Time in which two rings pass through each other twice and stand as before [T].

        From one moment with equal heights to the next but one. The relative motion of two
        rings is one closed orbit, or open: ``math.inf`` where the rings do not come back
        within ``longest`` (200 times their turning time without it). Rings much closer than
        their radius turn about each other as point vortices, period ``4 pi^2 d^2/(Gamma_1 +
        Gamma_2)``. Refuses other than two rings.
        """
        if len(self.radii) != 2:
            raise InputError(
                f"leapfrog_period is defined for two rings, got {len(self.radii)}",
                hint="trajectory(times), for any number",
            )
        radii, heights, strength, _ = self._arrays()
        distance = math.hypot(radii[0] - radii[1], heights[0] - heights[1])
        turn = 4.0 * math.pi**2 * distance**2 / max(float(np.sum(np.abs(strength))), 1e-300)
        span = longest if math.isfinite(longest) else 200.0 * turn

        def level(_: float, state: Vector) -> float:
            return float(state[2] - state[3])

        answer = self._solve((0.0, span), tolerance, events=_ending(level, 4))
        crossings = [t for t in answer.t_events[0] if t > 1e-3 * turn]  # the start is left out
        if len(crossings) < 3:
            return math.inf
        return float(crossings[2] - crossings[0])

    def _solve(self, span: tuple[float, float], tolerance: float, **options: Any) -> Any:
        """Integrate the rings over a span of time."""
        from scipy.integrate import solve_ivp

        count = len(self.radii)

        def law(_: float, state: Vector) -> Vector:
            return np.concatenate(self.rates(state[:count], state[count:]))

        radii, heights, _, _ = self._arrays()
        start = np.concatenate([radii, heights])
        scale = tolerance * float(radii.max())
        return solve_ivp(law, span, start, method="DOP853", rtol=tolerance, atol=scale, **options)


def _ending(law: Any, count: int) -> Any:
    """The law as an event of solve_ivp that ends the run when it has happened ``count`` times."""
    law.terminal = count
    return law
