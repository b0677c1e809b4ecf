"""Ghosts of blocks: what lies around a block, as values of its own level."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.layout import precision
from remesh.multires.blocks import Blocks
from remesh.multires.wavelets import get_wavelet
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Outside = Literal["zero", "last"]  # what a field is beyond unbounded ends: nothing, or as at them
ORDERS = (2, 4, 6, 8)  # points of a prediction


def padded(
    values: Array,
    blocks: Blocks,
    width: int,
    *,
    order: int | None = None,
    outside: Outside = "zero",
    threads: int | None = None,
) -> Array:
    """Blocks with ``width`` ghosts on each side, ``(..., n, *(block + 2 * width,) * ndim)``.

    ``values`` are ``(n, *(block,) * ndim)`` or ``(c, n, ...)``. A ghost that lies in a block of the
    same level is that block's value; elsewhere it is predicted from the even nodes around it, those
    of the level where blocks are, else those of the next coarser level: by the wavelet's own
    prediction, or by polynomials through ``order`` nodes along each axis, exact for degrees below
    that. Beyond an unbounded end the field is zero, also for predictions. With ``outside="last"``
    ghosts there hold the last node's value, and predictions near it see the cubics through the last
    four even nodes: constants stay constant. O(nodes); same bits for any number of threads.
    Refuses widths beyond ``block - order``.
    """
    values = check_values(values, blocks)
    last = goes_on(outside)
    weights = prediction(blocks, order, values.dtype)
    most = blocks.mesh.block - weights.size
    if int(width) != width or not 0 <= width <= most:
        raise InputError(
            f"width must be a whole number from 0 to {most} for blocks of {blocks.mesh.block} "
            f"nodes and predictions from {weights.size}, got {width}",
            hint="larger blocks, or a lower order",
        )
    from remesh.multires import _ghosts

    size = blocks.mesh.block + 2 * int(width)
    out = np.empty((*values.shape[: -blocks.mesh.ndim], *(size,) * blocks.mesh.ndim), values.dtype)
    share(
        _ghosts.pad, blocks.size, thread_count(threads), layers(values, blocks),
        blocks.neighbours, blocks.coarser, blocks.sides, weights, int(width), last,
        layers(out, blocks),
    )  # fmt: skip
    return out


def goes_on(outside: str) -> bool:
    """Whether values go on beyond unbounded ends; refuses other words."""
    if outside not in ("zero", "last"):
        raise InputError(
            f"outside must be 'zero' or 'last', got {outside!r}",
            hint='outside="last" for velocities, "zero" for what vanishes far away',
        )
    return outside == "last"


def check_values(values: Array, blocks: Blocks) -> Array:
    """Values on blocks as a contiguous array; refuses other shapes, and what is not real."""
    found = np.asarray(values)
    if found.dtype.kind not in "fiub":
        raise InputError(
            f"values must be real numbers, got {found.dtype}",
            hint="values.real and values.imag, one after the other",
        )
    shape = blocks.shape
    if found.shape[-len(shape) :] != shape or found.ndim not in (len(shape), len(shape) + 1):
        raise InputError(
            f"values must have shape {shape} or (c, *{shape}), got {found.shape}",
            hint="values on the nodes of these blocks",
        )
    return np.ascontiguousarray(found, precision(found))


def layers(values: Array, blocks: Blocks) -> Array:
    """Values as the loops take them, ``(c, n, bx, b, b)``: in 2-D ``bx`` is 1."""
    size = values.shape[-1]
    return values.reshape(-1, blocks.size, size if blocks.mesh.ndim == 3 else 1, size, size)


def prediction(blocks: Blocks, order: int | None, dtype: np.dtype[Any]) -> Array:
    """Weights of a prediction, of the mesh's wavelet or through ``order`` nodes."""
    if order is None:
        return lifting_weights(blocks, dtype)[0]
    if order not in ORDERS:
        raise InputError(f"order must be one of {ORDERS}, got {order}", hint="order=4")
    return midpoint_weights(int(order)).astype(dtype)


def lifting_weights(blocks: Blocks, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """Weights of the prediction and of the update of the mesh's wavelet."""
    wavelet = get_wavelet(blocks.mesh.wavelet)
    predict, update = ([float(w) for w in row] for row in (wavelet.predict, wavelet.update))
    return np.array(predict, dtype), np.array(update, dtype)


@lru_cache(maxsize=8)
def midpoint_weights(order: int) -> NDArray[np.float64]:
    """Interpolation midway between nodes by the polynomial through the ``order`` nearest."""
    nodes = np.arange(order) - (order - 1) / 2
    factors = [[-b / (a - b) for b in nodes if b != a] for a in nodes]  # at 0, of the one 1 at a
    weights: NDArray[np.float64] = np.prod(np.array(factors), axis=1)
    weights.flags.writeable = False
    return weights
