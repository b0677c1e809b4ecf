"""Compiled loops over a cell list: sums of Gaussian-type cutoffs around points."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, fastmath={"contract"})
def sum_cutoffs(
    first, pieces, step, size, points, positions, strengths, origin, width, shape, starts, reach,
    radius, cutoff, polynomial, result,
):  # fmt: skip
    """result[k] = sum over particles of strength * P(rho^2) exp(-rho^2), rho = distance/radius."""
    near = cutoff * cutoff
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    for piece in range(first, pieces, step):
        for k in range(piece * size, min((piece + 1) * size, points.shape[0])):
            for axis in range(3):
                c = (points[k, axis] - origin[axis]) / width
                c = min(max(c, -1e9), 1e9)
                low[axis] = max(np.int64(np.floor(c)) - reach, 0)
                high[axis] = min(np.int64(np.floor(c)) + reach, shape[axis] - 1)
            for i in range(low[0], high[0] + 1):
                for j in range(low[1], high[1] + 1):
                    if low[2] > high[2]:
                        continue
                    row = (i * shape[1] + j) * shape[2]
                    for p in range(starts[row + low[2]], starts[row + high[2] + 1]):
                        x = (points[k, 0] - positions[p, 0]) / radius
                        y = (points[k, 1] - positions[p, 1]) / radius
                        z = (points[k, 2] - positions[p, 2]) / radius
                        square = x * x + y * y + z * z
                        if square < near:
                            value = polynomial[2]
                            value = value * square + polynomial[1]
                            value = value * square + polynomial[0]
                            value *= math.exp(-square)
                            for part in range(result.shape[1]):
                                result[k, part] += strengths[p, part] * value
