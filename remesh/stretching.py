"""How vorticity in space stretches: strengths of particles deformed with their lattice."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from remesh import _stretching
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import precision, split, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Form = Literal["conservative", "classical"]
FORMS = ("conservative", "classical")
SIXTH = (3 / 4, -3 / 20, 1 / 60)  # weights of the sixth-order central difference


def stretched(
    strengths: Array,
    displacement: Array,
    grid: Grid,
    form: Form = "conservative",
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Array:
    """Strengths w (3, *shape) of particles that went from their nodes by d (3, *shape) [L].

    ``"classical"``: w + (w . grad) d, Cauchy's formula: exact for the vorticity of an inviscid
    flow, whose lines go with the fluid. ``"conservative"``: w + div(w d), the same where w has no
    divergence; it keeps the sum of the strengths to round-off where they vanish at unbounded edges.
    Sixth-order central differences, exact for displacements that are polynomials of degree 6 (of a
    product with w in the conservative form). They wrap on periodic axes; beyond unbounded edges
    strengths are zero, and d keeps its edge value. One pass; rows without vorticity cost nothing.
    Same bits for any number of threads. Refuses grids that are not in space, wrong shapes, an
    ``out`` that shares memory. Source: Cottet & Koumoutsakos, Vortex Methods (2000), chapter 3.
    """
    if form not in FORMS:
        raise InputError(f"form must be one of {', '.join(FORMS)}, got {form!r}", hint=FORMS[0])
    if grid.ndim != 3:
        raise InputError(
            "vorticity stretches in space, the grid is plane", hint="a Grid with three axes"
        )
    shape = (3, *grid.shape)
    w, d = np.asarray(strengths), np.asarray(displacement)
    for name, field in (("strengths", w), ("displacement", d)):
        if field.shape != shape:
            raise InputError(
                f"{name} must have shape {shape}, got {field.shape}",
                hint="one component per axis, in front",
            )
    dtype = precision(w)
    result = np.empty(shape, dtype) if out is None else out
    if result.shape != shape or result.dtype != dtype or not result.flags.c_contiguous:
        raise InputError(
            f"out must be a contiguous {dtype} array of shape {shape}, "
            f"got {result.dtype} {result.shape}",
            hint="np.empty_like(strengths)",
        )
    if np.may_share_memory(result, w) or np.may_share_memory(result, d):
        raise InputError(
            "out shares memory with strengths or displacement", hint="another array for out"
        )
    rows, pieces = split(grid.shape[0] * grid.shape[1])
    share(
        _stretching.stretch, pieces, thread_count(threads), rows,
        np.ascontiguousarray(w, dtype), np.ascontiguousarray(d, dtype),
        (np.array(SIXTH) / grid.spacing).astype(dtype), wraps(grid), form == "conservative",
        result,
    )  # fmt: skip
    return result
