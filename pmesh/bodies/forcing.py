"""Direct forcing: the impulse on markers of the bodies that gives the fluid there their velocity.

The immersed-boundary force of the seed, ``f = (u_desired - u)/dt - (-grad p + div tau)`` per unit
density: ``u* = u + dt (-grad p + div tau)`` is the velocity at the end of the step without the
force, so ``f dt = u_desired - u*`` on the boundary. In vorticity form u* is what advection and
spread leave. Impulses q of markers go to the mesh by a remeshing kernel (p2m), their curl becomes
vorticity, and the velocity comes back by the same kernel (m2p), its adjoint. Forcing once leaves
slip, because markers share nodes and the pressure answers: the impulses solve

    E A E^T q = u_desired - E u*

up to the slip of a soft law, f / lambda, which keeps the forces smooth. Conjugate residuals find
them from the last force (Luo et al. 2007 repeat the forcing, Taira & Colonius 2007 solve for it).
The first line of markers is retracted so that the flow sees the wall at distance zero (Breugem
2012), and the felt velocity sharpened a little so that nothing blows through it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.krylov import solve
from pmesh.bodies.markers import KERNEL, Markers
from pmesh.bodies.mask import Mask
from pmesh.bodies.penalise import Freedom, Imposed
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError, as_number
from remesh.kernels import get_kernel
from remesh.stencils import curl
from remesh.transfer import m2p, p2m

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
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
        for item in fields(self):
            low, high = RANGES[item.name]
            hint = f"{item.name}={item.default}"
            value = as_number(f"forcing {item.name}", getattr(self, item.name), hint=hint)
            whole = item.name == "iterations"
            if not low <= value <= high or (whole and value % 1):
                kind = "a whole number" if whole else "a number"
                raise InputError(
                    f"forcing {item.name} must be {kind} from {low:g} to {high:g}, got {value:g}",
                    hint=hint,
                )

    @property
    def width(self) -> float:
        """How far from the first line the force reaches, in spacings, and one more."""
        return get_kernel(KERNEL).half_width + 1.0


def force(
    velocity: Array,
    mask: Mask,
    markers: Markers,
    solver: VelocitySolver,
    *,
    rate: float,
    spread: float,
    speed: float,
    sharpening: float,
    settings: DirectForcing,
    guess: Array | None = None,
    freedom: Freedom | None = None,
) -> Imposed:
    """Give the fluid at the markers the bodies' velocity at the end of a time tau.

    ``velocity``: then, without the force, on the mask's box [L/T]; ``rate`` = lambda tau;
    ``spread`` = viscosity * tau [L^2]; ``speed``: the reference [L/T]; ``guess``: an impulse
    density to begin from; ``freedom``: of bodies that follow the fluid. The impulse and its moment
    on the mesh are those of the markers. ``slip`` of the result is on the mesh, in the bodies.
    Stops when the residual of ``slip at the markers = -f / lambda`` is within
    ``settings.tolerance * speed``; raises BlowUpError if it never is. One solve on the box per
    iteration and two more.
    """
    system = _System(mask, markers, solver, rate, spread, sharpening, freedom)
    begin = system.begin(guess)
    known = system.felt(mask.velocity) - system.felt(system.sharpened(velocity))
    rest = system.joined(known, -system.freedom.push) - system.apply(begin)
    weight = float(markers.weight.sum())
    target = weight * (settings.tolerance * speed) ** 2
    found = solve(system.apply, begin, rest, target=target, iterations=settings.iterations)
    residual = float(np.sqrt(found.residual / weight)) / speed
    if not found.residual <= target:
        raise BlowUpError(
            f"direct forcing left a slip residual of {residual:.2e} after {found.iterations} "
            f"iterations, asked for {settings.tolerance:.1e}",
            hint="a smaller forcing strength, or a larger tolerance",
        )
    g, values = system.parted(found.solution)
    impulse = system.balanced(system.spread(g), values)
    matter = mask.velocity + np.tensordot(values, system.freedom.modes, axes=1)
    within = np.where(mask.chi > 0.5, mask.root, 0.0)  # the rest of the force reaches the fluid
    slip = within * (velocity + system.induced(impulse) - matter)
    return Imposed(
        impulse=impulse,
        slip=np.asarray(slip, velocity.dtype),
        residual=residual,
        iterations=found.iterations,
        values=tuple(float(value) for value in values),
    )


class _System:
    """The forcing's matrix for the markers' scaled impulses and the free coordinates' values."""

    def __init__(
        self,
        mask: Mask,
        markers: Markers,
        solver: VelocitySolver,
        rate: float,
        spread: float,
        sharpening: float,
        freedom: Freedom | None,
    ) -> None:
        self.grid, self.solver, self.places = mask.grid, solver, markers.positions
        self.dtype = solver.dtype
        self.sharpening = sharpening
        self.softness = 1.0 / rate
        self.root = np.sqrt(markers.weight).astype(self.dtype)[:, None]
        self.smoothing = ("phi1", spread) if spread > 0 else None
        none = np.zeros(0)
        shape = (0, mask.grid.ndim, *mask.grid.shape)
        self.freedom = freedom or Freedom(np.zeros(shape), none, none, none)
        self.modes = np.empty((len(self.freedom.modes), self.places.size), self.dtype)
        for row, mode in zip(self.modes, self.freedom.modes, strict=True):
            row[:] = self.felt(mode).ravel()
        sizes = np.sum(np.square(self.modes, dtype=np.float64), axis=1)
        self.scale = 1.0 / np.sqrt(sizes + np.abs(self.freedom.inertia))

    def apply(self, unknown: Array) -> Array:
        """The matrix times the scaled impulses and values."""
        g, values = self.parted(unknown)
        slip = self.felt(self.sharpened(self.induced(self.spread(g)))) - self.moved(values)
        slip += self.softness * g
        moments = -self.modes @ g.ravel() - self.freedom.inertia * values
        return self.joined(slip, moments)

    def begin(self, guess: Array | None) -> Array:
        """The vector of the markers' impulses that are nearest to a density on the mesh."""
        g = np.zeros(self.places.shape, self.dtype)
        if guess is not None:
            known = self.felt(guess)
            found = solve(
                lambda unknown: self.felt(self.spread(unknown.reshape(g.shape))).ravel(),
                g.ravel(),
                known.ravel(),
                target=NEAREST**2 * float(np.sum(known**2)),
                iterations=60,
            )
            g = found.solution.reshape(g.shape)
        return self.joined(g, self.freedom.likely / self.scale**2)

    def spread(self, g: Array) -> Array:
        """Impulse density on the mesh from the markers' scaled impulses (n, ndim)."""
        strengths = self.root * g * self.grid.cell_volume
        return p2m(self.places, strengths, self.grid, KERNEL, outside="drop", threads=1)

    def felt(self, field: Array) -> Array:
        """A field at the markers, scaled: the adjoint of ``spread``."""
        field = np.ascontiguousarray(field, self.dtype)
        return self.root * m2p(field, self.places, self.grid, KERNEL, outside="drop", threads=1)

    def sharpened(self, velocity: Array) -> Array:
        """The velocity less a part of its Laplacian, where its neighbours are on the box."""
        inner = velocity[:, 1:-1, 1:-1]
        around = velocity[:, 2:, 1:-1] + velocity[:, :-2, 1:-1]
        around += velocity[:, 1:-1, 2:] + velocity[:, 1:-1, :-2]
        result = velocity.copy()
        result[:, 1:-1, 1:-1] += self.sharpening * (4 * inner - around)
        return result

    def moved(self, values: Values) -> Array:
        """Scaled velocity at the markers of the free coordinates."""
        return np.reshape(values.astype(self.dtype) @ self.modes, (-1, self.grid.ndim))

    def moments(self, impulse: Array) -> Values:
        """Sums of an impulse density along the free modes."""
        flat = impulse.ravel().astype(np.float64)
        return np.array([mode.ravel() @ flat for mode in self.freedom.modes], np.float64)

    def joined(self, field: Array, moments: Array) -> Array:
        """One flat vector of values at the markers and momenta, which are scaled."""
        return np.concatenate([field.ravel(), (self.scale * moments).astype(self.dtype)])

    def parted(self, unknown: Array) -> tuple[Array, Values]:
        """The values at the markers and the coordinates' values in one flat vector."""
        cut = len(unknown) - len(self.scale)
        return (
            unknown[:cut].reshape(-1, self.grid.ndim),
            self.scale * unknown[cut:].astype(np.float64),
        )

    def balanced(self, impulse: Array, values: Values) -> Array:
        """The impulse with the momenta that the coordinates ask for, to round-off."""
        if not len(values):
            return impulse
        freedom = self.freedom
        missing = freedom.push - freedom.inertia * values - self.moments(impulse)
        weighted = self.modes.astype(np.float64)
        share = np.linalg.solve(weighted @ weighted.T, missing)
        g = np.reshape(share @ weighted, (-1, self.grid.ndim)).astype(self.dtype)
        return np.asarray(impulse + self.spread(g), impulse.dtype)

    def induced(self, impulse: Array) -> Array:
        """Velocity that an impulse density induces at the end of the step."""
        created = curl(impulse, self.grid, order=4, edge="zero")
        return self.solver.velocity(created, smoothing=self.smoothing)
