"""Snapshots in space that are made by hand: a vortex ring, with a ball in it if asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.run.rundir import SNAPSHOTS
from pmesh.run.snapshots import Snapshot, write_snapshot
from remesh.grid import Grid

GRID = Grid((33, 33, 33), 1 / 16, (-1.0, -1.0, -1.0))
RADIUS, CORE, PEAK = 0.5, 0.15, 4.0  # of the ring


def ring(grid: Grid = GRID, height: float = 0.0, side: float = 0.0) -> NDArray[Any]:
    """Vorticity about +z around (side, 0, height), of Gaussian cores."""
    x, y, z = grid.points()
    away = np.hypot(x - side, y) + 1e-12
    size = PEAK * np.exp(-((away - RADIUS) ** 2 + (z - height) ** 2) / CORE**2)
    return np.stack([-y / away * size, (x - side) / away * size, 0 * size])


def ball(side: float = 0.0, radius: float = 0.25) -> NDArray[Any]:
    """The indicator of a ball."""
    x, y, z = GRID.points()
    edge = np.clip((np.sqrt((x - side) ** 2 + y**2 + z**2) - radius) / 0.12, -1, 1)
    return np.asarray(0.5 * (1 - edge - np.sin(np.pi * edge) / np.pi))


def shot(folder: Path, step: int, *, side: float = 0.0, chi: bool = False, **more: Any) -> Snapshot:
    """A snapshot of a run directory: the ring, rising, at the time step / 10."""
    fields = {"vorticity": ring(height=0.1 * step - 0.1, side=side), **more}
    if chi:
        fields["chi"] = ball(side)
    path = folder / SNAPSHOTS / f"{step:08d}.vtkhdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_snapshot(path, GRID, fields, step, 0.1 * step)
