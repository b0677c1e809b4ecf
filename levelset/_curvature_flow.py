"""Compiled loops over nodes: the second derivative of phi along its own normal."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

COARSE = 1.0 / 16.0  # of (h |Hess|)^2: squared slopes below it do not tell a direction


@njit(cache=True, nogil=True, inline="always")
def slope(a, b, c, d):
    """First derivative from the nodes -2, -1, 1, 2."""
    return (8.0 * (c - b) - (d - a)) / 12.0


@njit(cache=True, nogil=True, inline="always")
def bend(a, b, c, d, here):
    """Second derivative from the nodes -2, -1, 1, 2 and 0."""
    return (16.0 * (c + b) - (d + a) - 30.0 * here) / 12.0


@njit(cache=True, nogil=True, inline="always")
def twist(down, low, high, up, k):
    """Mixed derivative from four lines of nodes across, -2, -1, 1, 2, around the place k."""
    near = (high[k + 1] + low[k - 1]) - (high[k - 1] + low[k + 1])
    far = (up[k + 2] + down[k - 2]) - (up[k - 2] + down[k + 2])
    steep = (up[k + 1] + down[k - 1]) - (up[k - 1] + down[k + 1])
    shallow = (high[k + 2] + low[k - 2]) - (high[k - 2] + low[k + 2])
    return (64.0 * near - 8.0 * (steep + shallow) + far) / 144.0


@njit(cache=True, nogil=True, inline="always")
def along(steep, pure, size, cube):
    """n.Hess.n from the squared slope, grad.Hess.grad, tr Hess^2 and tr Hess^3.

    Where the slope does not tell a direction: its mean over the slopes Hess x close by, weighted
    with their squares, tr Hess^3/tr Hess^2.
    """
    coarse = COARSE * size
    total = steep * steep + coarse * coarse
    return (steep * pure + coarse * (COARSE * cube)) / total if total > 0.0 else 0.0


@njit(cache=True, nogil=True)
def normal_bend2(first, pieces, step, rows, padded, out):
    """h^2 n.Hess(phi).n of a plane phi with two nodes of ghosts around."""
    nx, ny = out.shape
    for piece in range(first, pieces, step):
        for i in range(piece * rows, min((piece + 1) * rows, nx)):
            down, low, mid = padded[i], padded[i + 1], padded[i + 2]
            high, up = padded[i + 3], padded[i + 4]
            for j in range(ny):
                k = j + 2
                here = mid[k]
                px = slope(down[k], low[k], high[k], up[k])
                py = slope(mid[k - 2], mid[k - 1], mid[k + 1], mid[k + 2])
                xx = bend(down[k], low[k], high[k], up[k], here)
                yy = bend(mid[k - 2], mid[k - 1], mid[k + 1], mid[k + 2], here)
                xy = twist(down, low, high, up, k)
                pure = px * px * xx + py * py * yy + 2.0 * (px * py * xy)
                size = xx * xx + yy * yy + 2.0 * (xy * xy)
                cube = xx * xx * xx + yy * yy * yy + 3.0 * (xx + yy) * (xy * xy)
                out[i, j] = along(px * px + py * py, pure, size, cube)


@njit(cache=True, nogil=True)
def normal_bend3(first, pieces, step, rows, padded, out):
    """h^2 n.Hess(phi).n of a phi in space with two nodes of ghosts around."""
    nx, ny, nz = out.shape
    for piece in range(first, pieces, step):
        for row in range(piece * rows, min((piece + 1) * rows, nx * ny)):
            i, j = row // ny + 2, row % ny + 2
            mid = padded[i, j]
            west2, west, east, east2 = (
                padded[i - 2, j], padded[i - 1, j], padded[i + 1, j], padded[i + 2, j]
            )  # fmt: skip
            south2, south, north, north2 = (
                padded[i, j - 2], padded[i, j - 1], padded[i, j + 1], padded[i, j + 2]
            )  # fmt: skip
            a, b, c, d = padded[i - 2], padded[i - 1], padded[i + 1], padded[i + 2]
            target = out[i - 2, j - 2]
            for n in range(nz):
                k = n + 2
                here = mid[k]
                px = slope(west2[k], west[k], east[k], east2[k])
                py = slope(south2[k], south[k], north[k], north2[k])
                pz = slope(mid[k - 2], mid[k - 1], mid[k + 1], mid[k + 2])
                xx = bend(west2[k], west[k], east[k], east2[k], here)
                yy = bend(south2[k], south[k], north[k], north2[k], here)
                zz = bend(mid[k - 2], mid[k - 1], mid[k + 1], mid[k + 2], here)
                xz = twist(west2, west, east, east2, k)
                yz = twist(south2, south, north, north2, k)
                near = (c[j + 1, k] + b[j - 1, k]) - (c[j - 1, k] + b[j + 1, k])
                far = (d[j + 2, k] + a[j - 2, k]) - (d[j - 2, k] + a[j + 2, k])
                steep = (d[j + 1, k] + a[j - 1, k]) - (d[j - 1, k] + a[j + 1, k])
                shallow = (c[j + 2, k] + b[j - 2, k]) - (c[j - 2, k] + b[j + 2, k])
                xy = (64.0 * near - 8.0 * (steep + shallow) + far) / 144.0
                pure = px * px * xx + py * py * yy + pz * pz * zz
                pure += 2.0 * (px * py * xy + px * pz * xz + py * pz * yz)
                size = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)
                cube = xx * xx * xx + yy * yy * yy + zz * zz * zz + 6.0 * (xy * xz * yz)
                cube += 3.0 * (
                    (xx + yy) * (xy * xy) + (xx + zz) * (xz * xz) + (yy + zz) * (yz * yz)
                )
                target[n] = along(px * px + py * py + pz * pz, pure, size, cube)
