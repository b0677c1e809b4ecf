"""Integrals of a vorticity field in space: impulse, energy, helicity, and how solenoidal it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


class Moments:
    """Sums of a vector field (3, *shape) [1/T] over planes, from which its low moments follow.

    Two passes over the field, sums in double precision. A lever along a periodic axis has no
    origin: it is NaN. Source: P. G. Saffman, Vortex Dynamics (1992), chapter 3.
    """

    def __init__(self, vorticity: Array, grid: Grid) -> None:
        profiles = []
        for part in vorticity:
            over_z = part.sum(axis=2, dtype=np.float64)
            over_y = part.sum(axis=1, dtype=np.float64)
            profiles.append([over_z.sum(axis=1), over_z.sum(axis=0), over_y.sum(axis=0)])
        self.profiles = profiles  # [i][j]: of w_i along axis j
        self.volume = grid.cell_volume
        self.levers = [
            np.full_like(axis, math.nan) if wraps else axis
            for axis, wraps in zip(grid.axes(), grid.periodic, strict=True)
        ]

    @property
    def total(self) -> Values:
        """``int w dV`` [L^3/T]."""
        return np.array([along[0].sum() for along in self.profiles]) * self.volume

    def first(self, part: int, axis: int) -> float:
        """``int x_axis w_part dV`` [L^4/T]."""
        return float(self.profiles[part][axis] @ self.levers[axis]) * self.volume

    @property
    def impulse(self) -> Values:
        """``1/2 int x cross w dV`` [L^4/T]."""
        cycles = ((1, 2), (2, 0), (0, 1))
        return np.array([0.5 * (self.first(k, j) - self.first(j, k)) for j, k in cycles])

    @property
    def angular_impulse(self) -> Values:
        """``-1/2 int |x|^2 w dV`` [L^5/T], about the origin."""
        squares = [
            sum(float(along[j] @ self.levers[j] ** 2) for j in range(3)) for along in self.profiles
        ]
        return -0.5 * np.array(squares) * self.volume


def energy(velocity: Array, vorticity: Array, grid: Grid) -> float:
    """Kinetic energy ``1/2 int u^2 dV`` [L^5/T^2] of a fluid at rest far away.

    ``velocity``: without a free stream. In a fully periodic box the sum over it; in free space
    Lamb's ``int u . (x cross w) dV``, which needs the velocity where vorticity is only; with mixed
    axes NaN (see `potential_energy`).
    """
    if all(grid.periodic):
        return 0.5 * dot(velocity, velocity) * grid.cell_volume
    if any(grid.periodic):
        return math.nan
    total = 0.0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        plane = _product_profile(velocity[j], vorticity[i], k)
        plane -= _product_profile(velocity[i], vorticity[j], k)
        total += float(plane @ grid.axes()[k])
    return total * grid.cell_volume


def potential_energy(stream: Array, vorticity: Array, grid: Grid) -> float:
    """The same from the stream function [L^2/T]: ``1/2 int psi . w dV``, with any axes."""
    return 0.5 * dot(stream, vorticity) * grid.cell_volume


def dot(one: Array, other: Array) -> float:
    """Sum of the products of two fields of one shape, in double precision, plane by plane."""
    return math.fsum(
        float(np.einsum("jk,jk->", a, b, dtype=np.float64))
        for first, second in zip(one, other, strict=True)
        for a, b in zip(first, second, strict=True)
    )


def drag_along(
    vorticity: Array, moments: Moments, freestream: Sequence[float], added: Array | None, grid: Grid
) -> tuple[Values, Values]:
    """Rates ``int u cross w dV`` and ``int x cross (u cross w) dV`` of an outer velocity u.

    Of impulse [L^4/T^2] and angular impulse [L^5/T^2]: of the free stream U they are U cross int w,
    which vanishes, and U cross impulse; of what is ``added`` to it sums over the mesh.
    """
    stream = np.asarray(freestream, np.float64)
    linear, turning = np.cross(stream, moments.total), np.cross(stream, moments.impulse)
    if added is not None:
        points = grid.points()
        force = np.cross(added, vorticity, axis=0)
        linear = linear + force.sum(axis=(1, 2, 3), dtype=np.float64) * grid.cell_volume
        arm = np.cross(points, force, axis=0)
        turning = turning + arm.sum(axis=(1, 2, 3), dtype=np.float64) * grid.cell_volume
    return linear, turning


def _product_profile(one: Array, other: Array, axis: int) -> Values:
    """Sums of a product over the planes across an axis."""
    rows = ("ijk,ijk->i", "ijk,ijk->j", "ijk,ijk->k")[axis]
    return np.asarray(np.einsum(rows, one, other, dtype=np.float64), np.float64)
