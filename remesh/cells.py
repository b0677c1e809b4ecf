"""A cell list: particles sorted into cells, so that a law finds those near a point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Points = NDArray[np.float64]
MOST_CELLS = 1 << 21
PARTS = 3  # cells along a reach


class CellList:
    """Particles by cells a third of ``reach`` [L] wide, wider where there would be too many."""

    def __init__(self, positions: Points, reach: float) -> None:
        from remesh import _cells

        n, ndim = positions.shape
        low = positions.min(axis=0)
        extent = positions.max(axis=0) - low
        most = int(MOST_CELLS ** (1 / ndim)) - 1
        self.width = max(reach / PARTS, float(extent.max()) / most)
        self.shape = np.array(
            [int(e / self.width) + 1 for e in extent] + [1] * (3 - ndim), np.int64
        )
        self.origin = np.pad(low, (0, 3 - ndim))
        self.reach = math.ceil(reach / self.width)  # cells
        self.starts = np.zeros(int(self.shape.prod()) + 1, np.int64)
        self.order = np.empty(n, np.int64)  # particles, cell by cell
        places = self.three(positions)
        _cells.bin_particles(places, self.origin, self.width, self.shape, self.starts, self.order)
        self.places = places[self.order]

    @property
    def arguments(self) -> tuple[Any, ...]:
        """What the loops over cells take: origin, width, shape, starts, reach."""
        return self.origin, self.width, self.shape, self.starts, self.reach

    @staticmethod
    def three(points: Points) -> Points:
        """Points with a third coordinate, zero in 2-D, so that one loop serves both."""
        return np.ascontiguousarray(np.pad(points, ((0, 0), (0, 3 - points.shape[1]))))


def check_points(values: Array, name: str) -> Points:
    """Points in double precision; refuses another shape than (n, 2) or (n, 3), and non-numbers."""
    points = np.asarray(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(
            f"{name} must have shape (n, 2) or (n, 3), got {points.shape}",
            hint=f"{name}.T" if points.shape[:1] in ((2,), (3,)) else "one row per point",
        )
    if not np.isfinite(points).all():
        raise InputError(f"{name} must be finite", hint="check the velocity and the time step")
    return points
