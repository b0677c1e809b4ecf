"""Whether triangles close around a solid: what is open, crossed, turned or flat is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]
Indices = NDArray[np.int64]
REPAIR = "close the surface in the program that made it, or from_file(..., merge=1e-6)"
SHELLS = 64  # parts whose turn is checked against the others, at most


def closed(vertices: ArrayLike, faces: ArrayLike) -> tuple[Values, Indices, Indices]:
    """Checked vertices, faces that look outward, and ids (m, 3) of corners.

    An id stands for a vertex and one round of triangles about it: where two rounds touch in one
    vertex each has its own. Refuses what does not part an inside from an outside.
    """
    places, triangles = _arrays(vertices, faces)
    here, there = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    twins = _twins(here, there, len(places))
    _refuse_flat(places[triangles])
    ids = _rounds(triangles, twins)
    shells = _parts(twins // 3, len(triangles))
    corners = places[triangles]
    corners -= corners.mean(axis=(0, 1))
    six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    if six.sum() < 0.0:
        triangles, ids, six = triangles[:, ::-1].copy(), ids[:, ::-1].copy(), -six
        corners = corners[:, ::-1]
    _refuse_turned_parts(corners, np.bincount(shells, six), shells)
    if abs(six.sum()) <= 1e-14 * np.abs(six).sum():
        raise InputError(
            f"TriangleMesh: its {len(six)} triangles enclose no volume", hint="a solid's surface"
        )
    return places, triangles, ids


def _arrays(vertices: ArrayLike, faces: ArrayLike) -> tuple[Values, Indices]:
    """Vertices (n, 3) and faces (m, 3), copied; refuses other shapes, and strangers."""
    try:
        places = np.array(vertices, np.float64)
        given: NDArray[Any] = np.array(faces)
        triangles = given.astype(np.int64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "TriangleMesh: vertices must be (n, 3) numbers and faces (m, 3) whole numbers",
            hint="TriangleMesh.from_file('body.stl')",
        ) from error
    for name, values in (("vertices", places), ("faces", triangles)):
        if values.ndim != 2 or values.shape[1] != 3 or len(values) < 4:
            raise InputError(
                f"TriangleMesh: {name} must have shape (n, 3) with n >= 4, got {values.shape}",
                hint="a tetrahedron has 4 vertices and 4 faces",
            )
    if not np.isfinite(places).all():
        count = int((~np.isfinite(places)).any(axis=1).sum())
        raise InputError(f"TriangleMesh: {count} vertices are not finite", hint="check the file")
    if (triangles != given).any() or triangles.min() < 0 or triangles.max() >= len(places):
        raise InputError(
            f"TriangleMesh: faces must hold whole numbers from 0 to {len(places) - 1}",
            hint="three numbers of vertices each",
        )
    return places, triangles


def _twins(here: Indices, there: Indices, count: int) -> Indices:
    """For each half edge 3 f + k (corner k to k + 1 of face f) the one that runs back along it."""
    low, high = np.minimum(here, there), np.maximum(here, there)
    if (low == high).any():
        faces = np.flatnonzero((low == high).reshape(-1, 3).any(axis=1))
        raise InputError(
            f"TriangleMesh: {len(faces)} triangles have a vertex twice, first face {faces[0]}",
            hint="leave them out",
        )
    _, edge, times = np.unique(low * count + high, return_inverse=True, return_counts=True)
    open_edges, crowded = int((times == 1).sum()), int((times > 2).sum())
    if open_edges:
        raise InputError(
            f"TriangleMesh: the surface is not watertight: {open_edges} of {len(times)} edges "
            "belong to one triangle only",
            hint=REPAIR,
        )
    if crowded:
        raise InputError(
            f"TriangleMesh: {crowded} of {len(times)} edges belong to more than two triangles",
            hint="separate parts that touch along an edge, remove double or inner triangles",
        )
    first, second = np.argsort(edge, kind="stable").reshape(-1, 2).T
    turned = int((here[first] == here[second]).sum())
    if turned:
        raise InputError(
            f"TriangleMesh: triangles are turned against their neighbours at {turned} of "
            f"{len(times)} edges",
            hint="pyvista.PolyData.compute_normals(consistent_normals=True) turns them alike",
        )
    twins = np.empty(len(here), np.int64)
    twins[first], twins[second] = second, first
    return twins


def _refuse_flat(corners: Values) -> None:
    """Refuse triangles whose area is nothing beside their longest side."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = (sides**2).sum(axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    flat = np.flatnonzero(area <= 1e-12 * longest)
    if flat.size:
        raise InputError(
            f"TriangleMesh: {flat.size} of {len(corners)} triangles have no area, "
            f"first face {flat[0]}",
            hint="mesh the surface anew, or from_file(..., merge=1e-6)",
        )


def _rounds(triangles: Indices, twins: Indices) -> Indices:
    """Ids (m, 3): corners joined across edges are one."""
    half = np.arange(triangles.size)
    following = half - half % 3 + (half + 1) % 3
    # edge k runs from corner k to the next one; its twin from that back
    links = (
        np.concatenate([half, following]),
        np.concatenate([twins - twins % 3 + (twins + 1) % 3, twins]),
    )
    return _components(*links, triangles.size).reshape(-1, 3)


def _parts(across: Indices, count: int) -> Indices:
    """The number of each triangle's connected part."""
    return _components(np.arange(3 * count) // 3, across, count)


def _components(first: Indices, second: Indices, count: int) -> Indices:
    """Numbers of connected components."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], np.int64)


def _refuse_turned_parts(corners: Values, six: NDArray[Any], shells: Indices) -> None:
    """Refuse parts that look inward though nothing is around them, or outward inside another."""
    if not 1 < len(six) <= SHELLS:
        return
    for k, volume in enumerate(six):
        probe = corners[shells == k][0, 0]
        around = round(_turns(corners[shells != k] - probe))
        if around != (0 if volume > 0 else 1):
            found = "inward" if volume < 0 else "outward"
            raise InputError(
                f"TriangleMesh: part {k} of {len(six)} looks {found} and has {around} other parts "
                "around it",
                hint="turn the part, or join parts that overlap by a union of meshes",
            )


def _turns(seen: Values) -> float:
    """How often a surface goes around 0: its solid angle over 4 pi (van Oosterom, Strackee)."""
    a, b, c = seen.transpose(1, 0, 2)
    la, lb, lc = np.linalg.norm(seen, axis=2).T
    up = np.einsum("ij,ij->i", a, np.cross(b, c))
    down = la * lb * lc + lc * (a * b).sum(1) + la * (b * c).sum(1) + lb * (c * a).sum(1)
    return float(2.0 * np.arctan2(up, down).sum() / (4.0 * np.pi))
