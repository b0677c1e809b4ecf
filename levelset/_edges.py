"""Compiled loops over points: signed distance to a polygon and to a four-digit aerofoil."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

STEPS = 60  # of the search for a foot point, at most


@njit(cache=True, nogil=True)
def polygon(x, y, corners, out):
    """Signed distance to the closed line through ``corners`` (n, 2)."""
    count = len(corners)
    for i in range(x.size):
        px, py = np.float64(x[i]), np.float64(y[i])
        far = abs(px) + abs(py)
        if not far < np.inf:
            out[i] = far
            continue
        nearest = np.inf
        inside = False
        ax, ay = corners[count - 1, 0], corners[count - 1, 1]
        for k in range(count):
            bx, by = corners[k, 0], corners[k, 1]
            ex, ey, qx, qy = bx - ax, by - ay, px - ax, py - ay
            along = min(max((qx * ex + qy * ey) / (ex * ex + ey * ey), 0.0), 1.0)
            dx, dy = qx - along * ex, qy - along * ey
            nearest = min(nearest, dx * dx + dy * dy)
            if (ay <= py) != (by <= py) and (ex * qy > ey * qx) == (by > ay):
                inside = not inside
            ax, ay = bx, by
        away = math.sqrt(nearest)
        out[i] = -away if inside else away


@njit(cache=True, nogil=True)
def aerofoil(x, y, law, vertices, out):
    """Signed distance to an aerofoil of unit chord, its nose at 0; ``law`` as in ``on_edge``.

    ``vertices`` (2, n, 2): of the upper and the lower side, at even steps of the root of x.
    """
    for i in range(x.size):
        px, py = np.float64(x[i]), np.float64(y[i])
        far = abs(px) + abs(py)
        if not far < np.inf:
            out[i] = far
            continue
        away, outside = _base(px, py, vertices)
        for side in range(2):
            s = _foot(px, py, law, side, vertices[side])
            ex, ey, tx, ty = on_edge(s, law, side)
            gap = math.hypot(px - ex, py - ey)
            if gap < away:
                away = gap
                left = tx * (py - ey) - ty * (px - ex) > 0.0
                outside = s >= 1.0 or left == (side == 0)
        out[i] = away if outside else -away


@njit(cache=True, nogil=True)
def on_edge(s, law, side):
    """Place and tangent of the edge at s = sqrt(x): upper side 0, lower side 1.

    ``law``: five thickness coefficients (of s, x, x^2, x^3, x^4), camber and its place.
    """
    sign = 1.0 - 2.0 * side
    camber, place = law[5], law[6]
    x, dx = s * s, 2.0 * s
    y = law[0] * s + x * (law[1] + x * (law[2] + x * (law[3] + x * law[4])))
    dy = law[0] + dx * (law[1] + x * (2.0 * law[2] + x * (3.0 * law[3] + x * 4.0 * law[4])))
    line, slope, bend = 0.0, 0.0, 0.0
    if camber > 0.0:
        span = place if x < place else 1.0 - place
        ratio = camber / (span * span)
        line = camber - ratio * (x - place) ** 2
        slope = -2.0 * ratio * (x - place)
        bend = -2.0 * ratio
    w = math.sqrt(1.0 + slope * slope)
    turn = y * bend / (w * w * w) * dx
    tx = dx - sign * (dy * slope / w + turn)
    ty = slope * dx + sign * (dy / w - slope * turn)
    return x - sign * y * slope / w, line + sign * y / w, tx, ty


@njit(cache=True, nogil=True)
def _foot(px, py, law, side, vertices):
    """Where one side is nearest: bracketed by its vertices, then regula falsi (Illinois)."""
    best, nearest = 0, np.inf
    last = len(vertices) - 1
    for k in range(last + 1):
        dx, dy = px - vertices[k, 0], py - vertices[k, 1]
        if dx * dx + dy * dy < nearest:
            best, nearest = k, dx * dx + dy * dy
    low, high = max(best - 1, 0) / last, min(best + 1, last) / last
    before, after = _climb(low, px, py, law, side), _climb(high, px, py, law, side)
    if before >= 0.0:
        return low
    if after <= 0.0:
        return high
    s = low
    for _ in range(STEPS):
        s, old = (low * after - high * before) / (after - before), s
        here = _climb(s, px, py, law, side)
        if here == 0.0 or abs(s - old) < 1e-12:
            break
        if here > 0.0:
            high, after = s, here
            before = 0.5 * before if s < old else before
        else:
            low, before = s, here
            after = 0.5 * after if s > old else after
    return s


@njit(cache=True, nogil=True)
def _climb(s, px, py, law, side):
    """Half the derivative of the squared distance along the edge."""
    ex, ey, tx, ty = on_edge(s, law, side)
    return (ex - px) * tx + (ey - py) * ty


@njit(cache=True, nogil=True)
def _base(px, py, vertices):
    """Distance to the blunt base between both sides' ends, and whether it is seen from outside."""
    ax, ay = vertices[1, -1, 0], vertices[1, -1, 1]
    ex, ey = vertices[0, -1, 0] - ax, vertices[0, -1, 1] - ay
    length = ex * ex + ey * ey
    qx, qy = px - ax, py - ay
    if length < 1e-24:
        return np.inf, True
    along = (qx * ex + qy * ey) / length
    if along <= 0.0 or along >= 1.0:
        return np.inf, True
    cross = ex * qy - ey * qx
    return abs(cross) / math.sqrt(length), cross <= 0.0
