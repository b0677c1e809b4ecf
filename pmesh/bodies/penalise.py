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

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.krylov import solve
from pmesh.bodies.mask import Mask
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError, as_number
from remesh.stencils import curl

Array = NDArray[np.floating[Any]]
RANGES = {  # outside of these the wall is not where its offset says
    "strength": (10.0, 1e6),
    "width": (0.5, 8.0),
    "tolerance": (1e-12, 0.1),
    "iterations": (1, 1_000_000),
}


@dataclass(frozen=True, kw_only=True)
class Penalisation:
    """How bodies are imposed on the flow.

    ``strength`` = lambda h^2/nu sets the Brinkman layer, h / sqrt(strength) thick: a larger one
    slips less and costs more iterations. ``width``: half width of the body's indicator in spacings.
    ``tolerance``: slip residual, root mean square over the body relative to the reference speed.
    ``sharp``: the indicator is the square of its ramp, and no fluid passes beside the wall; with
    width 2.5 and strength 1e4 the drag then converges with almost second order, at two to three
    times the iterations. Not for bodies thinner than about 16 spacings.
    """

    strength: float = 1000.0
    width: float = 1.5
    tolerance: float = 1e-5
    iterations: int = 500
    sharp: bool = False

    def __post_init__(self) -> None:
        """Refuse values that cannot hold a body."""
        for name, (low, high) in RANGES.items():
            hint = f"{name}={getattr(Penalisation, name)}"
            value = as_number(f"penalisation {name}", getattr(self, name), hint=hint)
            if not low <= value <= high or (name == "iterations" and value % 1):
                kind = "a whole number" if name == "iterations" else "a number"
                raise InputError(
                    f"penalisation {name} must be {kind} from {low:g} to {high:g}, got {value:g}",
                    hint=hint,
                )


class Freedom(NamedTuple):
    """Free coordinates of the bodies: velocities and spins that follow from the force.

    Each momentum ``inertia * value`` at the end of the step is ``push`` less the impulse of the
    force along the mode. The inertia is that of the body less that of the fluid in its place: zero
    for a neutrally buoyant body, negative for a light one.
    """

    modes: Array  # velocity per unit of each coordinate, (m, ndim, *shape)
    inertia: Array  # (m,), over the cell volume
    push: Array  # (m,), over the cell volume
    likely: Array  # (m,), values to begin from


class Imposed(NamedTuple):
    """What the penalisation did over a time tau."""

    impulse: Array  # force density times tau on the box, (ndim, *shape) [L/T]
    slip: Array  # sqrt(chi) (u - u_s) at the end, on the box [L/T]
    residual: float  # of the penalisation law, rms over the body relative to the speed
    iterations: int
    values: tuple[float, ...]  # of the free coordinates [L/T and rad/T]


def penalise(
    velocity: Array,
    mask: Mask,
    solver: VelocitySolver,
    *,
    rate: float,
    spread: float,
    speed: float,
    settings: Penalisation,
    guess: Array | None = None,
    freedom: Freedom | None = None,
    blur: float = 0.0,
) -> Imposed:
    """Hold the fluid to the bodies over a time tau.

    ``velocity``: at the end of the step without the force, on the mask's box [L/T]; ``rate`` =
    lambda tau; ``spread`` = viscosity * tau [L^2]; ``speed``: the reference [L/T]; ``guess``: an
    impulse density to begin from; ``freedom``: of bodies that follow the fluid; ``blur``: b of the
    velocity ``u + b h^2 laplace(u)`` that takes the place of u in the law. The sum of the
    impulse is the momentum given to the fluid; along free modes it is exact to round-off. Stops
    when the residual is within ``settings.tolerance * speed``; raises BlowUpError if it never is.
    """
    dtype = velocity.dtype
    system = _System(mask, solver, rate, spread, freedom or _held(velocity), blur)
    weight = max(float(mask.chi.sum(dtype=np.float64)), 1.0)
    target = weight * (settings.tolerance * speed) ** 2
    known = system.root * (mask.velocity.astype(dtype, copy=False) - system.felt_of(velocity))
    begin = system.begin(guess, velocity)
    rest = system.joined(known, system.push()) - system.apply(begin)
    found = solve(system.apply, begin, rest, target=target, iterations=settings.iterations)
    if not found.residual <= target:
        raise BlowUpError(
            f"the penalisation left a slip residual of "
            f"{np.sqrt(found.residual / weight) / speed:.2e} "
            f"after {found.iterations} iterations, asked for {settings.tolerance:.1e}",
            hint="a smaller penalisation strength, or a larger tolerance",
        )
    g, values = system.parted(found.solution)
    impulse = system.balanced(system.root * g, values)
    if blur:
        matter = mask.velocity + np.tensordot(values, system.freedom.modes, axes=1)
        slip = system.root * (velocity + system.induced(impulse) - matter.astype(dtype))
    else:
        slip = -g / dtype.type(rate) - system.parted(found.rest)[0]
    return Imposed(
        impulse=impulse,
        slip=slip,
        residual=float(np.sqrt(found.residual / weight)) / speed,
        iterations=found.iterations,
        values=tuple(float(value) for value in values),
    )


class _System:
    """The penalisation's matrix for g and, scaled, the values of the free coordinates."""

    def __init__(
        self,
        mask: Mask,
        solver: VelocitySolver,
        rate: float,
        spread: float,
        freedom: Freedom,
        blur: float,
    ) -> None:
        dtype = solver.dtype
        self.root = mask.root.astype(dtype, copy=False)
        self.grid, self.solver = mask.grid, solver
        self.rate, self.smoothing = rate, ("phi1", spread) if spread > 0 else None
        self.freedom, self.blur = freedom, blur
        felt = freedom.modes.astype(dtype) * self.root
        self.shape = (len(self.grid.shape), *self.grid.shape)
        self.felt = felt.reshape(len(felt), math.prod(self.shape))
        sizes = np.sum(np.square(self.felt, dtype=np.float64), axis=1)
        self.scale = 1.0 / np.sqrt(sizes + np.abs(freedom.inertia))

    def apply(self, unknown: Array) -> Array:
        """The matrix times g and the scaled values."""
        g, values = self.parted(unknown)
        image = g / g.dtype.type(self.rate) + self.root * self.felt_of(self.induced(self.root * g))
        if not len(values):
            return image.ravel()
        image = image.ravel() - values.astype(g.dtype) @ self.felt
        moments = -self.felt @ g.ravel() - self.freedom.inertia * values
        return self.joined(image, moments)

    def felt_of(self, velocity: Array) -> Array:
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

    def push(self) -> Array:
        """The right side of the coordinates' momenta."""
        return -self.freedom.push

    def joined(self, field: Array, moments: Array) -> Array:
        """One flat vector of a field and momenta, which are scaled."""
        flat = field.ravel()
        return np.concatenate([flat, (self.scale * moments).astype(flat.dtype)])

    def parted(self, unknown: Array) -> tuple[Array, Array]:
        """The field and the values of the coordinates in one flat vector."""
        count = len(self.scale)
        cut = len(unknown) - count
        return unknown[:cut].reshape(self.shape), self.scale * unknown[cut:].astype(np.float64)

    def begin(self, guess: Array | None, velocity: Array) -> Array:
        """The vector of a guessed impulse."""
        g = np.zeros_like(velocity) if guess is None else _divided(guess, self.root)
        return self.joined(
            g.astype(velocity.dtype, copy=False), self.freedom.likely / self.scale**2
        )

    def balanced(self, impulse: Array, values: Array) -> Array:
        """The impulse with the momenta that the coordinates ask for, to round-off."""
        if not len(values):
            return impulse
        modes = self.freedom.modes.reshape(len(values), -1)
        weighted = modes * np.broadcast_to(self.root**2, self.shape).ravel()
        missing = self.freedom.push - self.freedom.inertia * values - modes @ impulse.ravel()
        share = np.linalg.solve(weighted @ modes.T, missing)
        added = (share @ weighted).reshape(self.shape)
        return np.asarray(impulse + added, impulse.dtype)

    def induced(self, impulse: Array) -> Array:
        """Velocity that an impulse density induces at the end of the step."""
        created = curl(impulse, self.grid, order=4, edge="zero")
        return self.solver.velocity(created, smoothing=self.smoothing)


def _held(velocity: Array) -> Freedom:
    """No free coordinates."""
    nothing = np.zeros(0)
    return Freedom(np.zeros((0, *velocity.shape)), nothing, nothing, nothing)


def _divided(impulse: Array, root: Array) -> Array:
    """impulse / root where the root is not zero."""
    return np.divide(impulse, root, out=np.zeros_like(impulse), where=root > 0)
