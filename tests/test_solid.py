"""The distance to bodies with elliptic sections: straight, and bent."""

from dataclasses import replace

import numpy as np
import pytest

from levelset.ellipse import Ellipse
from levelset.triangle_mesh import TriangleMesh
from pmesh.bodies._solid import ellipse
from pmesh.bodies.gait import Gait, shape
from pmesh.bodies.hull import hull
from pmesh.bodies.midline import CARLING
from pmesh.bodies.outline import Eel
from pmesh.bodies.profile import Arch
from pmesh.bodies.solid import table
from pmesh.bodies.swimmer import Swimmer
from remesh.errors import InputError

FISH = Swimmer.carling(ndim=3)


def fine_surface(time):
    """A triangulated surface within 2e-5 L of the smooth one."""
    gait = Gait(midline=CARLING, outline=Eel(exponent=2.0), profile=Arch(), samples=400)
    return TriangleMesh(*hull(gait, shape(gait, time), 192))


@pytest.mark.parametrize("axes", [(0.04, 0.08), (0.08, 0.04), (0.001, 0.03), (0.05, 0.05)])
def test_the_distance_to_an_ellipse_is_exact(axes):
    places = np.concatenate((np.random.default_rng(0).random((2, 300)) * 0.1, np.zeros((2, 3))), 1)
    places[0, -2] = places[1, -1] = 0.02
    exact = Ellipse(axes=axes).distance(places)
    found = [ellipse(y, z, *axes) for y, z in places.T]
    assert found == pytest.approx(exact, abs=1e-9)


def test_a_section_without_width_is_an_upright_line():
    assert ellipse(0.03, 0.06, 0.0, 0.02) == pytest.approx(0.05)
    assert ellipse(0.03, 0.01, 0.0, 0.02) == pytest.approx(0.03)
    assert ellipse(0.03, 0.04, 0.0, 0.0) == pytest.approx(0.05)


def test_the_table_tells_the_distance_of_the_straight_body():
    told, exact = table(FISH.gait), fine_surface(0.0)
    i, j, k = (np.random.default_rng(1).integers(0, n, 4000) for n in told.values.shape)
    steps = np.array(told.steps)[:, None]
    points = np.stack((i, j, k)) * steps + np.array([[told.first - 0.4343692072], [0.0], [0.0]])
    assert told.values[i, j, k] == pytest.approx(exact.distance(points), abs=1e-4)


@pytest.mark.parametrize("time", [0.0, 1.1, 1.35, 1.6, 1.85])
def test_points_of_the_bent_surface_are_near_zero(time):
    pose = replace(FISH.start(), time=time)
    vertices, _ = FISH.surface(pose, 128)
    found = FISH.distance(vertices.T, pose)
    assert np.abs(found).max() <= 7e-4
    assert np.sqrt(np.mean(found**2)) <= 5e-5


@pytest.mark.parametrize("time", [1.1, 1.6])
def test_the_distance_is_that_to_a_triangulated_surface(time):
    pose = replace(FISH.start(), time=time)
    low, high = (np.array(corner)[:, None] for corner in FISH.bounds(pose))
    points = low - 0.06 + (high - low + 0.12) * np.random.default_rng(2).random((3, 6000))
    exact = fine_surface(time).distance(points)
    error = FISH.distance(points, pose) - exact
    for least, most, allowed in ((-0.02, 0, 2e-3), (0, 0.05, 5e-4), (0.05, 0.08, 2e-3)):
        band = (exact > least) & (exact <= most)
        assert np.abs(error[band]).max() <= allowed
        assert np.sqrt(np.mean(error[band] ** 2)) <= 1e-4
    far = exact > 0.08
    assert np.abs(error[far] / exact[far]).max() <= 0.1
    assert np.array_equal(exact > 0, exact + error > 0)


def test_a_plane_body_has_no_table():
    with pytest.raises(InputError, match="no height"):
        table(Swimmer.carling().gait)
