"""What a recipe of surfaces is given, checked: its grid, surface, precision and states."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.nodal import check_level_set
from levelset.shape import Shape
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import precision
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
EDGE = 2  # spacings that a surface must begin away from the end of an unbounded axis


def check_grid(grid: Grid) -> None:
    """Refuse what is no grid."""
    if not isinstance(grid, Grid):
        raise InputError(
            f"grid must be a Grid, got {grid!r:.60}", hint="remesh.Grid((64, 64), 1/32)"
        )


def check_adaptive(mesh: object, recipe: str, either: str) -> None:
    """Refuse what is no adaptive mesh, and a cap on blocks; ``either`` takes grids as well."""
    if not isinstance(mesh, AdaptiveMesh):
        raise InputError(
            f"{recipe} needs an AdaptiveMesh, got {mesh!r:.60}", hint=f"{either}(grid=...)"
        )
    if mesh.most_blocks is not None:
        raise InputError(
            f"an interface is kept in bands, not in blocks, got most_blocks={mesh.most_blocks}",
            hint="AdaptiveMesh(..., most_blocks=None)",
        )


def level_set(surface: Shape | Array, grid: Grid) -> Array:
    """phi of a shape, its distance, or as given on the nodes, checked; at every node of the box.

    Refuses what is neither, another shape than the grid's, and values that are not finite.
    """
    if isinstance(surface, Shape):
        return surface.distance(grid.points())
    phi = np.asarray(surface)
    if phi.dtype.kind not in "fiu":
        raise InputError(
            f"a surface is a shape or numbers on the nodes of the grid, got {surface!r:.60}",
            hint="levelset.shapes.Sphere(1.0)",
        )
    return check_level_set(phi, grid)


def precision_asked(dtype: Any, values: NDArray[Any]) -> np.dtype[Any]:
    """The precision that was asked for, None for that of the values; refuses any other."""
    if dtype is None:
        return precision(values)
    name = str(getattr(dtype, "__name__", dtype))
    if name not in ("float32", "float64"):
        raise InputError(
            f"dtype must be 'float32' or 'float64', got {dtype!r}", hint="dtype='float64'"
        )
    return np.dtype(name)


def check_ends(distance: Array, grid: Grid) -> None:
    """Refuse a distance [L] on the nodes that falls below ``EDGE`` spacings at an unbounded end."""
    near = EDGE * grid.spacing
    for axis in range(grid.ndim):
        ends = np.take(distance, [0, -1], axis=axis)
        if not grid.periodic[axis] and (ends < near).any():
            raise InputError(
                f"the shape comes within {EDGE} spacings ({near:.3g}) of the end of the "
                f"box along axis {axis}",
                hint="a larger box, or a finer mesh; phi is negative inside",
            )


def check_state(state: Any, kind: type, mesh: Grid | AdaptiveMesh) -> None:
    """Refuse a state that is not of a kind, or that was made on another mesh."""
    if type(state) is not kind:
        raise InputError(
            f"the flow steps states of kind {kind.__name__}, got {type(state).__name__}",
            hint="the mesh that the state was made on, or flow.start(...)",
        )
    other: object = getattr(state, "mesh" if isinstance(mesh, AdaptiveMesh) else "grid")
    if other != mesh:
        names = [part.name for part in fields(mesh)
                 if getattr(mesh, part.name) != getattr(other, part.name)]  # fmt: skip
        raise InputError(
            f"the state's mesh differs from the flow's in {', '.join(names)}",
            hint="the mesh that the run began with, or flow.start(...)",
        )
