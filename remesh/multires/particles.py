"""Nodes of an adaptive mesh as particles: how their arrays are checked and laid out for loops."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.kernels import Kernel, get_kernel, table
from remesh.layout import FAR, precision
from remesh.multires.blocks import Blocks, layout
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]


def check_displacement(displacement: Array, blocks: Blocks) -> Array:
    """The displacement as an array; refuses any shape but ``(ndim, *blocks.shape)``."""
    moves = np.asarray(displacement)
    wanted = (blocks.mesh.ndim, *blocks.shape)
    if moves.dtype.kind not in "fiub":
        raise InputError(
            f"displacement must be real numbers, got {moves.dtype}", hint="its real part"
        )
    if moves.shape != wanted:
        raise InputError(
            f"displacement must have shape {wanted}, got {moves.shape}",
            hint="velocity * dt on these blocks, one component per axis",
        )
    return np.ascontiguousarray(moves, precision(moves))


def as_blocks(values: NDArray[Any], blocks: Blocks) -> NDArray[Any]:
    """Values as the loops take them, (components, n, nx, nm, nc); in 2-D nm = 1."""
    edge = blocks.mesh.block
    return values.reshape(-1, blocks.size, edge, edge if blocks.mesh.ndim == 3 else 1, edge)


def as_three(given: tuple[Any, ...], middle: Any) -> NDArray[Any]:
    """What is given for each axis, for the three axes of that layout."""
    return np.array([given[0], given[1] if len(given) == 3 else middle, given[-1]])


def first_places(blocks: Blocks) -> NDArray[np.int64]:
    """Places of blocks on the three axes of that layout, (n, 3)."""
    places = as_three(tuple(blocks.places.T), np.zeros(blocks.size, np.int64))
    return np.ascontiguousarray(places.T)


def block_counts(mesh: AdaptiveMesh) -> NDArray[np.int64]:
    """Number of blocks along the three axes if a level covered the domain, (levels + 1, 3)."""
    counts = layout(mesh)[0]
    return as_three(tuple(counts.T), np.ones(len(counts), np.int64)).T.copy()


def inverse_spacings(blocks: Blocks, dtype: np.dtype[Any]) -> Array:
    """One over the spacing of each block [1/L]."""
    return (1.0 / blocks.spacings).astype(dtype)


def tables(kernel: str | Kernel, ndim: int, dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """A kernel as the loops take it: coefficients, taps, taps of the middle axis, terms; numbers.

    Taps and terms are tuples whose lengths, constants to the compiler, are what counts; the last
    entry holds 1/2 and `FAR` in this precision.
    """
    found = get_kernel(kernel)
    coeffs = table(found, dtype)
    taps = (0,) * found.width
    numbers = np.array([0.5, FAR], dtype)
    return coeffs.ravel(), taps, taps if ndim == 3 else (0,), (0,) * coeffs.shape[2], numbers


def refuse_far(bad: int) -> None:
    """Refuse displacements that are no usable numbers."""
    if bad:
        raise InputError(
            "displacement must be finite and below 2^30 cells, it is not at some nodes",
            hint="check the velocity and the time step",
        )
