"""Measures of rings about the z axis: circulation, radius, height, cores, waves around them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.transfer import m2p

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
LEAST = 0.25  # of the largest vorticity: a peak below it is no core
NEAR = 1.5  # core radii around a peak that its centre is the mean of


def half_plane_flux(vorticity: Array, grid: Grid) -> float:
    """Circulation [L^2/T]: ``int w_y dx dz`` over the half plane y = 0, x > 0.

    ``vorticity``: (3, *shape), on a lattice with nodes on the axis. A sum over nodes, spectrally
    accurate for rings that are smooth and vanish on the axis and at the edges.
    """
    first, middle = _axis_nodes(grid)
    lines = vorticity[1][first:, middle, :].sum(axis=1, dtype=np.float64)
    return float(lines.sum() - 0.5 * lines[0]) * grid.spacing**2


def swirl_profile(vorticity: Array, grid: Grid, power: int) -> Values:
    """``r^power w_theta`` summed over the planes across z, times the cell's volume, (nz,).

    For thin rings the sum of all is ``2 pi Gamma R^(1 + power)``; twice the impulse for power 1.
    """
    x, y = grid.axes()[0][:, None], grid.axes()[1][None, :]
    r = np.hypot(x, y)
    scale = np.where(r > 0, np.maximum(r, 0.5 * grid.spacing) ** (power - 1), 0.0)
    total = np.zeros(grid.shape[2])
    for plane, along_x, along_y in zip(range(grid.shape[0]), scale * x, scale * y, strict=True):
        total += along_x @ vorticity[1][plane] - along_y @ vorticity[0][plane]
    return total * grid.cell_volume


class Ring(NamedTuple):
    """Where a ring is."""

    radius: float  # [L]
    height: float  # [L]


def whole_ring(vorticity: Array, grid: Grid) -> Ring:
    """Mean radius, weighted with w_theta, and height of the impulse's centroid of all vorticity."""
    heavy, light = (swirl_profile(vorticity, grid, power) for power in (1, 0))
    z = grid.axes()[2]
    return Ring(float(heavy.sum() / light.sum()), float(z @ heavy / heavy.sum()))


def ring_below(vorticity: Array, grid: Grid) -> Ring:
    """Mean radius and height, weighted with w_theta, of the ring at z < 0."""
    heavy, light = (swirl_profile(vorticity, grid, power) for power in (1, 0))
    z = grid.axes()[2]
    below = np.where(z < -1e-9 * grid.spacing, 1.0, 0.0)
    part = float(light @ below)
    return Ring(float(heavy @ below) / part, float((z * light) @ below) / part)


def cores(vorticity: Array, grid: Grid, core: float, count: int = 2) -> list[Ring]:
    """The strongest cores in the half plane y = 0, x > 0: peaks of w_y, each with its centre.

    The centre is the mean place, weighted with the squared vorticity, within 1.5 ``core`` [L] of
    it. NaN for peaks that are not found: weaker than a quarter of the strongest, or within a core
    radius of a stronger one.
    """
    from scipy import ndimage

    first, middle = _axis_nodes(grid)
    plane = np.asarray(vorticity[1][first:, middle, :], np.float64)
    r, z = np.meshgrid(grid.axes()[0][first:], grid.axes()[2], indexing="ij")
    tops = (plane == ndimage.maximum_filter(plane, size=3)) & (plane > LEAST * plane.max())
    found: list[Ring] = []
    for place in sorted(zip(*np.nonzero(tops), strict=True), key=lambda one: -plane[one]):
        here = Ring(float(r[place]), float(z[place]))
        if all(np.hypot(here.radius - o.radius, here.height - o.height) > core for o in found):
            found.append(here)
        if len(found) == count:
            break
    centres = [_centre(plane, r, z, one, NEAR * core) for one in found]
    return centres + [Ring(np.nan, np.nan)] * (count - len(centres))


def waves(
    vorticity: Array, grid: Grid, centre: Ring, reach: float, count: int, spacing: float
) -> Values:
    """Amplitudes of the waves around a ring, n = 0 to ``count``, over that of the mean, (count+1,).

    ``sqrt(int |w_n|^2 r dr dz)`` with w_n the n-th Fourier coefficient over the angle of the
    vorticity's three components in cylindrical coordinates, within ``reach`` [L] of ``centre``,
    sampled at ``spacing`` [L]; times sqrt(2) for n > 0, which counts -n too.
    """
    r = np.arange(max(centre.radius - reach, spacing), centre.radius + reach, spacing)
    z = np.arange(centre.height - reach, centre.height + reach, spacing)
    angles = np.linspace(0.0, 2.0 * np.pi, 4 * count, endpoint=False)
    cos, sin = np.cos(angles), np.sin(angles)
    rr, zz = (one.ravel()[:, None] for one in np.meshgrid(r, z, indexing="ij"))
    points = np.stack([rr * cos, rr * sin, zz + 0.0 * angles], axis=-1).reshape(-1, 3)
    sampled = m2p(vorticity, points, grid, "M6'", outside="drop")
    wx, wy, wz = np.moveaxis(np.asarray(sampled, np.float64), -1, 0).reshape(3, -1, angles.size)
    turned = np.stack([wx * cos + wy * sin, wy * cos - wx * sin, wz])
    modes = np.fft.rfft(turned, axis=2)[:, :, : count + 1] / angles.size
    weight = rr * spacing**2
    size = np.sqrt((np.abs(modes) ** 2 * weight).sum(axis=(0, 1)))
    size[1:] *= np.sqrt(2.0)
    return np.asarray(size / size[0])


def _axis_nodes(grid: Grid) -> tuple[int, int]:
    """Index along x and y of the nodes on the z axis."""
    first, middle = (round(-start / grid.spacing) for start in grid.origin[:2])
    return first, middle


def _centre(plane: Values, r: Values, z: Values, start: Ring, reach: float) -> Ring:
    """Mean place weighted with the squared vorticity, about itself."""
    here = start
    for _ in range(4):
        near = np.hypot(r - here.radius, z - here.height) < reach
        weight = np.where(near, plane, 0.0) ** 2
        total = weight.sum()
        here = Ring(float((weight * r).sum() / total), float((weight * z).sum() / total))
    return here
