"""Pictures without OpenGL: the loop over pixels against its law, and what lies before what."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pmesh.cases._raster import nearest
from pmesh.cases.camera import aimed
from pmesh.cases.layer import Layer, Mesh
from pmesh.cases.plain import FINE, covered, draw

Values = NDArray[np.float64]


def seen(places: Values, faces: NDArray[np.int64], shape: tuple[int, int]) -> tuple[Values, ...]:
    near = np.zeros(shape, np.float32)
    which = np.full(shape, -1, np.int32)
    weights = np.zeros((*shape, 3), np.float32)
    nearest(places, faces, near, which, weights)
    return near, which, weights


def by_law(
    places: Values, faces: NDArray[np.int64], shape: tuple[int, int]
) -> tuple[Values, Values]:
    """Nearness and triangle of each pixel, from the barycentric coordinates of all triangles."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    pixels = np.stack([columns, rows, np.ones(shape)]).reshape(3, -1)
    near, which = np.zeros(pixels.shape[1]), np.full(pixels.shape[1], -1)
    for m, face in enumerate(faces):
        corners = places[face]
        part = np.linalg.solve(np.vstack([corners[:, :2].T, np.ones(3)]), pixels)
        here = np.where((part > -1e-6).all(axis=0), corners[:, 2] @ part, 0.0)
        which[here > near] = m
        near = np.maximum(near, here)
    return near.reshape(shape), which.reshape(shape)


def test_each_pixel_shows_its_nearest_triangle() -> None:
    rng = np.random.default_rng(4)
    places = rng.uniform((-8, -8, 0.1), (48, 38, 1), (60, 3))
    faces = rng.permutation(60).reshape(20, 3)
    near, which, _ = seen(places, faces, (30, 40))
    exact, told = by_law(places, faces, (30, 40))
    assert near == pytest.approx(exact, abs=1e-5)
    assert (which == told).mean() > 0.999
    assert (which < 0).any()


def test_neighbouring_triangles_leave_no_gap() -> None:
    rng = np.random.default_rng(5)
    x, y = np.meshgrid(np.linspace(0, 40, 9), np.linspace(0, 30, 9), indexing="ij")
    x[1:-1, 1:-1] += rng.uniform(-1.5, 1.5, (7, 7))
    y[1:-1, 1:-1] += rng.uniform(-1.5, 1.5, (7, 7))
    places = np.stack([x.ravel(), y.ravel(), np.ones(81)], axis=1)
    first = (9 * np.arange(8)[:, None] + np.arange(8)).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + 9], 1),
            np.stack([first + 1, first + 10, first + 9], 1),
        ]
    )
    assert (seen(places, faces, (31, 41))[1] >= 0).all()


def test_weights_find_the_point_in_space_again() -> None:
    """In perspective: the middle of an edge in the picture is not that in space."""
    points = np.array([[-1.0, 0.0, -1.0], [1.0, 3.0, -1.0], [0.0, 1.0, 1.5]])
    camera = aimed(points, (-90.0, 5.0), (60, 45))
    faces = np.array([[0, 1, 2]])
    near, which, weights = seen(camera.project(points), faces, (45, 60))
    rows, columns = np.nonzero(which >= 0)
    found = camera.project(weights[rows, columns].astype(float) @ points)
    assert len(rows) > 300
    assert found[:, 0] == pytest.approx(columns, abs=1e-3)
    assert found[:, 1] == pytest.approx(rows, abs=1e-3)
    assert found[:, 2] == pytest.approx(near[rows, columns], rel=1e-5)


def test_triangles_behind_the_eye_or_without_area_are_left_out() -> None:
    places = np.array([[0, 0, 1], [20, 0, 1], [0, 20, -1], [10, 0, 1]], float)
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 0, 1]])
    assert (seen(places, faces, (20, 20))[1] < 0).all()


def test_a_square_covers_a_quarter_of_one_twice_as_wide_and_y_is_up() -> None:
    points = np.array([[0, 0, 5], [2, 0, 5], [2, 2, 5], [0, 2, 5]], float)
    mesh = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), points, None)
    found, middle, half = covered([mesh], 100)
    assert found.mean() == pytest.approx(0.25)
    assert middle == pytest.approx([1, 1])
    assert half == 2
    corner = Mesh(points, np.array([[0, 1, 2], [0, 1, 2]]), points, None)  # below the diagonal
    rows, columns = np.nonzero(covered([corner], 100)[0])
    assert rows.mean() > 51
    assert columns.mean() > 51


def test_surfaces_hide_each_other_in_any_order_and_edges_behind_them() -> None:
    square = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], float)
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    normal = np.tile([0.0, -1.0, 0.0], (4, 1))
    front = Mesh(square, faces, normal, None)
    behind = front._replace(points=square + np.array([0.0, 1.0, 0.0]))
    red, blue = (Layer(surface=(), colour=c) for c in ("#ff0000", "#0000ff"))  # type: ignore[arg-type]
    camera = aimed(square * 1.2, (-90.0, 0.0), (60, 60))
    for y, hidden in ((0.5, True), (-0.5, False)):
        edges = np.array([[[-0.5, y, 0.0], [0.5, y, 0.0]]])
        one = draw([red, blue], [front, behind], camera, edges=edges)
        other = draw([blue, red], [behind, front], camera, edges=edges)
        assert np.array_equal(one, other)
        assert one[20, 30, 0] > one[20, 30, 2] + 100
        assert (one[29:31, 30, 1] < 5).all() == hidden  # the edges are grey, not red


def test_the_edge_of_a_surface_is_smooth() -> None:
    """A slanting edge goes through as many greys as there are fine pixels in one."""
    points = np.array([[-1, 0, -1], [1, 0, -0.8], [0, 0, 1.0]])
    mesh = Mesh(points, np.array([[0, 1, 2]]), np.tile([0.0, -1, 0], (3, 1)), None)
    layer = Layer(surface=(), colour="#000000")  # type: ignore[arg-type]
    image = draw([layer], [mesh], aimed(points, (-90.0, 0.0), (80, 60)))
    assert len(np.unique(image[..., 0])) == FINE**2 + 1
