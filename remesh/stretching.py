"""Vortex stretching of strengths on nodes: deformed with the lattice of their particles."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import precision, split, wraps
from remesh.stencils import weights
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Form = Literal["conservative", "classical"]
FORMS = ("conservative", "classical")


def stretched(
    strengths: Array,
    displacement: Array,
    grid: Grid,
    form: Form = "conservative",
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Array:
    """Strengths deformed with the lattice of the particles that a displacement d [L] moves.

    Both ``(3, *grid.shape)``. ``"conservative"``: w_i + sum_j D_j (w_j d_i), which keeps the sum of
    a field that is zero near unbounded edges; ``"classical"``: w_i + sum_j w_j (D_j d_i), no wider
    than w. D is the central difference of order 6, so both are of order 6 in the spacing, and exact
    for d = G x: w + G w (the conservative one where w is uniform). It wraps on periodic axes;
    beyond an unbounded edge w d is zero (conservative), d keeps its edge value (classical).
    Rows, and ends of rows, where all strengths in reach are zero cost nothing. Same bits for any
    number of threads. Refuses the plane, where nothing stretches, and an ``out`` that shares memory
    with what is read. Source: Cottet & Koumoutsakos, Vortex Methods (2000), section 3.1.
    """
    from remesh import _stretching

    if form not in FORMS:
        raise InputError(f"form must be one of {FORMS}, got {form!r}", hint="form='conservative'")
    values = _vectors(strengths, grid, "strengths")
    moves = np.ascontiguousarray(_vectors(displacement, grid, "displacement"), values.dtype)
    result = _output(out, values, moves)
    nodes = values.shape[1] * values.shape[2]
    rows, pieces = split(nodes)
    low, high = np.empty(nodes, np.int64), np.empty(nodes, np.int64)
    count = thread_count(threads)
    share(_stretching.extents, pieces, count, rows, values, low, high)
    share(
        _stretching.stretch, pieces, count, rows, values, moves, _slopes(grid, values.dtype),
        wraps(grid), form == "conservative", _lanes(grid), low, high, result,
    )  # fmt: skip
    return result


def _slopes(grid: Grid, dtype: np.dtype[Any]) -> Array:
    """Weights of the difference one, two and three nodes ahead [1/L]."""
    ahead = weights(1, tuple(range(-3, 4)))[4:]
    return np.array([float(w) / grid.spacing for w in ahead], dtype)


def _lanes(grid: Grid) -> tuple[int, ...]:
    """Nodes done at once: no more than a row has."""
    return (0,) * (8 if grid.shape[-1] >= 8 else 1)


def _vectors(field: Array, grid: Grid, name: str) -> Array:
    values = np.asarray(field)
    if grid.ndim != 3:
        raise InputError(
            f"{name} must be vectors in space, the grid has {grid.ndim} axes",
            hint="in the plane vorticity is a scalar: it does not stretch and has no divergence",
        )
    if values.shape != (3, *grid.shape):
        raise InputError(
            f"{name} must have shape {(3, *grid.shape)}, got {values.shape}",
            hint="one component per axis first",
        )
    return np.ascontiguousarray(values, precision(values))


def _output(out: Array | None, values: Array, moves: Array) -> Array:
    if out is None:
        return np.empty_like(values)
    if out.shape != values.shape or out.dtype != values.dtype or not out.flags.c_contiguous:
        raise InputError(
            f"out must be a contiguous {values.dtype} array of shape {values.shape}, "
            f"got {out.dtype} {out.shape}",
            hint="np.empty_like(strengths)",
        )
    if np.may_share_memory(out, values) or np.may_share_memory(out, moves):
        raise InputError(
            "out shares memory with strengths or displacement", hint="another array for out"
        )
    return out
