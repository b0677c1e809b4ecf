"""The solid inside a closed surface of triangles, with its exact signed distance."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from levelset.closed import closed
from levelset.shape import Array, Bounds, Moments, Shape
from remesh.errors import InputError
from remesh.layout import split
from remesh.threads import share, thread_count

Values = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class TriangleMesh(Shape):
    """The inside of a closed, oriented surface of triangles; either way round, parts and holes.

    ``vertices`` (n, 3) [L]; ``faces`` (m, 3): three vertices each, in one sense around the solid.
    Exact to rounding: the nearest triangle is found through a tree of boxes, about log m of them
    per point. Inside or outside is told by the angle-weighted normal of the face, edge or corner
    that is nearest. Volume, centre and inertia are exact. Refuses open edges, edges of more than
    two triangles, triangles turned against their neighbours or without area, and parts turned
    against each other. That the surface does not cross itself is not checked.

    Source: J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243.
    """

    vertices: Values
    faces: Indices

    def __post_init__(self) -> None:
        """Refuse a surface that does not part an inside from an outside."""
        vertices, faces, corners = closed(self.vertices, self.faces)
        for name, values in (("vertices", vertices), ("faces", faces), ("_ids", corners)):
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        digest = hashlib.sha256(vertices.tobytes() + faces.tobytes()).digest()
        object.__setattr__(self, "_digest", digest)

    @classmethod
    def from_file(cls, path: str | Path, *, scale: float = 1.0, merge: float = 0.0) -> TriangleMesh:
        """The solid in an STL, OBJ or PLY file, read by PyVista; faces of more corners are split.

        ``scale``: [L] per unit of the file. Vertices at the same place become one, with ``merge``
        > 0 also those that many units of the file apart or less; triangles that lose a corner by
        that are dropped. Refuses files that cannot be read or hold no triangles, a scale that is
        not positive, and what `TriangleMesh` refuses.
        """
        if not 0.0 < scale < math.inf:
            raise InputError(f"scale must be positive, got {scale:g}",
                             hint="scale=0.001 for a file in millimetres")  # fmt: skip
        vertices, faces = _read(Path(path), merge)
        try:
            return cls(scale * vertices, faces)
        except InputError as error:
            raise InputError(f"{path}: {error.problem}", hint=error.hint) from error

    def __eq__(self, other: object) -> bool:
        """Meshes of the same numbers are equal."""
        return isinstance(other, TriangleMesh) and self._key == other._key

    def __hash__(self) -> int:
        """Equal meshes have equal hashes."""
        return hash(self._key)

    def __repr__(self) -> str:
        """How many vertices and faces, and a digest of them."""
        told = f"{len(self.vertices)} vertices, {len(self.faces)} faces"
        return f"TriangleMesh({told}, sha256 {self._key.hex()[:12]})"

    @property
    def _key(self) -> bytes:
        return self.__dict__["_digest"]  # type: ignore[no-any-return]

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    @property
    def volume(self) -> float:
        """The sum of signed tetrahedra: exact."""
        return self._moments()[0]

    @property
    def surface(self) -> float:
        """Area of all triangles."""
        a, b, c = self._corners()
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def bounds(self) -> Bounds:
        """The box around the vertices."""
        used = self.vertices[self.faces]
        low, high = used.min(axis=(0, 1)), used.max(axis=(0, 1))
        return tuple(low.tolist()), tuple(high.tolist())

    def _corners(self) -> Values:
        """Corners (3, m, 3) of the triangles."""
        return self.vertices[self.faces.T]

    def _moments(self) -> Moments:
        corners = self._corners()
        middle = corners.mean(axis=(0, 1))
        a, b, c = corners - middle
        six = np.einsum("ij,ij->i", a, np.cross(b, c))
        volume = six.sum() / 6
        arm = (six @ (a + b + c)) / 24 / volume
        squares = sum(
            (p * q).sum(axis=1) for p, q in ((a, a), (b, b), (c, c), (a, b), (b, c), (c, a))
        )
        inertia = six @ squares / 60 - volume * (arm @ arm)
        return float(volume), tuple((middle + arm).tolist()), float(inertia)

    @cached_property
    def _tree(self) -> _Tree:
        from levelset._triangles import LEAF, build

        corners = np.ascontiguousarray(self._corners().transpose(1, 0, 2))
        levels = 0
        while LEAF << levels < len(corners):
            levels += 1
        order, boxes = np.empty(len(corners), np.int64), np.empty(((2 << levels) - 1, 6))
        build(corners, order, boxes)
        normals = _normals(corners, self.__dict__["_ids"])
        corners, normals = corners[order], normals[order]
        heights = np.einsum("ij,ij->i", normals[:, 0], corners[:, 0])
        return _Tree(corners, np.column_stack([normals[:, 0], heights]), normals, boxes)

    def _distance(self, points: Array) -> Array:
        from levelset._triangles import curve, distances

        places = np.ascontiguousarray(points.reshape(3, -1).T, np.float64)
        codes = np.empty(len(places), np.int32)
        box = np.ravel(self.reach(0.5 * max(np.subtract(*self.bounds()[::-1]))))
        curve(places, box, codes)
        order = np.argsort(codes, kind="stable")  # neighbours share triangles, and the cache
        piece, pieces = split(len(places))
        found, out = np.empty((2, len(places)))
        share(distances, pieces, thread_count(None), piece, places[order], *self._tree, found)
        out[order] = found
        return out.reshape(points.shape[1:])


class _Tree(NamedTuple):
    """Triangles in the order of the tree."""

    corners: Values  # (m, 3, 3)
    planes: Values  # (m, 4): unit normal, height over 0
    normals: Values  # (m, 7, 3): of faces, edges and corners
    boxes: Values  # (nodes, 6)


def _normals(corners: Values, ids: Indices) -> Values:
    """Normals (m, 7, 3) of faces, edges 01, 12, 20 and corners, weighted by angles."""
    sides = np.roll(corners, -1, axis=1) - corners
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    face = np.cross(sides[:, 0], sides[:, 1])
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    normals = np.empty((len(corners), 7, 3))
    normals[:, 0] = face
    keys = np.sort(np.stack([ids, np.roll(ids, -1, axis=1)]), axis=0)
    _, edges = np.unique(keys[0] * (ids.max() + 1) + keys[1], return_inverse=True)
    edges = edges.reshape(ids.shape)
    back = -np.roll(sides, 1, axis=1)
    cross = np.linalg.norm(np.cross(sides, back), axis=2)
    angles = np.arctan2(cross, np.einsum("ijk,ijk->ij", sides, back))
    for axis in range(3):
        part = np.repeat(face[:, axis], 3).reshape(-1, 3)
        normals[:, 1:4, axis] = np.bincount(edges.ravel(), part.ravel())[edges]
        normals[:, 4:7, axis] = np.bincount(ids.ravel(), (angles * part).ravel())[ids]
    return normals


def _read(path: Path, merge: float) -> tuple[Values, Indices]:
    """Vertices and triangles of a file, vertices at one place made one."""
    if path.suffix.lower() not in (".stl", ".obj", ".ply"):
        raise InputError(
            f"{path} is not an STL, OBJ or PLY file", hint="a file named .stl, .obj or .ply"
        )
    if not path.is_file():
        raise InputError(f"cannot read {path}: no such file", hint="the path of an STL file")
    import pyvista

    try:
        with _quiet():
            surface: Any = pyvista.read(path).triangulate()
        vertices = np.asarray(surface.points, np.float64)
        faces = np.asarray(surface.regular_faces, np.int64).reshape(-1, 3)
    except (OSError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise InputError(f"cannot read {path}: {error}", hint="a surface of triangles") from error
    if not len(faces):
        raise InputError(f"{path} holds no triangles", hint="a surface as STL, OBJ or PLY")
    return merged(vertices, faces, merge)


@contextmanager
def _quiet() -> Iterator[None]:
    """VTK says nothing inside: what it could not read is refused in our own words."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkObject

    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.GlobalWarningDisplayOff()
    try:
        with pyvista.vtk_verbosity("off"):
            yield
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)


def merged(vertices: ArrayLike, faces: ArrayLike, tolerance: float) -> tuple[Values, Indices]:
    """Vertices at one place, or no further apart than a tolerance, made one; slivers dropped."""
    places, triangles = np.asarray(vertices, np.float64), np.asarray(faces, np.int64)
    places, same = np.unique(places, axis=0, return_inverse=True)
    triangles = same.reshape(-1)[triangles]
    if tolerance > 0 and len(places):
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components
        from scipy.spatial import KDTree

        pairs = KDTree(places).query_pairs(tolerance, output_type="ndarray")
        links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(places),) * 2)
        _, label = connected_components(links, directed=False)
        _, first = np.unique(label, return_index=True)
        places, triangles = places[first], label.astype(np.int64)[triangles]
    a, b, c = triangles.T
    return places, triangles[(a != b) & (b != c) & (c != a)]
