"""The one system by which bodies hold the fluid, whatever carries the force to the mesh.

A force is a vector g of the carrier; ``spread`` makes it an impulse density on the mesh, and
``felt``, its adjoint, takes a velocity from the mesh to the carrier. With A the velocity that an
impulse density leaves at the end of the step, r = lambda tau and B the blur of the wall,

    g/r + felt(B A spread(g)) - felt(modes) U = felt(u_s - B u*)
    M U + modes . spread(g) = P

for g and the velocities U of bodies that follow the fluid, M the matrix of the body's masses and
moments of inertia less the fluid's: the fluid's inertia, added mass included, is in A. Symmetric
but for 0.1 %, indefinite with free bodies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.krylov import Solved, solve
from pmesh.bodies.mask import Mask
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError, as_number
from remesh.stencils import curl

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


class Freedom(NamedTuple):
    """Free coordinates of the bodies: velocities and spins that follow from the force.

    Each momentum ``inertia @ values`` at the end of the step is ``push`` less the impulse of the
    force along the mode. The inertia is that of the body less that of the fluid in its place: zero
    for a neutrally buoyant body, negative for a light one.
    """

    modes: Array  # velocity per unit of each coordinate, (m, ndim, *shape)
    inertia: Array  # (m, m), over the cell volume; symmetric, coupled within each body
    push: Array  # (m,), over the cell volume
    likely: Array  # (m,), values to begin from


class Imposed(NamedTuple):
    """What holding the bodies did over a time tau."""

    impulse: Array  # force density times tau on the box, (ndim, *shape) [L/T]
    slip: Array  # sqrt(chi) (u - u_s) at the end, on the box [L/T]
    residual: float  # of the law, root mean square over the body relative to the speed
    iterations: int
    values: tuple[float, ...]  # of the free coordinates [L/T and rad/T]


class Carrier(Protocol):
    """What carries a force to the mesh."""

    @property
    def weight(self) -> float:
        """Nodes' worth of body, for the root mean square of a residual."""

    def spread(self, g: Array) -> Array:
        """Impulse density on the mesh, (ndim, *shape)."""

    def felt(self, velocity: Array) -> Array:
        """A velocity on the mesh as the carrier sees it: the adjoint."""

    def nearest(self, impulse: Array) -> Array:
        """The vector whose spread is nearest to an impulse density."""

    def on_mesh(self, g: Array) -> Array | None:
        """A vector on the nodes that it belongs to; None if it belongs to none."""

    @property
    def inside(self) -> Array:
        """Weight of the slip on the mesh: sqrt(chi) where the fluid is meant to be held."""


@dataclass(frozen=True, kw_only=True)
class Held:
    """A step's fluid and bodies: what `hold` is asked."""

    mask: Mask
    solver: VelocitySolver
    rate: float  # lambda tau
    spread: float  # viscosity tau [L^2]
    blur: float = 0.0  # b of the felt velocity u + b h^2 laplace(u)
    freedom: Freedom | None = None

    def induced(self, impulse: Array) -> Array:
        """Velocity that an impulse density induces at the end of the step."""
        created = curl(impulse, self.mask.grid, order=4, edge="zero")
        smoothing = ("phi1", self.spread) if self.spread > 0 else None
        return self.solver.velocity(created, smoothing=smoothing)

    def blurred(self, velocity: Array) -> Array:
        """``u + blur h^2 laplace(u)`` where the neighbours are on the box."""
        if not self.blur:
            return velocity
        ndim = velocity.ndim - 1
        inner = (slice(None), *(slice(1, -1),) * ndim)
        change = -2 * ndim * velocity[inner]
        for axis in range(1, ndim + 1):
            for part in (slice(None, -2), slice(2, None)):
                change += velocity[(*inner[:axis], part, *inner[axis + 1 :])]
        result = velocity.copy()
        result[inner] += velocity.dtype.type(self.blur) * change
        return result


def hold(
    velocity: Array,
    carrier: Carrier,
    held: Held,
    *,
    speed: float,
    tolerance: float,
    iterations: int,
    guess: Array | None = None,
    what: str,
) -> Imposed:
    """Hold the fluid to the bodies over a time tau.

    ``velocity``: at the end of the step without the force, on the mask's box [L/T]; ``speed``: the
    reference [L/T]; ``guess``: an impulse density to begin from. The sum of the impulse is the
    momentum given to the fluid; along free modes it is exact to round-off. Stops when the residual
    is within ``tolerance * speed``; raises BlowUpError, which names ``what``, if it never is.
    """
    known = carrier.felt(held.mask.velocity.astype(velocity.dtype) - held.blurred(velocity))
    system = _System(carrier, held, velocity.shape, known.shape)
    g = np.zeros_like(known) if guess is None else carrier.nearest(guess)
    begin = system.joined(g, system.freedom.likely / system.scale**2)
    rest = system.joined(known, -system.freedom.push) - system.apply(begin)
    target = carrier.weight * (tolerance * speed) ** 2
    found = solve(system.apply, begin, rest, target=target, iterations=iterations)
    residual = float(np.sqrt(found.residual / carrier.weight)) / speed
    if not found.residual <= target:
        raise BlowUpError(
            f"{what} left a slip residual of {residual:.2e} after {found.iterations} "
            f"iterations, asked for {tolerance:.1e}",
            hint=f"a smaller {what.split()[-1]} strength, or a larger tolerance",
        )
    return system.outcome(found, velocity, residual)


class _System:
    """The matrix for g and, scaled, the values of the free coordinates."""

    def __init__(
        self, carrier: Carrier, held: Held, mesh: tuple[int, ...], shape: tuple[int, ...]
    ) -> None:
        self.carrier, self.held, self.shape = carrier, held, shape
        none = np.zeros(0)
        nothing = Freedom(np.zeros((0, *mesh)), np.zeros((0, 0)), none, none)
        self.freedom = held.freedom or nothing
        felt = [carrier.felt(mode.astype(held.solver.dtype)) for mode in self.freedom.modes]
        self.modes = np.array([mode.ravel() for mode in felt], held.solver.dtype)
        self.modes = self.modes.reshape(len(felt), math.prod(shape))
        sizes = np.sum(np.square(self.modes, dtype=np.float64), axis=1)
        self.scale = 1.0 / np.sqrt(sizes + np.abs(np.diag(self.freedom.inertia)))

    def apply(self, unknown: Array) -> Array:
        """The matrix times g and the scaled values."""
        g, values = self.parted(unknown)
        induced = self.held.blurred(self.held.induced(self.carrier.spread(g)))
        image = g / g.dtype.type(self.held.rate) + self.carrier.felt(induced)
        moments = self.freedom.inertia @ values
        image = image.ravel()
        if len(values):  # in one thread: these are small
            image -= np.einsum("m,mn->n", values.astype(g.dtype), self.modes)
            moments = moments + np.einsum("mn,n->m", self.modes, g.ravel())
        return self.joined(image, -moments)

    def joined(self, g: Array, moments: Array) -> Array:
        """One flat vector of g and momenta, which are scaled."""
        return np.concatenate([g.ravel(), (self.scale * moments).astype(g.dtype)])

    def parted(self, unknown: Array) -> tuple[Array, Values]:
        """g and the values of the coordinates in one flat vector."""
        cut = len(unknown) - len(self.scale)
        values = self.scale * unknown[cut:].astype(np.float64)
        return unknown[:cut].reshape(self.shape), values

    def outcome(self, found: Solved, velocity: Array, residual: float) -> Imposed:
        """The impulse, with the momenta that the coordinates ask for to round-off, and the slip."""
        g, values = self.parted(found.solution)
        impulse = self.carrier.spread(g)
        if len(values):
            modes = self.freedom.modes.reshape(len(values), -1)
            asked = self.freedom.push - self.freedom.inertia @ values
            missing = asked - modes @ impulse.ravel().astype(np.float64)
            weighted = self.modes.astype(np.float64)
            share = np.linalg.solve(weighted @ weighted.T, missing) @ weighted
            impulse = impulse + self.carrier.spread(share.reshape(self.shape).astype(g.dtype))
        return Imposed(
            impulse=impulse,
            slip=self._slip(found, impulse, velocity, values),
            residual=residual,
            iterations=found.iterations,
            values=tuple(float(value) for value in values),
        )

    def _slip(self, found: Solved, impulse: Array, velocity: Array, values: Values) -> Array:
        """sqrt(chi) (u - u_s) on the mesh."""
        mask = self.held.mask
        if not self.held.blur:  # the law itself tells it
            g, rest = self.parted(found.solution)[0], self.parted(found.rest)[0]
            told = self.carrier.on_mesh(-g / g.dtype.type(self.held.rate) - rest)
            if told is not None:
                return told
        matter = mask.velocity + np.tensordot(values, self.freedom.modes, axes=1)
        left = velocity + self.held.induced(impulse) - matter
        return np.asarray(self.carrier.inside * left, velocity.dtype)


def check_settings(name: str, settings: Any, ranges: dict[str, tuple[float, float]]) -> None:
    """Refuse settings outside of their ranges."""
    for part, (low, high) in ranges.items():
        hint = f"{part}={getattr(type(settings), part)}"
        value = as_number(f"{name} {part}", getattr(settings, part), hint=hint)
        whole = part == "iterations"
        if not low <= value <= high or (whole and value % 1):
            kind = "a whole number" if whole else "a number"
            raise InputError(
                f"{name} {part} must be {kind} from {low:g} to {high:g}, got {value:g}", hint=hint
            )
