"""Direct forcing: the impulse on markers of the bodies that gives the fluid there their velocity.

The immersed-boundary force ``f = (u_desired - u)/dt - (-grad p + div tau)`` per unit density:
``u* = u + dt (-grad p + div tau)`` is the velocity at the end of the step without the force, so
``f dt = u_desired - u*`` on the boundary. In vorticity form u* is what advection and spread leave.
Impulses q of markers go to the mesh by a remeshing kernel (p2m), their curl becomes vorticity, and
the velocity comes back by the same kernel (m2p), its adjoint. Forcing once leaves slip, because
markers share nodes and the pressure answers: the impulses solve

    E A E^T q = u_desired - E u*

up to the slip of a soft law, f / lambda, which keeps the forces smooth. Conjugate residuals find
them from the last force (Luo et al. 2007 repeat the forcing, Taira & Colonius 2007 solve for it).
The first line of markers is retracted so that the flow sees the wall at distance zero (Breugem
2012), and the felt velocity sharpened a little so that nothing blows through it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.hold import Held, Imposed, check_settings, hold
from pmesh.bodies.krylov import solve
from pmesh.bodies.markers import KERNEL, Markers
from pmesh.bodies.mask import Mask
from remesh.kernels import get_kernel
from remesh.transfer import m2p, p2m

Array = NDArray[np.floating[Any]]
RANGES = {
    "strength": (10.0, 1e6),
    "spacing": (0.5, 2.0),
    "tolerance": (1e-12, 0.1),
    "iterations": (1, 1_000_000),
}
NEAREST = 1e-6  # of a guessed force that its markers may miss


@dataclass(frozen=True, kw_only=True)
class DirectForcing:
    """How bodies are imposed on the flow by forces of markers.

    ``strength`` = lambda h^2/nu, as in a penalisation: markers leave the slip ``f / lambda`` for a
    force density f, which makes their forces smooth. ``spacing`` of the markers along a line, in
    spacings of the mesh. Lines lie one spacing apart and fill the body, so that the fluid inside
    follows it.
    ``tolerance``: slip residual, root mean square over the markers relative to the reference
    speed.
    """

    strength: float = 1000.0
    spacing: float = 1.0
    tolerance: float = 1e-5
    iterations: int = 500

    def __post_init__(self) -> None:
        """Refuse values that cannot hold a body."""
        check_settings("forcing", self, RANGES)

    @property
    def width(self) -> float:
        """How far from the first line the force reaches, in spacings, and one more."""
        return get_kernel(KERNEL).half_width + 1.0


def force(
    velocity: Array,
    markers: Markers,
    held: Held,
    *,
    speed: float,
    settings: DirectForcing,
    guess: Array | None = None,
) -> Imposed:
    """Give the fluid at the markers the bodies' velocity at the end of a time tau: see `hold`.

    The impulse and its moment on the mesh are those of the markers. ``slip`` of the result is on
    the mesh, in the bodies. One solve on the box per iteration and two more.
    """
    return hold(
        velocity, _Lines(held.mask, markers, velocity.dtype), held, speed=speed, guess=guess,
        tolerance=settings.tolerance, iterations=settings.iterations, what="direct forcing",
    )  # fmt: skip


class _Lines:
    """Impulses of markers, each with the square root of its share of the body."""

    def __init__(self, mask: Mask, markers: Markers, dtype: np.dtype[Any]) -> None:
        self.grid, self.places, self.dtype = mask.grid, markers.positions, dtype
        self.root = np.sqrt(markers.weight).astype(dtype)[:, None]
        self.weight = float(markers.weight.sum())
        self.inside = np.where(mask.chi > 0.5, mask.root, 0.0)  # the rest reaches the fluid

    def spread(self, g: Array) -> Array:
        """Impulse density on the mesh from the markers' scaled impulses (n, ndim)."""
        strengths = self.root * g * self.grid.cell_volume
        return p2m(self.places, strengths, self.grid, KERNEL, outside="drop", threads=1)

    def felt(self, velocity: Array) -> Array:
        """A field at the markers, scaled, (n, ndim)."""
        field = np.ascontiguousarray(velocity, self.dtype)
        return self.root * m2p(field, self.places, self.grid, KERNEL, outside="drop", threads=1)

    def on_mesh(self, g: Array) -> None:
        """None: markers lie between nodes."""

    def nearest(self, impulse: Array) -> Array:
        """The markers' impulses whose spread is nearest to a density, in the kernel's own norm."""
        known = self.felt(impulse)
        found = solve(
            lambda unknown: self.felt(self.spread(unknown.reshape(known.shape))).ravel(),
            np.zeros(known.size, self.dtype),
            known.ravel(),
            target=NEAREST**2 * float(np.sum(known**2)),
            iterations=60,
        )
        return found.solution.reshape(known.shape)
