"""Diffusion of a quantity along an implicit surface, by particles in a narrow band around it.

On the surface dc/dt = D laplace_s c. Off it c is made constant along normals, c(x) = c(cp(x)) with
cp(x) the closest point of the surface. With P = I - n n the anisotropic operator is

    div(D P grad c) = D (lap c - kappa n . grad c - n . Hess c . n),

and as both last terms vanish for such a c, lap c is D laplace_s c on the surface: of the
anisotropic operator the plain one is left (Ruuth & Merriman, J. Comput. Phys. 227 (2008) 1943).
The band holds all nodes within sqrt(4 (ndim-1) + 9) h of the surface. With E the reading of the
closest points by cubics and L the second-order Laplacian, all of the band follows

    dc/dt = D A c,    A c = E L c - (2 ndim/h^2) (c - E c)

(von Glehn, März & Macdonald, arXiv:1307.5624): L is read only where all its nodes are in the band,
so no condition is needed at the band's edge, and the second term holds c constant along normals.
In time: two implicit stages of weight g = 1 - 1/sqrt 2, of order 2, damping all waves (L-stable),

    (1 - g dt D A) a = c,    (1 - g dt D A) b = c + (1-g)/g (a - c),    c <- b.

A keeps constants, but the surface integral only to order 2. With M(c) the integral over the
surface, the c nearest to the one computed, in the mean square over the surface, with the right
integral differs from it by a constant, (M_0 - M(c))/area: it is added after each step. Constants
are what A keeps, so that changes nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.shape import Shape
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps
from remesh.limit import Limit
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Values = NDArray[np.float64]
Law = Callable[[Values], Array]  # values at points (ndim, n)
STAGE = 1.0 - 1.0 / math.sqrt(2.0)  # g of the module
SOLVED = 1e-11  # residual of an implicit stage over its right side
ROUNDS = 200  # of the solver, at most


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
    """A surface as diffusion knows it: the nodes around it and their closest points on it."""

    grid: Grid
    nodes: Nodes  # flat, ascending
    closest: Values  # (n, ndim) [L]
    distance: Values  # signed [L]

    @classmethod
    def around(cls, surface: Shape | Array, grid: Grid) -> Surface:
        """The surface of a shape, or of any phi on the nodes.

        Refuses one that comes too near an unbounded edge, and a phi of one sign.
        """
        from levelset.closest import closest_points

        given = surface.distance(grid.points()) if isinstance(surface, Shape) else surface
        phi = np.asarray(given, np.float64)
        reach = math.sqrt(4.0 * (grid.ndim - 1) + 9.0) * (1.0 + 1e-9)
        found = closest_points(phi, grid, width=reach * grid.spacing)
        made = cls(grid=grid, nodes=found.nodes, closest=found.points, distance=found.distance)
        made.stencil  # noqa: B018 - refused now rather than at the first step
        return made

    @cached_property
    def band(self) -> Band:
        """The signed distance."""
        return Band(self.grid, self.nodes, self.distance)

    @cached_property
    def area(self) -> float:
        """Area, in 2-D the length [L^(ndim-1)]."""
        return self.integral(np.ones(len(self.nodes)))

    @cached_property
    def reading(self) -> tuple[Nodes, Values]:
        """How the closest points are read."""
        return self.read_at(self.closest)

    @cached_property
    def stencil(self) -> tuple[Nodes, Nodes]:
        """The nodes that are read, and those around each of them."""
        from levelset import _surface_diffusion

        shape, axes = layout(self.grid)[1:], 2 * self.grid.ndim
        marks, known = np.zeros(self.grid.size, np.uint8), np.zeros(self.grid.size, np.uint8)
        known[self.nodes] = 1
        _surface_diffusion.mark(self.reading[0], self.middle, marks)
        inner = np.empty(len(self.nodes), np.int64)
        around = np.empty((len(self.nodes), axes), np.int64)
        count = _surface_diffusion.neighbours(
            self.nodes, marks, known, shape, tuple(wraps(self.grid).tolist()), inner, around
        )
        if count < 0:
            raise InputError(
                "the surface comes within five spacings of an unbounded edge of the grid",
                hint="a larger grid, or a periodic axis",
            )
        return inner[:count].copy(), around[:count].copy()

    @property
    def middle(self) -> int:
        """Taps along the middle axis of the loops."""
        return 4 if self.grid.ndim == 3 else 1

    def read_at(self, points: Values) -> tuple[Nodes, Values]:
        """How points (n, ndim) on the surface are read from the nodes."""
        from levelset import _surface_diffusion

        spots = np.zeros((len(points), 3))
        spots[:, (0, 1, 2) if self.grid.ndim == 3 else (0, 2)] = (
            points - np.array(self.grid.origin)
        ) / self.grid.spacing
        taps, shares = np.empty((len(points), 3, 4), np.int64), np.empty((len(points), 3, 4))
        rows, pieces = split(len(points))
        share(
            _surface_diffusion.place, pieces, thread_count(None), rows, spots,
            layout(self.grid)[1:], tuple(wraps(self.grid).tolist()), taps, shares,
        )  # fmt: skip
        return taps, shares

    def read(self, field: Values, reading: tuple[Nodes, Values]) -> Values:
        """A flat field read at points."""
        from levelset import _surface_diffusion

        taps, shares = reading
        out = np.empty(len(taps))
        rows, pieces = split(len(taps))
        share(
            _surface_diffusion.read, pieces, thread_count(None), rows, field, taps, shares,
            self.middle, out,
        )  # fmt: skip
        return out

    def on_grid(self, values: Array) -> Values:
        """Values of the nodes in a flat array of all nodes, zero elsewhere."""
        field = np.zeros(self.grid.size)
        field[self.nodes] = values
        return field

    def at(self, values: Array, points: Values) -> Values:
        """Values, given at the nodes, at points (n, ndim) of the surface; order 4."""
        return self.read(self.on_grid(values), self.read_at(np.asarray(points, np.float64)))

    def integral(self, values: Array) -> float:
        """The integral over the surface of values at the nodes, of order 4."""
        from levelset.quadrature import integrate

        shape = self.grid.shape
        phi = self.on_grid(self.distance).reshape(shape)
        given = self.on_grid(values).reshape(shape)
        return integrate(given, phi, self.grid, over="surface", nodes=self.nodes)

    def laplacian(self, values: Values) -> Values:
        """h^2 A of the module: h^2 laplace_s where the values are constant along normals."""
        from levelset import _surface_diffusion

        inner, around = self.stencil
        total = np.zeros(self.grid.size)
        rows, pieces = split(len(inner))
        share(
            _surface_diffusion.spread_sum, pieces, thread_count(None), rows, self.on_grid(values),
            inner, around, total,
        )  # fmt: skip
        return self.read(total, self.reading) - 2.0 * self.grid.ndim * values


@dataclass(frozen=True, kw_only=True)
class SurfaceState:
    """A quantity on its way along a surface; all that a restart needs."""

    time: float
    step: int
    surface: Surface
    values: Array  # at the surface's nodes, constant along normals [Q/L^(ndim-1)]
    mass: float  # the integral over the surface that is kept [Q]

    @property
    def grid(self) -> Grid:
        """The mesh."""
        return self.surface.grid

    @property
    def size(self) -> int:
        """Nodes that a step moves."""
        return len(self.values)


@dataclass(frozen=True, kw_only=True)
class SurfaceDiffusion:
    """A quantity spreads along a surface that stands still; dt is bound by accuracy only."""

    grid: Grid
    diffusivity: float  # D [L^2/T]
    stretch: float = 20.0  # largest dt over the explicit limit h^2/(2 ndim D)
    keep: bool = True  # the surface integral, by a constant added to the values

    def __post_init__(self) -> None:
        """Refuse a diffusivity and a stretch that are not positive."""
        for name in ("diffusivity", "stretch"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value}", hint=f"{name}=1.0")

    def start(
        self, surface: Shape | Array | Surface, values: Law | Array, *, dtype: str | None = None
    ) -> SurfaceState:
        """The state at time 0 on the surface of a shape, or of phi on the nodes.

        ``values``: a law of points (ndim, n), asked on the surface only, or an array of
        ``grid.shape``, of which only what is near the surface is read. Refuses values that are not
        finite, a surface that comes within five spacings of an unbounded edge, a phi of one sign.
        """
        found = surface if isinstance(surface, Surface) else Surface.around(surface, self.grid)
        if found.grid != self.grid:
            raise InputError(
                "the surface was laid out on another grid", hint="Surface.around(shape, flow.grid)"
            )
        if callable(values):
            given = np.asarray(values(np.ascontiguousarray(found.closest.T)))
        else:
            field = np.asarray(values)
            if field.shape != self.grid.shape:
                raise InputError(
                    f"values must have the grid's shape {self.grid.shape}, got {field.shape}",
                    hint="or a law: lambda points: points[2]",
                )
            flat = np.ascontiguousarray(field, np.float64).reshape(-1)
            given = found.read(flat, found.reading).astype(precision(field), copy=False)
        kept = np.array(np.broadcast_to(given, found.nodes.shape), dtype or precision(given))
        if not np.isfinite(kept).all():
            raise InputError("values must be finite on the surface", hint="check the law")
        mass = found.integral(kept)
        return SurfaceState(time=0.0, step=0, surface=found, values=kept, mass=mass)

    def step(self, state: SurfaceState, dt: float) -> SurfaceState:
        """The state dt [T] later."""
        surface, before = state.surface, state.values.astype(np.float64)
        reach = STAGE * dt * self.diffusivity / self.grid.spacing**2
        first = implicit(surface, before, reach, before)
        values = implicit(surface, before + (1 - STAGE) / STAGE * (first - before), reach, first)
        if self.keep:
            values += (state.mass - surface.integral(values)) / surface.area
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
            "mass": state.surface.integral(state.values),
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
        far = math.sqrt(4.0 * (self.grid.ndim - 1) + 9.0) * self.grid.spacing
        return {"values": values.reshape(self.grid.shape), "phi": surface.band.filled(far)}


def implicit(surface: Surface, right: Values, reach: float, guess: Values) -> Values:
    """c with ``c - reach h^2 A c = right``, from a guess; ``reach`` is a time times D over h^2."""
    from scipy.sparse.linalg import LinearOperator, bicgstab

    count = len(right)
    operator = LinearOperator(
        (count, count), matvec=lambda c: c - reach * surface.laplacian(c), dtype=np.float64
    )
    found, failed = bicgstab(operator, right, x0=guess, rtol=SOLVED, atol=0.0, maxiter=ROUNDS)
    if failed:
        raise BlowUpError(
            f"the implicit stage of surface diffusion is not solved after {ROUNDS} rounds",
            hint="a smaller `stretch`",
        )
    return np.asarray(found)
