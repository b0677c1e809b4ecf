"""Implicit penalisation: the force density that holds the fluid to the bodies' velocity.

Over a step tau the force density f [L/T^2] is constant, ``f = lambda chi (u_s - u)`` with the
velocity u at the end of the step, which the force itself changes by ``A f``: curl(f) becomes
vorticity, spreads for the time tau (phi1, exact for a constant source) and induces velocity.
With ``f = sqrt(chi) g / tau`` this is the system

    (1/(lambda tau) + sqrt(chi) A sqrt(chi)) g = sqrt(chi) (u_s - u*)

for the velocity u* without the force, symmetric but for 0.1 %: the curl of the force is a compact
difference, so that the impulse it gives is exact, the curl of the velocity is exact. Conjugate
gradients iterate it on its own residual, on a box around the bodies only: in free space that is
the same convolution as on the whole mesh. The cost grows with the box around all bodies.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.wall import indicator
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError, as_number
from remesh.grid import Grid
from remesh.stencils import curl

Array = NDArray[np.floating[Any]]
NODE = 1e-6  # a box ends on a node when it comes this close, in spacings: the same box on any mesh
RANGES = {  # outside of these the wall is not where its offset says
    "strength": (10.0, 1e6),
    "width": (0.5, 8.0),
    "tolerance": (1e-12, 0.1),
    "iterations": (1, 1_000_000),
}
MARGIN = 4  # nodes of a box beyond the indicator: the curl's stencil and one more


@dataclass(frozen=True, kw_only=True)
class Penalisation:
    """How bodies are imposed on the flow.

    ``strength`` = lambda h^2/nu sets the Brinkman layer, h / sqrt(strength) thick: a larger one
    slips less and costs more iterations. ``width``: half width of the body's indicator in spacings.
    ``tolerance``: slip residual, root mean square over the body relative to the reference speed.
    """

    strength: float = 1000.0
    width: float = 1.5
    tolerance: float = 1e-6
    iterations: int = 500

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


class Mask(NamedTuple):
    """The bodies on a box of the mesh."""

    grid: Grid  # of the box
    chi: Array  # indicator, shape of the box
    root: Array  # its square root
    owner: NDArray[np.int64]  # index of the nearest body at every node
    velocity: Array  # of the bodies' matter, (ndim, *shape) [L/T]


class Imposed(NamedTuple):
    """What the penalisation did over a time tau."""

    impulse: Array  # force density times tau on the box, (ndim, *shape) [L/T]
    velocity: Array  # at the end, on the box [L/T]
    residual: float  # of the penalisation law, rms over the body relative to the speed
    iterations: int


@lru_cache(maxsize=8)
def mask_of(bodies: tuple[Body, ...], grid: Grid, time: float, width: float, offset: float) -> Mask:
    """Bodies on a box: the indicator of ``distance < -offset`` over +-``width`` [L], and owners."""
    points = grid.points()
    distances = np.stack([body.distance(points, time) for body in bodies])
    owner = np.argmin(distances, axis=0)
    chi = indicator(distances.min(axis=0) + offset, width)
    velocity = np.zeros_like(points)
    for number, body in enumerate(bodies):
        velocity = np.where(owner == number, body.velocity(points, time), velocity)
    return Mask(grid, chi, np.sqrt(chi), owner, velocity)


def box_around(bodies: tuple[Body, ...], grid: Grid, time: float, reach: float) -> Grid:
    """The part of the mesh's lattice that holds the bodies and ``reach`` [L] around them.

    A periodic axis is taken whole. The box may stick out of the mesh: the caller decides.
    """
    corners = [body.bounds(time) for body in bodies]
    shape, origin = [], []
    for axis in range(grid.ndim):
        if grid.periodic[axis]:
            shape.append(grid.shape[axis])
            origin.append(grid.origin[axis])
            continue
        low = min(lower[axis] for lower, _ in corners) - reach - grid.origin[axis]
        high = max(upper[axis] for _, upper in corners) + reach - grid.origin[axis]
        first = int(np.floor(low / grid.spacing + NODE)) - MARGIN
        last = int(np.ceil(high / grid.spacing - NODE)) + MARGIN
        shape.append(last - first + 1)
        origin.append(grid.origin[axis] + first * grid.spacing)
    return Grid(shape, grid.spacing, origin, grid.boundary)


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
) -> Imposed:
    """Hold the fluid to the bodies over a time tau.

    ``velocity``: at the end of the step without the force, on the mask's box [L/T]; ``rate`` =
    lambda tau; ``spread`` = viscosity * tau [L^2]; ``speed``: the reference [L/T]; ``guess``: an
    impulse density to begin from. The sum of the impulse is the momentum given to the fluid. Stops
    when the residual is within ``settings.tolerance * speed``; raises BlowUpError if it never is.
    """
    mask = mask._replace(
        root=mask.root.astype(velocity.dtype, copy=False),
        velocity=mask.velocity.astype(velocity.dtype, copy=False),
    )
    root = mask.root
    weight = max(float(mask.chi.sum(dtype=np.float64)), 1.0)
    g = np.zeros_like(velocity) if guess is None else _divided(guess, root)
    induced = _induced(g, mask, solver, spread)
    rest = root * (mask.velocity - velocity - induced) - g / rate
    direction, norm = rest.copy(), _dot(rest, rest)
    target, count = weight * (settings.tolerance * speed) ** 2, 0
    while not norm <= target:
        if count >= settings.iterations or not np.isfinite(norm):
            raise BlowUpError(
                f"the penalisation left a slip residual of {np.sqrt(norm / weight) / speed:.2e} "
                f"after {count} iterations, asked for {settings.tolerance:.1e}",
                hint="a smaller penalisation strength, or a larger tolerance",
            )
        answer = _induced(direction, mask, solver, spread)
        image = direction / rate + root * answer
        length = norm / _dot(direction, image)
        g += length * direction
        induced += length * answer
        rest -= length * image
        before, norm = norm, _dot(rest, rest)
        direction = rest + (norm / before) * direction
        count += 1
    return Imposed(root * g, velocity + induced, float(np.sqrt(norm / weight)) / speed, count)


def _induced(g: Array, mask: Mask, solver: VelocitySolver, spread: float) -> Array:
    """Velocity on the box from the impulse ``root * g``, whose curl spreads like phi1."""
    created = curl(mask.root * g, mask.grid, order=4, edge="zero")
    smoothing = ("phi1", spread) if spread > 0 else None
    return solver.velocity(created, smoothing=smoothing)


def _divided(impulse: Array, root: Array) -> Array:
    """impulse / root where the root is not zero."""
    return np.divide(impulse, root, out=np.zeros_like(impulse), where=root > 0)


def _dot(a: Array, b: Array) -> float:
    return float(np.sum(a * b, dtype=np.float64))
