"""Compiled loops over nodes: rows are cut into runs of equal whole-cell displacement, for SIMD.

Fields are ``(components, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one
node and one tap, so that one text serves 2-D and 3-D. ``taps``, ``mid`` and ``terms`` are tuples
whose lengths (nodes reached per axis, Horner terms) are constants to the compiler.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _lanes, _rows
from remesh._rows import (
    CHUNK,
    any_value,
    find_rows,
    gather,
    gather_edge,
    gather_even,
    group,
    lay,
    multiply,
    spread,
    spread_edge,
    spread_even,
    weigh,
)
from remesh.compiled import drop_stale
from remesh.layout import FAR

drop_stale(__file__, _rows.__file__, _lanes.__file__)


@njit(cache=True, nogil=True)
def reach(first, pieces, step, rows, displacement, scale, lowest, highest):
    """Smallest and largest whole-cell displacement in each piece of the rows."""
    far = scale[2]
    size = displacement.size
    for piece in range(first, pieces, step):
        part = displacement[piece * rows : min((piece + 1) * rows, size)]
        low = np.int32(FAR)
        high = np.int32(-FAR)
        for n in range(part.size):
            x = part[n] * scale[0]
            x = x if abs(x) < far else far
            k = np.int32(np.floor(x))
            low = min(low, k)
            high = max(high, k)
        lowest[piece] = low
        highest[piece] = high


@njit(cache=True, nogil=True, fastmath={"contract"})
def advect(
    first, pieces, step, colour, edges, field, displacement,
    scale, coeffs, taps, mid, terms, lanes, periodic, out, dropped, bad,
):  # fmt: skip
    """Every second band of rows, moved and remeshed into ``out``."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    flat = out.reshape(parts, nx * nm * nc)
    rows = np.empty(width * len(mid), np.int64)
    wa = np.zeros(width * CHUNK + 2, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    table = np.empty(CHUNK * len(lanes), field.dtype)
    across = np.empty(CHUNK * len(lanes), field.dtype)
    both = np.zeros((CHUNK + 2) * width * len(lanes), field.dtype) if len(mid) > 1 else wa
    level = np.zeros(CHUNK, np.int64)
    lifted = np.empty(CHUNK, field.dtype)
    cells = (np.zeros(CHUNK, np.int32), np.zeros(CHUNK, np.int32), np.zeros(CHUNK, np.int32))
    ka, kb, kc = cells
    local = np.empty(CHUNK, field.dtype)
    same = np.empty(CHUNK, np.bool_)
    cuts = np.empty(CHUNK + 1, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
    even = np.zeros(CHUNK + 1, np.bool_)
    bases = np.empty(CHUNK, np.int64)
    places = np.empty(CHUNK, np.int64)
    offsets = np.empty(CHUNK, np.int64)
    for piece in range(first, pieces, step):
        band = 2 * piece + colour
        for row in range(edges[band] * nm, edges[band + 1] * nm):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                stop = min(column + CHUNK, nc)
                used = False
                for p in range(parts):
                    used |= any_value(field[p, i, m, column:stop])
                if not used:
                    continue
                count = stop - column
                bad[band] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[band] += weigh(
                        displacement[1, i, m, column:stop], scale, coeffs, taps, terms, kb, local,
                        wb,
                    )  # fmt: skip
                bad[band] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                found = group(
                    count, nc, column, cells, taps, mid, lanes, periodic[2], same, cuts, starts,
                    bases, even, places, offsets,
                )  # fmt: skip
                lay(wc, starts, even, found, offsets, taps, lanes, table)
                if len(mid) > 1:
                    lay(wb, starts, even, found, level, taps, lanes, across)
                    multiply(wa, across, count, taps, lanes, both)
                for p in range(parts):
                    source = field[p, i, m, column:stop]
                    whole = False
                    for g in range(found):
                        n = starts[g]
                        if g == 0 or ka[n] != ka[n - 1] or kb[n] != kb[n - 1]:
                            x = i + np.int64(ka[n]) - left
                            y = m + np.int64(kb[n]) - left
                            whole = find_rows(x, y, (nx, nm, nc), periodic, False, taps, mid, rows)
                        if whole and even[g]:
                            spread_even(
                                source, rows, bases[g], wa, wc, n, starts[g + 1] - n, taps, lifted,
                                flat[p],
                            )  # fmt: skip
                            continue
                        if whole and bases[g] >= 0:
                            spread(
                                source, rows, bases[g], both, table, n, starts[g + 1], taps, mid,
                                lanes, flat[p],
                            )  # fmt: skip
                            continue
                        for k in range(n, starts[g + 1]):
                            dropped[band, p] += spread_edge(
                                source[k], rows, places[k], nc, periodic[2], both, wc, k, taps,
                                mid, lanes, flat[p],
                            )  # fmt: skip


@njit(cache=True, nogil=True, fastmath={"contract"})
def sample(
    first, pieces, step, size, field, displacement,
    scale, coeffs, taps, mid, terms, lanes, periodic, clamps, out, bad,
):  # fmt: skip
    """Pieces of ``size`` rows of ``out``: the field at node + displacement."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    flat = field.reshape(parts, nx * nm * nc)
    rows = np.empty(width * len(mid), np.int64)
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    table = np.empty(CHUNK * len(lanes), field.dtype)
    cells = (np.zeros(CHUNK, np.int32), np.zeros(CHUNK, np.int32), np.zeros(CHUNK, np.int32))
    ka, kb, kc = cells
    local = np.empty(CHUNK, field.dtype)
    same = np.empty(CHUNK, np.bool_)
    cuts = np.empty(CHUNK + 1, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
    even = np.zeros(CHUNK + 1, np.bool_)
    bases = np.empty(CHUNK, np.int64)
    places = np.empty(CHUNK, np.int64)
    offsets = np.empty(CHUNK, np.int64)
    for piece in range(first, pieces, step):
        for row in range(piece * size, min((piece + 1) * size, nx * nm)):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                stop = min(column + CHUNK, nc)
                count = stop - column
                bad[piece] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[piece] += weigh(
                        displacement[1, i, m, column:stop], scale, coeffs, taps, terms, kb, local,
                        wb,
                    )  # fmt: skip
                bad[piece] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                found = group(
                    count, nc, column, cells, taps, mid, lanes, periodic[2], same, cuts, starts,
                    bases, even, places, offsets,
                )  # fmt: skip
                lay(wc, starts, even, found, offsets, taps, lanes, table)
                for p in range(parts):
                    target = out[p, i, m, column:stop]
                    whole = False
                    for g in range(found):
                        n = starts[g]
                        if g == 0 or ka[n] != ka[n - 1] or kb[n] != kb[n - 1]:
                            x = i + np.int64(ka[n]) - left
                            y = m + np.int64(kb[n]) - left
                            whole = find_rows(x, y, (nx, nm, nc), periodic, clamps, taps, mid, rows)
                        if whole and even[g]:
                            gather_even(
                                flat[p], rows, bases[g], wa, wc, n, starts[g + 1], taps, lanes,
                                target,
                            )  # fmt: skip
                            continue
                        if whole and bases[g] >= 0:
                            for k in range(n, starts[g + 1]):
                                target[k] = gather(
                                    flat[p], rows, bases[g], wa, wb, table, k, taps, mid, lanes
                                )
                            continue
                        for k in range(n, starts[g + 1]):
                            target[k] = gather_edge(
                                flat[p], rows, places[k], nc, periodic[2], clamps, wa, wb, wc, k,
                                taps, mid,
                            )  # fmt: skip
