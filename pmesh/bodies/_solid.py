"""Compiled loops on bodies of elliptic sections: a table of the straight one, the bent one by it.

The body holds all its sections, the outside all that they leave over: each distance squared is the
least over the sections s' of (s - s')^2 plus the squared distance in the plane of the section.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from pmesh.bodies._swimmer import FOLD, RUN, SAME, attached, circles, segments

THIN = 1e-9  # [L] a section thinner than this is a line
TURNS = 60  # of Newton's iteration, at most


@njit(cache=True, nogil=True, error_model="numpy")
def ellipse(y, z, width, height):
    """Signed distance in the quadrant y, z >= 0 to an ellipse of these half axes.

    The foot is (w^2 y / (t + w^2), h^2 z / (t + h^2)); t is the largest root of a function that
    falls and is convex, so that Newton's steps from the left of it do not overshoot.
    """
    if width < THIN or height < THIN:
        return math.hypot(y - min(y, width), z - min(z, height))
    if width > height:
        y, z, width, height = z, y, height, width
    ww, hh = width * width, height * height
    if y < 1e-12 and z * height <= hh - ww:  # nearest to the flat side, from the middle plane
        share = z * height / max(hh - ww, 1e-300)
        return -width * math.sqrt(max(1.0 - share * share, 0.0) + (z - share * height) ** 2 / ww)
    t = max(width * y - ww, height * z - hh)
    for _ in range(TURNS):
        p, q = width * y / (t + ww), height * z / (t + hh)
        over = p * p + q * q - 1.0
        fall = 2.0 * (p * p / (t + ww) + q * q / (t + hh))
        if over <= 1e-14 or fall == 0.0:
            break
        t += over / fall
    away = math.hypot(y - ww * y / (t + ww), z - hh * z / (t + hh))
    return away if t > 0.0 else -away


@njit(cache=True, nogil=True, error_model="numpy")
def _envelope(places, squares, asked, sites, ends, result):
    """The least of (s - s')^2 + squares(s') at rising places ``asked``; between the s' a parabola.

    By the lower envelope of parabolas (P. Felzenszwalb and D. Huttenlocher, Theory of Computing 8
    (2012) 415). ``sites`` and ``ends`` are scratch.
    """
    count = 0
    for j in range(len(places)):
        start = -np.inf
        while count > 0:
            i = sites[count - 1]
            rise = squares[j] - squares[i] + places[j] ** 2 - places[i] ** 2
            start = 0.5 * rise / (places[j] - places[i])
            if start > ends[count - 1]:
                break
            count -= 1
            start = -np.inf
        sites[count], ends[count] = j, start
        count += 1
    k = 0
    for n in range(len(asked)):
        s = asked[n]
        while k + 1 < count and ends[k + 1] <= s:
            k += 1
        j = sites[k]
        here = (s - places[j]) ** 2 + squares[j]
        result[n] = here
        if 0 < j < len(places) - 1:
            back, ahead = places[j - 1] - places[j], places[j + 1] - places[j]
            low = ((s - places[j - 1]) ** 2 + squares[j - 1] - here) / back
            high = ((s - places[j + 1]) ** 2 + squares[j + 1] - here) / ahead
            bow = (high - low) / (ahead - back)
            slope = low - bow * back
            if bow > 0.0 and back < -0.5 * slope / bow < ahead:
                result[n] = max(here - 0.25 * slope * slope / bow, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def fill(places, widths, heights, along, across, up, table):
    """Signed distance of the straight body at the nodes ``along`` x ``across`` x ``up``."""
    n = len(places)
    outer, inner, sites, ends = np.empty(n), np.empty(n), np.empty(n, np.int64), np.empty(n)
    out, into = np.empty(len(along)), np.empty(len(along))
    for j in range(len(across)):
        for k in range(len(up)):
            for i in range(n):
                away = ellipse(across[j], up[k], widths[i], heights[i])
                outer[i], inner[i] = max(away, 0.0) ** 2, min(away, 0.0) ** 2
            _envelope(places, outer, along, sites, ends, out)
            _envelope(places, inner, along, sites, ends, into)
            for i in range(len(along)):
                inside = out[i] < into[i] and places[0] < along[i] < places[n - 1]
                table[i, j, k] = -math.sqrt(into[i]) if inside else math.sqrt(out[i])


@njit(cache=True, nogil=True, error_model="numpy")
def _look(table, s, y, z, step_s, step_y, step_z, first):
    """Distance of the straight body, linear between nodes, and its way out, of length one."""
    a, b, c = (s - first) / step_s, y / step_y, z / step_z
    i = min(max(int(a), 0), table.shape[0] - 2)
    j, k = min(int(b), table.shape[1] - 2), min(int(c), table.shape[2] - 2)
    a, b, c = a - i, b - j, c - k
    e00 = table[i, j, k] + c * (table[i, j, k + 1] - table[i, j, k])
    e01 = table[i, j + 1, k] + c * (table[i, j + 1, k + 1] - table[i, j + 1, k])
    e10 = table[i + 1, j, k] + c * (table[i + 1, j, k + 1] - table[i + 1, j, k])
    e11 = table[i + 1, j + 1, k] + c * (table[i + 1, j + 1, k + 1] - table[i + 1, j + 1, k])
    low, high = e00 + b * (e01 - e00), e10 + b * (e11 - e10)
    rise = (1.0 - a) * (
        (1.0 - b) * (table[i, j, k + 1] - table[i, j, k])
        + b * (table[i, j + 1, k + 1] - table[i, j + 1, k])
    ) + a * (
        (1.0 - b) * (table[i + 1, j, k + 1] - table[i + 1, j, k])
        + b * (table[i + 1, j + 1, k + 1] - table[i + 1, j + 1, k])
    )
    p = (high - low) / step_s
    q = ((1.0 - a) * (e01 - e00) + a * (e11 - e10)) / step_y
    r = rise / step_z
    size = math.sqrt(p * p + q * q + r * r)
    if size < 1e-3:
        return low + a * (high - low), 0.0, 1.0, 0.0
    return low + a * (high - low), p / size, q / size, r / size


@njit(cache=True, nogil=True, error_model="numpy")
def bent_distance(
    points, places, line, angle, curvature, table, step_s, step_y, step_z, first, reach, result
):
    """Signed distance at points (3, n) of the body's own axes.

    A point has a place s, an offset rho and a height in the bent body; (s, rho - kappa rho^2 / 2,
    z) is where it came from in the straight one. There the table tells the nearest point of the
    surface; that point is bent, along the osculating circle, and its distance taken. On the
    surface and beside a straight midline this is exact but for the table; elsewhere the error is
    of second order in the shift of the nearest point by the bending.
    """
    pieces, small, large = segments(line), circles(line, RUN), circles(line, RUN * RUN)
    ways = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    end_s = first + step_s * (table.shape[0] - 1)
    end_y, end_z = step_y * (table.shape[1] - 1), step_z * (table.shape[2] - 1)
    guess, last_x, last_y = 0, np.inf, np.inf
    place, offset, ahead, bend = 0.0, 0.0, 0.0, 0.0
    for p in range(points.shape[1]):
        x, y, z = points[0, p], points[1, p], abs(np.float64(points[2, p]))
        if not abs(x - last_x) + abs(y - last_y) <= SAME:  # columns along z share their foot
            last_x, last_y = x, y
            k, u, c, s, dx, dy = attached(
                np.float64(x), np.float64(y), places, line, ways, angle, curvature,
                pieces, small, large, guess, reach,
            )  # fmt: skip
            guess = k // RUN
            place = places[k] + u * (places[k + 1] - places[k])
            bend = curvature[k] + u * (curvature[k + 1] - curvature[k])
            offset, ahead = c * dy - s * dx, c * dx + s * dy
        kept = offset
        if bend * kept > FOLD:
            kept = FOLD / bend
        rho = kept - 0.5 * bend * kept * kept
        side = 1.0 if rho >= 0.0 else -1.0
        at_s = min(max(place + ahead, first), end_s)
        at_y, at_z = min(side * rho, end_y), min(z, end_z)
        away, way_s, way_y, way_z = _look(table, at_s, at_y, at_z, step_s, step_y, step_z, first)
        foot = at_s - away * way_s - place
        rho = side * (at_y - away * way_y)
        rho = 2.0 * rho / (1.0 + math.sqrt(max(1.0 - 2.0 * bend * rho, 0.01)))
        turn = bend * foot
        # along and across the circle: (1/kappa - rho) sin turn, 1/kappa - (1/kappa - rho) cos turn
        square = turn * turn
        if square < 0.04:
            sine = turn * (1.0 - square / 6.0 * (1.0 - square / 20.0))
            along = foot * (1.0 - square / 6.0 * (1.0 - square / 20.0)) - rho * sine
            bow = 0.5 * turn * (1.0 - square / 12.0 * (1.0 - square / 30.0))
            across = rho + (foot - rho * turn) * bow
        else:
            along = (1.0 / bend - rho) * math.sin(turn)
            across = 1.0 / bend - (1.0 / bend - rho) * math.cos(turn)
        up = at_z - away * way_z
        far = math.sqrt((ahead - along) ** 2 + (offset - across) ** 2 + (z - up) ** 2)
        result[p] = far if away > 0.0 else -far
