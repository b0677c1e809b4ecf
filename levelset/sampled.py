"""A level set on a mesh as a shape: what particles carry can be a body in a flow."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Array, Bounds, Shape, grown
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel


@dataclass(frozen=True, eq=False)
class Sampled(Shape):
    """The shape whose signed distances at the nodes of a mesh are ``phi``, negative inside.

    Between nodes the kernel interpolates; the default keeps moments 0 to 4: of fifth order where
    ``phi`` is smooth. As exact as ``phi`` is a distance. Beyond the mesh the distance to its box
    and the value at the box's nearest point are the legs of a right angle: a lower bound, without
    a jump. Periodic axes are not wrapped: it is one body. Equal to itself only. Refuses values
    that are not finite, no inside, and an inside that reaches the edge of the mesh.
    """

    phi: NDArray[np.floating[Any]]  # of grid.shape [L]
    grid: Grid
    kernel: str | Kernel = field(default="M6'", kw_only=True)

    def __post_init__(self) -> None:
        """Refuse what is not a level set with an inside, within its mesh."""
        phi: Array = np.array(self.phi)
        if phi.dtype != np.float32:
            phi = phi.astype(np.float64)
        if phi.shape != self.grid.shape:
            raise InputError(
                f"Sampled: phi must have shape {self.grid.shape}, got {phi.shape}",
                hint="a level set on the nodes of this grid",
            )
        if not np.isfinite(phi).all():
            raise InputError(
                f"Sampled: phi must be finite, {int((~np.isfinite(phi)).sum())} nodes are not",
                hint="fill the nodes outside a narrow band by their sign",
            )
        if not (phi < 0).any():
            raise InputError(
                "Sampled: the level set has no inside: no node is negative",
                hint="phi < 0 inside, and a mesh that resolves the shape",
            )
        low, high = self._negative(phi)
        if (low == 0).any() or (high == np.array(phi.shape) - 1).any():
            raise InputError(
                "Sampled: the inside reaches the edge of the mesh", hint="a larger grid"
            )
        phi.setflags(write=False)
        object.__setattr__(self, "phi", phi)
        get_kernel(self.kernel)

    @staticmethod
    def _negative(phi: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last node with an inside, along each axis."""
        found = [
            np.flatnonzero((phi < 0).any(axis=tuple(j for j in range(phi.ndim) if j != i)))
            for i in range(phi.ndim)
        ]
        return np.array([f[0] for f in found]), np.array([f[-1] for f in found])

    @property
    def ndim(self) -> int:
        """Number of axes of the mesh."""
        return self.grid.ndim

    @property
    def volume(self) -> float | None:
        """None: `levelset.measure.measure` finds it."""
        return None

    def bounds(self) -> Bounds:
        """The box around the negative nodes, one spacing wider."""
        low, high = self._negative(self.phi)
        start, h = np.array(self.grid.origin), self.grid.spacing
        return tuple((start + h * (low - 1)).tolist()), tuple((start + h * (high + 1)).tolist())

    def reach(self, distance: float) -> Bounds:
        """That box grown by sqrt(2) times the distance: beyond the mesh the value is a bound."""
        return grown(self.bounds(), math.sqrt(2.0) * distance)

    @cached_property
    def _padded(self) -> tuple[Array, Grid]:
        """The values gone on beyond the mesh by as many nodes as the kernel needs, oddly."""
        width = min(int(np.ceil(get_kernel(self.kernel).half_width)), min(self.grid.shape) - 1)
        values = np.pad(self.phi, width, mode="reflect", reflect_type="odd")
        grid = Grid(
            values.shape,
            self.grid.spacing,
            tuple(x - width * self.grid.spacing for x in self.grid.origin),
        )
        return values, grid

    def _distance(self, points: Array) -> Array:
        from remesh.transfer import m2p

        start = np.array(self.grid.origin)
        last = start + self.grid.spacing * (np.array(self.grid.shape) - 1)
        places = points.reshape(self.ndim, -1).T.astype(np.float64)
        nearest = np.clip(places, start, last)
        values, grid = self._padded
        value = m2p(values, np.where(np.isnan(nearest), start, nearest), grid, self.kernel)
        beyond = np.sqrt(np.sum((places - nearest) ** 2, axis=1))
        away = np.where(beyond == 0.0, value, np.hypot(value, beyond))
        return np.asarray(away.reshape(points.shape[1:]))
