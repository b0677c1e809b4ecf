"""Compiled loops over points: signed distance to an ellipse or ellipsoid, and to a smooth star."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

STEPS = 60  # of Newton, at most
STACK = 256  # intervals that wait to be searched, at most
NARROW = 1e-6  # of a star's sector: what is left of the search below it is beneath rounding


@njit(cache=True, nogil=True, error_model="numpy")
def ellipsoid(points, axes, out):
    """Signed distance to the ellipse or ellipsoid of half ``axes`` around 0, ``points`` (ndim, n).

    With the least half axis e and s > 0 the root of sum (e_k p_k/(s + e_k^2 - e^2))^2 = 1, the
    nearest point is e_k^2 p_k/(s + e_k^2 - e^2) and lies (s - e^2) |p_k/(s + e_k^2 - e^2)| away.
    The sum is convex and falls: Newton from a lower bound of the root climbs to it without fail.
    """
    ndim = len(axes)
    least = 0
    for k in range(ndim):
        if axes[k] < axes[least]:
            least = k
    e = axes[least]
    p, gap = np.empty(ndim), np.empty(ndim)
    for k in range(ndim):
        gap[k] = (axes[k] - e) * (axes[k] + e)
    for i in range(points.shape[1]):
        s, far = 0.0, 0.0
        for k in range(ndim):
            p[k] = abs(points[k, i])
            far += p[k]
            if k == least:  # off the middle plane: the nearest point stays unique
                p[k] = max(p[k], 1e-30 * e)
            s = max(s, axes[k] * p[k] - gap[k])
        if not far < np.inf:
            out[i] = far
            continue
        for _ in range(STEPS):
            value, slope = -1.0, 0.0
            for k in range(ndim):
                q = axes[k] * p[k] / (s + gap[k])
                value += q * q
                slope += q * q / (s + gap[k])
            more = 0.5 * value / slope
            s += max(more, 0.0)
            if more <= 1e-15 * s:
                break
        square = 0.0
        for k in range(ndim):
            q = p[k] / (s + gap[k])
            square += q * q
        out[i] = (s - e * e) * math.sqrt(square)


@njit(cache=True, nogil=True, error_model="numpy")
def star(x, y, radius, amplitude, arms, out):
    """Signed distance to r = radius (1 + amplitude cos(arms angle)).

    The curve is its own mirror image in every edge of a sector pi/arms wide, so the nearest point
    lies in the sector of the point. There the half squared distance is minimised by intervals:
    dropped where a bound of second order says so, solved by Newton where its slope is monotone
    (the third derivative bounded), halved otherwise.
    """
    sector = math.pi / arms
    low, high = np.empty(STACK), np.empty(STACK)
    law = np.array([radius, radius * amplitude, float(arms)])
    sizes = np.array([radius * (1.0 + amplitude), law[1] * arms, law[1] * arms**2])
    third = law[1] * float(arms) ** 3
    for i in range(x.size):
        away = math.hypot(x[i], y[i])
        if not away < np.inf:
            out[i] = away
            continue
        turn = abs(math.atan2(y[i], x[i])) % (2.0 * sector)
        if turn > sector:
            turn = 2.0 * sector - turn
        # largest third derivative of the half squared distance
        bend = 3.0 * sizes[1] * sizes[2] + sizes[0] * third
        bend += away * (third + 3.0 * sizes[2] + 3.0 * sizes[1] + sizes[0])
        best = min(_at(0.0, away, turn, law)[0], _at(sector, away, turn, law)[0])
        best = min(best, _at(turn, away, turn, law)[0])
        count = 1
        low[0], high[0] = 0.0, sector
        while count > 0:
            count -= 1
            a, b = low[count], high[count]
            middle, half = 0.5 * (a + b), 0.5 * (b - a)
            value, slope, curve = _at(middle, away, turn, law)
            best = min(best, value)
            slack = min(curve - bend * half, 0.0) * half * half
            if value - abs(slope) * half + 0.5 * slack >= best:
                continue
            if curve > bend * half:
                best = min(best, _lowest(a, b, away, turn, law))
            elif -curve >= bend * half or half < NARROW * sector or count + 2 > STACK:
                best = min(best, _at(a, away, turn, law)[0], _at(b, away, turn, law)[0])
            else:
                low[count], high[count] = a, middle
                low[count + 1], high[count + 1] = middle, b
                count += 2
        edge = radius * (1.0 + amplitude * math.cos(arms * turn))
        out[i] = math.copysign(math.sqrt(2.0 * best), away - edge)


@njit(cache=True, nogil=True, error_model="numpy")
def _at(angle, away, turn, law):
    """Half the squared distance from (away, turn) to the star at an angle, and two derivatives."""
    phase = law[2] * angle
    r = law[0] + law[1] * math.cos(phase)
    dr = -law[1] * law[2] * math.sin(phase)
    ddr = -law[1] * law[2] ** 2 * math.cos(phase)
    cos, sin = math.cos(angle - turn), math.sin(angle - turn)
    chord = math.sin(0.5 * (angle - turn))
    value = 0.5 * (r - away) ** 2 + 2.0 * r * away * chord * chord
    slope = dr * (r - away * cos) + away * r * sin
    curve = dr * dr + ddr * (r - away * cos) + away * (2.0 * dr * sin + r * cos)
    return value, slope, curve


@njit(cache=True, nogil=True, error_model="numpy")
def _lowest(a, b, away, turn, law):
    """Least half squared distance between two angles, where its slope rises."""
    if _at(a, away, turn, law)[1] >= 0.0:
        return _at(a, away, turn, law)[0]
    if _at(b, away, turn, law)[1] <= 0.0:
        return _at(b, away, turn, law)[0]
    angle = 0.5 * (a + b)
    for _ in range(STEPS):
        _, slope, curve = _at(angle, away, turn, law)
        if slope > 0.0:
            b = angle
        else:
            a = angle
        old, angle = angle, angle - slope / curve if curve > 0.0 else a
        if not a <= angle <= b:
            angle = 0.5 * (a + b)
        if abs(angle - old) < 1e-15:
            break
    return _at(angle, away, turn, law)[0]
