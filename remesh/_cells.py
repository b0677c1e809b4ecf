"""Compiled counting sort of particles into cells."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def bin_particles(positions, origin, width, shape, starts, order):
    """Stable counting sort of particles by cell; ``positions`` ``(n, 3)``, cells in C order."""
    n = positions.shape[0]
    cell = np.empty(n, np.int64)
    for p in range(n):
        index = 0
        for axis in range(3):
            k = np.int64((positions[p, axis] - origin[axis]) / width)
            index = index * shape[axis] + min(max(k, 0), shape[axis] - 1)
        cell[p] = index
        starts[index + 1] += 1
    for index in range(starts.size - 1):
        starts[index + 1] += starts[index]
    place = starts[:-1].copy()
    for p in range(n):
        order[place[cell[p]]] = p
        place[cell[p]] += 1
