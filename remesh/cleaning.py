"""Divergence cleaning: what remeshing and stretching leave of it, taken out step by step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import split, wraps
from remesh.stencils import weights
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]

STRENGTH = 0.2  # c of w + c h^2 grad div w; the shortest waves are unstable beyond 0.265


def clean_divergence(
    field: Array, grid: Grid, *, scratch: Array | None = None, threads: int | None = None
) -> None:
    """Take part of the divergence out of a vector field (3, *shape), in place.

    One step of parabolic cleaning, ``w + c h^2 grad div w`` with sixth-order central differences
    and c = 0.2: a wave k loses the part c |k h|^2 of its divergence, short waves most of it, but
    none of what goes from node to node, which remeshing takes. A field without divergence stays to
    round-off. The velocity that w induces stays as far as differences and the exact curl agree, on
    waves that are resolved. Keeps the sum and the impulse of a field that vanishes towards
    unbounded edges, beyond which it is taken as zero, and its angular impulse if the sum is zero.
    ``scratch``: an array of ``grid.shape`` to work in. Rows of zeros cost little. Same bits for any
    number of threads. Refuses grids and fields that are not in space, fields that are not of
    floats, and a scratch that does not fit.
    Source: Dedner et al., J. Comput. Phys. 175 (2002) 645, the parabolic correction.
    """
    from remesh import _cleaning

    if grid.ndim != 3 or field.shape != (3, *grid.shape) or not field.flags.c_contiguous:
        raise InputError(
            f"the field must be contiguous with shape (3, *shape) on a grid in space, got "
            f"{field.shape} on {grid.shape}",
            hint="np.ascontiguousarray of one component per axis",
        )
    if field.dtype not in (np.float32, np.float64):
        raise InputError(f"the field must hold floats, got {field.dtype}", hint="float64")
    divergence = np.empty(grid.shape, field.dtype) if scratch is None else scratch
    if (
        divergence.shape != grid.shape
        or divergence.dtype != field.dtype
        or not divergence.flags.c_contiguous
        or np.may_share_memory(divergence, field)
    ):
        raise InputError(
            f"scratch must be a contiguous {field.dtype} array of its own of shape {grid.shape}, "
            f"got {divergence.dtype} {divergence.shape}",
            hint="np.empty(grid.shape, field.dtype)",
        )
    slopes = np.array([float(w) for w in weights(1, tuple(range(-3, 4)))[4:]]).astype(field.dtype)
    rows, pieces = split(grid.shape[0] * grid.shape[1])
    count, periodic = thread_count(threads), wraps(grid)
    share(_cleaning.diverge, pieces, count, rows, field, slopes, periodic, divergence)
    downhill = slopes * field.dtype.type(STRENGTH)
    share(_cleaning.descend, pieces, count, rows, divergence, downhill, periodic, field)
