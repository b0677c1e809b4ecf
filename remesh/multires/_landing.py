"""Compiled search of the blocks that moved cells of particles touch.

Blocks are ``(n, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh.compiled import drop_stale
from remesh.layout import FAR
from remesh.multires import _hashing
from remesh.multires._hashing import EMPTY, slot_of
from remesh.multires.mesh import CELL

drop_stale(__file__, _hashing.__file__)


@njit(cache=True, nogil=True, inline="always")
def span(low, high, buffer, edge, count, wraps):
    """First and last place of the blocks on an axis that hold the nodes low - buffer to high + 1
    + buffer; places of periodic axes go on unwrapped, once round at most."""
    first = (low - buffer) // edge
    last = (high + 1 + buffer) // edge
    if wraps:
        return first, min(last, first + count - 1)
    return max(first, 0), min(last, count - 1)


@njit(cache=True, nogil=True)
def put(key, keys, bits):
    """Note a key in a table; whether it is new."""
    mask = (1 << bits) - 1
    slot = slot_of(key, bits)
    while keys[slot] != EMPTY:
        if keys[slot] == key:
            return 0
        slot = (slot + 1) & mask
    keys[slot] = key
    return 1


@njit(cache=True, nogil=True)
def corner(moves, cell, inverse, low, high):
    """Lowest and highest whole node offset of the particles of a cell, (3,) each, of the home
    node 0 of the block; whether all are numbers of a usable size."""
    parts, nm = moves.shape[0], moves.shape[2]
    i0, m0, k0 = cell
    fine = True
    for axis in range(3):
        low[axis] = 0
        high[axis] = 0
    middle = min(CELL, nm)
    for part in range(parts):
        axis = 2 if part == parts - 1 else part
        least, most = np.inf, -np.inf
        for i in range(i0, i0 + CELL):
            for m in range(m0, m0 + middle):
                row = moves[part, i, m]
                for k in range(k0, k0 + CELL):
                    home = i if axis == 0 else (m if axis == 1 else k)
                    place = home + row[k] * inverse
                    fine &= abs(place) < FAR
                    least = min(least, place)
                    most = max(most, place)
        if fine:
            low[axis] = np.int64(np.floor(least))
            high[axis] = np.int64(np.floor(most))
    return fine


@njit(cache=True, nogil=True)
def touched(moves, busy, places, inverse, buffer, counts, wraps, keys, bits):
    """Note the keys of the blocks of one level on which moved busy cells land.

    Returns how many; -1 if the table is too small, -2 if a displacement is no usable number.
    """
    blocks, nx, nm, nc = moves.shape[1:]
    low = np.zeros(3, np.int64)
    high = np.zeros(3, np.int64)
    most = (1 << bits) // 2
    found = 0
    for b in range(blocks):
        for ci in range(busy.shape[1]):
            for cm in range(busy.shape[2]):
                for ck in range(busy.shape[3]):
                    if not busy[b, ci, cm, ck]:
                        continue
                    cell = (ci * CELL, cm * CELL, ck * CELL)
                    if not corner(moves[:, b], cell, inverse, low, high):
                        return -2
                    x0, z0 = places[b, 0] * nx, places[b, places.shape[1] - 1] * nc
                    a0, a1 = span(x0 + low[0], x0 + high[0], buffer, nx, counts[0], wraps[0])
                    m0, m1 = 0, 0
                    if nm > 1:
                        y0 = places[b, 1] * nm
                        m0, m1 = span(y0 + low[1], y0 + high[1], buffer, nm, counts[1], wraps[1])
                    c0, c1 = span(z0 + low[2], z0 + high[2], buffer, nc, counts[2], wraps[2])
                    for a in range(a0, a1 + 1):
                        for m in range(m0, m1 + 1):
                            for c in range(c0, c1 + 1):
                                place = (a % counts[0]) * counts[1] + m % counts[1]
                                found += put(place * counts[2] + c % counts[2], keys, bits)
                                if found > most:
                                    return -1
    return found
