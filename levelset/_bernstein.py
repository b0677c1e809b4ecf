"""Compiled algebra of cubic polynomials on a cell, by their Bernstein coefficients.

Coefficients have shape (4, 4, 4), in the plane (4, 4, 1); on the unit cell a polynomial lies
between the smallest and the largest of them, and so does each derivative with its own.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

STEPS = 60  # of a search for a root, at most
CLOSE = 3e-8  # a step of Newton's so short is the last: what is left is of its square


def _matrices():
    """From four nodal values to coefficients on [0, 1], the nodes from 0, -1 or -2 on.

    Then: of the line through the first two, of the parabola without the last node, or the first.
    """
    powers = np.arange(4)
    binomial = np.array([[math.comb(i, k) / math.comb(3, k) for k in powers] for i in powers])
    found = np.zeros((6, 4, 4))
    for lead in range(3):
        nodes = np.arange(4.0) - lead
        found[lead] = binomial @ np.linalg.inv(nodes[:, None] ** powers)
    found[LINE, :, 0], found[LINE, :, 1] = 1 - powers / 3, powers / 3
    for row, first in ((WITHOUT_LAST, 0), (WITHOUT_FIRST, 1)):
        nodes = np.arange(3.0) + first - 1
        few = np.linalg.inv(nodes[:, None] ** powers[:3])
        found[row, :, first : first + 3] = binomial[:, :3] @ few
    return np.round(18 * found) / 18  # exact: the first and the last coefficient are nodal values


LINE, WITHOUT_LAST, WITHOUT_FIRST = 3, 4, 5
MATRICES = _matrices()
MIDDLE = (0.125, 0.375, 0.375, 0.125)  # the four cubics in the middle of the cell,
BETWEEN = (0.25, 0.5, 0.25, 0.0)  # the three parabolas that their derivatives are made of,
ALONE = (1.0, 0.0, 0.0, 0.0)  # and along an axis of one coefficient


@njit(cache=True, nogil=True)
def along(coefficients, axis, matrix):
    """Multiply by a matrix along one axis, in place."""
    a = coefficients
    for m in range(a.shape[(axis + 1) % 3]):
        for n in range(a.shape[(axis + 2) % 3]):
            if axis == 0:
                v0, v1, v2, v3 = a[0, m, n], a[1, m, n], a[2, m, n], a[3, m, n]
            elif axis == 1:
                v0, v1, v2, v3 = a[n, 0, m], a[n, 1, m], a[n, 2, m], a[n, 3, m]
            else:
                v0, v1, v2, v3 = a[m, n, 0], a[m, n, 1], a[m, n, 2], a[m, n, 3]
            for i in range(4):
                value = matrix[i, 0] * v0 + matrix[i, 1] * v1
                value += matrix[i, 2] * v2 + matrix[i, 3] * v3
                if axis == 0:
                    a[i, m, n] = value
                elif axis == 1:
                    a[n, i, m] = value
                else:
                    a[m, n, i] = value


@njit(cache=True, nogil=True)
def halve(coefficients, axis, upper):
    """Restrict to the lower or upper half along one axis, in place (de Casteljau)."""
    a = coefficients
    for m in range(a.shape[(axis + 1) % 3]):
        for n in range(a.shape[(axis + 2) % 3]):
            if axis == 0:
                line = a[:, m, n]
            elif axis == 1:
                line = a[n, :, m]
            else:
                line = a[m, n, :]
            for level in range(3):
                if upper:
                    for i in range(3 - level):
                        line[i] = 0.5 * (line[i] + line[i + 1])
                else:
                    for i in range(3, level, -1):
                        line[i] = 0.5 * (line[i - 1] + line[i])


@njit(cache=True, nogil=True)
def sign(coefficients):
    """-1 or 1 where the coefficients are of one sign, else 0."""
    below = False
    above = False
    for value in coefficients.flat:
        below |= value < 0
        above |= value >= 0
    return 0 if below and above else (-1 if below else 1)


@njit(cache=True, nogil=True)
def slope(coefficients, axis):
    """The derivative along an axis: at the cell's middle, its least and its largest coefficient."""
    a = coefficients
    u = BETWEEN if axis == 0 else (MIDDLE if a.shape[0] == 4 else ALONE)
    v = BETWEEN if axis == 1 else (MIDDLE if a.shape[1] == 4 else ALONE)
    w = BETWEEN if axis == 2 else (MIDDLE if a.shape[2] == 4 else ALONE)
    x, y, z = int(axis == 0), int(axis == 1), int(axis == 2)
    least, most, total = np.inf, -np.inf, 0.0
    for i in range(a.shape[0] - x):
        for j in range(a.shape[1] - y):
            weight = u[i] * v[j]
            for k in range(a.shape[2] - z):
                step = a[i + x, j + y, k + z] - a[i, j, k]
                least = step if step < least else least  # faster than min, which minds NaN
                most = step if step > most else most
                total += weight * w[k] * step
    return 3 * total, 3 * least, 3 * most


@njit(cache=True, nogil=True)
def basis(x):
    """The four cubics at x."""
    y = 1.0 - x
    return y * y * y, 3 * x * y * y, 3 * x * x * y, x * x * x


@njit(cache=True, nogil=True)
def tangent(x):
    """Their derivatives at x."""
    y = 1.0 - x
    return -3 * y * y, 3 * y * (y - 2 * x), 3 * x * (2 * y - x), 3 * x * x


@njit(cache=True, nogil=True)
def value(coefficients, x, y, z):
    """The polynomial at a point of the unit cell."""
    u, v = basis(x), basis(y)
    w = basis(z)
    if coefficients.shape[2] == 1:
        w = (1.0, 0.0, 0.0, 0.0)
    total = 0.0
    for i in range(4):
        for j in range(4):
            inner = 0.0
            for k in range(coefficients.shape[2]):
                inner += w[k] * coefficients[i, j, k]
            total += u[i] * v[j] * inner
    return total


@njit(cache=True, nogil=True)
def cubic(a, b, c, d, x):
    """The cubic of these coefficients at x."""
    y = 1.0 - x
    return y * y * (y * a + 3 * x * b) + x * x * (3 * y * c + x * d)


@njit(cache=True, nogil=True)
def single(a, b, c, d, low, high):
    """The root of a cubic between two places of opposite sign: Newton kept in a bracket."""
    rising = cubic(a, b, c, d, low) < 0
    left, right = low, high
    first, last = cubic(a, b, c, d, left), cubic(a, b, c, d, right)
    x = left + (right - left) * first / (first - last) if first != last else 0.5 * (left + right)
    for _ in range(STEPS):
        y = 1.0 - x
        here = cubic(a, b, c, d, x)
        if here == 0:
            break
        if (here < 0) == rising:
            left = x
        else:
            right = x
        steep = 3 * (y * y * (b - a) + 2 * x * y * (c - b) + x * x * (d - c))
        ahead = x - here / steep if steep != 0 else left - 1.0
        close = CLOSE
        if not left < ahead < right:
            ahead, close = 0.5 * (left + right), CLOSE * CLOSE
        moved = abs(ahead - x)
        x = ahead
        if moved < close:
            break
    return x


@njit(cache=True, nogil=True)
def roots(a, b, c, d, found, count):
    """Append the roots of a cubic in (0, 1), ascending; returns how many are found by now."""
    if (a < 0) == (b < 0) and (b < 0) == (c < 0) and (c < 0) == (d < 0):
        return count
    # where it turns: derivative 3 ((1-x)^2 p + 2 x (1-x) q + x^2 r)
    p, q, r = b - a, c - b, d - c
    if (p <= 0 and q <= 0 and r <= 0) or (p >= 0 and q >= 0 and r >= 0):
        if (a < 0) != (d < 0):
            found[count] = single(a, b, c, d, 0.0, 1.0)
            count += 1
        return count
    places = (0.0, 1.0, 1.0, 1.0)
    square, half = p - 2 * q + r, q - p
    inner = half * half - square * p
    if inner > 0:
        root = math.sqrt(inner)
        top = -(half + math.copysign(root, half))
        one = top / square if square != 0 else 2.0
        two = p / top if top != 0 else 2.0
        one, two = min(one, two), max(one, two)
        one = min(max(one, 0.0), 1.0)
        two = min(max(two, 0.0), 1.0)
        places = (0.0, one, two, 1.0)
    for i in range(3):
        low, high = places[i], places[i + 1]
        if high > low and (cubic(a, b, c, d, low) < 0) != (cubic(a, b, c, d, high) < 0):
            found[count] = single(a, b, c, d, low, high)
            count += 1
    return count


@njit(cache=True, nogil=True)
def ascending(values, count):
    """Sort the first values in place."""
    for i in range(1, count):
        this = values[i]
        k = i - 1
        while k >= 0 and values[k] > this:
            values[k + 1] = values[k]
            k -= 1
        values[k + 1] = this
