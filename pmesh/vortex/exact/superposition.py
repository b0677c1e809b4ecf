"""Sums of flows: vorticity, velocity and the invariants that are linear in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import Array, as_array
from remesh.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Superposition:
    """Several flows at once, of the same number of dimensions; a start, not a solution.

    Energy, helicity and enstrophy of a sum are not sums: for tubes, which know their mutual parts,
    write ``one + other`` instead.
    """

    parts: tuple[Any, ...]

    def __post_init__(self) -> None:
        """Refuse parts without vorticity."""
        if not self.parts or not all(hasattr(part, "vorticity") for part in self.parts):
            raise InputError(
                f"Superposition: parts must be flows with a vorticity, got {self.parts}",
                hint="Superposition(parts=(HillVortex(), VortexRing()))",
            )

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity [1/T] at ``points`` (ndim, ...) [L], of all parts."""
        return as_array(sum(part.vorticity(points, time) for part in self.parts))

    def velocity(self, points: Array, time: float = 0.0) -> Array:
        """Velocity [L/T] at ``points`` (ndim, ...) [L], of all parts that know theirs."""
        self._need("velocity")
        return as_array(sum(part.velocity(points, time) for part in self.parts))

    @property
    def impulse(self) -> NDArray[np.float64]:
        """Sum of the parts' impulses at t = 0, (3,) [L^4/T]."""
        self._need("impulse")
        parts = (part.impulse for part in self.parts)
        return np.asarray(np.sum([p() if callable(p) else p for p in parts], axis=0))

    def _need(self, name: str) -> None:
        """Refuse a sum of what a part does not know."""
        for part in self.parts:
            if not hasattr(part, name):
                raise InputError(
                    f"Superposition: {type(part).__name__} has no {name} in closed form",
                    hint="pmesh.velocity(vorticity, grid)" if name == "velocity" else None,
                )
