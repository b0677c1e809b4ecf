"""How values on a uniform mesh spread: the heat equation solved by a stencil along each axis."""

from __future__ import annotations

import math
from functools import lru_cache
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, layout, precision, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
REACHES = {2: 0.4, 4: 0.6, 8: 1.3, 12: 2.0}  # half widths; nu t [spacings^2] they are good for
NARROWEST = 4  # half width of a stencil on a uniform mesh, at least


def spread_nodes(
    field: Array,
    grid: Grid,
    diffused: float,
    *,
    out: Array | None = None,
    threads: int | None = None,
) -> Array:
    """Values after the heat equation's time t, ``diffused`` = nu t [L^2].

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)`` [Q/L^ndim]; ``out`` may be the field. Along
    each axis the stencil of half width w with the moments 0 to 2w + 1 of the heat kernel: of order
    2w (8 up to nu t = 0.6 spacings^2, 16 up to 1.3, 24 up to 2.0; more takes equal substeps), one
    step without error in time, no wave grows. Keeps the sum and the first moments, but what spreads
    beyond unbounded edges is cut. Two passes over the memory per substep; same bits for any number
    of threads. Refuses wrong shapes, an ``out`` that overlaps the field, and ``diffused`` that is
    negative or not finite.
    """
    from remesh import _spreading
    from remesh._rows import CHUNK

    values = check_field(field, grid)
    dtype = precision(values)
    if not (math.isfinite(diffused) and diffused >= 0):
        raise InputError(
            f"diffused must be finite and >= 0, got {diffused}", hint="viscosity * dt [L^2]"
        )
    if out is not None and (
        out.shape != values.shape or out.dtype != dtype or not out.flags.c_contiguous
    ):
        raise InputError(
            f"out must be a contiguous {dtype} array of shape {values.shape}, "
            f"got {out.dtype} {out.shape}",
            hint="np.empty_like(field), or the field itself",
        )
    result: Array = np.empty(values.shape, dtype) if out is None else out
    source = np.ascontiguousarray(values, dtype).reshape(layout(grid))
    target = result.reshape(layout(grid))
    if np.may_share_memory(source, target) and source.ctypes.data != target.ctypes.data:
        raise InputError("out overlaps the field", hint="the field itself, or another array")
    parts, nx, nm, nc = source.shape
    if diffused == 0:
        np.copyto(target, source)
        return result
    reach, steps = plan(diffused / grid.spacing**2, max(REACHES))
    reach = max(reach, NARROWEST)
    weights = stencil(diffused / steps / grid.spacing**2, reach).astype(dtype)
    strips = parts * nm * -(-nc // CHUNK)
    periodic, count = wraps(grid), thread_count(threads)
    for _ in range(steps):
        share(_spreading.over_first, strips, count, source, weights, periodic[0], target)
        share(_spreading.over_others, parts * nx, count, target, weights, periodic)
        source = target
    return result


@lru_cache(maxsize=64)
def stencil(diffused: float, reach: int) -> NDArray[np.float64]:
    """Weights from the middle out for nu t in spacings^2: those with the right moments.

    exp(-nu t k^2) as a power series in y = 4 sin^2(k / 2), the symbol of minus the second
    difference, up to y^reach; k^2 = 2 sum_n y^n / (n^2 binomial(2n, n)).
    """
    logarithm = [0.0] + [-2 * diffused / (n * n * comb(2 * n, n)) for n in range(1, reach + 1)]
    series = [1.0]
    for n in range(1, reach + 1):
        series.append(sum(k * logarithm[k] * series[n - k] for k in range(1, n + 1)) / n)
    weights = np.zeros(reach + 1)
    for n, factor in enumerate(series):
        for j in range(n + 1):
            weights[j] += factor * (-1) ** j * comb(2 * n, n - j)
    weights.setflags(write=False)
    return weights


def plan(diffused: float, most: int) -> tuple[int, int]:
    """Half width, at most ``most`` nodes, and number of substeps for nu t in spacings^2."""
    usable = {reach: good for reach, good in REACHES.items() if reach <= most}
    for reach, good in usable.items():
        if diffused <= good:
            return reach, 1
    reach = max(usable)
    return reach, math.ceil(diffused / usable[reach])
