"""The nodes around an implicit surface, where each reads the surface, and the Laplacian along it.

A quantity c of the surface is made constant along normals off it, c(x) = c(cp(x)) with cp(x) the
closest point of the surface. With P = I - n n the anisotropic operator is

    div(D P grad c) = D (lap c - kappa n . grad c - n . Hess c . n),

and as both last terms vanish for such a c, lap c is D laplace_s c on the surface: of the
anisotropic operator the plain one is left (Ruuth & Merriman, J. Comput. Phys. 227 (2008) 1943).
The band holds all nodes within sqrt(4 (ndim-1) + 9) h of the surface. With E the reading of the
closest points by cubics and L the second-order Laplacian,

    A c = E L c - (2 ndim/h^2) (c - E c)

is laplace_s c in all of the band (von Glehn, März & Macdonald, arXiv:1307.5624): L is read only
where all its nodes are in the band, so no condition is needed at the band's edge, and the second
term holds c constant along normals. No node that is read may lie between two sheets, with
neighbours that belong to the other one: A would let values leak across, and grow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.given import level_set
from levelset.shape import Shape
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import layout, split, wraps
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Values = NDArray[np.float64]
FACING = -0.9  # cosine between normals: below it two nodes look at sheets that face one another
ON = 1e-3  # spacings: nodes so near the surface do not see its normal by their closest point


def half_width(grid: Grid) -> float:
    """Half width of the band [L]."""
    return math.sqrt(4.0 * (grid.ndim - 1) + 9.0) * grid.spacing


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceBand:
    """A surface as diffusion knows it: the nodes around it and their closest points on it."""

    grid: Grid
    nodes: Nodes  # flat, ascending
    closest: Values  # (n, ndim) [L]
    distance: Values  # signed [L]

    @classmethod
    def around(
        cls, surface: Shape | Array, grid: Grid, *, threads: int | None = None
    ) -> SurfaceBand:
        """The band of a shape's surface, or of any phi on the nodes.

        Gaps and parts must be thicker than the mesh sees across: eight spacings always do (two
        reaches, 7.2 spacings in the plane and 8.2 in space), six where the surface lies along
        an axis. Refuses thinner ones, edges sharper than some 25 degrees, a surface that comes too
        near an unbounded edge, and a phi of one sign. Looks at every node of the box, once.
        """
        from levelset.closest import closest_points

        phi = level_set(surface, grid).astype(np.float64, copy=False)
        width = half_width(grid) * (1.0 + 1e-9)
        found = closest_points(phi, grid, width=width, threads=threads)
        made = cls(grid=grid, nodes=found.nodes, closest=found.points, distance=found.distance)
        made._refuse_near_sheets()  # now rather than at the first step
        return made

    @cached_property
    def band(self) -> Band:
        """The signed distance."""
        return Band(self.grid, self.nodes, self.distance)

    @cached_property
    def reading(self) -> tuple[Nodes, Values]:
        """How the closest points are read."""
        return self.read_at(self.closest)

    @cached_property
    def stencil(self) -> tuple[Nodes, Nodes]:
        """The nodes that are read, and those around each of them."""
        from levelset import _surface_band

        shape, axes = layout(self.grid)[1:], 2 * self.grid.ndim
        marks, known = np.zeros(self.grid.size, np.uint8), np.zeros(self.grid.size, np.uint8)
        known[self.nodes] = 1
        _surface_band.mark(self.reading[0], self.middle, marks)
        inner = np.empty(len(self.nodes), np.int64)
        around = np.empty((len(self.nodes), axes), np.int64)
        count = _surface_band.neighbours(
            self.nodes, marks, known, shape, tuple(wraps(self.grid).tolist()), inner, around
        )
        if count < 0:
            raise InputError(
                "the surface comes within five spacings of an unbounded edge of the grid",
                hint="a larger grid, or a periodic axis",
            )
        return inner[:count].copy(), around[:count].copy()

    @cached_property
    def parts(self) -> tuple[Nodes, ...]:
        """Places in ``nodes`` of each connected part of the surface, ascending."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        inner, around = self.stencil
        places, count = self.on_grid(np.arange(len(self.nodes))), len(self.nodes)
        first = np.repeat(places[inner], around.shape[1])
        links = np.ones(len(first), np.uint8)
        graph = coo_array((links, (first, places[around].ravel())), shape=(count, count))
        _, label = connected_components(graph, directed=False)
        read = places[self.reading[0][:, :, 1].sum(axis=1)]  # of each node: one that is linked
        _, part = np.unique(label[read], return_inverse=True)
        ends = np.cumsum(np.bincount(part))[:-1]
        return tuple(np.split(np.argsort(part, kind="stable"), ends))

    @cached_property
    def areas(self) -> Values:
        """Area of every part, in 2-D its length [L^(ndim-1)]."""
        return self.integrals(np.ones(len(self.nodes)))

    @property
    def area(self) -> float:
        """Area, in 2-D the length [L^(ndim-1)]."""
        return float(self.areas.sum())

    @property
    def middle(self) -> int:
        """Taps along the middle axis of the loops."""
        return 4 if self.grid.ndim == 3 else 1

    def read_at(self, points: Values, *, threads: int | None = None) -> tuple[Nodes, Values]:
        """How points (n, ndim) on the surface are read from the nodes."""
        from levelset import _surface_band

        spots = np.zeros((len(points), 3))
        spots[:, (0, 1, 2) if self.grid.ndim == 3 else (0, 2)] = (
            points - np.array(self.grid.origin)
        ) / self.grid.spacing
        taps, shares = np.empty((len(points), 3, 4), np.int64), np.empty((len(points), 3, 4))
        rows, pieces = split(len(points))
        share(
            _surface_band.place, pieces, thread_count(threads), rows, spots,
            layout(self.grid)[1:], tuple(wraps(self.grid).tolist()), taps, shares,
        )  # fmt: skip
        return taps, shares

    def read(
        self, field: Values, reading: tuple[Nodes, Values], *, threads: int | None = None
    ) -> Values:
        """A flat field read at points."""
        from levelset import _surface_band

        taps, shares = reading
        out = np.empty(len(taps))
        rows, pieces = split(len(taps))
        share(
            _surface_band.read, pieces, thread_count(threads), rows, field, taps, shares,
            self.middle, out,
        )  # fmt: skip
        return out

    def on_grid(self, values: NDArray[Any], places: Nodes | None = None) -> NDArray[Any]:
        """Values of the nodes, or of some, in a flat array of all nodes, zero elsewhere."""
        given = np.asarray(values)
        field = np.zeros(self.grid.size, np.int64 if given.dtype.kind == "i" else np.float64)
        field[self.nodes if places is None else self.nodes[places]] = given
        return field

    def at(self, values: Array, points: Values) -> Values:
        """Values, given at the nodes, at points (n, ndim) of the surface; order 4."""
        return self.read(self.on_grid(values), self.read_at(np.asarray(points, np.float64)))

    def integral(self, values: Array, *, threads: int | None = None) -> float:
        """The integral over the surface of values at the nodes, of order 4."""
        return float(self.integrals(values, threads=threads).sum())

    def integrals(self, values: Array, *, threads: int | None = None) -> Values:
        """The same over every part, (parts,)."""
        from levelset.quadrature import integrate

        found = []
        for part in self.parts:
            phi, given = (
                self.on_grid(one[part], part).reshape(self.grid.shape)
                for one in (self.distance, values)
            )
            nodes = self.nodes[part]
            found.append(integrate(given, phi, self.grid, nodes=nodes, threads=threads))
        return np.array(found)

    def laplacian(self, values: Values, *, threads: int | None = None) -> Values:
        """h^2 A of the module: h^2 laplace_s where the values are constant along normals."""
        from levelset import _surface_band

        inner, around = self.stencil
        total = np.zeros(self.grid.size)
        rows, pieces = split(len(inner))
        share(
            _surface_band.spread_sum, pieces, thread_count(threads), rows, self.on_grid(values),
            inner, around, total,
        )  # fmt: skip
        read = self.read(total, self.reading, threads=threads)
        return read - 2.0 * self.grid.ndim * values

    def _refuse_near_sheets(self) -> None:
        """Refuse neighbours, of which one is read, whose closest points are on facing sheets."""
        inner, around = self.stencil
        places = self.on_grid(np.arange(len(self.nodes)))
        mine, beside = places[inner], places[around]
        spots = np.stack(np.unravel_index(self.nodes, self.grid.shape), axis=1)
        away = np.array(self.grid.origin) + self.grid.spacing * spots - self.closest
        normal = away * np.sign(self.distance)[:, None]
        on = np.abs(self.distance[mine]) < ON * self.grid.spacing
        if on.any():  # all their neighbours are known
            ends = self.distance[beside[on]].reshape(-1, self.grid.ndim, 2)
            normal[mine[on]] = ends[..., 1] - ends[..., 0]
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        turned = [(normal[mine] * normal[other]).sum(axis=1) for other in beside.T]
        if np.min(turned) < FACING:
            _, m = np.unravel_index(int(np.argmin(turned)), np.shape(turned))
            raise InputError(
                "two sheets of the surface are too close for the mesh, near "
                f"{tuple(np.round(self.closest[mine[m]], 6).tolist())}: values would leak across",
                hint="a spacing of an eighth of the narrowest gap or part",
            )
