"""Surfaces that part no inside from an outside are refused, each with what was found."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.closed import closed
from remesh.errors import InputError

CORNERS = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
TWO = np.concatenate([CORNERS, CORNERS + np.array((5, 0, 0))])
INNER = np.concatenate([CORNERS, 0.25 + 0.1 * (CORNERS - 0.25)])


def turned(faces, *which):
    faces = faces.copy()
    for k in which:
        faces[k] = faces[k, ::-1]
    return faces


def test_a_tetrahedron_is_closed_and_looks_outward():
    for faces in (FACES, FACES[:, ::-1]):
        places, triangles, ids = closed(CORNERS, faces)
        a, b, c = places[triangles].transpose(1, 0, 2)
        assert np.all(np.sum(np.cross(b - a, c - a) * (a - places.mean(axis=0)), axis=1) > 0)
        assert len(np.unique(ids)) == 4


@pytest.mark.parametrize(
    ("vertices", "faces", "said"),
    [
        (CORNERS, FACES[:3], r"faces must have shape \(n, 3\) with n >= 4, got \(3, 3\)"),
        (
            TWO,
            np.concatenate([FACES, FACES[1:] + 4]),
            "not watertight: 3 of 12 edges belong to one",
        ),
        (CORNERS, turned(FACES, 2), "turned against their neighbours at 3 of 6 edges"),
        (CORNERS, np.concatenate([FACES, FACES]), "6 of 6 edges belong to more than two triangles"),
        (CORNERS * (1, 1, 0), FACES, "2 of 4 triangles have no area, first face 1"),
        (
            [*CORNERS[:3], (0.3, 0.3, 0.0)],
            FACES,
            "4 triangles enclose no volume",
        ),
        (
            CORNERS,
            np.concatenate([FACES, [[0, 0, 1]]]),
            "1 triangles have a vertex twice, .* face 4",
        ),
        (CORNERS[:, :2], FACES, r"vertices must have shape \(n, 3\) .* got \(4, 2\)"),
        (CORNERS + np.inf, FACES, "vertices are not finite"),
        (CORNERS, FACES + 1, "faces must hold whole numbers from 0 to 3"),
        (CORNERS, FACES + 0.5, "faces must hold whole numbers from 0 to 3"),
        ("body", FACES, "vertices must be"),
        (
            TWO,
            np.concatenate([FACES, FACES[:, ::-1] + 4]),
            "part 1 of 2 looks inward and has 0 other",
        ),
        (
            INNER,
            np.concatenate([FACES, FACES + 4]),
            "part 1 of 2 looks outward and has 1 other parts",
        ),
    ],
)
def test_what_does_not_close_around_a_solid_is_refused(vertices, faces, said):
    with pytest.raises(InputError, match=said):
        closed(vertices, faces)


def test_every_refusal_says_what_to_do():
    with pytest.raises(InputError, match="try: close the surface"):
        closed(TWO, np.concatenate([FACES, FACES[1:] + 4]))


def test_a_vertex_that_two_parts_share_counts_once_for_each():
    mirror = np.where(FACES == 0, 0, FACES + 3)[:, ::-1]
    vertices = np.concatenate([CORNERS, -CORNERS[1:]])
    _, _, ids = closed(vertices, np.concatenate([FACES, mirror]))
    assert len(np.unique(ids)) == 8
