"""Laws between particles and a mesh: p2m, its adjoint m2p, and remesh, which counts losses."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh import _transfer
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.layout import check_field, even_bands, layout, precision, split, tables, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Outside = Literal["refuse", "drop"]


class Remeshed(NamedTuple):
    """A field and what did not reach it.

    ``dropped_count`` particles lay outside the box; ``dropped_strength`` [Q], shape ``()`` or
    ``(c,)``, is theirs and that of all stencil parts beyond unbounded edges.
    """

    field: Array
    dropped_count: int
    dropped_strength: Array


def p2m(
    positions: Array,
    strengths: Array,
    grid: Grid,
    kernel: str | Kernel = "M4'",
    *,
    outside: Outside = "refuse",
    threads: int | None = None,
) -> Array:
    """Particles to mesh: node values are strength densities [Q/L^ndim].

    ``positions`` ``(n, ndim)`` [L]; ``strengths`` ``(n,)`` or ``(n, c)`` [Q] give a field of
    ``grid.shape`` or ``(c, *grid.shape)``. Conserves the kernel's moments (periodic axes wrap;
    stencil parts beyond an unbounded edge are lost: `remesh` counts them). The adjoint of `m2p`:
    sum(p2m(q) g) h^ndim = sum(q m2p(g)). Same bits for any number of threads.
    float32 strengths give a float32 field, all others float64. Positions have a precision of their
    own: the origin is subtracted in it, and only what is left takes that of the field; far from
    zero give them in float64. Within round-off of an edge a particle is inside.
    Refuses values that are not finite, and particles outside the box unless ``outside="drop"``.
    """
    return _spread(positions, strengths, grid, kernel, outside, threads).field


def remesh(
    positions: Array,
    strengths: Array,
    grid: Grid,
    kernel: str | Kernel = "M4'",
    *,
    outside: Outside = "drop",
    threads: int | None = None,
) -> Remeshed:
    """As `p2m`, and the particles and strength that did not reach the mesh.

    sum(strengths) = sum(field) h^ndim + dropped_strength, to round-off.
    """
    return _spread(positions, strengths, grid, kernel, outside, threads)


def m2p(
    field: Array,
    positions: Array,
    grid: Grid,
    kernel: str | Kernel = "M4'",
    *,
    outside: Outside = "refuse",
    threads: int | None = None,
) -> Array:
    """Mesh to particles: the field interpolated at the positions.

    ``field`` ``grid.shape`` or ``(c, *grid.shape)``, ``positions`` ``(n, ndim)`` [L]; returns
    ``(n,)`` or ``(n, c)``. The field is zero beyond an unbounded edge. Exact for polynomials of
    degree kernel.moments where the stencil is inside. Precision as in `p2m`, that of the field.
    Refuses particles outside the box; with ``outside="drop"`` their values are zero.
    """
    values = check_field(field, grid)
    plan = _Plan(positions, grid, kernel, outside, precision(values), threads)
    mesh = np.ascontiguousarray(values, plan.dtype).reshape(plan.layout)
    result = np.empty((plan.positions.shape[0], mesh.shape[0]), plan.dtype)
    share(
        _transfer.gather, plan.pieces, plan.threads, plan.piece, plan.home, plan.positions,
        plan.origin, *plan.shape, plan.periodic, mesh, result,
    )  # fmt: skip
    return result if values.ndim > grid.ndim else result[:, 0]


class _Plan:
    """Checked particles, the kernel's table and the band of every particle."""

    def __init__(
        self,
        positions: Array,
        grid: Grid,
        kernel: str | Kernel,
        outside: Outside,
        dtype: np.dtype[Any],
        threads: int | None,
    ) -> None:
        if outside not in ("refuse", "drop"):
            raise InputError(
                f"outside must be 'refuse' or 'drop', got {outside!r}", hint="outside='refuse'"
            )
        points = np.asarray(positions)
        if points.ndim != 2 or points.shape[1] != grid.ndim:
            swapped = points.ndim == 2 and points.shape[0] == grid.ndim
            raise InputError(
                f"positions must have shape (n, {grid.ndim}), got {points.shape}",
                hint="positions.T" if swapped else "one row per particle",
            )
        self.dtype = dtype
        self.positions = np.ascontiguousarray(points, precision(points))
        self.threads = thread_count(threads)
        self.shape = tables(kernel, grid, dtype)
        self.origin = np.array(grid.origin, self.positions.dtype)
        self.periodic, self.layout = wraps(grid), layout(grid)
        self.bands = even_bands(grid.shape[0] // len(self.shape[2]))
        self._find_home(grid, outside)

    def _find_home(self, grid: Grid, outside: Outside) -> None:
        rows = np.arange(grid.shape[0])
        edges = [grid.shape[0] * k // self.bands for k in range(1, self.bands)]
        band_of_row = np.searchsorted(edges, rows, side="right").astype(np.int32)
        n = self.positions.shape[0]
        self.piece, self.pieces = split(n)
        self.home = np.empty(n, np.int32)
        share(
            _transfer.locate, self.pieces, self.threads, self.piece, self.positions, self.origin,
            self._slack(grid), self.shape[0], np.array(grid.shape), np.array(grid.periodic),
            band_of_row, self.home,
        )  # fmt: skip
        lowest = int(self.home.min(initial=0))
        if lowest == _transfer.NOT_A_NUMBER:
            raise InputError(
                f"positions must be finite, {int((self.home == lowest).sum())} of {n} are not",
                hint="check the velocity and the time step",
            )
        self.missing = int((self.home < 0).sum())
        if self.missing and outside == "refuse":
            raise InputError(
                f"{self.missing} of {n} particles lie outside the box, first: "
                f"{self.positions[np.argmax(self.home < 0)].tolist()}",
                hint="a larger grid, or outside='drop'",
            )

    def _slack(self, grid: Grid) -> float:
        """Round-off of positions on this mesh [cells]: its own nodes lie inside."""
        ends = [abs(x) + side for x, side in zip(grid.origin, grid.length, strict=True)]
        place = float(np.finfo(self.positions.dtype).eps) * max(ends) / grid.spacing
        return min(0.5, 4.0 * (place + float(np.finfo(self.dtype).eps) * max(grid.shape)))


def _spread(
    positions: Array,
    strengths: Array,
    grid: Grid,
    kernel: str | Kernel,
    outside: Outside,
    threads: int | None,
) -> Remeshed:
    values = np.asarray(strengths)
    plan = _Plan(positions, grid, kernel, outside, precision(values), threads)
    n = plan.positions.shape[0]
    if values.ndim not in (1, 2) or values.shape[0] != n:
        raise InputError(
            f"strengths must have shape ({n},) or ({n}, c), got {values.shape}",
            hint="one strength, or one row of components, per particle",
        )
    given = np.ascontiguousarray(values, plan.dtype).reshape(n, -1 if n else values[:1].size or 1)
    if not np.isfinite(given).all():
        raise InputError(
            f"strengths must be finite, {int((~np.isfinite(given)).sum())} values are not",
            hint="check the field that they were taken from",
        )
    parts = given.shape[1]
    starts = np.zeros(plan.bands + 1, np.int64)
    order = np.empty(n, np.int64)
    _transfer.sort(plan.home, plan.bands, starts, order)
    mesh = np.zeros((parts, *grid.shape), plan.dtype)
    dropped = np.zeros((plan.bands, parts), np.float64)
    for colour in (0, 1):
        share(
            _transfer.scatter, len(starts[colour:-1:2]), plan.threads, colour, starts, order,
            plan.positions, given, plan.origin, *plan.shape, plan.periodic,
            mesh.reshape(plan.layout), dropped,
        )  # fmt: skip
    mesh /= plan.dtype.type(grid.cell_volume)
    lost = dropped.sum(axis=0) + given[plan.home < 0].sum(axis=0, dtype=np.float64)
    if values.ndim == 1:
        return Remeshed(mesh[0], plan.missing, lost.reshape(()))
    return Remeshed(mesh, plan.missing, lost)
