"""Surfaces made ready for light: their normals, their values, whole and closed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from levelset.surface import triangles
from pmesh.cases.layer import Layer, mesh_of
from remesh.grid import Grid

GRID = Grid((33, 33, 33), 1 / 16, (-1.0, -1.0, -1.0))


def ball() -> Any:
    return np.sqrt((GRID.points() ** 2).sum(axis=0)) - 0.6


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_level_set_is_drawn_on_its_triangles(dtype: type) -> None:
    phi = ball().astype(dtype)
    mesh, surface = mesh_of(Layer(surface=(phi, GRID))), triangles(phi, GRID)
    assert np.array_equal(mesh.points, surface.vertices)
    assert np.array_equal(mesh.faces, surface.faces)
    assert surface.open_edges == 0
    assert mesh.normals == pytest.approx(mesh.points / 0.6, abs=5e-3)


def test_values_are_those_at_the_points() -> None:
    x, y, z = GRID.points()
    mesh = mesh_of(Layer(surface=(ball(), GRID), values=x + 2 * y * z))
    exact = mesh.points[:, 0] + 2 * mesh.points[:, 1] * mesh.points[:, 2]
    assert mesh.values == pytest.approx(exact, abs=1e-12)


def test_normals_that_differ_from_the_triangles_give_way_to_those() -> None:
    """Half of them turned around: light would fall on the wrong side."""
    surface: Any = triangles(ball(), GRID)
    turned = np.where(surface.vertices[:, :1] > 0, -1.0, 1.0) * surface.normals
    object.__setattr__(surface, "normals", turned)
    mesh = mesh_of(Layer(surface=surface))
    assert ((mesh.normals * mesh.points).sum(axis=1) > 0.58).all()
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0)


def test_triangles_of_any_sense_get_normals_that_agree() -> None:
    surface = triangles(ball(), GRID)

    class Mixed:
        vertices = surface.vertices
        faces = np.where(np.arange(len(surface.faces))[:, None] % 2, surface.faces[:, ::-1],
                         surface.faces)  # fmt: skip

    mesh = mesh_of(Layer(surface=Mixed()))
    side = (mesh.normals * mesh.points).sum(axis=1)
    assert abs(np.sign(side).sum()) == len(side)
    assert abs(side).min() > 0.55
