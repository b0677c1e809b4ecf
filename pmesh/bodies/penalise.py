"""Implicit penalisation: the force density that holds the fluid to the bodies' velocity.

Over a step tau the force density f [L/T^2] is constant, ``f = lambda chi (u_s - u)`` with the
velocity u at the end of the step, which the force itself changes by ``A f``: curl(f) becomes
vorticity, spreads for the time tau (phi1, exact for a constant source) and induces velocity.
With ``f = sqrt(chi) g / tau`` this is the system

    (1/(lambda tau) + sqrt(chi) A sqrt(chi)) g = sqrt(chi) (u_s - u*)

for the velocity u* without the force, symmetric but for 0.1 %: the curl of the force is a compact
difference, so that the impulse it gives is exact, the curl of the velocity is exact. Velocities of
bodies that follow the fluid are further unknowns U, and their momenta further equations:

    M U = P - sum of f tau along the body's rigid motions,

M the body's mass less the fluid's: the fluid's inertia, added mass included, is in A. So a body of
any density, lighter than the fluid too, moves with no iteration between fluid and body. Conjugate
residuals iterate the system on a box around the bodies only: in free space that is the same
convolution as on the whole mesh. The cost grows with the box around all bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.hold import Held, Imposed, check_settings, hold
from pmesh.bodies.mask import Mask

Array = NDArray[np.floating[Any]]
RANGES = {  # outside of these the wall is not where its offset says
    "strength": (10.0, 1e6),
    "width": (0.5, 8.0),
    "tolerance": (1e-12, 0.1),
    "iterations": (1, 1_000_000),
    "thinnest": (3.0, 1e3),
}


@dataclass(frozen=True, kw_only=True)
class Penalisation:
    """How bodies are imposed on the flow.

    ``strength`` = lambda h^2/nu sets the Brinkman layer, h / sqrt(strength) thick: a larger one
    slips less and costs more iterations. ``width``: half width of the body's indicator in spacings.
    ``tolerance``: slip residual, root mean square over the body relative to the reference speed.
    ``sharp``: the indicator is the square of its ramp, and no fluid passes beside the wall; with
    width 2.5 and strength 1e4 the drag then converges with almost second order, at two to three
    times the iterations. Not for bodies thinner than about 16 spacings. ``thinnest``: spacings
    between the walls of a body at its thickest place, below which it is refused; a coarse mesh sees
    a swimmer in space, which is taller than wide, with 4 too, but not well what it sheds.
    """

    strength: float = 1000.0
    width: float = 1.5
    tolerance: float = 1e-5
    iterations: int = 500
    sharp: bool = False
    thinnest: float = 8.0

    def __post_init__(self) -> None:
        """Refuse values that cannot hold a body."""
        check_settings("penalisation", self, RANGES)


def penalise(
    velocity: Array,
    held: Held,
    *,
    speed: float,
    settings: Penalisation,
    guess: Array | None = None,
) -> Imposed:
    """Hold the fluid to the bodies over a time tau by the indicator: see `hold`."""
    return hold(
        velocity, _Indicator(held.mask, velocity.dtype), held, speed=speed, guess=guess,
        tolerance=settings.tolerance, iterations=settings.iterations, what="the penalisation",
    )  # fmt: skip


class _Indicator:
    """A force density ``f tau = sqrt(chi) g`` on the nodes where that is not zero."""

    def __init__(self, mask: Mask, dtype: np.dtype[Any]) -> None:
        self.inside = mask.root.astype(dtype, copy=False)
        self.weight = max(float(mask.chi.sum(dtype=np.float64)), 1.0)
        self.nodes = np.flatnonzero(self.inside > 0)
        self.root = self.inside.ravel()[self.nodes]

    def spread(self, g: Array) -> Array:
        """sqrt(chi) g on the mesh, from g on the body's nodes (ndim, n)."""
        return self.on_mesh(self.root * g)

    def felt(self, velocity: Array) -> Array:
        """sqrt(chi) u on the body's nodes (ndim, n)."""
        return np.asarray(self.root * self._own(velocity))

    def nearest(self, impulse: Array) -> Array:
        """impulse / sqrt(chi)."""
        return np.asarray(self._own(impulse).astype(self.root.dtype, copy=False) / self.root)

    def on_mesh(self, g: Array) -> Array:
        """Values (ndim, n) of the body's nodes on the mesh, zero elsewhere."""
        result = np.zeros((len(g), self.inside.size), g.dtype)
        result[:, self.nodes] = g
        return result.reshape(len(g), *self.inside.shape)

    def _own(self, field: Array) -> Array:
        return field.reshape(len(field), -1)[:, self.nodes]
