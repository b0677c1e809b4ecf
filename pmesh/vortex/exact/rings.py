"""Vortex rings with Gaussian cores, and the classical pairs of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import (
    Array,
    Triple,
    as_array,
    check,
    check_start,
    check_triple,
    frame,
    relative,
)
from pmesh.vortex.exact.thin_rings import thin_ring_speed
from pmesh.vortex.exact.tubes import Filament, Tubes, VortexTubes, closed_filament, node_count
from remesh.errors import InputError, as_whole

_PANEL, _WEIGHT = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True, kw_only=True)
class VortexRing(Tubes):
    """Ring ``R (1 + amplitude sum sin(n angle + phase))`` with a Gaussian core, any direction.

    The circular filament smoothed in space, ``w_theta = 2 Gamma R/(sqrt(pi) a^3)
    exp(-(r^2 + R^2 + z^2)/a^2) I_1(2 r R/a^2)``: near the core
    ``Gamma/(pi a^2) exp(-s^2/a^2) sqrt(R/r)``, nothing on the axis, divergence-free, perturbed
    or not. The round ring has impulse pi Gamma R^2, flux ``Gamma [1 - exp(-R^2/a^2)]`` through
    a half plane, and is what Stokes flow makes of a thin ring, ``a^2 = 4 nu t``. It moves
    along ``axis`` where Gamma is positive. Fields and invariants: see Tubes.
    Source: F. Kaplanski, Y. Rudi, Phys. Fluids 17 (2005) 087101, for the round ring.
    """

    radius: float = 1.0  # R [L]
    core: float = 0.1  # a [L]
    circulation: float = 1.0  # Gamma [L^2/T]
    center: Triple = (0.0, 0.0, 0.0)  # [L]
    axis: Triple = (0.0, 0.0, 1.0)  # direction of travel, any length
    amplitude: float = 0.0  # of the radius, over R
    modes: tuple[int, ...] = ()  # n, waves around the ring
    phases: tuple[float, ...] = ()  # one per mode; none: all zero

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive, odd vectors, and a radius that could vanish."""
        check(self, positive=("radius", "core"), not_negative=("amplitude",))
        check_triple(self, "center", "axis")
        frame(self.axis)
        for n in self.modes:
            as_whole("VortexRing: a mode", n, least=1, hint="modes=(5,)")
        if self.amplitude and not self.modes:
            raise InputError("VortexRing: an amplitude needs modes", hint="modes=(5,)")
        if self.phases and len(self.phases) != len(self.modes):
            raise InputError(
                f"VortexRing: {len(self.modes)} modes and {len(self.phases)} phases",
                hint="one phase per mode, or none",
            )
        if self.amplitude * len(self.modes) >= 1.0:
            raise InputError(
                f"VortexRing: the radius could vanish, amplitude = {self.amplitude}",
                hint=f"amplitude={0.1 / len(self.modes):.3g}",
            )

    def filaments(self) -> tuple[Filament, ...]:
        """The ring's centre line."""
        waves = max((abs(n) for n in self.modes), default=0)
        longest = self.radius * (1.0 + self.amplitude * sum(1 + abs(n) for n in self.modes))
        count = node_count(self, longest, self.core, waves + 1)
        angle = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
        phases = self.phases or (0.0,) * len(self.modes)
        ripple = np.zeros(count)
        for n, phase in zip(self.modes, phases, strict=True):
            ripple += np.sin(n * angle + phase)
        reach = self.radius * (1.0 + self.amplitude * ripple)
        first, second, _ = frame(self.axis)
        curve = np.asarray(self.center, float)[:, None] + reach * (
            first[:, None] * np.cos(angle) + second[:, None] * np.sin(angle)
        )
        return (closed_filament(curve, self.circulation, self.core),)

    @property
    def speed(self) -> float:
        """Gamma/(4 pi R) [ln(8R/a) - 0.5579658], the law of thin cores [L/T]; see thin_rings."""
        return thin_ring_speed(self.radius, self.core, self.circulation)

    @property
    def centroid_speed(self) -> float:
        """Speed of the round ring's impulse centroid at this instant, for any core [L/T].

        The centroid is ``int r^2 z w dr dz / int r^2 w dr dz``; viscosity does not move it.
        ``U = Gamma/(2R) int_0^inf J_1(x)^2 [(1/2 - 3 s^2) erfc(s) + 3 s exp(-s^2)/sqrt(pi)] dx``
        with ``s = x a/(sqrt(2) R)``: ``int (2 r z u_r + r^2 u_z) w dr dz`` in Fourier space, where
        ``z w = -a^2/2 dw/dz``. Thin cores: ``speed``. Refuses a perturbed ring.
        """
        from scipy.special import erfc, j1  # imported late: scipy is slow to load

        if self.amplitude and self.modes:
            raise InputError(
                "centroid_speed is known for a round ring", hint="VortexRing(amplitude=0)"
            )
        thickness = self.core / (math.sqrt(2.0) * self.radius)
        edges = np.linspace(0.0, 6.0 / thickness, math.ceil(6.0 / thickness) + 8)
        half = 0.5 * np.diff(edges)[:, None]
        x = edges[:-1, None] + half * (1.0 + _PANEL)
        s = thickness * x
        law = (0.5 - 3.0 * s * s) * erfc(s) + 3.0 / math.sqrt(math.pi) * s * np.exp(-s * s)
        total = float(np.sum(half * _WEIGHT * j1(x) ** 2 * law))
        return self.circulation / (2.0 * self.radius) * total


@dataclass(frozen=True, kw_only=True)
class GaussianRing:
    """Round ring whose section is a Gaussian, its mirror image beyond the axis taken off.

    ``w_theta = Gamma/(pi a^2 erf(R/a)) [exp(-((r-R)^2 + z^2)/a^2) - exp(-((r+R)^2 + z^2)/a^2)]``,
    odd in r: smooth and zero on the axis, divergence-free; Gamma is the whole circulation.
    The usual start of computed rings; for thin cores the image is below round-off.
    """

    radius: float = 1.0  # R [L]
    core: float = 0.1  # a [L]
    circulation: float = 1.0  # Gamma [L^2/T]
    center: Triple = (0.0, 0.0, 0.0)  # [L]
    axis: Triple = (0.0, 0.0, 1.0)  # direction of travel, any length

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive and odd vectors."""
        check(self, positive=("radius", "core"), not_negative=())
        check_triple(self, "center", "axis")
        frame(self.axis)

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity (3, ...) [1/T] at ``points`` (3, ...) [L]; refuses any time but zero."""
        check_start(self, time)
        local = relative(points, self.center, (0.0, 0.0, 0.0), 0.0)
        turn = frame(self.axis).astype(local.dtype)
        x, y, z = np.tensordot(turn, local, axes=1)
        square = self.core**2
        r = np.maximum(np.hypot(x, y), np.finfo(local.dtype).tiny ** 0.5)
        peak = self.circulation / (math.pi * square * math.erf(self.radius / self.core))
        bell = peak * np.exp(-((r - self.radius) ** 2 + z * z) / square)
        over_r = bell * -np.expm1(-4.0 * self.radius / square * r) / r
        return as_array(
            np.tensordot(turn.T, np.stack([-y * over_r, x * over_r, np.zeros_like(x)]), axes=1)
        )

    @property
    def impulse(self) -> NDArray[np.float64]:
        """pi Gamma [R^2 + a^2/2 + R a exp(-R^2/a^2)/(sqrt(pi) erf(R/a))] along the axis, (3,)."""
        ratio = self.radius / self.core
        image = math.exp(-(ratio**2)) / (math.sqrt(math.pi) * math.erf(ratio))
        square = self.radius**2 + 0.5 * self.core**2 + self.radius * self.core * image
        return np.asarray(math.pi * self.circulation * square * frame(self.axis)[2])

    @property
    def speed(self) -> float:
        """Gamma/(4 pi R) [ln(8R/a) - 0.5579658], the law of thin cores [L/T]; see thin_rings."""
        return thin_ring_speed(self.radius, self.core, self.circulation)


def leapfrogging(
    *, radius: float = 1.0, gap: float = 1.0, core: float = 0.1, circulation: float = 1.0
) -> VortexTubes:
    """Two equal coaxial rings, one ``gap`` [L] behind the other on the z axis, both moving to +z.

    The origin is midway. Their period by thin-ring theory: CoaxialRings.leapfrog_period.
    """
    rings = (
        VortexRing(radius=radius, core=core, circulation=circulation, center=(0.0, 0.0, z))
        for z in (-0.5 * gap, 0.5 * gap)
    )
    return VortexTubes(parts=tuple(rings))


def head_on(
    *,
    radius: float = 1.0,
    gap: float = 2.0,
    core: float = 0.1,
    circulation: float = 1.0,
    offset: float = 0.0,
    amplitude: float = 0.0,
    modes: tuple[int, ...] = (),
    phases: tuple[float, ...] = (),
) -> VortexTubes:
    """Two equal rings on the z axis, ``gap`` [L] apart, that run into each other at z = 0.

    They are mirror images at z = 0, ripples included, unless ``offset`` [L] parts their axes
    along x. Impulse: zero.
    """
    lower = VortexRing(
        radius=radius,
        core=core,
        circulation=circulation,
        center=(-0.5 * offset, 0.0, -0.5 * gap),
        amplitude=amplitude,
        modes=modes,
        phases=phases,
    )
    # the mirror image of a ring that turns the same lines the other way round
    upper = VortexRing(
        radius=radius,
        core=core,
        circulation=-circulation,
        center=(0.5 * offset, 0.0, 0.5 * gap),
        amplitude=amplitude,
        modes=modes,
        phases=phases,
    )
    return VortexTubes(parts=(lower, upper))


def oblique(
    *,
    radius: float = 1.0,
    distance: float = 3.0,
    angle: float = math.pi / 12.0,
    core: float = 0.3,
    circulation: float = 1.0,
) -> VortexTubes:
    """Two equal rings side by side that travel to +z and towards each other, and reconnect.

    Centres at x = -+distance/2 [L]; each axis leans by ``angle`` [rad] from z towards x = 0.
    Mirror images at x = 0; impulse 2 pi Gamma R^2 cos(angle) along z.
    Source of the arrangement: S. Kida, M. Takaoka, F. Hussain, J. Fluid Mech. 230 (1991) 583.
    """
    if not 0.5 * distance > radius * abs(math.cos(angle)):
        raise InputError(
            f"oblique: rings of radius {radius} at distance {distance} overlap",
            hint=f"distance={3.0 * radius:.3g}",
        )
    lean, up = math.sin(angle), math.cos(angle)
    rings = (
        VortexRing(
            radius=radius,
            core=core,
            circulation=circulation,
            center=(side * 0.5 * distance, 0.0, 0.0),
            axis=(-side * lean, 0.0, up),
        )
        for side in (-1.0, 1.0)
    )
    return VortexTubes(parts=tuple(rings))
