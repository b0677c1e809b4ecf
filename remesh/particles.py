"""Particles: positions and strengths as one value, and how distorted their lattice is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, precision
from remesh.stencils import derivative

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Particles:
    """``positions`` ``(n, ndim)`` [L] and ``strengths`` ``(n,)`` or ``(n, c)`` [Q].

    Refuses shapes that do not match. Moving makes new Particles; nothing changes in place.
    """

    positions: Array
    strengths: Array

    def __post_init__(self) -> None:
        """Refuse positions and strengths that do not belong together."""
        positions, strengths = np.asarray(self.positions), np.asarray(self.strengths)
        if positions.ndim != 2 or positions.shape[1] not in (2, 3):
            raise InputError(
                f"positions must have shape (n, 2) or (n, 3), got {positions.shape}",
                hint="positions.T" if positions.shape[:1] in ((2,), (3,)) else "one row each",
            )
        if strengths.ndim not in (1, 2) or strengths.shape[0] != positions.shape[0]:
            raise InputError(
                f"strengths must have shape ({positions.shape[0]},) or ({positions.shape[0]}, c), "
                f"got {strengths.shape}",
                hint="one strength, or one row of components, per particle",
            )
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "strengths", strengths)

    @classmethod
    def on_grid(cls, field: Array, grid: Grid) -> Particles:
        """Every node as a particle of strength value * h^ndim, nodes in C order.

        ``field`` ``grid.shape`` or ``(c, *grid.shape)`` [Q/L^ndim]; float32 stays float32,
        positions too: they then keep 6e-8 of their distance from zero.
        """
        values = check_field(field, grid)
        dtype = precision(values)
        positions = grid.points().reshape(grid.ndim, -1).T.astype(dtype, order="C")
        strengths = values.astype(dtype) * dtype.type(grid.cell_volume)
        if values.ndim == grid.ndim:
            return cls(positions, strengths.ravel())
        return cls(positions, np.ascontiguousarray(strengths.reshape(values.shape[0], -1).T))

    @property
    def ndim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.positions.shape[1])

    def __len__(self) -> int:
        """Number of particles."""
        return int(self.positions.shape[0])

    def moved(self, displacement: Array) -> Particles:
        """The same strengths at positions + displacement ``(n, ndim)`` [L]."""
        return Particles(self.positions + displacement, self.strengths)


def distortion(displacement: Array, grid: Grid, *, where: NDArray[np.bool_] | None = None) -> float:
    """How far a lattice of displaced nodes is from a regular one: max |ln(principal stretch)|.

    ``displacement`` ``(ndim, *grid.shape)`` [L] since the last remeshing, ``where`` the nodes
    that count. Zero for translations and rigid rotations, however large; ln(a) when a neighbour
    spacing grew or shrank by a; infinite where the map folds. A shear of angle gamma gives
    asinh(gamma / 2). Particles overlap as long as exp(distortion) h stays below the mollifier's
    radius: remesh at a few tenths. Second-order central differences of the flow map, whose
    Cauchy-Green tensor has the squared stretches as eigenvalues.
    """
    moves = np.asarray(displacement, dtype=np.float64)
    if moves.shape != (grid.ndim, *grid.shape):
        raise InputError(
            f"displacement must have shape {(grid.ndim, *grid.shape)}, got {moves.shape}",
            hint="positions - nodes, one component per axis",
        )
    rows = np.stack([derivative(moves, grid, axis, order=2) for axis in range(grid.ndim)])
    map_gradient = np.moveaxis(rows, (0, 1), (-1, -2)) + np.eye(grid.ndim)  # [.., i, j] dx_i/dX_j
    if where is not None:
        map_gradient = map_gradient[np.asarray(where, dtype=bool)]
    if map_gradient.size == 0:
        return 0.0
    if not np.isfinite(map_gradient).all():
        raise InputError("displacement must be finite", hint="check the velocity and the step")
    volume = np.linalg.det(map_gradient)
    if (volume <= 0).any():
        return float("inf")
    if grid.ndim == 2:  # closed form: many times faster than a decomposition per node
        (a, b), (c, d) = np.moveaxis(map_gradient, (-2, -1), (0, 1))
        largest = (np.hypot(a + d, b - c) + np.hypot(a - d, b + c)) / 2
        return float(np.log(np.maximum(largest, largest / volume)).max())
    stretches = np.linalg.svd(map_gradient, compute_uv=False)
    return float(np.abs(np.log(stretches)).max())
