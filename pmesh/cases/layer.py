"""A surface to be drawn, and how it looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

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


def mesh_of(layer: Layer) -> Any:
    """The surface as VTK takes it: with point normals, and with "values" if it has some."""
    import pyvista

    surface: Any = layer.surface
    if not hasattr(surface, "vertices"):
        return _contour(surface[0], surface[1], layer.values)
    vertices = np.asarray(surface.vertices, np.float64)
    faces = np.asarray(surface.faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError(
            f"vertices must have shape (n, 3) and faces (m, 3), got {vertices.shape} and "
            f"{faces.shape}",
            hint="render((phi, grid))",
        )
    if not len(faces):
        raise InputError("the surface has no triangles", hint="a level set with both signs")
    if not np.isfinite(vertices).all():
        raise InputError("vertices must be finite", hint="check the level set they come from")
    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    normals = getattr(surface, "normals", None)
    if normals is None:
        mesh = mesh.compute_normals(cell_normals=False, split_vertices=False)
    else:
        mesh.point_data["Normals"] = np.asarray(normals, np.float64)
        _mend_normals(mesh)
    if layer.values is not None:
        values = np.asarray(layer.values)
        if values.shape != (len(vertices),):
            raise InputError(
                f"values must have shape ({len(vertices)},), got {values.shape}",
                hint="one value per vertex",
            )
        mesh.point_data["values"] = values
    return mesh


def _contour(phi: Array, grid: Grid, values: Array | None) -> Any:
    """The zero contour of a level set, normals from its gradient."""
    import pyvista

    phi = np.asarray(phi)
    for name, field in (("phi", phi), ("values", phi if values is None else np.asarray(values))):
        if grid.ndim != 3 or field.shape != grid.shape:
            raise InputError(
                f"{name} must have the shape of a grid in space, {grid.shape}, got {field.shape}",
                hint="render((phi, grid)) with nodal values",
            )
    if not np.isfinite(phi).all():
        raise InputError("phi must be finite", hint="fill the nodes beyond the band")
    image = pyvista.ImageData(
        dimensions=grid.shape, spacing=(grid.spacing,) * 3, origin=grid.origin
    )
    image.point_data["phi"] = phi.ravel(order="F")
    if values is not None:
        image.point_data["values"] = np.asarray(values).ravel(order="F")
    mesh = image.contour([0.0], scalars="phi", method="contour", compute_normals=True)
    if not mesh.n_cells:
        raise InputError("the level set has no zero contour", hint="a phi of both signs")
    _mend_normals(mesh)
    return mesh


def _mend_normals(mesh: Any) -> None:
    """Go over to the triangles' normals where those of the gradient differ from them.

    So they do in sheets of a cell or two, which differences reach across; elsewhere they are
    smoother.
    """
    options = {"cell_normals": False, "split_vertices": False, "consistent_normals": False}
    smooth = np.array(mesh.point_data.pop("Normals"))  # VTK would pass them on as they are
    flat = mesh.compute_normals(**options).point_data["Normals"]
    cosine = (flat * smooth).sum(axis=1, keepdims=True)
    trust = np.clip((cosine - DIFFER) / (AGREE - DIFFER), 0.0, 1.0)
    both = flat + trust * (smooth - flat)
    mesh.point_data["Normals"] = both / np.linalg.norm(both, axis=1, keepdims=True)
    mesh.point_data.active_normals_name = "Normals"
