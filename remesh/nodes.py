"""Laws from nodes to nodes: nodes as displaced particles, remeshed or sampled in one pass."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh import _nodes
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.layout import FAR, check_field, even_bands, layout, precision, split, tables, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Outside = Literal["nearest", "zero"]


class Advected(NamedTuple):
    """A remeshed field and the strength [Q] that left through unbounded edges, per component."""

    field: Array
    dropped: Array


def advect_nodes(
    field: Array,
    displacement: Array,
    grid: Grid,
    kernel: str | Kernel = "M4'",
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Advected:
    """Move every node value by its displacement and remesh onto the same nodes, in one pass.

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)``, ``displacement`` ``(ndim, *grid.shape)``
    [L], any number of cells. Returns the field (in ``out`` if given) and the strength [Q] that
    left through unbounded edges, of shape ``()`` or ``(c,)``: sum(field) h^ndim = before - dropped.
    Conserves the kernel's moments; with dt following h the method is of order kernel.moments.
    Same bits for any number of threads. Pieces of rows that are zero cost nothing. Displacements
    count from their own node, so float32 keeps its digits on large meshes. Refuses wrong shapes,
    and displacements that are not finite where the field is not zero (elsewhere not all are read).
    Source: Cottet & Koumoutsakos, Vortex Methods (2000), section 7.2.
    """
    plan = _Plan(field, displacement, grid, kernel, out, threads)
    edges = _bands(plan, grid)
    plan.out.fill(0)
    dropped = np.zeros((len(edges) - 1, plan.field.shape[0]), dtype=plan.field.dtype)
    bad = np.zeros(len(edges) - 1, dtype=np.int64)
    for colour in (0, 1):
        share(
            _nodes.advect, len(edges[colour:-1:2]), plan.threads, colour, edges, plan.field,
            plan.displacement, *plan.shape, plan.lanes, plan.periodic, plan.out, dropped, bad,
        )  # fmt: skip
    plan.refuse(int(bad.sum()))
    lost = dropped.sum(axis=0, dtype=np.float64) * grid.cell_volume
    return Advected(plan.result, lost.reshape(plan.result.shape[: -grid.ndim]))


def sample_nodes(
    field: Array,
    displacement: Array,
    grid: Grid,
    kernel: str | Kernel = "M4'",
    *,
    out: Array | None = None,
    outside: Outside = "nearest",
    threads: int | None = None,
) -> Array:
    """The field at node + displacement, all components in one pass.

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)``, ``displacement`` ``(ndim, *grid.shape)``
    [L], any number of cells. Beyond an unbounded edge the field keeps its edge value
    (``outside="nearest"``, for velocities) or is zero (``outside="zero"``, for strengths; then
    this is the adjoint of `advect_nodes`). Exact for polynomials of degree kernel.moments away
    from the edges; order kernel.moments + 1. Same bits for any number of threads.
    Refuses wrong shapes and displacements that are not finite.
    """
    if outside not in ("nearest", "zero"):
        raise InputError(
            f"outside must be 'nearest' or 'zero', got {outside!r}", hint="outside='nearest'"
        )
    plan = _Plan(field, displacement, grid, kernel, out, threads)
    rows, pieces = split(plan.field.shape[1] * plan.field.shape[2])
    bad = np.zeros(pieces, dtype=np.int64)
    share(
        _nodes.sample, pieces, plan.threads, rows, plan.field, plan.displacement, *plan.shape,
        plan.lanes, plan.periodic, outside == "nearest", plan.out, bad,
    )  # fmt: skip
    plan.refuse(int(bad.sum()))
    return plan.result


class _Plan:
    """The arguments of both laws, checked and laid out as (components, nx, nm, nc)."""

    def __init__(
        self,
        field: Array,
        displacement: Array,
        grid: Grid,
        kernel: str | Kernel,
        out: Array | None,
        threads: int | None,
    ) -> None:
        values = check_field(field, grid)
        dtype = precision(values)
        moves = np.asarray(displacement)
        if moves.shape != (grid.ndim, *grid.shape):
            raise InputError(
                f"displacement must have shape {(grid.ndim, *grid.shape)}, got {moves.shape}",
                hint="velocity * dt, one component per axis",
            )
        if out is not None and (
            out.shape != values.shape or out.dtype != dtype or not out.flags.c_contiguous
        ):
            raise InputError(
                f"out must be a contiguous {dtype} array of shape {values.shape}, "
                f"got {out.dtype} {out.shape}",
                hint="np.empty_like(field)",
            )
        if out is not None and (
            np.may_share_memory(out, values) or np.may_share_memory(out, moves)
        ):
            raise InputError(
                "out shares memory with field or displacement", hint="another array for out"
            )
        self.result: Array = np.empty(values.shape, dtype) if out is None else out
        lines = layout(grid)
        self.field = np.ascontiguousarray(values, dtype).reshape(lines)
        self.displacement = np.ascontiguousarray(moves, dtype).reshape(lines)
        self.out = self.result.reshape(lines)
        self.threads = thread_count(threads)
        self.shape = tables(kernel, grid, dtype)
        width = len(self.shape[2])
        self.lanes = (0,) * max(8, 1 << (width - 1).bit_length())
        self.periodic = wraps(grid)

    def refuse(self, bad: int) -> None:
        """Refuse displacements that are no usable numbers."""
        if bad:
            raise InputError(
                "displacement must be finite and below 2^30 cells, it is not at some nodes",
                hint="check the velocity and the time step",
            )


def _bands(plan: _Plan, grid: Grid) -> NDArray[np.int64]:
    """Rows cut into bands so wide that every second one writes to rows of its own.

    The cut follows from the displacements alone, never from the number of threads.
    """
    moves = plan.displacement[0].ravel()
    rows, pieces = split(moves.size)
    low = np.zeros(pieces, np.int32)
    high = np.zeros(pieces, np.int32)
    share(_nodes.reach, pieces, plan.threads, rows, moves, plan.shape[0], low, high)
    plan.refuse(int(high.max() == FAR))
    span = int(high.max()) - int(low.min()) + len(plan.shape[2])
    count = even_bands(grid.shape[0] // span)
    return np.array([grid.shape[0] * k // count for k in range(count + 1)], dtype=np.int64)
