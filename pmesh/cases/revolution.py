"""Surfaces of revolution that shrink by their mean curvature, followed as a curve: a reference.

The curve (x, r)(u, t) turns about the x axis. Its surface moves along its normal n at minus the
mean curvature, the curve's own and that of the turn, n_r/r; moving its points by

    X_t = X_uu/|X_u|^2 - (n_r/r) n,    on the axis 2 X_uu/|X_u|^2,

does that, for the first term is the curve's curvature and a slide along it (Deckelnick & Dziuk).
Central differences in u, of order 2, and stiff integration in time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
SMALLEST = 0.02  # neck or drop, over its start, at which the curve is given up


class Shrinking(NamedTuple):
    """A curve on its way: times, points (times, n, 2), and when it pinches or vanishes."""

    time: Values
    curves: Values
    end: float

    @property
    def volume(self) -> Values:
        """Enclosed by the turn of the curve, at each time; of half a surface half of it."""
        x, r = self.curves[..., 0], self.curves[..., 1]
        area = np.pi * r**2
        return np.asarray(np.sum(0.5 * (area[:, 1:] + area[:, :-1]) * np.diff(x, axis=1), axis=1))


def shrink(points: Values, *, until: float, mirrored: bool, frames: int = 200) -> Shrinking:
    """A curve's way until it pinches, vanishes or the time is up.

    ``points`` (n, 2): x and r, outward on the left, from the plane x = 0, a mirror, if
    ``mirrored``, else from the axis; to the axis. Even spacing is best. Order 2 in it.
    """
    from scipy.integrate import solve_ivp

    start = np.asarray(points, np.float64)
    neck, tall = start[0, 1], start[:, 1].max()

    def thin(_: float, state: Values) -> float:
        r = state[1::2]
        gone = r.max() - SMALLEST * tall
        return float(min(gone, r[0] - SMALLEST * neck) if mirrored else gone)

    thin.terminal = True  # type: ignore[attr-defined]
    found: Any = solve_ivp(
        lambda _, state: _velocity(state.reshape(-1, 2), mirrored).ravel(),
        (0.0, until),
        start.ravel(),
        method="LSODA",
        dense_output=True,
        events=thin,
        rtol=1e-6,
        atol=1e-8,
        lband=3,
        uband=3,
    )
    last = found.t[-1]
    time = np.linspace(0.0, last, frames)
    curves = found.sol(time).T.reshape(frames, -1, 2)
    end = last
    if found.status == 1:  # the rest by the laws of the cylinder or of the sphere
        pinched = mirrored and curves[-1, :, 1].max() > 2 * SMALLEST * tall
        left = curves[-1, 0, 1] if pinched else curves[-1, :, 1].max()
        end = last + left**2 / (2.0 if pinched else 4.0)
    return Shrinking(time, curves, float(end))


def spaced(points: Values, count: int) -> Values:
    """A line of points (n, 2) with ``count`` of them evenly along it."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    places = np.linspace(0.0, arc[-1], count)
    return np.stack([np.interp(places, arc, part) for part in points.T], axis=1)


def drop(pinched: Values) -> Values:
    """The curve on one side after a pinch at x = 0, closed on the axis behind the neck."""
    thin = int(np.argmax(pinched[:, 1] > 2.0 * pinched[0, 1]))
    closed = np.concatenate([[[pinched[thin, 0], 0.0]], pinched[thin:]])
    return spaced(closed, len(pinched))


def _velocity(points: Values, mirrored: bool) -> Values:
    """X_t of all points; the last, and the first unless mirrored, stay on the axis."""
    first = points[1] * (-1, 1) if mirrored else points[1] * (1, -1)
    ghosts = np.concatenate([[first], points, [points[-2] * (1, -1)]])
    slope = 0.5 * (ghosts[2:] - ghosts[:-2])
    square = np.maximum((slope**2).sum(axis=1), 1e-300)
    bend = (ghosts[2:] - 2.0 * points + ghosts[:-2]) / square[:, None]
    turn = np.divide(slope[:, 0], points[:, 1], out=np.zeros(len(points)), where=points[:, 1] > 0)
    normal = np.stack([-slope[:, 1], slope[:, 0]], axis=1)
    moved = bend - (turn / square)[:, None] * normal
    for tip in (-1,) if mirrored else (0, -1):
        moved[tip] = 2.0 * bend[tip, 0], 0.0
    if mirrored:
        moved[0, 0] = 0.0
    return np.asarray(moved)
