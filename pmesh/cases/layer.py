"""A surface to be drawn, and how it looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
DIFFER, AGREE = 0.8, 0.95  # cosines between two normals of one point
STEEL, COPPER, SAGE, PLUM = "#5b9bd5", "#d98850", "#7fb89a", "#9b7fc0"


class Triangles(Protocol):
    """A triangle surface; if it has ``normals`` (n, 3), they are used."""

    @property
    def vertices(self) -> NDArray[Any]:
        """Points (n, 3) [L]."""

    @property
    def faces(self) -> NDArray[Any]:
        """Three indices of vertices each (m, 3)."""


Surface = Triangles | tuple[Array, Grid]


@dataclass(frozen=True, kw_only=True)
class Layer:
    """A surface and how it looks: one colour, or values in a map of colours."""

    surface: Surface  # triangles, or (phi, grid): the zero contour of a level set
    colour: str = STEEL
    opacity: float = 1.0
    values: Array | None = None  # per vertex (n,), or of grid.shape for (phi, grid)
    colours: str = "viridis"  # Matplotlib's name of the map of ``values``
    limits: tuple[float, float] | None = None  # of the map; those of the values if None


class Mesh(NamedTuple):
    """Triangles ready to be lit."""

    points: NDArray[np.float64]  # (n, 3) [L]
    faces: NDArray[np.int64]  # (m, 3)
    normals: NDArray[np.float64]  # (n, 3), unit
    values: NDArray[np.float64] | None  # (n,)


def mesh_of(layer: Layer) -> Mesh:
    """The triangles of a layer, with normals that light falls well on."""
    surface: Any = layer.surface
    if not hasattr(surface, "vertices"):
        return _contour(surface[0], surface[1], layer.values)
    points = np.ascontiguousarray(surface.vertices, np.float64)
    faces = np.ascontiguousarray(surface.faces)
    if points.ndim != 2 or points.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError(
            f"vertices must have shape (n, 3) and faces (m, 3), got {points.shape} and "
            f"{faces.shape}",
            hint="render((phi, grid))",
        )
    if not len(faces):
        raise InputError("the surface has no triangles", hint="a level set with both signs")
    if faces.dtype.kind not in "iu" or faces.min() < 0 or faces.max() >= len(points):
        raise InputError(
            f"faces must be places in {len(points)} vertices, got {faces.dtype} from "
            f"{faces.min()} to {faces.max()}",
            hint="count vertices from 0",
        )
    if not np.isfinite(points).all():
        raise InputError("vertices must be finite", hint="check the level set they come from")
    values = None if layer.values is None else np.asarray(layer.values, np.float64)
    if values is not None and values.shape != (len(points),):
        raise InputError(
            f"values must have shape ({len(points)},), got {values.shape}",
            hint="one value per vertex",
        )
    faces = faces.astype(np.int64)
    normals = getattr(surface, "normals", None)
    if normals is None:
        return Mesh(points, faces, _smooth(points, faces), values)
    return Mesh(points, faces, _mended(points, faces, np.asarray(normals, np.float64)), values)


def _contour(phi: Array, grid: Grid, values: Array | None) -> Mesh:
    """The zero contour of a level set, normals from its gradient."""
    from levelset.extension import values_at
    from levelset.surface import triangles

    phi = np.asarray(phi)
    for name, field in (("phi", phi), ("values", phi if values is None else np.asarray(values))):
        if grid.ndim != 3 or field.shape != grid.shape:
            raise InputError(
                f"{name} must have the shape of a grid in space, {grid.shape}, got {field.shape}",
                hint="render((phi, grid)) with nodal values",
            )
    found = triangles(phi, grid)
    points, faces = found.vertices, found.faces
    mesh = Mesh(points, faces, _mended(points, faces, found.normals), None)
    if values is None:
        return mesh
    known: Any = values_at(np.asarray(values, np.float64), points, grid)
    return mesh._replace(values=known)


def _smooth(points: Any, faces: Any) -> NDArray[np.float64]:
    """Normals at the points of triangles of any sense, turned to agree with their neighbours."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(points, faces)
    told = mesh.compute_normals(cell_normals=False, split_vertices=False)
    return np.asarray(told.point_data["Normals"], np.float64)


def _mended(
    points: Array, faces: NDArray[np.int64], smooth: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Go over to the triangles' normals where those of the gradient differ from them.

    So they do in sheets of a cell or two, which differences reach across; elsewhere they are
    smoother.
    """
    a, b, c = (points[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)  # twice the area: large triangles count for more
    total = np.zeros_like(smooth)
    for axis in range(3):
        part = np.repeat(across[:, axis], 3)
        total[:, axis] = np.bincount(faces.ravel(), part, minlength=len(points))
    flat = _unit(total)
    cosine = (flat * smooth).sum(axis=1, keepdims=True)
    trust = np.clip((cosine - DIFFER) / (AGREE - DIFFER), 0.0, 1.0)
    return _unit(flat + trust * (smooth - flat))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-300))
