"""Compiled loops over nodes: rows are cut into runs of equal whole-cell displacement, for SIMD.

Fields are ``(components, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one
node and one tap, so that one text serves 2-D and 3-D. ``taps``, ``mid`` and ``terms`` are tuples
whose lengths (nodes reached per axis, Horner terms) are constants to the compiler.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _rows
from remesh._rows import (
    CHUNK,
    any_value,
    find_rows,
    gather,
    gather_edge,
    gather_short,
    lift,
    runs,
    spread,
    spread_edge,
    spread_short,
    weigh,
)
from remesh.compiled import drop_stale
from remesh.layout import FAR

SHORT = 12  # nodes: shorter runs go node by node

drop_stale(__file__, _rows.__file__)


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
    scale, coeffs, taps, mid, terms, periodic, out, dropped, bad,
):  # fmt: skip
    """Every second band of rows, moved and remeshed into ``out``."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    shape = (nx, nm, nc)
    flat = out.reshape(out.size)
    bases = np.empty(width * len(mid), np.int64)
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    lifted = np.empty((width * len(mid), CHUNK), field.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, field.dtype)
    changes = np.empty(CHUNK, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
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
                bad[band] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[band] += weigh(
                        displacement[1, i, m, column:stop],
                        scale,
                        coeffs,
                        taps,
                        terms,
                        kb,
                        local,
                        wb,
                    )
                bad[band] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                found = runs(
                    stop - column, nc - width + 1, left, ka, kb, kc, column, changes, starts
                )
                for p in range(parts):
                    lift(field[p, i, m, column:stop], wa, wb, taps, mid, lifted)
                    part = flat[p * nx * nm * nc : (p + 1) * nx * nm * nc]
                    for r in range(found):
                        n0, n1 = starts[r], starts[r + 1]
                        reached = n1 - n0 + width - 1
                        x = i + np.int64(ka[n0]) - left
                        y = m + np.int64(kb[n0]) - left
                        z = column + n0 + np.int64(kc[n0]) - left
                        whole = find_rows(x, y, z, shape, periodic, False, taps, mid, bases)
                        if not whole or z < 0 or z + reached > nc:
                            dropped[band, p] += spread_edge(
                                lifted, wc, n0, n1, taps, mid, out[p], x, y, z, periodic
                            )
                        elif n1 - n0 < max(SHORT, width):
                            spread_short(part, bases, lifted, wc, n0, n1, taps)
                        else:
                            for k in range(len(bases)):
                                target = part[bases[k] : bases[k] + reached]
                                spread(lifted[k], wc, n0, n1 - n0, taps, target)


@njit(cache=True, nogil=True, fastmath={"contract"})
def sample(
    first, pieces, step, rows, field, displacement,
    scale, coeffs, taps, mid, terms, periodic, clamps, out, bad,
):  # fmt: skip
    """Pieces of ``rows`` rows of ``out``: the field at node + displacement."""
    width = len(taps)
    left = width // 2 - 1
    parts, nx, nm, nc = field.shape
    last = displacement.shape[0] - 1
    shape = (nx, nm, nc)
    flat = field.reshape(field.size)
    wa = np.empty(width * CHUNK, field.dtype)
    wb = np.empty(width * CHUNK, field.dtype)
    wc = np.empty(width * CHUNK, field.dtype)
    ka = np.zeros(CHUNK, np.int32)
    kb = np.zeros(CHUNK, np.int32)
    kc = np.zeros(CHUNK, np.int32)
    local = np.empty(CHUNK, field.dtype)
    changes = np.empty(CHUNK, np.int64)
    starts = np.empty(CHUNK + 1, np.int64)
    bases = np.empty(width * len(mid), np.int64)
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * nm)):
            i = row // nm
            m = row % nm
            for column in range(0, nc, CHUNK):
                stop = min(column + CHUNK, nc)
                bad[piece] += weigh(
                    displacement[0, i, m, column:stop], scale, coeffs, taps, terms, ka, local, wa
                )
                if len(mid) > 1:
                    bad[piece] += weigh(
                        displacement[1, i, m, column:stop],
                        scale,
                        coeffs,
                        taps,
                        terms,
                        kb,
                        local,
                        wb,
                    )
                bad[piece] += weigh(
                    displacement[last, i, m, column:stop], scale, coeffs, taps, terms, kc, local, wc
                )
                found = runs(
                    stop - column, nc - width + 1, left, ka, kb, kc, column, changes, starts
                )
                for r in range(found):
                    n0, n1 = starts[r], starts[r + 1]
                    x = i + np.int64(ka[n0]) - left
                    y = m + np.int64(kb[n0]) - left
                    z = column + n0 + np.int64(kc[n0]) - left
                    whole = find_rows(x, y, z, shape, periodic, clamps, taps, mid, bases)
                    inside = whole and z >= 0 and z + n1 - n0 + width - 1 <= nc
                    for p in range(parts):
                        target = out[p, i, m, column:stop]
                        part = flat[p * nx * nm * nc : (p + 1) * nx * nm * nc]
                        if inside and n1 - n0 < 4:
                            gather_short(part, bases, wa, wb, wc, n0, n1, taps, mid, target)
                        elif inside:
                            gather(part, bases, wa, wb, wc, n0, n1, taps, mid, target)
                        else:
                            gather_edge(
                                field[p], wa, wb, wc, n0, n1, taps, mid, x, y, z, periodic,
                                clamps, target,
                            )  # fmt: skip
