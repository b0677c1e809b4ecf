"""Solids inside triangles: distances against a search of all triangles, files, exact measures."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from levelset.measure import measure
from levelset.shapes import Box, Sphere, Torus, TriangleMesh
from levelset.triangle_mesh import merged
from remesh.errors import InputError

CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-0.5, 0.5) for z in (-1.5, 1.5)])
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACES = np.array([t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))])
BOX = TriangleMesh(CORNERS, FACES)


def ring(around, across, radius=1.0, tube=0.4):
    """A torus of triangles, vertices on the true one."""
    u, v = np.meshgrid(
        2 * np.pi * np.arange(around) / around,
        2 * np.pi * np.arange(across) / across,
        indexing="ij",
    )
    r = radius + tube * np.cos(v)
    vertices = np.stack([r * np.cos(u), r * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.indices((around, across))
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return vertices, faces


def plain_distance(mesh, points):
    """All triangles: planes, sides and corners; the sign by the solid angle of the surface."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]][None] for k in range(3))
    p = points.T[:, None]
    normal = np.cross(b - a, c - a)
    normal = normal / np.linalg.norm(normal, axis=2, keepdims=True)
    inside = np.ones(np.broadcast_shapes(p.shape, a.shape)[:2], bool)
    near = np.full(inside.shape, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        side, arm = v - u, p - u
        inside &= np.sum(np.cross(side, arm) * normal, axis=2) >= 0
        share = np.clip(np.sum(arm * side, axis=2) / np.sum(side * side, axis=2), 0, 1)
        near = np.minimum(near, np.linalg.norm(arm - share[..., None] * side, axis=2))
    near = np.where(inside, np.abs(np.sum((p - a) * normal, axis=2)), near)
    x, y, z = a - p, b - p, c - p
    la, lb, lc = (np.linalg.norm(w, axis=2) for w in (x, y, z))
    up = np.sum(x * np.cross(y, z), axis=2)
    down = la * lb * lc + lc * (x * y).sum(2) + la * (y * z).sum(2) + lb * (z * x).sum(2)
    turns = 2 * np.arctan2(up, down).sum(axis=1) / (4 * np.pi)
    return np.where(turns > 0.5, -1, 1) * near.min(axis=1)


def rough(seed):
    """A ring whose vertices are shaken: edges and corners of all kinds."""
    vertices, faces = ring(17, 9)
    return TriangleMesh(
        vertices + np.random.default_rng(seed).normal(0, 0.05, vertices.shape), faces
    )


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_distance_through_the_tree_is_that_of_all_triangles(dtype):
    mesh = rough(1)
    points = np.random.default_rng(2).uniform(-1.8, 1.8, (3, 20, 100)).astype(dtype)
    found = mesh.distance(points)
    assert found.dtype == dtype
    true = plain_distance(mesh, points.reshape(3, -1).astype(float)).reshape(20, 100)
    assert found == pytest.approx(true, abs=1e-12 if dtype == np.float64 else 1e-6)


def test_points_nearest_to_edges_and_corners_are_on_the_right_side():
    """Stepped off vertices and middles of edges to all sides."""
    mesh = rough(3)
    rng = np.random.default_rng(4)
    corners = mesh.vertices[mesh.faces]
    middles = 0.5 * (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)
    for places in (mesh.vertices, middles):
        points = (places + 1e-3 * rng.normal(size=places.shape)).T
        assert mesh.distance(points) == pytest.approx(plain_distance(mesh, points), abs=1e-12)


def spike(slivers):
    """A thin pyramid on three corners, its tip up; one side is a fan of slivers around the tip."""
    turn = 2 * np.pi * np.arange(3) / 3
    base = np.stack([0.2 * np.cos(turn), 0.2 * np.sin(turn), 0 * turn], axis=1)
    share = np.arange(1, slivers)[:, None] / slivers
    vertices = np.concatenate([base, [(0, 0, 2.0)], base[0] + share * (base[1] - base[0])])
    line = [0, *range(4, 3 + slivers), 1]
    sides = [(a, b, 3) for a, b in pairwise(line)]
    floor = [(b, a, 2) for a, b in pairwise(line)]
    return TriangleMesh(vertices, [*sides, *floor, (1, 2, 3), (2, 0, 3)])


@pytest.mark.parametrize("slivers", [1, 2, 50])
def test_sharp_edges_and_tips_are_seen_from_outside_on_all_sides(slivers):
    """Where the normal of one nearest face, or a plain mean of many, would look away."""
    mesh = spike(slivers)
    rng = np.random.default_rng(4)
    points = rng.uniform(-0.4, 0.4, (3, 3000)) + np.array([[0], [0], [1.0]]) * rng.uniform(
        0, 2, 3000
    )
    assert mesh.distance(points) == pytest.approx(plain_distance(mesh, points), abs=1e-12)
    faces = np.cross(
        *(mesh.vertices[mesh.faces[:, k]] - mesh.vertices[mesh.faces[:, 0]] for k in (1, 2))
    )
    faces = faces[mesh.faces[:, 2] == 3]
    faces /= np.linalg.norm(faces, axis=1, keepdims=True)
    away = (rng.exponential(size=(1000, len(faces))) ** 4) @ faces  # all are nearest to the tip
    found = mesh.distance((mesh.vertices[3] + 0.1 * away).T)
    assert found == pytest.approx(np.linalg.norm(0.1 * away, axis=1), rel=1e-12)


def test_a_box_of_triangles_is_a_box():
    plain = Box((2.0, 1.0, 3.0))
    points = np.random.default_rng(2).uniform(-3, 3, (3, 2000))
    assert BOX.distance(points) == pytest.approx(plain.distance(points), abs=1e-14)
    assert BOX.bounds() == plain.bounds()
    assert BOX.surface == pytest.approx(plain.surface, rel=1e-15)
    found, true = measure(BOX.moved((1, 2, 3))), measure(plain.moved((1, 2, 3)))
    assert found.volume == pytest.approx(true.volume, rel=1e-14)
    assert found.center == pytest.approx(true.center, rel=1e-14)
    assert found.inertia == pytest.approx(true.inertia, rel=1e-14)


def test_a_fine_ring_tends_to_the_torus_with_the_square_of_its_sides():
    torus = Torus(1.0, 0.4)
    points = np.random.default_rng(2).uniform(-1.6, 1.6, (3, 3000))
    off, lost = [], []
    for n in (40, 80):
        mesh = TriangleMesh(*ring(2 * n, n))
        off.append(np.abs(mesh.distance(points) - torus.distance(points)).max())
        lost.append(1 - mesh.volume / torus.volume)
    assert 2**1.8 < off[0] / off[1] < 2**2.2
    assert 2**1.9 < lost[0] / lost[1] < 2**2.1


def test_threads_do_not_change_a_bit():
    import numba

    mesh, points = rough(1), np.random.default_rng(2).uniform(-1.8, 1.8, (3, 5000))
    kept = numba.get_num_threads()
    one = mesh.distance(points)
    numba.set_num_threads(1)
    try:
        assert np.array_equal(mesh.distance(points), one)
    finally:
        numba.set_num_threads(kept)


def test_faces_may_go_either_way_round_and_holes_and_parts_are_kept():
    inward = TriangleMesh(CORNERS, FACES[:, ::-1])
    points = np.random.default_rng(2).uniform(-3, 3, (3, 500))
    assert inward.distance(points) == pytest.approx(BOX.distance(points), abs=1e-14)
    vertices = np.concatenate(
        [CORNERS, 0.5 * CORNERS, 0.2 * CORNERS, CORNERS + np.array((9, 0, 0))]
    )
    faces = np.concatenate([FACES, FACES[:, ::-1] + 8, FACES + 16, FACES + 24])
    nested = TriangleMesh(vertices, faces)
    assert nested.volume == pytest.approx(6 * (1 - 0.5**3 + 0.2**3 + 1))
    probes = np.array([[0.0, 0.0, 0.0, 9.0], [0.0, 0.2, 0.4, 0.0], [0.0, 0.0, 0.0, 0.0]])
    assert np.array_equal(np.sign(nested.distance(probes)), [-1, 1, -1, -1])


def test_parts_that_touch_in_a_vertex_keep_their_own_corners():
    vertices = np.concatenate([CORNERS, -CORNERS[:-1] + 2 * CORNERS[-1]])
    second = np.where(FACES == 7, 7, FACES + 8)[:, ::-1]  # the mirror image in the last corner
    mesh = TriangleMesh(vertices, second.tolist() + FACES.tolist())
    points = np.random.default_rng(2).uniform(-3, 5, (3, 2000))
    both = Box((2, 1, 3)) | Box((2, 1, 3), center=(2, 1, 3))
    assert mesh.distance(points) == pytest.approx(both.distance(points), abs=1e-14)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_files_are_read_back(tmp_path, suffix):
    import pyvista

    vertices, faces = ring(12, 8)
    mesh = TriangleMesh(vertices.astype(np.float32), faces)
    path = tmp_path / f"ring.{suffix}"
    pyvista.PolyData.from_regular_faces(mesh.vertices.astype(np.float32), mesh.faces).save(path)
    found = TriangleMesh.from_file(path)
    assert len(found.faces) == len(faces)
    assert len(found.vertices) == len(vertices)
    points = np.random.default_rng(2).uniform(-1.6, 1.6, (3, 300))
    assert found.distance(points) == pytest.approx(mesh.distance(points), abs=1e-6)
    double = TriangleMesh.from_file(str(path), scale=2.0)
    assert double.volume == pytest.approx(8 * found.volume)


def test_a_face_of_four_corners_is_split(tmp_path):
    path = tmp_path / "box.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS]
    lines += ["f " + " ".join(str(k + 1) for k in square) for square in SQUARES]
    path.write_text("\n".join(lines) + "\n")
    found = TriangleMesh.from_file(path)
    assert len(found.faces) == 12
    assert found.volume == pytest.approx(6.0)


def test_vertices_a_little_apart_are_merged_when_asked():
    """A soup of triangles whose corners are shaken by 1e-7."""
    vertices, faces = ring(12, 8)
    soup = vertices[faces].reshape(-1, 3)
    loose = soup + np.random.default_rng(1).uniform(-1e-7, 1e-7, soup.shape)
    numbers = np.arange(len(soup)).reshape(-1, 3)
    assert len(merged(soup, numbers, 0.0)[0]) == len(vertices)
    with pytest.raises(InputError, match="not watertight"):
        TriangleMesh(*merged(loose, numbers, 0.0))
    mesh = TriangleMesh(*merged(loose, numbers, 1e-6))
    assert len(mesh.vertices) == len(vertices)
    assert mesh.volume == pytest.approx(TriangleMesh(vertices, faces).volume, rel=1e-5)


def test_slivers_without_a_third_corner_are_dropped_on_reading():
    places, faces = merged(CORNERS, [*FACES.tolist(), [0, 0, 1]], 0.0)
    assert len(faces) == 12
    assert TriangleMesh(places, faces).volume == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("none.stl", None, "no such file"),
        ("body.txt", "hello", "is not an STL, OBJ or PLY file"),
        ("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n", "open.obj"),
        ("empty.obj", "v 0 0 0\n", r"empty\.obj holds no triangles"),
        ("junk.stl", "no mesh\n" * 30, r"junk\.stl holds no triangles"),
        ("junk.ply", "no mesh\n" * 30, r"junk\.ply holds no triangles"),
    ],
)
def test_files_without_a_solid_are_refused_by_name_in_our_words_only(
    tmp_path, name, text, said, capfd, caplog
):
    from vtkmodules.vtkCommonCore import vtkObject

    if text is not None:
        (tmp_path / name).write_text(text)
    shown = vtkObject.GetGlobalWarningDisplay()
    with pytest.raises(InputError, match=said):
        TriangleMesh.from_file(tmp_path / name)
    assert capfd.readouterr() == ("", "")
    assert not caplog.records
    assert vtkObject.GetGlobalWarningDisplay() == shown


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan, math.inf])
def test_a_scale_that_is_not_positive_is_refused(tmp_path, scale):
    import pyvista

    path = tmp_path / "box.stl"
    pyvista.PolyData.from_regular_faces(CORNERS, FACES).save(path)
    with pytest.raises(InputError, match="scale must be positive"):
        TriangleMesh.from_file(path, scale=scale)


def test_an_open_file_says_how_many_edges_are_open(tmp_path):
    import pyvista

    path = tmp_path / "open.stl"
    pyvista.PolyData.from_regular_faces(CORNERS, FACES[1:]).save(path)
    with pytest.raises(InputError, match=r"open\.stl: .* not watertight: 3 of 18 edges"):
        TriangleMesh.from_file(path)


def test_meshes_of_equal_numbers_are_equal_and_told_shortly():
    same = TriangleMesh(CORNERS.tolist(), FACES.tolist())
    assert same == BOX
    assert hash(same) == hash(BOX)
    assert same != TriangleMesh(2 * CORNERS, FACES)
    assert repr(BOX).startswith("TriangleMesh(8 vertices, 12 faces, sha256 ")
    with pytest.raises(ValueError, match="read-only"):
        BOX.vertices[0, 0] = 1.0


def test_a_ball_of_triangles_is_near_the_ball():
    import pyvista

    poly = pyvista.Icosphere(radius=0.5, nsub=4)
    mesh = TriangleMesh(*merged(poly.points, poly.regular_faces, 1e-6))
    points = np.random.default_rng(2).uniform(-1, 1, (3, 2000))
    assert mesh.distance(points) == pytest.approx(Sphere(0.5).distance(points), abs=2e-3)
    assert mesh.volume == pytest.approx(math.pi / 6, rel=5e-3)
