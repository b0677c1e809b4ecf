"""Torus knots: writhe, handedness, direction of travel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import TorusKnot
from remesh.errors import InputError


def writhe(knot, count=400):
    """Gauss's double integral over a polygon of the centre line, by the solid angles of its pairs.

    Exact for a polygon. Source: K. Klenin, J. Langowski, Biopolymers 54 (2000) 307, method 1a.
    """
    line = knot.filaments()[0].nodes
    corners = line[np.linspace(0, len(line), count, endpoint=False).astype(int)]
    i, j = np.triu_indices(count, 2)
    keep = ~((i == 0) & (j == count - 1))
    i, j = i[keep], j[keep]
    p1, p2 = corners[i], corners[(i + 1) % count]
    p3, p4 = corners[j], corners[(j + 1) % count]
    faces = [np.cross(p3 - p1, p4 - p1), np.cross(p4 - p1, p4 - p2)]
    faces += [np.cross(p4 - p2, p3 - p2), np.cross(p3 - p2, p3 - p1)]
    faces = [f / np.maximum(np.linalg.norm(f, axis=1, keepdims=True), 1e-300) for f in faces]
    angle = np.zeros(len(i))
    for one, other in zip(faces, [*faces[1:], faces[0]], strict=True):
        angle += np.arcsin(np.clip(np.sum(one * other, axis=1), -1.0, 1.0))
    sign = np.sign(np.sum(np.cross(p4 - p3, p2 - p1) * (p3 - p1), axis=1))
    return float(np.sum(angle * sign) / (2.0 * math.pi))


@pytest.mark.parametrize("turns", [(2, 3), (3, 2)])
def test_the_helicity_of_a_thin_knot_is_its_writhe(turns):
    thin = TorusKnot(turns=turns, core=0.03, circulation=2.0)
    assert thin.helicity == pytest.approx(4.0 * writhe(thin), rel=1e-3)


def test_a_trefoil_writhes_by_about_three_crossings():
    assert 3.0 < writhe(TorusKnot()) < 4.0
    assert 3.0 < TorusKnot(core=0.05).helicity < 4.0


def test_a_mirrored_knot_has_the_opposite_helicity_and_the_same_energy():
    right, left = TorusKnot(), TorusKnot(right_handed=False)
    assert right.helicity > 0.0
    assert left.helicity == pytest.approx(-right.helicity)
    assert left.energy == pytest.approx(right.energy)


def test_a_knot_moves_along_its_axis_wherever_that_points():
    upright, tilted = TorusKnot(), TorusKnot(axis=(2.0, -1.0, 2.0), center=(3.0, 1.0, 0.0))
    # r^2 dangle/2, p turns: the mean of r^2 is R^2 + b^2/2
    assert upright.impulse == pytest.approx([0.0, 0.0, 2.0 * math.pi * (1.0 + 0.5 * 0.16)])
    assert tilted.impulse == pytest.approx(upright.impulse[2] * np.array([2.0, -1.0, 2.0]) / 3.0)
    assert tilted.energy == pytest.approx(upright.energy)


@pytest.mark.parametrize(
    "bad", [{"turns": (2, 4)}, {"turns": (0, 1)}, {"turns": (2.5, 3)}, {"tube": 1.0}, {"core": -1}]
)
def test_knots_that_cannot_be_are_refused(bad):
    with pytest.raises(InputError):
        TorusKnot(**bad)
