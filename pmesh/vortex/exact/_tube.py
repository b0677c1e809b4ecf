"""Compiled sums over closed filaments with Gaussian cores."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

_SQRT_PI = math.sqrt(math.pi)
_FAR = 40.0  # exp(-40) = 4e-18 of the peak is left out
_NEAR = 0.05  # below it the two laws of distance are taken from their series


@njit(cache=True, nogil=True)
def _longest_stride(nodes):
    """Largest distance from a node to the next."""
    square = 0.0
    for m in range(nodes.shape[0] - 1):
        dx = nodes[m + 1, 0] - nodes[m, 0]
        dy = nodes[m + 1, 1] - nodes[m, 1]
        dz = nodes[m + 1, 2] - nodes[m, 2]
        square = max(square, dx * dx + dy * dy + dz * dz)
    return math.sqrt(square)


@njit(cache=True, nogil=True)
def add_core(points, nodes, elements, strength, core, out):
    """Add strength * sum of elements * Gaussian(point - node); points and out (n, 3)."""
    scale = strength / (_SQRT_PI * core) ** 3
    inverse = 1.0 / core**2
    reach = math.sqrt(_FAR) * core
    stride = _longest_stride(nodes)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        a = b = c = 0.0
        m = 0
        while m < nodes.shape[0]:
            dx, dy, dz = x - nodes[m, 0], y - nodes[m, 1], z - nodes[m, 2]
            square = dx * dx + dy * dy + dz * dz
            if square < reach * reach:
                weight = math.exp(-square * inverse)
                a += weight * elements[m, 0]
                b += weight * elements[m, 1]
                c += weight * elements[m, 2]
                m += 1
            else:  # no node comes within reach before the line has run that far
                m += max(1, int((math.sqrt(square) - reach) / stride))
        out[p, 0] += scale * a
        out[p, 1] += scale * b
        out[p, 2] += scale * c


@njit(cache=True, nogil=True)
def _turning(ratio):
    """[erf(q) - 2 q exp(-q^2)/sqrt(pi)]/q^3, q = distance over core."""
    square = ratio * ratio
    if ratio < _NEAR:
        return (4.0 / 3.0 - square * (4.0 / 5.0 - square * 2.0 / 7.0)) / _SQRT_PI
    inner = math.erf(ratio) - 2.0 * ratio * math.exp(-square) / _SQRT_PI
    return inner / (square * ratio)


@njit(cache=True, nogil=True)
def _potential(ratio):
    """erf(q)/q, q = distance over core."""
    square = ratio * ratio
    if ratio < _NEAR:
        return (2.0 - square * (2.0 / 3.0 - square * (1.0 / 5.0 - square / 21.0))) / _SQRT_PI
    return math.erf(ratio) / ratio


@njit(cache=True, nogil=True)
def add_velocity(points, nodes, elements, strength, core, out):
    """Add the Biot-Savart velocity of the smoothed filament; points and out (n, 3)."""
    scale = strength / (4.0 * math.pi * core**3)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        a = b = c = 0.0
        for m in range(nodes.shape[0]):
            dx, dy, dz = x - nodes[m, 0], y - nodes[m, 1], z - nodes[m, 2]
            weight = _turning(math.sqrt(dx * dx + dy * dy + dz * dz) / core)
            a += weight * (elements[m, 1] * dz - elements[m, 2] * dy)
            b += weight * (elements[m, 2] * dx - elements[m, 0] * dz)
            c += weight * (elements[m, 0] * dy - elements[m, 1] * dx)
        out[p, 0] += scale * a
        out[p, 1] += scale * b
        out[p, 2] += scale * c


@njit(cache=True, nogil=True)
def pair_sums(nodes, elements, others, other_elements, core):
    """Double sums over two filaments: (twice the energy, helicity, enstrophy) per strengths.

    ``core``: of the pair, the root of the sum of the squared cores.
    """
    sums = np.zeros(3)
    for m in range(nodes.shape[0]):
        for n in range(others.shape[0]):
            dx = nodes[m, 0] - others[n, 0]
            dy = nodes[m, 1] - others[n, 1]
            dz = nodes[m, 2] - others[n, 2]
            ax, ay, az = elements[m, 0], elements[m, 1], elements[m, 2]
            bx, by, bz = other_elements[n, 0], other_elements[n, 1], other_elements[n, 2]
            ratio = math.sqrt(dx * dx + dy * dy + dz * dz) / core
            aligned = ax * bx + ay * by + az * bz
            volume = dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)
            sums[0] += aligned * _potential(ratio)
            sums[1] += volume * _turning(ratio)
            sums[2] += aligned * math.exp(-ratio * ratio)
    sums[0] /= 4.0 * math.pi * core
    sums[1] /= 4.0 * math.pi * core**3
    sums[2] /= (_SQRT_PI * core) ** 3
    return sums
