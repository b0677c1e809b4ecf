"""The triangulated surface of a swimmer in space."""

import math

import numpy as np
import pytest

from levelset.triangle_mesh import TriangleMesh
from pmesh.bodies.gait import Gait, shape, straight
from pmesh.bodies.hull import hull
from pmesh.bodies.midline import CARLING
from pmesh.bodies.outline import Eel, Foil
from pmesh.bodies.profile import Arch

FISH = Gait(midline=CARLING, outline=Eel(exponent=2.0), profile=Arch(), samples=200)


@pytest.mark.parametrize("outline", [Eel(exponent=2.0), Foil()])
@pytest.mark.parametrize("middle", [0.5, 0.51])
def test_the_surface_is_closed_and_holds_the_body(outline, middle):
    """With a tail that ends in a point and with one that ends in an edge."""
    gait = Gait(midline=CARLING, outline=outline, profile=Arch(middle=middle), samples=200)
    around = 128
    solid = TriangleMesh(*hull(gait, shape(gait, 1.3), around))  # refuses what is not closed
    corners = around / (2 * math.pi) * math.sin(2 * math.pi / around)  # of an ellipse, by its area
    assert solid.volume == pytest.approx(corners * straight(gait)[0], rel=2e-4)


def test_it_is_seen_anticlockwise_from_outside():
    vertices, faces = hull(FISH, shape(FISH, 0.0))
    a, b, c = vertices[faces.T]
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0
