"""Finite differences on a mesh: gradient, divergence, curl, Laplacian of order 2, 4 or 6."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import layout, precision, split, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Edge = Literal["onesided", "zero"]
ORDERS = (2, 4, 6)


@lru_cache(maxsize=64)
def weights(derivative: int, offsets: tuple[int, ...]) -> tuple[Fraction, ...]:
    """Exact weights w with sum w_k f(k) = f^(derivative)(0) for polynomials of degree < n."""
    n = len(offsets)
    rows = [[Fraction(k) ** power for k in offsets] for power in range(n)]
    right = [Fraction(0)] * n
    right[derivative] = Fraction(1 if derivative < 2 else 2)
    for i in range(n):
        pivot = next(r for r in range(i, n) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        right[i], right[pivot] = right[pivot], right[i]
        scale = rows[i][i]
        rows[i] = [value / scale for value in rows[i]]
        right[i] /= scale
        for r in range(n):
            if r != i and rows[r][i] != 0:
                factor = rows[r][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i], strict=True)]
                right[r] -= factor * right[i]
    return tuple(right)


def derivative(
    field: Array,
    grid: Grid,
    axis: int,
    *,
    degree: int = 1,
    order: int = 4,
    edge: Edge = "onesided",
) -> Array:
    """First or second derivative of a field along one axis, for any leading component axes.

    ``field`` ``(..., *grid.shape)``; the last ``ndim`` axes are the mesh. Central differences of
    ``order`` 2, 4 or 6; they wrap on a periodic axis. At an unbounded edge they lean inward with
    the same order (``edge="onesided"``), or take the field to go on as zero (``edge="zero"``).
    Source: Fornberg, Math. Comp. 51 (1988) 699; the weights here are solved in exact rationals.
    """
    _check_order(order, edge)
    values = _field(field, grid)
    along = values.ndim - grid.ndim + axis
    source = np.moveaxis(values, along, 0)
    result = np.zeros_like(values)
    target = np.moveaxis(result, along, 0)
    half = order // 2
    size = source.shape[0]
    narrow = order + degree  # nodes that a one-sided difference of this order reads
    if edge == "onesided" and not grid.periodic[axis] and size < narrow:
        raise InputError(
            f"differences of order {order} read {narrow} nodes, axis {axis} has {size}",
            hint="a lower order, or a longer axis",
        )
    central = weights(degree, tuple(range(-half, half + 1)))
    for offset, exact in zip(range(-half, half + 1), central, strict=True):
        if exact == 0:
            continue
        weight = values.dtype.type(float(exact) / grid.spacing**degree)
        if grid.periodic[axis]:
            target += weight * np.roll(source, -offset, axis=0)
        else:
            low, high = max(0, -offset), min(size, size - offset)
            target[low:high] += weight * source[low + offset : high + offset]
    if edge == "onesided" and not grid.periodic[axis]:
        for i in [*range(half), *range(size - half, size)]:
            start = 0 if i < half else size - narrow
            leaning = weights(degree, tuple(k - i for k in range(start, start + narrow)))
            scaled = np.array([float(w) for w in leaning]) / grid.spacing**degree
            target[i] = np.tensordot(
                scaled.astype(values.dtype), source[start : start + narrow], axes=1
            )
    return result


def gradient(field: Array, grid: Grid, *, order: int = 4, edge: Edge = "onesided") -> Array:
    """grad f, shape ``(ndim, *field.shape)``: entry i holds the derivative along axis i.

    For a vector field ``(c, *shape)`` entry [i, j] is du_j/dx_i. Edges as in `derivative`.
    """
    return np.stack(
        [derivative(field, grid, axis, order=order, edge=edge) for axis in range(grid.ndim)]
    )


def divergence(field: Array, grid: Grid, *, order: int = 4, edge: Edge = "onesided") -> Array:
    """div u of a vector field ``(ndim, *shape)``: ``grid.shape``. Edges as in `derivative`."""
    vector = _vector(field, grid)
    result = derivative(vector[0], grid, 0, order=order, edge=edge)
    for axis in range(1, grid.ndim):
        result += derivative(vector[axis], grid, axis, order=order, edge=edge)
    return result


def curl(field: Array, grid: Grid, *, order: int = 4, edge: Edge = "onesided") -> Array:
    """curl u. In 2-D a vector gives dv/dx - du/dy, a scalar psi gives (dpsi/dy, -dpsi/dx).

    In 3-D a vector ``(3, *shape)`` gives a vector. Counter-clockwise is positive.
    Central differences along different axes commute, so divergence(curl) is zero to round-off.
    """
    values = _field(field, grid)

    def d(axis: int, part: Array) -> Array:
        return derivative(part, grid, axis, order=order, edge=edge)

    if grid.ndim == 2 and values.ndim == 2:
        return np.stack([d(1, values), -d(0, values)])
    vector = _vector(values, grid)
    if grid.ndim == 2:
        return np.asarray(d(0, vector[1]) - d(1, vector[0]))
    u, v, w = vector
    return np.stack([d(1, w) - d(2, v), d(2, u) - d(0, w), d(0, v) - d(1, u)])


def laplacian(field: Array, grid: Grid, *, order: int = 4, edge: Edge = "onesided") -> Array:
    """Laplacian of each component, same shape as ``field``. Edges as in `derivative`."""
    result = derivative(field, grid, 0, degree=2, order=order, edge=edge)
    for axis in range(1, grid.ndim):
        result += derivative(field, grid, axis, degree=2, order=order, edge=edge)
    return result


def max_gradient_norm(velocity: Array, grid: Grid, *, threads: int | None = None) -> float:
    """Largest over the nodes of the row-sum norm max_i sum_j |du_i/dx_j| [1/T].

    ``velocity`` ``(ndim, *shape)`` [L/T]. Second-order differences (first-order at an unbounded
    edge): this sets time steps (LCFL) and bounds every strain rate. Not a number if the velocity
    is not one somewhere. Same bits for any number of threads; one pass over the velocity.
    """
    from remesh import _stencils

    vector = np.ascontiguousarray(_vector(velocity, grid))
    lines = vector.reshape(layout(grid))
    rows, pieces = split(lines.shape[1] * lines.shape[2])
    result = np.zeros(pieces, vector.dtype)
    share(
        _stencils.largest_gradient, pieces, thread_count(threads), rows, lines,
        vector.dtype.type(1 / grid.spacing), wraps(grid), result,
    )  # fmt: skip
    return float(result.max())


def divergence_ratio(field: Array, grid: Grid, *, threads: int | None = None) -> float:
    """How far a vector field (3, *shape) is from solenoidal: rms of div over rms of all gradients.

    Sixth-order central differences, at the nodes whose stencils lie on the mesh: 0 for a field
    without divergence, 1/3 to 1 for one without a curl; 0 for a uniform one. One pass; same bits
    for any number of threads. Refuses fields and grids that are not in space.
    """
    from remesh import _stencils

    if grid.ndim != 3:
        raise InputError("the field must be in space, the grid is plane", hint="three axes")
    vector = np.ascontiguousarray(_vector(field, grid))
    central = [float(w) for w in weights(1, tuple(range(-3, 4)))[4:]]
    sums = np.zeros((grid.shape[0], 2))
    share(
        _stencils.split_gradient, grid.shape[0], thread_count(threads), vector,
        np.array(central, vector.dtype) / vector.dtype.type(grid.spacing), wraps(grid), sums,
    )  # fmt: skip
    squared, whole = sums.sum(axis=0)
    return math.sqrt(squared / whole) if whole > 0 else 0.0


def _check_order(order: int, edge: str) -> None:
    if order not in ORDERS:
        raise InputError(f"order must be 2, 4 or 6, got {order!r}", hint="order=4")
    if edge not in ("onesided", "zero"):
        raise InputError(f"edge must be 'onesided' or 'zero', got {edge!r}", hint="edge='onesided'")


def _field(field: Array, grid: Grid) -> Array:
    values = np.asarray(field)
    if values.shape[-grid.ndim :] != grid.shape:
        raise InputError(
            f"field must end in the grid's shape {grid.shape}, got {values.shape}",
            hint="component axes first: (c, *grid.shape)",
        )
    return values.astype(precision(values), copy=False)


def _vector(field: Array, grid: Grid) -> Array:
    values = _field(field, grid)
    if values.shape != (grid.ndim, *grid.shape):
        raise InputError(
            f"a vector field must have shape {(grid.ndim, *grid.shape)}, got {values.shape}",
            hint="np.stack of one component per axis",
        )
    return values
