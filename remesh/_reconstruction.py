"""Compiled loops over a cell list: moving least squares around points."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

SINGULAR = 1e-9  # of the first pivot: particles that do not fix a polynomial


@njit(cache=True, nogil=True)
def factor(matrix, size):
    """Cholesky factor in the lower half; False if the matrix is nearly singular."""
    for j in range(size):
        pivot = matrix[j, j]
        for k in range(j):
            pivot -= matrix[j, k] * matrix[j, k]
        if not pivot > SINGULAR * matrix[0, 0] * matrix[0, 0]:
            return False
        matrix[j, j] = math.sqrt(pivot)
        for i in range(j + 1, size):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j]
    return True


@njit(cache=True, nogil=True)
def first_row(matrix, size, row):
    """The solution for a right side of 1, 0, 0, ...: what weighs the terms' sums at the point."""
    for i in range(size):
        total = 1.0 if i == 0 else 0.0
        for k in range(i):
            total -= matrix[i, k] * row[k]
        row[i] = total / matrix[i, i]
    for i in range(size - 1, -1, -1):
        total = row[i]
        for k in range(i + 1, size):
            total -= matrix[k, i] * row[k]
        row[i] = total / matrix[i, i]


@njit(cache=True, nogil=True)
def fit(
    first, pieces, step, size, points, positions, values, origin, width, shape, starts, reach,
    radius, cutoff, powers, result,
):  # fmt: skip
    """The polynomial through the values, weighed by exp(-rho^2), at each point; NaN without any."""
    count = powers.shape[0]
    parts = values.shape[1]
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    matrix, terms, row = np.empty((count, count)), np.empty(count), np.empty(count)
    sums, along = np.empty((count, parts)), np.ones((3, 3))
    for piece in range(first, pieces, step):
        for k in range(piece * size, min((piece + 1) * size, points.shape[0])):
            matrix[:] = 0.0
            sums[:] = 0.0
            for axis in range(3):
                c = (points[k, axis] - origin[axis]) / width
                c = min(max(c, -1e9), 1e9)
                low[axis] = max(np.int64(np.floor(c)) - reach, 0)
                high[axis] = min(np.int64(np.floor(c)) + reach, shape[axis] - 1)
            for i in range(low[0], high[0] + 1):
                for j in range(low[1], high[1] + 1):
                    if low[2] > high[2]:
                        continue
                    line = (i * shape[1] + j) * shape[2]
                    for p in range(starts[line + low[2]], starts[line + high[2] + 1]):
                        x = (positions[p, 0] - points[k, 0]) / radius
                        y = (positions[p, 1] - points[k, 1]) / radius
                        z = (positions[p, 2] - points[k, 2]) / radius
                        square = x * x + y * y + z * z
                        if square >= cutoff * cutoff:
                            continue
                        weight = math.exp(-square)
                        along[1, 0], along[1, 1], along[1, 2] = x, y, z
                        along[2, 0], along[2, 1], along[2, 2] = x * x, y * y, z * z
                        for t in range(count):
                            terms[t] = (
                                along[powers[t, 0], 0]
                                * along[powers[t, 1], 1]
                                * along[powers[t, 2], 2]
                            )
                        for t in range(count):
                            for s in range(t + 1):
                                matrix[t, s] += weight * terms[t] * terms[s]
                            for part in range(parts):
                                sums[t, part] += weight * terms[t] * values[p, part]
            used = count
            mean = matrix[0, 0]
            if not mean > 0.0:
                result[k] = np.nan
                continue
            for t in range(count):
                for s in range(t + 1):
                    matrix[t, s] /= mean
            if factor(matrix, count):
                first_row(matrix, count, row)
            else:
                used = 1
                row[0] = 1.0
            for part in range(parts):
                total = 0.0
                for t in range(used):
                    total += row[t] * sums[t, part]
                result[k, part] = total / mean
