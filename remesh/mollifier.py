"""Mollified particles: the smooth field that a set of particles stands for, at any point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from remesh.cells import CellList, check_points
from remesh.errors import InputError
from remesh.layout import precision, split
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
CUTOFF = 6.5  # radii; beyond, a cutoff is below 1e-15 of its peak

# (ndim, order): P with zeta(rho) = P(rho^2) exp(-rho^2) / pi^(ndim/2), coefficients low to high.
# Generalised Laguerre polynomials L_{order/2 - 1}^{(ndim/2)}; in 2-D those of Beale & Majda (1985).
CUTOFFS: Mapping[tuple[int, int], tuple[float, float, float]] = MappingProxyType(
    {
        (2, 2): (1.0, 0.0, 0.0),
        (2, 4): (2.0, -1.0, 0.0),
        (2, 6): (3.0, -3.0, 0.5),
        (3, 2): (1.0, 0.0, 0.0),
        (3, 4): (2.5, -1.0, 0.0),
        (3, 6): (4.375, -3.5, 0.5),
    }
)


def cutoff(rho: ArrayLike, ndim: int, order: int = 2) -> Array:
    """zeta(rho) for rho = r / radius: integral 1, moments 1 to order - 1 zero.

    Source: Beale & Majda, J. Comput. Phys. 58 (1985) 188; Cottet & Koumoutsakos (2000), ch. 2.3.
    """
    if (ndim, order) not in CUTOFFS:
        raise InputError(
            f"cutoffs exist of order 2, 4 and 6 in 2-D and 3-D, got order {order!r}, {ndim!r}-D",
            hint="order=2",
        )
    square = np.asarray(rho, dtype=np.float64) ** 2
    a, b, c = CUTOFFS[ndim, order]
    result: Array = (a + square * (b + square * c)) * np.exp(-square) / math.pi ** (ndim / 2)
    return result


def mollify(
    positions: Array,
    values: Array,
    volumes: float | Array,
    points: Array,
    radius: float,
    *,
    order: int = 2,
    threads: int | None = None,
) -> Array:
    """The field q(x) = sum_p volume_p value_p zeta(|x - x_p| / radius) / radius^ndim at ``points``.

    ``positions`` ``(n, ndim)`` and ``points`` ``(m, ndim)`` [L], ``values`` ``(n,)`` or ``(n, c)``,
    ``volumes`` one or ``(n,)`` [L^ndim] (1 if the values are strengths), ``radius`` [L] the
    mollifier's epsilon; returns ``(m,)`` or ``(m, c)``. On a lattice of spacing h the error is
    C1 radius^order + C2 (h / radius)^m: particles must overlap, radius > h, and with a Gaussian
    m is as large as the field is smooth. Free space. Sums stop at 6.5 radii, below 1e-15 of the
    peak of one particle. Cost grows with the particles within that distance. Same bits for any
    number of threads. Refuses a radius that is not positive and values that are not finite.
    """
    from remesh import _mollifier

    given = np.asarray(values)
    places = check_points(positions, "positions")
    ndim = places.shape[1]
    targets = check_points(points, "points")
    if targets.shape[1] != ndim:
        raise InputError(
            f"points must have shape (m, {ndim}) like the positions, got {targets.shape}",
            hint="grid.points().reshape(grid.ndim, -1).T",
        )
    if not (math.isfinite(radius) and radius > 0):
        raise InputError(f"radius must be a positive length, got {radius}", hint="radius=2 * h")
    n = places.shape[0]
    if given.ndim not in (1, 2) or given.shape[0] != n:
        raise InputError(
            f"values must have shape ({n},) or ({n}, c), got {given.shape}",
            hint="one value, or one row of components, per particle",
        )
    weights = np.asarray(volumes, dtype=np.float64)
    if weights.shape not in ((), (n,)):
        raise InputError(
            f"volumes must be one number or have shape ({n},), got {weights.shape}",
            hint="volumes=grid.cell_volume",
        )
    peak = cutoff(0.0, ndim, order) / (CUTOFFS[ndim, order][0] * radius**ndim)
    flat = given.reshape(n, -1) if n else np.zeros((0, given[:1].size or 1))
    strengths = flat * (weights * peak)[..., None]
    if not np.isfinite(strengths).all():
        raise InputError("values and volumes must be finite", hint="check the field they come from")
    result = np.zeros((targets.shape[0], strengths.shape[1]))
    if n and len(targets):
        cells = CellList(places, CUTOFF * radius)
        size, pieces = split(len(targets))
        share(
            _mollifier.sum_cutoffs, pieces, thread_count(threads), size, cells.three(targets),
            cells.places, strengths[cells.order], *cells.arguments, float(radius), CUTOFF,
            np.array(CUTOFFS[ndim, order]), result,
        )  # fmt: skip
    smooth: Array = result.astype(precision(given), copy=False)
    return smooth.reshape(len(targets), *given.shape[1:])
