"""An oracle: a plane level set carried by the fifth-order HJ-WENO scheme, as Eulerian codes do it.

phi_t + u . grad phi = 0 on the nodes of a mesh: upwind differences by WENO of fifth order, steps by
the TVD Runge-Kutta scheme of third order, no redistancing. Beyond an unbounded edge phi goes on
as a straight line. Sources: G.-S. Jiang & D. Peng, SIAM J. Sci. Comput. 21 (2000) 2126; C.-W. Shu &
S. Osher, J. Comput. Phys. 77 (1988) 439. Tested in test_weno_level_set.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from remesh.grid import Grid

Array = NDArray[np.float64]
Velocity = Callable[[float, Array], NDArray[Any]]
GHOSTS = 3


def carried(
    phi: NDArray[Any],
    grid: Grid,
    velocity: Velocity,
    until: float,
    *,
    start: float = 0.0,
    courant: float = 0.5,
    dt: float | None = None,
) -> Array:
    """phi at time ``until``; steps of equal length, at most ``dt`` if given, else by ``courant``.

    ``velocity(time, positions)`` with positions (n, 2); courant = dt max(|u| + |v|) / h, of the
    velocity at ``start``.
    """
    positions = grid.points().reshape(2, -1).T.copy()

    def at(time: float) -> Array:
        return np.ascontiguousarray(np.asarray(velocity(time, positions), np.float64).T).reshape(
            2, *grid.shape
        )

    if dt is None:
        dt = courant * grid.spacing / float(np.abs(at(start)).sum(axis=0).max())
    steps = math.ceil((until - start) / dt - 1e-9)
    dt = (until - start) / steps
    wraps = (bool(grid.periodic[0]), bool(grid.periodic[1]))
    now = np.array(phi, np.float64)

    def change(values: Array, time: float) -> Array:
        rate = np.empty_like(values)
        transport(padded(values, wraps), at(time), 1.0 / grid.spacing, rate)
        return dt * rate

    for step in range(steps):
        time = start + step * dt
        first = now + change(now, time)
        second = 0.75 * now + 0.25 * (first + change(first, time + dt))
        now = now / 3 + 2 / 3 * (second + change(second, time + 0.5 * dt))
    return now


def padded(values: Array, wraps: tuple[bool, bool]) -> Array:
    """The values with three more nodes at each edge: wrapped, or straight on."""
    for axis, wrap in enumerate(wraps):
        width = [(0, 0), (0, 0)]
        width[axis] = (GHOSTS, GHOSTS)
        if wrap:
            values = np.pad(values, width, mode="wrap")
        else:
            values = np.pad(values, width)
            flat = np.moveaxis(values, axis, 0)
            for k in range(GHOSTS):
                flat[GHOSTS - 1 - k] = 2 * flat[GHOSTS - k] - flat[GHOSTS - k + 1]
                flat[k - GHOSTS] = 2 * flat[k - GHOSTS - 1] - flat[k - GHOSTS - 2]
    return values


@njit(cache=True, inline="always")
def weno(a, b, c, d, e):  # type: ignore[no-untyped-def]
    """The fifth-order upwind derivative from five differences, the farthest upwind first."""
    one = a / 3 - 7 * b / 6 + 11 * c / 6
    two = -b / 6 + 5 * c / 6 + d / 3
    three = c / 3 + 5 * d / 6 - e / 6
    rough1 = 13 / 12 * (a - 2 * b + c) ** 2 + 0.25 * (a - 4 * b + 3 * c) ** 2
    rough2 = 13 / 12 * (b - 2 * c + d) ** 2 + 0.25 * (b - d) ** 2
    rough3 = 13 / 12 * (c - 2 * d + e) ** 2 + 0.25 * (3 * c - 4 * d + e) ** 2
    w1 = 0.1 / (1e-6 + rough1) ** 2
    w2 = 0.6 / (1e-6 + rough2) ** 2
    w3 = 0.3 / (1e-6 + rough3) ** 2
    return (w1 * one + w2 * two + w3 * three) / (w1 + w2 + w3)


@njit(cache=True)
def transport(phi, velocity, inverse, rate):  # type: ignore[no-untyped-def]
    """rate = -u . grad phi; ``phi`` has three ghosts at each edge, ``inverse`` is 1/h."""
    for i in range(rate.shape[0]):
        for j in range(rate.shape[1]):
            total = 0.0
            for axis in range(2):
                speed = velocity[axis, i, j]
                if speed == 0.0:
                    continue
                back = 1 if speed > 0.0 else -1  # the way upwind is -back
                di, dj = (back, 0) if axis == 0 else (0, back)
                ci, cj = i + 3, j + 3
                v0 = phi[ci - 3 * di, cj - 3 * dj]
                v1 = phi[ci - 2 * di, cj - 2 * dj]
                v2 = phi[ci - di, cj - dj]
                v3 = phi[ci, cj]
                v4 = phi[ci + di, cj + dj]
                v5 = phi[ci + 2 * di, cj + 2 * dj]
                slope = weno(
                    (v1 - v0) * inverse, (v2 - v1) * inverse, (v3 - v2) * inverse,
                    (v4 - v3) * inverse, (v5 - v4) * inverse,
                )  # fmt: skip
                total += speed * back * slope
            rate[i, j] = -total
