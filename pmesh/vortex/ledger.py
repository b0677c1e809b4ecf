"""Integrals of a vorticity field: what a flow keeps, and what bodies change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.budget import Moments, drag_along
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Outer = tuple[Array | None, Array | None]


def circulation(vorticity: Array, grid: Grid) -> Any:
    """Sum of vorticity, ``int w dV`` [L^ndim/T]: a float in the plane, (3,) in space."""
    if grid.ndim == 3:
        return vorticity.sum(axis=(1, 2, 3), dtype=np.float64) * grid.cell_volume
    return float(np.sum(vorticity, dtype=np.float64)) * grid.cell_volume


def impulse(vorticity: Array, grid: Grid) -> tuple[float, float]:
    """Linear impulse ``int (y w, -x w) dV`` [L^3/T]; the momentum of the fluid at rest far away.

    NaN where the lever is a periodic coordinate, which has no origin.
    """
    x, y = _levers(grid)
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_y @ y) * grid.cell_volume, -float(along_x @ x) * grid.cell_volume


def angular_moment(vorticity: Array, grid: Grid) -> float:
    """Second moment ``int (x^2 + y^2) w dV`` about the origin [L^4/T]; NaN on periodic axes."""
    x, y = _levers(grid)
    along_x = np.sum(vorticity, axis=1, dtype=np.float64)
    along_y = np.sum(vorticity, axis=0, dtype=np.float64)
    return float(along_x @ x**2 + along_y @ y**2) * grid.cell_volume


def enstrophy(vorticity: Array, grid: Grid) -> float:
    """``int w^2 dV`` [L^2/T^2]."""
    return float(np.sum(np.square(vorticity), dtype=np.float64)) * grid.cell_volume


def impulse_force(
    fields: tuple[Array, Array], grid: Grid, dt: float, freestream: Sequence[float], outer: Outer
) -> NDArray[np.float64]:
    """Less the force on the fluid [L^(ndim+1)/T^2], mean over dt, from the impulse's change.

    ``fields``: vorticity before and after. Velocity that no vorticity induces, the free stream
    (U, V) and what is added to it in ``outer`` before and after, carries impulse along at the
    rate ``int (V w, -U w) dV``. In space six numbers: the torque about the origin from the change
    of the angular impulse too.
    """
    if grid.ndim == 3:
        return _force_and_torque(fields, grid, dt, freestream, outer)
    old, new = (np.array(impulse(field, grid)) for field in fields)
    first, last = (
        _drag_along(field, grid, freestream, added)
        for field, added in zip(fields, outer, strict=True)
    )
    return np.asarray(0.5 * (first + last) - (new - old) / dt)


def _force_and_torque(
    fields: tuple[Array, Array], grid: Grid, dt: float, freestream: Sequence[float], outer: Outer
) -> NDArray[np.float64]:
    values, rates = [], []
    for field, added in zip(fields, outer, strict=True):
        moments = Moments(field, grid)
        values.append(np.concatenate([moments.impulse, moments.angular_impulse]))
        rates.append(np.concatenate(drag_along(field, moments, freestream, added, grid)))
    return np.asarray(0.5 * (rates[0] + rates[1]) - (values[1] - values[0]) / dt)


def _drag_along(
    vorticity: Array, grid: Grid, freestream: Sequence[float], added: Array | None
) -> NDArray[np.float64]:
    """int (V w, -U w) dV of an outer velocity (U, V)."""
    total = circulation(vorticity, grid)
    flux = np.array([freestream[1] * total, -freestream[0] * total])
    if added is not None:
        along, across = (float(np.sum(u * vorticity, dtype=np.float64)) for u in added)
        flux += np.array([across, -along]) * grid.cell_volume
    return flux


def _levers(grid: Grid) -> list[NDArray[np.float64]]:
    """Coordinates along each axis; NaN along periodic ones."""
    return [
        np.full_like(axis, np.nan) if wraps else axis
        for axis, wraps in zip(grid.axes(), grid.periodic, strict=True)
    ]
