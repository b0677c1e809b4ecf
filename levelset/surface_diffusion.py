"""Diffusion of a quantity along an implicit surface, by particles in a narrow band around it.

On the surface dc/dt = D laplace_s c. All of the band (`surface_band`) follows

    dc/dt = D A c,

A the embedded Laplacian; a second-order one, for c constant along normals. In time: two implicit
stages of weight g = 1 - 1/sqrt 2, of order 2, damping all waves (L-stable),

    (1 - g dt D A) a = c,    (1 - g dt D A) b = c + (1-g)/g (a - c),    c <- b.

A keeps constants, but the surface integral only to order 2. With M(c) the integral over a connected
part of the surface, the c nearest to the one computed, in the mean square over it, with the right
integral differs from it by a constant, (M_0 - M(c))/area: it is added to every part after each
step. Constants are what A keeps, so that changes nothing else, and no part gains from another;
where c is far below its mean, it may fall below zero by as much.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.given import check_grid, precision_asked
from levelset.shape import Shape
from levelset.surface_band import SurfaceBand, half_width
from remesh.errors import BlowUpError, InputError, as_number
from remesh.grid import Grid
from remesh.limit import Limit, check_step

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
Law = Callable[[Values], Array]  # values at points (ndim, n)
STAGE = 1.0 - 1.0 / math.sqrt(2.0)  # g of the module
SOLVED = 1e-11  # residual of an implicit stage over its right side
ROUNDS = 200  # of the solver, at most
BEYOND = 1.0  # how far values may leave their extremes in a step, over the span of these
LEAST = 1e-5  # the same over their size, for round-off


@dataclass(frozen=True, kw_only=True)
class SurfaceState:
    """A quantity on its way along a surface; all that a restart needs."""

    time: float
    step: int
    surface: SurfaceBand
    values: Array  # at the surface's nodes, constant along normals [Q/L^(ndim-1)]
    masses: Values  # the integral over every part of the surface, that is kept [Q]

    @property
    def grid(self) -> Grid:
        """The mesh."""
        return self.surface.grid

    @property
    def size(self) -> int:
        """Nodes that a step moves."""
        return len(self.values)

    @property
    def mass(self) -> float:
        """The integral over the surface that is kept [Q]."""
        return float(self.masses.sum())


@dataclass(frozen=True, kw_only=True)
class SurfaceDiffusion:
    """A quantity spreads along a surface that stands still; dt is bound by accuracy only."""

    grid: Grid
    diffusivity: float  # D [L^2/T]
    stretch: float = 20.0  # largest dt over the explicit limit h^2/(2 ndim D)
    keep: bool = True  # the integral over every part, by a constant added to its values
    threads: int | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Refuse what is no grid, and a diffusivity and a stretch that are not positive."""
        check_grid(self.grid)
        for name in ("diffusivity", "stretch"):
            value = as_number(name, getattr(self, name), hint=f"{name}=1.0")
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value}", hint=f"{name}=1.0")

    def start(
        self, surface: Shape | Array | SurfaceBand, values: Law | Array, *, dtype: str | None = None
    ) -> SurfaceState:
        """The state at time 0 on the surface of a shape, or of phi on the nodes.

        ``values``: a law of points (ndim, n), asked on the surface only, or an array of
        ``grid.shape``, of which only what is near the surface is read. Looks at every node of the
        box once. Refuses values that are not finite, and the surfaces that `SurfaceBand.around`
        refuses: sheets less than about seven spacings apart, one near an unbounded edge.
        """
        if isinstance(surface, SurfaceBand):
            found = surface
        else:
            found = SurfaceBand.around(surface, self.grid, threads=self.threads)
        if found.grid != self.grid:
            raise InputError(
                "the surface was laid out on another grid",
                hint="SurfaceBand.around(shape, flow.grid)",
            )
        given = self._by_law(found, values) if callable(values) else self._read(found, values)
        kept = np.array(np.broadcast_to(given, found.nodes.shape), precision_asked(dtype, given))
        if not np.isfinite(kept).all():
            raise InputError("values must be finite on the surface", hint="check the law")
        masses = found.integrals(kept, threads=self.threads)
        return SurfaceState(time=0.0, step=0, surface=found, values=kept, masses=masses)

    def _by_law(self, surface: SurfaceBand, law: Law) -> Array:
        """What a law gives on the surface."""
        given = np.asarray(law(np.ascontiguousarray(surface.closest.T)))
        if given.shape not in ((), surface.nodes.shape) or given.dtype.kind not in "fiu":
            raise InputError(
                f"values must be one number per point, of shape {surface.nodes.shape}, for points "
                f"of shape {surface.closest.T.shape}, got {given.dtype} {given.shape}",
                hint="lambda points: points[0]",
            )
        return given

    def _read(self, surface: SurfaceBand, values: Array) -> Array:
        """A field read on the surface."""
        given = np.asarray(values)
        if given.shape != self.grid.shape or given.dtype.kind not in "fiu":
            raise InputError(
                f"values must be numbers of the grid's shape {self.grid.shape}, "
                f"got {given.dtype} {given.shape}",
                hint="or a law: lambda points: points[0]",
            )
        flat = np.ascontiguousarray(given, np.float64).reshape(-1)
        found = surface.read(flat, surface.reading, threads=self.threads)
        return found.astype(precision_asked(None, given), copy=False)

    def step(self, state: SurfaceState, dt: float) -> SurfaceState:
        """The state dt [T] later; values that leave their extremes by far are a BlowUpError."""
        dt, surface, before = check_step(dt), state.surface, state.values.astype(np.float64)
        reach = STAGE * dt * self.diffusivity / self.grid.spacing**2
        first = implicit(surface, before, reach, before, threads=self.threads)
        right = before + (1 - STAGE) / STAGE * (first - before)
        values = implicit(surface, right, reach, first, threads=self.threads)
        _check_bounded(values, before)
        if self.keep:
            missing = state.masses - surface.integrals(values, threads=self.threads)
            for part, more in zip(surface.parts, missing / surface.areas, strict=True):
                values[part] += more
        return replace(
            state, time=state.time + dt, step=state.step + 1,
            values=values.astype(state.values.dtype, copy=False),
        )  # fmt: skip

    def limit(self, state: SurfaceState) -> Limit:
        """``stretch`` explicit steps."""
        explicit = self.grid.spacing**2 / (2 * self.grid.ndim * self.diffusivity)
        return Limit(self.stretch * explicit, "diffusion")

    def ledger(self, state: SurfaceState) -> dict[str, float]:
        """``mass``, the integral over the surface [Q]; least and largest value."""
        return {
            "mass": state.surface.integral(state.values, threads=self.threads),
            "lowest": float(state.values.min()),
            "highest": float(state.values.max()),
        }

    def forces(self, state: SurfaceState) -> dict[str, float]:
        """None."""
        return {}

    def fields(self, state: SurfaceState) -> dict[str, Array]:
        """Values, zero where there are none, and the signed distance, as far as the band goes."""
        surface = state.surface
        values = surface.on_grid(state.values).astype(state.values.dtype, copy=False)
        phi = surface.band.filled(half_width(self.grid))
        return {"values": values.reshape(self.grid.shape), "phi": phi}


def implicit(
    surface: SurfaceBand,
    right: Values,
    reach: float,
    guess: Values,
    *,
    threads: int | None = None,
) -> Values:
    """c with ``c - reach h^2 A c = right``, from a guess; ``reach`` is a time times D over h^2."""
    from scipy.sparse.linalg import LinearOperator, bicgstab

    count = len(right)
    operator = LinearOperator(
        (count, count),
        matvec=lambda c: c - reach * surface.laplacian(c, threads=threads),
        dtype=np.float64,
    )
    found, failed = bicgstab(operator, right, x0=guess, rtol=SOLVED, atol=0.0, maxiter=ROUNDS)
    if failed:
        raise BlowUpError(
            f"the implicit stage of surface diffusion is not solved after {ROUNDS} rounds",
            hint="a smaller `stretch`",
        )
    return np.asarray(found)


def _check_bounded(values: Values, before: Values) -> None:
    """Refuse values that diffusion cannot make of those before."""
    low, high = float(before.min()), float(before.max())
    room = BEYOND * (high - low) + LEAST * max(abs(low), abs(high))
    if not (low - room <= values.min() and values.max() <= high + room):
        raise BlowUpError(
            f"surface diffusion made values from {values.min():.4g} to {values.max():.4g} of such "
            f"from {low:.4g} to {high:.4g}",
            hint="a finer spacing, or a smaller `stretch`",
        )
