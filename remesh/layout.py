"""How fields are laid out for the compiled loops: precision, shape, tables, pieces of work."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel, table

Array = NDArray[np.floating[Any]]
PIECES = 64  # pieces of work that threads share; fixed, so that results do not depend on threads
FAR = 1 << 30  # displacements beyond this many cells, or not numbers, are told by this value


def precision(values: NDArray[Any]) -> np.dtype[Any]:
    """float32 stays float32, all else is float64."""
    return np.dtype(np.float32 if values.dtype == np.float32 else np.float64)


def check_field(field: Array, grid: Grid) -> Array:
    """The field as an array; refuses what has not the shape ``grid.shape`` or ``(c, *shape)``."""
    values = np.asarray(field)
    if values.shape[-grid.ndim :] != grid.shape or values.ndim not in (grid.ndim, grid.ndim + 1):
        raise InputError(
            f"field must have shape {grid.shape} or (c, *{grid.shape}), got {values.shape}",
            hint="a field on the nodes of this grid",
        )
    return values


def layout(grid: Grid) -> tuple[int, ...]:
    """The shape (components, nx, nm, nc) of the loops; in 2-D the middle axis has one node."""
    return (-1, grid.shape[0], *(grid.shape[1:-1] or (1,)), grid.shape[-1])


def wraps(grid: Grid) -> NDArray[np.bool_]:
    """Which of the three axes of that layout are periodic."""
    return np.array([grid.periodic[0], grid.ndim == 3 and grid.periodic[1], grid.periodic[-1]])


def tables(kernel: str | Kernel, grid: Grid, dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """A kernel as the loops take it: scale, coefficients, taps, taps of the middle axis, terms.

    The last three are tuples whose lengths, constants to the compiler, are what counts.
    """
    found = get_kernel(kernel)
    coeffs = table(found, dtype)
    taps = (0,) * found.width
    scale = np.array([1 / grid.spacing, 0.5, FAR], dtype)
    return scale, coeffs.ravel(), taps, taps if grid.ndim == 3 else (0,), (0,) * coeffs.shape[2]


def split(count: int, least: int = 1) -> tuple[int, int]:
    """Size, ``least`` or more, and number of the pieces of so many rows, particles or points."""
    size = max(least, -(-count // PIECES))
    return size, -(-count // size)


def even_bands(count: int) -> int:
    """At most ``count`` bands: a multiple of four, or two, or one; every second is done at once."""
    count = min(count, PIECES)
    if count >= 4:
        return count - count % 4  # each half of them is even: two threads have as much to do
    return 2 if count > 1 else 1
