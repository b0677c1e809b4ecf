"""Compiled search for kinks beside the cells of a contour: which nodes to leave out there."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

from levelset import _interpolant
from levelset._interpolant import KIND_X, KIND_Y, KIND_Z, KINK, beside, kind_of
from remesh.compiled import drop_stale

drop_stale(__file__, _interpolant.__file__)

SEEN = 128  # a cell that was looked at
HELD = 64  # a cell between kinks on both its sides where phi already is a distance
LEAST, MOST = 0.9, 1.05  # slopes there: of all axes together at least, of any axis at most


@njit(cache=True, nogil=True)
def around(low, size, wraps):
    """The nodes low - 1 to low + 2 of an axis; -1 beyond an unbounded edge."""
    return (
        beside(low, -1, size, wraps),
        beside(low, 0, size, wraps),
        beside(low, 1, size, wraps),
        beside(low, 2, size, wraps),
    )


@njit(cache=True, nogil=True)
def find_kinks(first, pieces, step, rows, flat, shape, wraps, gaps, spacing, nodes, kinds):
    """Mark the cells around the nodes: ``kinds`` as the interpolant takes them, and `SEEN`."""
    nx, nm, nc = shape
    flatland = nm == 1
    for piece in range(first, pieces, step):
        for n in range(piece * rows, min((piece + 1) * rows, len(nodes))):
            node = nodes[n]
            i, m, k = node // (nc * nm), (node // nc) % nm, node % nc
            for x in range(i - 1, i + 1):
                px = around(x, nx, wraps[0])
                for y in range(m if flatland else m - 1, m + 1):
                    py = (0, 0, 0, 0) if flatland else around(y, nm, wraps[1])
                    for z in range(k - 1, k + 1):
                        pz = around(z, nc, wraps[2])
                        if px[1] < 0 or py[1] < 0 or pz[1] < 0:
                            continue
                        cell = (px[1] * nm + py[1]) * nc + pz[1]
                        if kinds[cell] == 0:
                            kx, sx, hx = along(flat, px, py, pz, nm * nc, nc, 1, gaps)
                            kz, sz, hz = along(flat, pz, px, py, 1, nm * nc, nc, gaps)
                            ky, sy, hy = 0, 0.0, False
                            if not flatland:
                                ky, sy, hy = along(flat, py, px, pz, nc, nm * nc, 1, gaps)
                            found = kx << KIND_X | ky << KIND_Y | kz << KIND_Z
                            least = (LEAST * spacing) ** 2 < sx * sx + sy * sy + sz * sz
                            even = least and max(sx, sy, sz) < MOST * spacing
                            if even and (hx or hy or hz):
                                found |= HELD
                            kinds[cell] = SEEN | found


@njit(cache=True, nogil=True)
def along(flat, line, across, beyond, stride, stride_across, stride_beyond, gaps):
    """Kind of a cell along one axis; the largest slope; whether there are kinks on both sides.

    From the lines through its corners.
    """
    if line[0] < 0 or line[2] < 0 or line[3] < 0 or across[2] < 0 or beyond[2] < 0:
        return 0, 0.0, False
    largest, ahead, turn_low, turn_high = 0.0, 0.0, 0.0, 0.0
    for q in range(1, 3):
        for r in range(1, 3):
            base = across[q] * stride_across + beyond[r] * stride_beyond
            f0, f1 = flat[base + line[0] * stride], flat[base + line[1] * stride]
            f2, f3 = flat[base + line[2] * stride], flat[base + line[3] * stride]
            if gaps and (f0 == 0.0 or f1 == 0.0 or f2 == 0.0 or f3 == 0.0):
                return 0, 0.0, False
            largest = max(largest, abs(f1 - f0), abs(f2 - f1), abs(f3 - f2))
            low, high = f0 - 2.0 * f1 + f2, f1 - 2.0 * f2 + f3
            turn_low, turn_high = max(turn_low, abs(low)), max(turn_high, abs(high))
            ahead = max(ahead, abs(high - low))
    kind = kind_of(largest, ahead, turn_low, turn_high)
    return kind, largest, kind != 0 and min(turn_low, turn_high) > KINK * largest
