"""Triangles and lines lie on the contour, are closed, and go around the inside."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.band import Band
from levelset.quadrature import area, volume
from levelset.shapes import Box, Disk, Sphere
from levelset.surface import contours, triangles
from remesh.errors import InputError, StorageError
from remesh.grid import Grid


def mesh(n, ndim, boundary="unbounded"):
    h = 3.1 / n
    return Grid((n,) * ndim, h, origin=(-1.55 + h / 2,) * ndim, boundary=boundary)


def torus(places):
    x, y, z = places
    return np.hypot(np.hypot(x - 0.013, y) - 1.0, z) - 0.4


def ellipse(places):
    x, y = places
    return np.exp((x - 0.013) ** 2 + (y / 0.6) ** 2 - 1.0) - 1.0


def test_vertices_are_of_order_four_and_triangles_of_order_two():
    errors = []
    for n in (24, 48, 96):
        grid = mesh(n, 3)
        phi = torus(grid.points())
        found = triangles(phi, grid)
        assert found.open_edges == 0
        off = np.abs(torus(found.vertices.T)).max()
        errors.append((off, abs(found.volume - volume(phi, grid)), found.area - area(phi, grid)))
    orders = np.log2(np.abs(np.array(errors[1]) / errors[2]))
    assert orders[0] > 3.5, (orders, errors)
    np.testing.assert_allclose(orders[1:], 2.0, atol=0.2)


def test_lines_are_of_order_four_closed_and_anticlockwise():
    errors = []
    for n in (32, 64, 128):
        (line,) = contours(ellipse(mesh(n, 2).points()), mesh(n, 2))
        np.testing.assert_array_equal(line[0], line[-1])
        errors.append(np.abs(ellipse(line.T)).max())
        x, y = line.T
        inside = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
        assert inside == pytest.approx(0.6 * np.pi, rel=10 / n**2)
    assert np.log2(errors[1] / errors[2]) > 3.5, errors


def test_holes_go_clockwise():
    grid = mesh(48, 2)
    phi = (Disk(1.0) - Disk(0.5)).distance(grid.points())
    areas = []
    for line in contours(phi, grid):
        x, y = line.T
        areas.append(0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    assert sorted(areas) == pytest.approx([-np.pi / 4, np.pi], rel=1e-2)


def test_normals_point_outward_and_faces_agree_with_them():
    grid = mesh(24, 3)
    found = triangles(Sphere(1.0).distance(grid.points()), grid)
    np.testing.assert_allclose(found.normals, found.vertices, atol=2e-3)
    a, b, c = (found.vertices[found.faces[:, k]] for k in range(3))
    faced = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.normals[found.faces[:, 0]])
    assert (faced > 0).all()
    assert found.volume == pytest.approx(4 / 3 * np.pi, rel=1e-2)


@pytest.mark.parametrize("shape", [Sphere(0.5), Box((1.0, 1.0, 1.0))])
def test_a_contour_through_nodes_is_closed_without_triangles_of_no_area(shape):
    grid = Grid((21, 21, 21), 0.1, origin=(-1.0, -1.0, -1.0))
    phi = shape.distance(grid.points())
    phi[np.abs(phi) < 1e-12] = 0.0
    assert (phi == 0).any()
    found = triangles(phi, grid)
    assert found.open_edges == 0
    a, b, c = (found.vertices[found.faces[:, k]] for k in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1e-9
    assert found.volume == pytest.approx(shape.volume, rel=0.06)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_band_draws_what_all_nodes_do(dtype):
    for grid, phi in (
        (mesh(24, 3), torus(mesh(24, 3).points())),
        (mesh(32, 2), ellipse(mesh(32, 2).points())),
    ):
        phi = phi.astype(dtype)
        nodes = np.flatnonzero(np.abs(phi) < (0.9 if grid.ndim == 3 else 2.5))
        band = Band(grid, nodes, phi.reshape(-1)[nodes])
        if grid.ndim == 3:
            np.testing.assert_array_equal(triangles(band).vertices, triangles(phi, grid).vertices)
            np.testing.assert_array_equal(triangles(band).faces, triangles(phi, grid).faces)
        else:
            np.testing.assert_array_equal(contours(band), contours(phi, grid))


def test_a_surface_that_leaves_the_box_is_open_and_has_no_volume():
    grid = Grid((12, 12, 12), 0.1)
    found = triangles(grid.points()[0] - 0.52, grid)
    assert found.open_edges == 44
    assert found.area == pytest.approx(1.21, rel=1e-6)
    with pytest.raises(InputError, match="a surface with 44 open edges has no volume"):
        _ = found.volume
    (line,) = contours(grid.points()[0, :, :, 0] - 0.52, Grid((12, 12), 0.1))
    assert line == pytest.approx(np.stack([np.full(12, 0.52), np.arange(12) / 10], axis=1))


def test_lines_go_on_to_a_periodic_seam():
    grid = mesh(30, 2, "periodic")
    phi = np.roll(Disk(1.0).distance(grid.points()), 15, 0)
    length = 0.0
    for line in contours(phi, grid):
        length += np.hypot(*np.diff(line, axis=0).T).sum()
    assert length == pytest.approx(2 * np.pi, rel=1e-2)


@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj", ".vtp"])
def test_files_hold_the_triangles(tmp_path, ending):
    import pyvista

    grid = mesh(16, 3)
    found = triangles(torus(grid.points()), grid)
    read = pyvista.read(found.save(tmp_path / f"torus{ending}"))
    assert read.n_cells == len(found.faces)
    assert read.is_manifold
    assert read.volume == pytest.approx(found.volume, rel=1e-5)


def test_bad_input_is_refused(tmp_path):
    plane, space = Grid((8, 9), 0.5), Grid((8, 9, 7), 0.5)
    line, wall = plane.points()[0] - 1.1, space.points()[0] - 1.1
    with pytest.raises(InputError, match="triangles are drawn in space"):
        triangles(line, plane)
    with pytest.raises(InputError, match="contours are drawn in the plane"):
        contours(wall, space)
    with pytest.raises(InputError, match="has no contour: it is nowhere negative"):
        contours(line + 9, plane)
    with pytest.raises(InputError, match="has no contour: it is negative"):
        triangles(wall - 9, space)
    with pytest.raises(InputError, match="needs its grid"):
        triangles(wall)
    with pytest.raises(InputError, match="phi must be finite"):
        triangles(wall * np.nan, space)
    found = triangles(wall, space)
    with pytest.raises(InputError, match="surfaces are written as"):
        found.save(tmp_path / "a.png")
    with pytest.raises(StorageError, match="there is no folder"):
        found.save(tmp_path / "none" / "a.stl")
