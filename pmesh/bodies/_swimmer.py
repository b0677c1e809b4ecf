"""Compiled loops over points near a line of segments: signed distance, and velocity of matter.

Segments come in runs of RUN; circles that hold the runs tell which can be skipped.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

RUN = 16
FOLD = 0.8  # offsets are not followed beyond this, times the radius of curvature


@njit(cache=True, nogil=True)
def runs(line):
    """Circles (n, 3) around the runs of an open line (m, 2): x, y, radius."""
    last = line.shape[0] - 1
    count = (last + RUN - 1) // RUN
    circles = np.zeros((count, 3))
    for c in range(count):
        first, end = c * RUN, min((c + 1) * RUN, last)
        low_x = high_x = line[first, 0]
        low_y = high_y = line[first, 1]
        for k in range(first, end + 1):
            low_x, high_x = min(low_x, line[k, 0]), max(high_x, line[k, 0])
            low_y, high_y = min(low_y, line[k, 1]), max(high_y, line[k, 1])
        x, y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
        radius = 0.0
        for k in range(first, end + 1):
            radius = max(radius, math.hypot(line[k, 0] - x, line[k, 1] - y))
        circles[c, 0], circles[c, 1], circles[c, 2] = x, y, radius
    return circles


@njit(cache=True, nogil=True)
def _scan(x, y, line, first, end, best, segment, share):
    """The nearest segment among some: squared distance, index, share of its length."""
    for k in range(first, end):
        ax, ay = line[k, 0], line[k, 1]
        dx, dy = line[k + 1, 0] - ax, line[k + 1, 1] - ay
        px, py = x - ax, y - ay
        along = (px * dx + py * dy) / (dx * dx + dy * dy)
        along = min(max(along, 0.0), 1.0)
        ex, ey = px - along * dx, py - along * dy
        square = ex * ex + ey * ey
        if square < best:
            best, segment, share = square, k, along
    return best, segment, share


@njit(cache=True, nogil=True)
def _nearest(x, y, line, circles, guess):
    """The nearest segment of a line; ``guess`` is a run that may hold it."""
    last = line.shape[0] - 1
    best, segment, share = _scan(
        x, y, line, guess * RUN, min((guess + 1) * RUN, last), np.inf, 0, 0.0
    )
    far = math.sqrt(best)
    for c in range(circles.shape[0]):
        dx, dy = x - circles[c, 0], y - circles[c, 1]
        reach = far + circles[c, 2]
        if c != guess and dx * dx + dy * dy < reach * reach:
            best, segment, share = _scan(
                x, y, line, c * RUN, min((c + 1) * RUN, last), best, segment, share
            )
            far = math.sqrt(best)
    return far, segment, share


@njit(cache=True, nogil=True)
def ring_distance(points, ring, circles, result):
    """Signed distance to a closed line (its last point is its first), negative on its left.

    At a corner the sign is that of the mean of its two normals: right for any corner.
    """
    last = ring.shape[0] - 1
    guess = 0
    for p in range(points.shape[1]):
        x, y = np.float64(points[0, p]), np.float64(points[1, p])
        far, k, share = _nearest(x, y, ring, circles, guess)
        guess = k // RUN
        dx, dy = ring[k + 1, 0] - ring[k, 0], ring[k + 1, 1] - ring[k, 1]
        at_x, at_y = ring[k, 0] + share * dx, ring[k, 1] + share * dy
        if share <= 0.0 or share >= 1.0:
            j = (k - 1 + last) % last if share <= 0.0 else (k + 1) % last
            ex, ey = ring[j + 1, 0] - ring[j, 0], ring[j + 1, 1] - ring[j, 1]
            here, there = math.hypot(dx, dy), math.hypot(ex, ey)
            dx, dy = dx / here + ex / there, dy / here + ey / there
        outside = (x - at_x) * dy - (y - at_y) * dx
        result[p] = far if outside > 0.0 else -far


@njit(cache=True, nogil=True)
def _hermite(a, b, slope_a, slope_b, step, u):
    """The cubic with these ends and slopes at a share u of the step."""
    v = 1.0 - u
    return v * v * ((1.0 + 2.0 * u) * a + u * step * slope_a) + u * u * (
        (1.0 + 2.0 * v) * b - v * step * slope_b
    )


@njit(cache=True, nogil=True)
def _foot(x, y, places, line, angle, curvature, k, u):
    """Share u of piece k of the midline at which its normal goes through a point."""
    step = places[k + 1] - places[k]
    for _ in range(8):
        turn = _hermite(angle[k], angle[k + 1], curvature[k], curvature[k + 1], step, u)
        c, s = math.cos(turn), math.sin(turn)
        dx = x - _hermite(
            line[k, 0], line[k + 1, 0], math.cos(angle[k]), math.cos(angle[k + 1]), step, u
        )
        dy = y - _hermite(
            line[k, 1], line[k + 1, 1], math.sin(angle[k]), math.sin(angle[k + 1]), step, u
        )
        bend = curvature[k] + u * (curvature[k + 1] - curvature[k])
        change = (dx * c + dy * s) / (step * max(1.0 - bend * (c * dy - s * dx), 0.2))
        u = min(max(u + change, 0.0), 1.0)
        if abs(change) < 1e-9:
            break
    return u


@njit(cache=True, nogil=True)
def matter(
    points, places, line, circles, angle, velocity, spin, curvature, rate, below, above,
    margin, soft, result,
):  # fmt: skip
    """Velocity of the matter at points: result[0], result[1]; its divergence: result[2].

    ``soft``: sections keep their area, else their length. Offsets are followed up to ``margin``
    beyond the outline.
    """
    guess = 0
    for p in range(points.shape[1]):
        x, y = np.float64(points[0, p]), np.float64(points[1, p])
        _, k, u = _nearest(x, y, line, circles, guess)
        guess = k // RUN
        u = _foot(x, y, places, line, angle, curvature, k, u)
        if u == 0.0 and k > 0:  # the foot may lie on the piece beside
            k, u = k - 1, _foot(x, y, places, line, angle, curvature, k - 1, 1.0)
        elif u == 1.0 and k < line.shape[0] - 2:
            k, u = k + 1, _foot(x, y, places, line, angle, curvature, k + 1, 0.0)
        step, v = places[k + 1] - places[k], 1.0 - u
        turn = _hermite(angle[k], angle[k + 1], curvature[k], curvature[k + 1], step, u)
        spun = _hermite(spin[k], spin[k + 1], rate[k], rate[k + 1], step, u)
        c, s = math.cos(turn), math.sin(turn)
        ca, sa = math.cos(angle[k]), math.sin(angle[k])
        cb, sb = math.cos(angle[k + 1]), math.sin(angle[k + 1])
        dx = x - _hermite(line[k, 0], line[k + 1, 0], ca, cb, step, u)
        dy = y - _hermite(line[k, 1], line[k + 1, 1], sa, sb, step, u)
        bend = v * curvature[k] + u * curvature[k + 1]
        bending = v * rate[k] + u * rate[k + 1]
        low, high = v * below[k] + u * below[k + 1], v * above[k] + u * above[k + 1]
        low, high = low - margin, high + margin
        if bend > 0.0:
            high = min(high, FOLD / bend)
        elif bend < 0.0:
            low = max(low, FOLD / bend)
        offset = min(max(c * dy - s * dx, low), high)
        ahead = min(max(c * dx + s * dy, -margin), margin)  # not zero only beyond the ends
        swell = 0.5 * bending * offset * offset / (1.0 - bend * offset) if soft else 0.0
        left = ahead * spun + swell
        result[0, p] = (
            _hermite(velocity[k, 0], velocity[k + 1, 0], -sa * spin[k], -sb * spin[k + 1], step, u)
            - offset * spun * c
            - left * s
        )
        result[1, p] = (
            _hermite(velocity[k, 1], velocity[k + 1, 1], ca * spin[k], cb * spin[k + 1], step, u)
            - offset * spun * s
            + left * c
        )
        result[2, p] = 0.0 if soft else -bending * offset / (1.0 - bend * offset)
