"""Compiled loops over particles for velocity laws: affine fields, vortices of the unit box."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 256  # particles whose sines are kept at a time: they fit the first cache


@njit(cache=True, nogil=True, fastmath={"contract"})
def affine(first, pieces, step, size, positions, matrix, center, drift, result):
    """result = matrix (positions - center) + drift."""
    n, ndim = positions.shape
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    g, h, i = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    for piece in range(first, pieces, step):
        low, high = piece * size, min((piece + 1) * size, n)
        if ndim == 2:
            for p in range(low, high):
                x, y = positions[p, 0] - center[0], positions[p, 1] - center[1]
                result[p, 0] = a * x + b * y + drift[0]
                result[p, 1] = d * x + e * y + drift[1]
        else:
            for p in range(low, high):
                x, y = positions[p, 0] - center[0], positions[p, 1] - center[1]
                z = positions[p, 2] - center[2]
                result[p, 0] = a * x + b * y + c * z + drift[0]
                result[p, 1] = d * x + e * y + f * z + drift[1]
                result[p, 2] = g * x + h * y + i * z + drift[2]


@njit(cache=True, nogil=True, fastmath={"contract"})
def sines(places, half, sine, cosine, squares, doubles):
    """sin^2(pi x) and sin(2 pi x) = 2 sin(pi x) cos(pi x) of each coordinate x.

    Both have period 1, so that x may be replaced by its distance from the nearest whole number:
    two polynomials do, without a branch, and the loop runs on vectors.
    """
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, s10 = sine
    c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10 = cosine
    for k in range(places.size):
        x = places[k] - np.floor(places[k] + half)
        q = x * x
        s = s8 + q * (s9 + q * s10)
        s = s6 + q * (s7 + q * s)
        s = s4 + q * (s5 + q * s)
        s = s2 + q * (s3 + q * s)
        s = x * (s0 + q * (s1 + q * s))
        c = c8 + q * (c9 + q * c10)
        c = c6 + q * (c7 + q * c)
        c = c4 + q * (c5 + q * c)
        c = c2 + q * (c3 + q * c)
        c = c0 + q * (c1 + q * c)
        squares[k] = s * s
        doubles[k] = (s + s) * c


@njit(cache=True, nogil=True, fastmath={"contract"})
def vortices(first, pieces, step, size, positions, half, sine, cosine, swing, result):
    """The single vortex (2-D) or the deformation field (3-D), times ``swing``."""
    n, ndim = positions.shape
    flat = positions.reshape(-1)
    squares = np.empty(BLOCK * ndim, positions.dtype)
    doubles = np.empty(BLOCK * ndim, positions.dtype)
    for piece in range(first, pieces, step):
        stop = min((piece + 1) * size, n)
        for low in range(piece * size, stop, BLOCK):
            high = min(low + BLOCK, stop)
            sines(flat[low * ndim : high * ndim], half, sine, cosine, squares, doubles)
            if ndim == 2:
                for p in range(high - low):
                    result[low + p, 0] = swing * (squares[2 * p] * doubles[2 * p + 1])
                    result[low + p, 1] = -swing * (squares[2 * p + 1] * doubles[2 * p])
            else:
                for p in range(high - low):
                    x, y, z = 3 * p, 3 * p + 1, 3 * p + 2
                    u = squares[x] * (doubles[y] * doubles[z])
                    result[low + p, 0] = swing * (u + u)
                    result[low + p, 1] = -swing * (doubles[x] * (squares[y] * doubles[z]))
                    result[low + p, 2] = -swing * (doubles[x] * (doubles[y] * squares[z]))
