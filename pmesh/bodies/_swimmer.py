"""Compiled loops over points near a line of segments: signed distance, and velocity of matter.

Segments come in runs and runs in groups; circles that hold them tell which can be skipped.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

RUN = 8  # segments to a run, and runs to a group
SAME = 1e-9  # of the body's length: points so close have one foot, as those of a column in space
FOLD = 0.8  # offsets are not followed beyond this, times the radius of curvature


@njit(cache=True, nogil=True)
def circles(line, size):
    """Circles (n, 3) that hold ``size`` segments each of an open line (m, 2): x, y, radius."""
    last = line.shape[0] - 1
    result = np.zeros(((last + size - 1) // size, 3))
    for c in range(result.shape[0]):
        first, end = c * size, min((c + 1) * size, last)
        low_x = high_x = line[first, 0]
        low_y = high_y = line[first, 1]
        for k in range(first, end + 1):
            low_x, high_x = min(low_x, line[k, 0]), max(high_x, line[k, 0])
            low_y, high_y = min(low_y, line[k, 1]), max(high_y, line[k, 1])
        x, y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
        radius = 0.0
        for k in range(first, end + 1):
            radius = max(radius, math.hypot(line[k, 0] - x, line[k, 1] - y))
        result[c, 0], result[c, 1], result[c, 2] = x, y, radius
    return result


@njit(cache=True, nogil=True)
def segments(line):
    """Segments (n, 5) of an open line (n + 1, 2): start, way, one over its square."""
    result = np.empty((line.shape[0] - 1, 5))
    for k in range(result.shape[0]):
        dx, dy = line[k + 1, 0] - line[k, 0], line[k + 1, 1] - line[k, 1]
        result[k, 0], result[k, 1], result[k, 2], result[k, 3] = line[k, 0], line[k, 1], dx, dy
        result[k, 4] = 1.0 / (dx * dx + dy * dy)
    return result


@njit(cache=True, nogil=True)
def _scan(x, y, pieces, run, best, segment, share):
    """The nearest segment, of a run too: squared distance, index, share of its length."""
    for k in range(run * RUN, min((run + 1) * RUN, pieces.shape[0])):
        px, py = x - pieces[k, 0], y - pieces[k, 1]
        along = (px * pieces[k, 2] + py * pieces[k, 3]) * pieces[k, 4]
        along = min(max(along, 0.0), 1.0)
        ex, ey = px - along * pieces[k, 2], py - along * pieces[k, 3]
        square = ex * ex + ey * ey
        if square < best:
            best, segment, share = square, k, along
    return best, segment, share


@njit(cache=True, nogil=True)
def _nearest(x, y, pieces, small, large, guess):
    """The nearest segment: distance, index, share; ``guess`` is a run that may hold it."""
    best, segment, share = _scan(x, y, pieces, guess, np.inf, 0, 0.0)
    far = math.sqrt(best)
    for g in range(large.shape[0]):
        dx, dy, reach = x - large[g, 0], y - large[g, 1], far + large[g, 2]
        if dx * dx + dy * dy >= reach * reach:
            continue
        for c in range(g * RUN, min((g + 1) * RUN, small.shape[0])):
            dx, dy, reach = x - small[c, 0], y - small[c, 1], far + small[c, 2]
            if c != guess and dx * dx + dy * dy < reach * reach:
                best, segment, share = _scan(x, y, pieces, c, best, segment, share)
                far = math.sqrt(best)
    return far, segment, share


@njit(cache=True, nogil=True)
def ring_distance(points, ring, result):
    """Signed distance to a closed line (its last point is its first), negative on its left.

    At a corner the sign is that of the mean of its two normals: right for any corner.
    """
    last = ring.shape[0] - 1
    pieces, small, large = segments(ring), circles(ring, RUN), circles(ring, RUN * RUN)
    guess = 0
    for p in range(points.shape[1]):
        x, y = np.float64(points[0, p]), np.float64(points[1, p])
        far, k, share = _nearest(x, y, pieces, small, large, guess)
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
def _foot(x, y, places, line, ways, angle, curvature, k, u):
    """Share u of piece k of the midline at which its normal goes through a point."""
    step = places[k + 1] - places[k]
    for _ in range(8):
        turn = _hermite(angle[k], angle[k + 1], curvature[k], curvature[k + 1], step, u)
        c, s = math.cos(turn), math.sin(turn)
        dx = x - _hermite(line[k, 0], line[k + 1, 0], ways[k, 0], ways[k + 1, 0], step, u)
        dy = y - _hermite(line[k, 1], line[k + 1, 1], ways[k, 1], ways[k + 1, 1], step, u)
        bend = curvature[k] + u * (curvature[k + 1] - curvature[k])
        change = (dx * c + dy * s) / (step * max(1.0 - bend * (c * dy - s * dx), 0.2))
        u = min(max(u + change, 0.0), 1.0)
        if abs(change) < 1e-9:
            break
    return u


@njit(cache=True, nogil=True)
def attached(x, y, places, line, ways, angle, curvature, pieces, small, large, guess, reach):
    """The foot of a point on the midline: piece, share of it, its tangent, and the way from it.

    ``reach``: beyond it [L] the nearest segment's place will do.
    """
    far, k, u = _nearest(x, y, pieces, small, large, guess)
    if far < reach:
        u = _foot(x, y, places, line, ways, angle, curvature, k, u)
    if far < reach and u == 0.0 and k > 0:  # the foot may lie on the piece beside
        k, u = k - 1, _foot(x, y, places, line, ways, angle, curvature, k - 1, 1.0)
    elif far < reach and u == 1.0 and k < line.shape[0] - 2:
        k, u = k + 1, _foot(x, y, places, line, ways, angle, curvature, k + 1, 0.0)
    step = places[k + 1] - places[k]
    turn = _hermite(angle[k], angle[k + 1], curvature[k], curvature[k + 1], step, u)
    ca, sa, cb, sb = ways[k, 0], ways[k, 1], ways[k + 1, 0], ways[k + 1, 1]
    dx = x - _hermite(line[k, 0], line[k + 1, 0], ca, cb, step, u)
    dy = y - _hermite(line[k, 1], line[k + 1, 1], sa, sb, step, u)
    return k, u, math.cos(turn), math.sin(turn), dx, dy


@njit(cache=True, nogil=True)
def matter(
    points, places, line, angle, velocity, spin, curvature, rate, below, above,
    margin, soft, result,
):  # fmt: skip
    """Velocity of the matter at points: result[0], result[1]; its divergence: result[2].

    ``soft``: sections keep their area, else their length. Offsets are followed up to ``margin``
    beyond the outline.
    """
    pieces, small, large = segments(line), circles(line, RUN), circles(line, RUN * RUN)
    ways = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    reach = 2.0 * margin + max(above.max(), -below.min())
    guess, last_x, last_y, same = 0, np.inf, np.inf, SAME * places[-1]
    for p in range(points.shape[1]):
        x, y = np.float64(points[0, p]), np.float64(points[1, p])
        if abs(x - last_x) + abs(y - last_y) <= same:
            for i in range(3):
                result[i, p] = result[i, p - 1]
            continue
        last_x, last_y = x, y
        k, u, c, s, dx, dy = attached(
            x, y, places, line, ways, angle, curvature, pieces, small, large, guess, reach
        )
        guess = k // RUN
        ca, sa, cb, sb = ways[k, 0], ways[k, 1], ways[k + 1, 0], ways[k + 1, 1]
        step, v = places[k + 1] - places[k], 1.0 - u
        spun = _hermite(spin[k], spin[k + 1], rate[k], rate[k + 1], step, u)
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
