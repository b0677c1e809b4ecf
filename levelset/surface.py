"""The zero contour of nodal values as lines in the plane and as triangles in space."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.nodal import Laid, laid_out, refuse_empty, three
from remesh.errors import InputError, StorageError
from remesh.grid import Grid
from remesh.layout import split
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
REACH = 0.75  # node spacings that a point moves onto the contour of the cubics, at most
LEAST = 1e-3  # of its neighbours' size is a nodal value lifted to, so that no triangle is a point
FILES = (".stl", ".ply", ".obj", ".vtp")


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of a surface, their corners anticlockwise when seen from outside."""

    vertices: Values  # (n, 3) [L]
    faces: NDArray[np.int64]  # (m, 3): places in ``vertices``
    normals: Values  # (n, 3): unit, outward, at the vertices

    @property
    def area(self) -> float:
        """Area of the triangles [L^2]."""
        return float(0.5 * np.linalg.norm(np.cross(*self._sides), axis=1).sum())

    @property
    def volume(self) -> float:
        """Volume inside the triangles [L^3]; refuses a surface with open edges."""
        if self.open_edges:
            raise InputError(
                f"a surface with {self.open_edges} open edges has no volume",
                hint="a shape that does not leave the box, or levelset.volume(phi, grid)",
            )
        middle = self.vertices.mean(axis=0) if len(self.vertices) else 0.0
        first = self.vertices[self.faces[:, 0]] - middle
        return float(np.einsum("ij,ij->", first, np.cross(*self._sides)) / 6)

    @cached_property
    def open_edges(self) -> int:
        """Number of edges that are not shared by two triangles of opposite sense; 0 if closed."""
        ahead = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        count = len(self.vertices)
        key, back = ahead[:, 0] * count + ahead[:, 1], ahead[:, 1] * count + ahead[:, 0]
        return int(len(key) - np.isin(key, back).sum() + len(key) - len(np.unique(key)))

    @property
    def _sides(self) -> tuple[Values, Values]:
        """Two sides of each triangle."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return b - a, c - a

    def save(self, path: str | Path) -> Path:
        """Write the triangles to a file: .stl (in float32), .ply, .obj or .vtp, by its ending.

        Refuses another ending; raises StorageError where the file cannot be written.
        """
        import pyvista

        target = Path(path)
        if target.suffix.lower() not in FILES:
            raise InputError(
                f"surfaces are written as {', '.join(FILES)}, got {target.name!r}",
                hint="surface.save('surface.stl')",
            )
        if not target.parent.is_dir():
            raise StorageError(f"there is no folder {target.parent}", hint="create it first")
        faces = np.insert(self.faces, 0, 3, axis=1).ravel()
        pyvista.PolyData(self.vertices, faces).save(target)
        return target


def triangles(
    phi: Array | Band, grid: Grid | None = None, *, threads: int | None = None
) -> Surface:
    """The surface ``phi = 0`` in space as triangles, about two per cell that it crosses.

    ``phi`` of ``grid.shape``, negative inside, of any slope; or a `Band`. Flying edges (VTK), then
    each vertex moved along the gradient onto the contour of the cubic interpolant: vertices are of
    order 4, area and volume of the flat triangles of order 2 (`area` and `volume` have order 4).
    Closed where the surface does not leave the box; on a periodic axis it goes on to the seam and
    is open there. Same bits for any number of threads. Refuses the plane, a phi of one sign, and
    values that are not finite.
    """
    import pyvista

    values, laid = _filled(phi, grid)
    mesh = laid.grid
    if mesh.ndim != 3:
        raise InputError("triangles are drawn in space, got a plane", hint="contours(phi, grid)")
    image = pyvista.ImageData(
        dimensions=values.shape, spacing=(mesh.spacing,) * 3, origin=mesh.origin
    )
    image.point_data["phi"] = values.ravel(order="F")
    found = image.contour([0.0], scalars="phi", method="flying_edges", compute_normals=False)
    faces = np.asarray(found.faces, np.int64).reshape(-1, 4)[:, 1:]
    vertices, normals = _landed(np.asarray(found.points, np.float64), laid, threads)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    outward = np.einsum("ij,ij->", np.cross(b - a, c - a), normals[faces[:, 0]])
    return Surface(
        vertices, np.ascontiguousarray(faces if outward >= 0 else faces[:, ::-1]), normals
    )


def contours(
    phi: Array | Band, grid: Grid | None = None, *, threads: int | None = None
) -> list[Values]:
    """The lines ``phi = 0`` in the plane, each ``(n, 2)`` [L], with the inside on their left.

    ``phi`` of ``grid.shape``, negative inside, of any slope; or a `Band`. A closed line ends where
    it begins; one that leaves the box, or meets the seam of a periodic axis, does not. Points are
    where the contour of the bilinear interpolant crosses mesh lines (contourpy), then moved along
    the gradient onto that of the cubic one, of order 4. Refuses space, a phi of one sign, and
    values that are not finite.
    """
    from contourpy import contour_generator

    values, laid = _filled(phi, grid)
    mesh = laid.grid
    if mesh.ndim != 2:
        raise InputError("contours are drawn in the plane", hint="triangles(phi, grid)")
    axes = [
        start + mesh.spacing * np.arange(count)
        for start, count in zip(mesh.origin, values.shape, strict=True)
    ]
    drawn = contour_generator(axes[1], axes[0], values, line_type="Separate").lines(0.0)
    lines = []
    for line in drawn:
        points, normals = _landed(np.asarray(line, np.float64)[:, ::-1], laid, threads)
        along = np.diff(points, axis=0)
        left = along[:, 1] * normals[:-1, 0] - along[:, 0] * normals[:-1, 1]  # outward on the right
        lines.append(points if left.sum() >= 0 else points[::-1].copy())
    return lines


def _filled(phi: Array | Band, grid: Grid | None) -> tuple[Values, Laid]:
    """Values on all nodes and past periodic seams, none too small to draw; and the loops' own."""
    laid = laid_out(phi, grid)
    refuse_empty(laid)
    mesh, known = laid.grid, laid.known
    field = laid.flat.reshape(mesh.shape)
    if laid.gaps:
        field = np.asarray(Band(mesh, laid.nodes, known).filled(float(np.abs(known).max())))
    padded = np.pad(field, [(0, int(w)) for w in mesh.periodic], mode="wrap")
    around = np.zeros_like(padded)
    size = np.abs(padded)
    for axis in range(mesh.ndim):
        here, beside = np.moveaxis(around, axis, 0), np.moveaxis(size, axis, 0)
        np.maximum(here[1:], beside[:-1], out=here[1:])
        np.maximum(here[:-1], beside[1:], out=here[:-1])
    lifted = np.maximum(size, LEAST * around)
    return np.where(padded < 0, -lifted, np.maximum(lifted, 1e-300)), laid


def _landed(points: Values, laid: Laid, threads: int | None) -> tuple[Values, Values]:
    """Points (n, ndim) on the contour of the cubic interpolant, and the unit normals there."""
    from levelset import _extension

    grid = laid.grid
    places = three(grid, points)
    normals = np.zeros_like(places)
    size, pieces = split(len(places))
    share(
        _extension.land, pieces, thread_count(threads), size, laid.flat, laid.shape, laid.wraps,
        laid.gaps, REACH, places, normals,
    )  # fmt: skip
    own = slice(None, None, 1 if grid.ndim == 3 else 2)
    moved = np.array(grid.origin) + grid.spacing * places[:, own]
    return np.asarray(moved), np.ascontiguousarray(normals[:, own])
