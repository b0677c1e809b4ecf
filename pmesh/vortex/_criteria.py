"""Compiled loops over nodes for what the velocity gradient says of vortices."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

TAPS = 4  # nodes that a difference reads
TINY = 1e-280


@njit(cache=True, nogil=True, inline="always")
def middle_eigenvalue(a, b, c, d, e, f):
    """Middle eigenvalue of [[a, d, e], [d, b, f], [e, f, c]].

    Of its three eigenvalues the one that stands apart comes from the trigonometric formula, which
    is sure of it; the other two from the plane across its eigenvector: equal ones lose no digits.
    """
    mean = (a + b + c) / 3.0
    a -= mean
    b -= mean
    c -= mean
    square = (a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0
    if not square > TINY:
        return mean + square
    size = math.sqrt(square)
    a /= size
    b /= size
    c /= size
    d /= size
    e /= size
    f /= size
    half = 0.5 * (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e))
    half = min(max(half, -1.0), 1.0)
    apart = 2.0 * math.cos(math.acos(abs(half)) / 3.0)  # from sqrt(3) to 2
    apart = apart if half >= 0.0 else -apart
    # its eigenvector: the longest cross product of two rows of the matrix less the eigenvalue
    p, q, r = a - apart, b - apart, c - apart
    x0, y0, z0 = d * f - e * q, e * d - p * f, p * q - d * d
    x1, y1, z1 = d * r - e * f, e * e - p * r, p * f - d * e
    x2, y2, z2 = q * r - f * f, f * e - d * r, d * f - q * e
    n0 = x0 * x0 + y0 * y0 + z0 * z0
    n1 = x1 * x1 + y1 * y1 + z1 * z1
    n2 = x2 * x2 + y2 * y2 + z2 * z2
    x, y, z, n = x0, y0, z0, n0
    if n1 > n:
        x, y, z, n = x1, y1, z1, n1
    if n2 > n:
        x, y, z, n = x2, y2, z2, n2
    n = 1.0 / math.sqrt(n)
    x *= n
    y *= n
    z *= n
    # two unit vectors across it (Duff et al., J. Comput. Graph. Tech. 6 (2017) 1)
    sign = math.copysign(1.0, z)
    s = -1.0 / (sign + z)
    t = x * y * s
    ux, uy, uz = 1.0 + sign * x * x * s, sign * t, -sign * x
    vx, vy, vz = t, sign + y * y * s, -y
    along = a * ux * ux + b * uy * uy + c * uz * uz
    along += 2.0 * (d * ux * uy + e * ux * uz + f * uy * uz)
    across = a * vx * vx + b * vy * vy + c * vz * vz
    across += 2.0 * (d * vx * vy + e * vx * vz + f * vy * vz)
    mixed = a * ux * vx + b * uy * vy + c * uz * vz
    mixed += d * (ux * vy + uy * vx) + e * (ux * vz + uz * vx) + f * (uy * vz + uz * vy)
    spread = math.sqrt(0.25 * (along - across) ** 2 + mixed * mixed)
    pair = 0.5 * (along + across)
    return mean + size * (pair + spread if half >= 0.0 else pair - spread)


@njit(cache=True, nogil=True)
def _slopes(velocity, i, m, tables, slopes):
    """Differences of all components along all axes, of one row of nodes: [component, axis, k]."""
    (at_x, by_x), (at_y, by_y), (at_z, by_z) = tables
    parts, nm, nc = velocity.shape[0], velocity.shape[2], velocity.shape[3]
    last = parts - 1
    for p in range(parts):
        for k in range(nc):
            total = 0.0
            for tap in range(TAPS):
                total += by_z[k, tap] * velocity[p, i, m, at_z[k, tap]]
            slopes[p, last, k] = total
        target = slopes[p, 0]
        target[:] = 0.0
        for tap in range(TAPS):
            weight, row = by_x[i, tap], velocity[p, at_x[i, tap], m]
            for k in range(nc):
                target[k] += weight * row[k]
        if nm > 1:
            target = slopes[p, 1]
            target[:] = 0.0
            for tap in range(TAPS):
                weight, row = by_y[m, tap], velocity[p, i, at_y[m, tap]]
                for k in range(nc):
                    target[k] += weight * row[k]


@njit(cache=True, nogil=True)
def swirl(first, pieces, step, rows, velocity, tables, middle, result):
    """Q of every node, or lambda-2 if ``middle``; result (nx, nm, nc)."""
    parts, nx, nm, nc = velocity.shape
    slopes = np.empty((parts, parts, nc))
    for piece in range(first, pieces, step):
        for line in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            i = line // nm
            m = line % nm
            _slopes(velocity, i, m, tables, slopes)
            row = result[i, m]
            if parts == 2:
                for k in range(nc):
                    own = slopes[0, 0, k] ** 2 + slopes[1, 1, k] ** 2
                    row[k] = -0.5 * own - slopes[0, 1, k] * slopes[1, 0, k]
                continue
            for k in range(nc):
                xx, xy, xz = slopes[0, 0, k], slopes[0, 1, k], slopes[0, 2, k]
                yx, yy, yz = slopes[1, 0, k], slopes[1, 1, k], slopes[1, 2, k]
                zx, zy, zz = slopes[2, 0, k], slopes[2, 1, k], slopes[2, 2, k]
                a = xx * xx + xy * yx + xz * zx
                b = yx * xy + yy * yy + yz * zy
                c = zx * xz + zy * yz + zz * zz
                if not middle:
                    row[k] = -0.5 * (a + b + c)
                    continue
                d = 0.5 * (xx * xy + xy * yy + xz * zy + yx * xx + yy * yx + yz * zx)
                e = 0.5 * (xx * xz + xy * yz + xz * zz + zx * xx + zy * yx + zz * zx)
                f = 0.5 * (yx * xz + yy * yz + yz * zz + zx * xy + zy * yy + zz * zy)
                row[k] = middle_eigenvalue(a, b, c, d, e, f)
