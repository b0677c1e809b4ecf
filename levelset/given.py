"""What a recipe of surfaces is given: its grid, its surface and its precision, checked."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.nodal import check_level_set
from levelset.shape import Shape
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import precision

Array = NDArray[np.floating[Any]]


def check_grid(grid: Grid) -> None:
    """Refuse what is no grid."""
    if not isinstance(grid, Grid):
        raise InputError(
            f"grid must be a Grid, got {grid!r:.60}", hint="remesh.Grid((64, 64), 1/32)"
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
