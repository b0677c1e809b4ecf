"""Closed vortex tubes with Gaussian cores: fields and invariants shared by rings and knots."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import Array, check_start, relative
from remesh.errors import InputError

_PER_CORE = 2.0  # nodes per core radius: the trapezoidal rule is then exact to 1e-16
_MOST = 40_000  # nodes of one filament


@dataclass(frozen=True, kw_only=True)
class Filament:
    """A closed line cut into elements; the elements add up to zero."""

    nodes: NDArray[np.float64]  # (n, 3) [L]
    elements: NDArray[np.float64]  # (n, 3), dX at the nodes [L]
    circulation: float  # Gamma [L^2/T]
    core: float  # a [L]


def closed_filament(curve: NDArray[np.float64], circulation: float, core: float) -> Filament:
    """The filament through nodes (3, n) at even parameters; its tangent is spectral."""
    count = curve.shape[1]
    waves = np.fft.rfftfreq(count, 1.0 / count)
    waves[-1] *= count % 2  # the highest wave of an even count has no derivative
    tangent = np.fft.irfft(1j * waves * np.fft.rfft(curve), count)
    elements = np.ascontiguousarray(tangent.T) * (2.0 * math.pi / count)
    return Filament(
        nodes=np.ascontiguousarray(curve.T), elements=elements, circulation=circulation, core=core
    )


class Tubes(ABC):
    """Vortex tubes: closed lines of strength Gamma, each smoothed by a Gaussian of core a.

    ``w(x) = sum Gamma int g(x - X) dX``, ``g = exp(-r^2/a^2)/(sqrt(pi) a)^3``. Divergence-free
    without approximation, since the lines close; the profile across a tube is
    ``Gamma/(pi a^2) exp(-s^2/a^2) [1 + O(a/R)]`` where R is the radius of curvature. Velocity,
    impulse, energy, helicity and enstrophy follow from the lines by sums that converge faster
    than any power: exact to round-off at the nodes chosen. All is in free space, no periodic
    images. ``one + other`` are both together.
    """

    @abstractmethod
    def filaments(self) -> tuple[Filament, ...]:
        """The lines, cut finely enough for their cores."""

    def __add__(self, other: Tubes) -> VortexTubes:
        """Both flows together, energy and helicity between them included."""
        if not isinstance(other, Tubes):
            return NotImplemented
        return VortexTubes(parts=(self, other))

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity (3, ...) [1/T] at ``points`` (3, ...) [L]; costs points times nodes."""
        from pmesh.vortex.exact._tube import add_core  # imported late: numba is slow to load

        return self._summed(add_core, points, time)

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity (3, ...) [L/T] at ``points`` (3, ...) [L], at rest far away; meant for few."""
        from pmesh.vortex.exact._tube import add_velocity

        return self._summed(add_velocity, points, time)

    def _summed(self, law: Any, points: Array, time: float) -> Array:
        """One of the compiled sums over all filaments."""
        check_start(self, time)
        points = relative(points, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
        places = np.ascontiguousarray(points.reshape(3, -1).T)
        out = np.zeros_like(places)
        for line in self.filaments():
            law(places, line.nodes, line.elements, line.circulation, line.core, out)
        return np.ascontiguousarray(out.T).reshape(points.shape)

    @property
    def impulse(self) -> NDArray[np.float64]:
        """1/2 int x cross w dV = Gamma/2 int X cross dX, (3,) [L^4/T]; of any core."""
        total = np.zeros(3)
        for line in self.filaments():
            total += 0.5 * line.circulation * np.cross(line.nodes, line.elements).sum(axis=0)
        return total

    @property
    def angular_impulse(self) -> NDArray[np.float64]:
        """-1/2 int |x|^2 w dV = -Gamma/2 int |X|^2 dX about the origin, (3,) [L^5/T]."""
        total = np.zeros(3)
        for line in self.filaments():
            square = np.sum(line.nodes**2, axis=1)
            total -= 0.5 * line.circulation * square @ line.elements
        return total

    @property
    def energy(self) -> float:
        """1/2 int u^2 dV of a fluid at rest far away [L^5/T^2]."""
        return 0.5 * float(self._pairs()[0])

    @property
    def helicity(self) -> float:
        """Int u . w dV [L^4/T^2]: Gamma^2 writhe, plus 2 Gamma_1 Gamma_2 linking per pair."""
        return float(self._pairs()[1])

    @property
    def enstrophy(self) -> float:
        """Int w^2 dV [L^3/T^2]."""
        return float(self._pairs()[2])

    def _pairs(self) -> NDArray[np.float64]:
        """Twice the energy, the helicity and the enstrophy."""
        from pmesh.vortex.exact._tube import pair_sums

        lines = self.filaments()
        total = np.zeros(3)
        for k, one in enumerate(lines):
            for other in lines[: k + 1]:
                both = one.circulation * other.circulation * (1.0 if one is other else 2.0)
                core = math.hypot(one.core, other.core)
                total += both * pair_sums(
                    one.nodes, one.elements, other.nodes, other.elements, core
                )
        return total


@dataclass(frozen=True, kw_only=True)
class VortexTubes(Tubes):
    """Several tubes at once: rings, knots, links of both; made by ``one + other``."""

    parts: tuple[Tubes, ...]

    def __post_init__(self) -> None:
        """Refuse parts that are not tubes."""
        if not self.parts or not all(isinstance(part, Tubes) for part in self.parts):
            raise InputError(
                f"parts must be tubes, got {self.parts}", hint="VortexRing() + TorusKnot()"
            )

    def filaments(self) -> tuple[Filament, ...]:
        """The lines of all parts."""
        return tuple(line for part in self.parts for line in part.filaments())


def node_count(flow: object, longest: float, core: float, waves: int) -> int:
    """Nodes for a curve whose |dX/dangle| is at most ``longest``, with modes up to ``waves``."""
    count = max(2.0 * math.pi * longest / core * _PER_CORE, 8.0 * waves, 64.0)
    if not count <= _MOST:
        raise InputError(
            f"{type(flow).__name__}: a core of {core:.3g} needs {count:.0f} nodes, over {_MOST}",
            hint=f"core={core * count / _MOST:.3g}, or thin_rings.CoaxialRings",
        )
    return 2 * math.ceil(0.5 * count)
