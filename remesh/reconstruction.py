"""Scattered values as a field: the mollified sum, corrected so that it keeps polynomials."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.cells import CellList, check_points
from remesh.errors import InputError
from remesh.layout import precision, split
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
CUTOFF = 4.5  # radii; beyond, a weight is below 2e-9
DEGREES = (0, 1, 2)


def reconstruct(
    positions: Array,
    values: Array,
    points: Array,
    radius: float,
    *,
    degree: int = 1,
    threads: int | None = None,
) -> Array:
    """The field that particles stand for at ``points``, from their values where they happen to be.

    The mollified sum q(x) = sum_p q_p zeta(|x - x_p| / radius) divided by that of ones
    (``degree=0``, Shepard), or corrected so that it keeps linear or quadratic fields
    (``degree=1, 2``): moving least squares with Gaussian weights, of order degree + 1 in the
    spacing when ``radius`` follows it. Needs no volumes and no regular positions; turns and shifts
    with the particles, to round-off. ``positions`` ``(n, ndim)`` and ``points`` ``(m, ndim)`` [L],
    ``values`` ``(n,)`` or ``(n, c)``, ``radius`` [L] about 1 to 2 spacings; returns ``(m,)`` or
    ``(m, c)``, NaN at points with no particle within 4.5 radii; of degree 0 where the particles
    there do not fix a polynomial. Same bits for any number of threads. Refuses a radius
    that is not positive and values that are not finite.
    Source: Lancaster & Salkauskas, Math. Comp. 37 (1981) 141.
    """
    from remesh import _reconstruction

    places = check_points(positions, "positions")
    targets = check_points(points, "points")
    given = np.asarray(values)
    n, ndim = places.shape
    if targets.shape[1] != ndim:
        raise InputError(
            f"points must have shape (m, {ndim}) like the positions, got {targets.shape}",
            hint="grid.points().reshape(grid.ndim, -1).T",
        )
    if given.ndim not in (1, 2) or given.shape[0] != n:
        raise InputError(
            f"values must have shape ({n},) or ({n}, c), got {given.shape}",
            hint="one value, or one row of components, per particle",
        )
    if not np.isfinite(given).all():
        raise InputError("values must be finite", hint="check the field they come from")
    if not (math.isfinite(radius) and radius > 0):
        raise InputError(f"radius must be a positive length, got {radius}", hint="radius=1.5 * h")
    if degree not in DEGREES:
        raise InputError(f"degree must be 0, 1 or 2, got {degree!r}", hint="degree=1")
    flat = np.ascontiguousarray(given.reshape(n, math.prod(given.shape[1:])), np.float64)
    result = np.full((len(targets), flat.shape[1]), np.nan)
    if n and len(targets):
        cells = CellList(places, CUTOFF * radius)
        powers = np.array(
            [p for p in itertools.product(range(degree + 1), repeat=3)
             if sum(p) <= degree and not any(p[ndim:])]
        )  # fmt: skip
        powers = powers[np.argsort(powers.sum(axis=1), kind="stable")]
        size, pieces = split(len(targets))
        share(
            _reconstruction.fit, pieces, thread_count(threads), size, cells.three(targets),
            cells.places, flat[cells.order], *cells.arguments, float(radius), CUTOFF, powers,
            result,
        )  # fmt: skip
    smooth: Array = result.astype(precision(given), copy=False)
    return smooth.reshape(len(targets), *given.shape[1:])
