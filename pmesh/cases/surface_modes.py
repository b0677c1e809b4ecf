"""Waves that keep their shape while they spread along a surface: on the sphere, on a torus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from levelset.shapes import Sphere
from levelset.solids import Torus

Values = NDArray[np.float64]
Mode = Callable[[Values], Values]  # values at points (ndim, n) of the surface
TUBE = 0.5  # radius of the torus's tube, over that of its ring
RULE = 12, 24  # nodes along height or tube, and around


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Eigenfunctions of a surface's Laplacian, and a rule that tells them apart."""

    shape: Shape
    names: tuple[str, ...]
    rates: tuple[float, ...]  # of decay, for D = 1 [1/L^2]
    modes: tuple[Mode, ...]
    points: Values  # (n, 3) on the surface
    weights: Values  # of the rule

    def start(self, points: Values) -> Values:
        """One, and all modes."""
        return np.asarray(1.0 + sum(mode(points) for mode in self.modes))

    def amplitudes(self, values: Values) -> Values:
        """Of the modes in values at the rule's points."""
        known = [mode(self.points.T) for mode in self.modes]
        return np.array([self.weights @ (m * values) / (self.weights @ m**2) for m in known])


@lru_cache(maxsize=2)
def sphere() -> Modes:
    """Spherical harmonics of degree l = 1, 2, 3 on the unit sphere: rates l (l + 1)."""
    height, weight = np.polynomial.legendre.leggauss(RULE[0])
    turn = np.arange(RULE[1]) * 2 * np.pi / RULE[1]
    z, around = np.meshgrid(height, turn, indexing="ij")
    r = np.sqrt(1 - z * z)
    points = np.stack([r * np.cos(around), r * np.sin(around), z], axis=-1).reshape(-1, 3)
    return Modes(
        shape=Sphere(1.0),
        names=("l = 1", "l = 2", "l = 3"),
        rates=(2.0, 6.0, 12.0),
        modes=(
            lambda p: p[2],
            lambda p: p[0] ** 2 - p[1] ** 2,
            lambda p: p[0] * (5 * p[2] ** 2 - 1),
        ),
        points=points,
        weights=np.repeat(weight, RULE[1]),
    )


@lru_cache(maxsize=2)
def torus(count: int = 64) -> Modes:
    """The first three waves around the tube of a torus of ring radius 1.

    With w = 1 + r cos the law is c_t = (w c')'/(r^2 w), a Sturm-Liouville problem in the angle of
    the tube; solved by Fourier series, to round-off.
    """
    turn = np.arange(count) * 2 * np.pi / count
    number = np.fft.fftfreq(count, 1 / count)
    slope = np.real(np.fft.ifft(1j * number[:, None] * np.fft.fft(np.eye(count), axis=0), axis=0))
    root = np.sqrt(1 + TUBE * np.cos(turn))
    half = slope * root[None, :] ** -1 * root[:, None]  # of root c: a symmetric problem
    rates, vectors = np.linalg.eigh(half.T @ half / TUBE**2)
    waves = [vectors[:, k] / root for k in np.argsort(rates) if rates[k] > 1e-6 * rates.max()][:3]
    found = sorted(rate for rate in rates if rate > 1e-6 * rates.max())[:3]
    around = np.arange(RULE[1]) * 2 * np.pi / RULE[1]
    tube, ring = np.meshgrid(turn, around, indexing="ij")
    out = 1 + TUBE * np.cos(tube)
    points = np.stack([out * np.cos(ring), out * np.sin(ring), TUBE * np.sin(tube)], axis=-1)
    return Modes(
        shape=Torus(1.0, TUBE),
        names=("wave 1", "wave 2", "wave 3"),
        rates=(float(found[0]), float(found[1]), float(found[2])),
        modes=(_wave(waves[0]), _wave(waves[1]), _wave(waves[2])),
        points=points.reshape(-1, 3),
        weights=out.ravel(),
    )


def _wave(samples: Values) -> Mode:
    """The Fourier series through samples around the tube, its largest size one."""
    series = np.fft.rfft(samples / np.abs(samples).max()) / len(samples)
    kept = np.flatnonzero(np.abs(series) > 1e-14)

    def mode(points: Values) -> Values:
        turn = np.arctan2(points[2], np.hypot(points[0], points[1]) - 1.0)
        total = np.zeros_like(turn)
        for k in kept:
            part = series[k] * np.exp(1j * k * turn)
            total += part.real if k == 0 else 2.0 * part.real
        return np.asarray(total)

    return mode
