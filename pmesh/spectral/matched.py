"""Velocity kernels matched to a scaling function: what the vorticity of one node sets in motion."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.spectral.greens import hej
from remesh.errors import InputError
from remesh.multires.ghosts import midpoint_weights

Array = NDArray[np.float64]

ORDERS = (2, 4, 6, 8, 10)
_RADIUS = {2: 128, 3: 32}  # beyond, the point kernel itself: its error is below 2e-10 there


def point_kernel(offsets: tuple[NDArray[Any], ...]) -> Array:
    """d_0 G of -laplace G = delta at these offsets, zero at the point itself [1/L^(ndim - 1)]."""
    r2 = np.asarray(sum(np.square(x, dtype=np.float64) for x in offsets))
    apart = np.where(r2 > 0, r2, np.inf)
    if len(offsets) == 2:
        return np.asarray(-offsets[0] / (2 * math.pi * apart))
    return np.asarray(-offsets[0] / (4 * math.pi * apart**1.5))


@lru_cache(maxsize=16)
def matched_kernel(order: int, ndim: int) -> Array:
    """V(n) = (d_0 G * zeta)(n) at the whole offsets |n_i| <= 128 in 2-D, 32 in 3-D.

    zeta is the tensor product of the interpolating scaling function of that ``order`` (Deslauriers
    and Dubuc) with unit spacing: with spacing h, V h^(1 - ndim). Its moments 1 to ``order - 1``
    vanish, so that smooth vorticity is solved to that order and V is the point kernel but for
    O(|n|^(1 - ndim - order)). Odd along axis 0, even along others; other axes by exchange.
    From K(x/2) = 2^(ndim - 1) K(x) and the refinement of zeta follows V(n) = sum_j h_j V(2n - j)
    / 2, which goes inwards from far values and contracts by half around the origin.
    """
    if order not in ORDERS or ndim not in (2, 3):
        raise InputError(
            f"order must be one of {ORDERS} in 2-D or 3-D, got {order} in {ndim}-D", hint="order=8"
        )
    half, inner = order - 1, _RADIUS[ndim]
    outer = 2 * inner + half
    span = np.arange(-outer, outer + 1)
    values = point_kernel(np.meshgrid(*(span,) * ndim, indexing="ij", sparse=True))
    _refine(values, inner, order, 2 + math.ceil(math.log2(inner)))
    near = 3 * half
    core = tuple(slice(outer - near, outer + near + 1) for _ in range(ndim))
    _refine(values[core], half, order, 64)
    kept = tuple(slice(outer - inner, outer + inner + 1) for _ in range(ndim))
    result = np.ascontiguousarray(values[kept])
    result.flags.writeable = False
    return result


def _refine(values: Array, inner: int, order: int, times: int) -> None:
    """Renew the values up to ``inner`` from twice as far, again and again, in place."""
    half, middle = order - 1, values.shape[0] // 2
    taps = {0: 1.0, **dict(zip(range(-half, half + 1, 2), midpoint_weights(order), strict=True))}
    nodes = middle + 2 * np.arange(-inner, inner + 1)
    kept = tuple(slice(middle - inner, middle + inner + 1) for _ in values.shape)
    for _ in range(times):
        sums = values
        for axis in range(values.ndim):
            parts = (w * np.take(sums, nodes - j, axis) for j, w in taps.items())
            sums = np.asarray(sum(parts))
        values[kept] = sums / 2


def kernel_values(order: int, ndim: int, reach: int) -> Array:
    """The matched kernel at offsets up to ``reach``, continued by the point kernel."""
    known = matched_kernel(order, ndim)
    middle = known.shape[0] // 2
    if reach <= middle:
        return known[tuple(slice(middle - reach, middle + reach + 1) for _ in range(ndim))]
    span = np.arange(-reach, reach + 1)
    values = point_kernel(np.meshgrid(*(span,) * ndim, indexing="ij", sparse=True))
    values[tuple(slice(reach - middle, reach + middle + 1) for _ in range(ndim))] = known
    return values


def gaussian_values(order: int, radius: float, ndim: int, reach: int) -> Array:
    """d_0 of the Gaussian-regularised Green's function at whole offsets up to ``reach``.

    The kernel that `pmesh.velocity` takes on uniform meshes: of that ``order``, its ``radius`` in
    spacings. Source: `pmesh.spectral.greens.hej`.
    """
    span = np.arange(-reach, reach + 1, dtype=np.float64)
    offsets = np.meshgrid(*(span,) * ndim, indexing="ij", sparse=True)
    r2 = np.asarray(sum(np.square(x) for x in offsets))
    slope = hej(r2, np.zeros(()), ndim, sigma=radius, order=order)[1]
    return np.asarray(slope * offsets[0], np.float64)
