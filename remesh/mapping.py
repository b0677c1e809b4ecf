"""Adaptive global mappings: a smooth map of a mesh draws its nodes to where they are needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.nodes import sample_nodes
from remesh.stencils import derivative

Values = NDArray[np.float64]
Array = NDArray[np.floating[Any]]
SWEEPS = 12  # of Newton's method, at most
CLOSE = 1e-9  # cells of the reference mesh; iterations end there
ITERATIONS = 200  # of conjugate gradients, at most


@dataclass(frozen=True, eq=False)
class Mapping:
    """The map x = xi + ``offset`` from the nodes xi of a periodic ``grid``, onto the same box.

    ``offset`` ``(ndim, *grid.shape)`` [L] is what particles on the nodes carry; between them it is
    interpolated. Particles are uniform in xi and remeshed there, whatever their distance in x.
    Refuses meshes with ends, and maps that fold.
    Source: Bergdorf, Cottet & Koumoutsakos, Multiscale Model. Simul. 4 (2005) 328.
    """

    grid: Grid
    offset: Values

    def __post_init__(self) -> None:
        """Refuse what is no smooth map of a periodic box onto itself."""
        offset = np.asarray(self.offset, np.float64)
        if not all(self.grid.periodic):
            raise InputError(
                f"a mapping needs periodic axes, got {self.grid.boundary}",
                hint='Grid(..., boundary="periodic")',
            )
        if offset.shape != (self.grid.ndim, *self.grid.shape):
            raise InputError(
                f"offset must have shape {(self.grid.ndim, *self.grid.shape)}, got {offset.shape}",
                hint="x - xi at the nodes, one component per axis",
            )
        object.__setattr__(self, "offset", offset)
        if not float(self.volume().min()) > 0:
            raise InputError("the mapping folds", hint="a smoother monitor, or smaller steps")

    @classmethod
    def identity(cls, grid: Grid) -> Mapping:
        """Nodes where they are on the reference mesh."""
        return cls(grid, np.zeros((grid.ndim, *grid.shape)))

    def points(self) -> Values:
        """Where the nodes are, ``(ndim, *shape)`` [L]."""
        return self.grid.points() + self.offset

    def volume(self, displacement: Values | None = None) -> Values:
        """Volume per reference volume at each node, ``shape``, after a displacement if given.

        Its mean over the nodes is 1, to round-off in 2-D: the box keeps its volume.
        """
        moved = self.offset if displacement is None else self.offset + displacement
        return np.asarray(np.linalg.det(_gradient(moved, self.grid)))

    def gradient(self, field: Array) -> Values:
        """Gradient in space of a field on the nodes, ``(ndim, *shape)``; fourth order."""
        along = _along(field, self.grid)
        return _solved(np.swapaxes(_gradient(self.offset, self.grid), -1, -2), along)

    def pull_back(self, positions: Values, kernel: str | Kernel = "L4,2") -> Values:
        """How far each node would have to move on the reference mesh to lie at ``positions``.

        ``positions`` and the result ``(ndim, *shape)`` [L], as `sample_nodes` and `advect_nodes`
        take displacements. Newton's method on the interpolated map, to 1e-9 cells. Refuses places
        that it does not find.
        """
        grid, ndim = self.grid, self.grid.ndim
        slopes = _gradient(self.offset, grid)
        parts = np.moveaxis(slopes, (-2, -1), (0, 1)).reshape(-1, *grid.shape)
        table = np.concatenate([self.offset, parts])
        goal = positions - grid.points()
        found = _solved(slopes, goal - self.offset)
        for _ in range(SWEEPS):
            here = sample_nodes(table, found, grid, kernel)
            local = np.moveaxis(here[ndim:].reshape(ndim, ndim, *grid.shape), (0, 1), (-2, -1))
            change = _solved(np.asarray(local, np.float64), goal - found - here[:ndim])
            found = found + change
            if float(np.abs(change).max()) < CLOSE * grid.spacing:
                return found
        raise InputError(
            "some positions were not found on the mapping", hint="smaller steps, a smoother monitor"
        )

    def driven(self, monitor: Values, strength: float, *, smooth: float = 4.0) -> Mapping:
        """The map an implicit step of x_s = div(monitor grad x) later; ``strength`` [L^2] the step.

        ``monitor`` ``shape``, positive, counts relative to its mean: nodes gather where it is
        large, in one dimension until spacing times monitor is the same everywhere. It is smoothed
        over ``smooth`` cells first. Small steps follow a field without swinging about it.
        Conjugate gradients, preconditioned by a transform.
        Source: Ceniceros & Hou, J. Comput. Phys. 172 (2001) 609.
        """
        wanted = as_number("strength", strength, hint="strength=0.02")
        if np.shape(monitor) != self.grid.shape or not (
            np.isfinite(monitor).all() and np.min(monitor) > 0
        ):
            raise InputError(
                f"the monitor must be positive at the nodes {self.grid.shape}, got "
                f"{np.shape(monitor)} with values down to {np.min(monitor):.3g}",
                hint="1 + a |grad f|",
            )
        even = np.asarray(monitor, np.float64) / np.mean(monitor)
        narrow = 1.0 / (1.0 + (smooth * self.grid.spacing) ** 2 * _waves(self.grid))
        return Mapping(self.grid, _relaxed(self.offset, _filtered(even, narrow), wanted, self.grid))


def _along(field: Array, grid: Grid) -> Values:
    """Derivatives along the axes of the reference mesh, stacked; fourth order."""
    values = np.asarray(field, np.float64)
    parts = [derivative(values, grid, axis, order=4) for axis in range(grid.ndim)]
    return np.stack([np.asarray(part, np.float64) for part in parts])


def _gradient(offset: Values, grid: Grid) -> Values:
    """d x_i / d xi_j at the nodes, ``(*shape, ndim, ndim)``."""
    slopes: Values = np.moveaxis(_along(offset, grid), (0, 1), (-1, -2))
    return slopes + np.eye(grid.ndim)


def _solved(matrices: Values, right: Values) -> Values:
    """One small linear system per node; right sides and results ``(ndim, *shape)``."""
    columns = np.moveaxis(right, 0, -1)[..., None]
    found: Values = np.asarray(np.linalg.solve(matrices, columns), np.float64)
    return np.moveaxis(found[..., 0], -1, 0)


def _waves(grid: Grid) -> Values:
    """Symbol of minus the second-order Laplacian, for the real transform [1/L^2]."""
    total: Values = np.zeros((1,) * grid.ndim)
    for axis, nodes in enumerate(grid.shape):
        count = nodes // 2 + 1 if axis == grid.ndim - 1 else nodes
        waves = (2.0 / grid.spacing * np.sin(np.pi * np.arange(count) / nodes)) ** 2
        total = total + waves.reshape(-1, *(1,) * (grid.ndim - 1 - axis))
    return total


def _filtered(field: Values, symbol: Values) -> Values:
    """A field whose Fourier coefficients are multiplied by a symbol, along the symbol's axes."""
    axes = tuple(range(-symbol.ndim, 0))
    spectrum = np.fft.rfftn(field, axes=axes) * symbol
    return np.fft.irfftn(spectrum, s=field.shape[-symbol.ndim :], axes=axes)


def _spread(field: Values, between: list[Values], grid: Grid) -> Values:
    """div(monitor grad field) in the reference mesh, second order, monitors between nodes."""
    result = np.zeros_like(field)
    for axis, monitor in enumerate(between):
        along = axis - grid.ndim
        flux = monitor * (np.roll(field, -1, along) - field)
        result += flux - np.roll(flux, 1, along)
    return result / grid.spacing**2


def _relaxed(offset: Values, monitor: Values, strength: float, grid: Grid) -> Values:
    """Offset after an implicit step of x_s = div(monitor grad x), by conjugate gradients."""
    between = [0.5 * (monitor + np.roll(monitor, -1, axis)) for axis in range(grid.ndim)]
    pull = np.stack([(m - np.roll(m, 1, axis)) / grid.spacing for axis, m in enumerate(between)])
    near = 1.0 / (1.0 + strength * _waves(grid))
    found = offset.copy()
    rest = strength * (pull + _spread(found, between, grid))  # right side minus operator on offset
    goal = CLOSE * grid.spacing
    search = better = _filtered(rest, near)
    size = float(np.vdot(rest, better))
    for _ in range(ITERATIONS):
        if float(np.abs(better).max()) < goal:
            break
        image = search - strength * _spread(search, between, grid)
        step = size / float(np.vdot(search, image))
        found += step * search
        rest = rest - step * image
        better = _filtered(rest, near)
        size, before = float(np.vdot(rest, better)), size
        search = better + size / before * search
    return found
