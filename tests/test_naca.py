"""The four-digit aerofoil: its digits mean what the report says, its distance is one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.measure import measure
from levelset.naca import Naca
from levelset.polygon import Polygon
from remesh.errors import InputError

FOILS = {
    "symmetric": Naca("0012"),
    "cambered": Naca("2412", chord=2.0, center=(0.3, -0.1)),
    "thick": Naca("9640"),
    "blunt": Naca("4415", closed=False),
}


def half_thickness(x, thickness):
    """NACA Report 460: ordinates of the basic thickness form over the chord."""
    terms = (0.29690 * np.sqrt(x), -0.12600 * x, -0.35160 * x**2, 0.28430 * x**3, -0.10150 * x**4)
    return thickness / 0.20 * sum(terms)


@pytest.mark.parametrize("name", FOILS)
def test_the_distance_is_that_to_a_dense_polygon_of_the_edge(name):
    foil = FOILS[name]
    lower, upper = (np.array(corner)[:, None] for corner in foil.bounds())
    share = np.random.default_rng(5).uniform(-0.3, 1.3, (2, 400))
    points = lower + (upper - lower) * share
    edge = Polygon.__new__(Polygon)  # without the check of crossings: it has 8000 sides
    object.__setattr__(edge, "corners", tuple(map(tuple, foil.outline(8000).tolist())))
    assert foil.distance(points) == pytest.approx(edge.distance(points), abs=1e-5 * foil.chord)


@pytest.mark.parametrize("name", FOILS)
def test_the_distance_has_a_unit_gradient_and_is_lipschitz_one(name):
    foil = FOILS[name]
    points = np.random.default_rng(6).uniform(-1.2, 1.2, (2, 3000)) * np.array([[1.0], [0.4]])
    step = 1e-6
    shifts = step * np.eye(2)[:, :, None]
    slopes = np.stack([foil.distance(points + s) - foil.distance(points - s) for s in shifts])
    slope = np.sqrt(np.sum(slopes**2, axis=0)) / (2 * step)
    assert slope.max() < 1.0 + 1e-6
    assert np.mean(np.abs(slope - 1.0) < 1e-6) > 0.99


def test_the_edge_of_a_symmetric_foil_has_the_published_ordinates():
    foil = Naca("0012", closed=False)
    x = np.linspace(0.0, 1.0, 101)[:-1]
    y = half_thickness(x, 0.12)
    for side in (y, -y):
        assert foil.distance(np.stack([x - 0.5, side])) == pytest.approx(0.0, abs=1e-12)
    at_30 = foil.distance(np.array([[-0.2, -0.2], [0.061, 0.059]]))  # thickest at 30 % of the chord
    assert at_30[0] > 0 > at_30[1]
    # Report 460 lists 6.002 % at 30 % of the chord and 0.126 % at the trailing edge
    assert half_thickness(np.array([0.3, 1.0]), 0.12) == pytest.approx([0.06002, 0.00126], abs=5e-6)


def test_the_nose_has_the_published_radius():
    """1.1019 t^2 (Report 460): a disk of it meets the nose to third order."""
    radius = 1.1019 * 0.2**2
    nose = radius * np.array([1.0 - math.cos(0.1), math.sin(0.1)])
    foil = Naca("0020")
    assert foil.distance(np.array([-0.5 - 0.25, 0.0])) == pytest.approx(0.25, abs=1e-12)
    assert foil.distance(nose - (0.5, 0.0)) == pytest.approx(0.0, abs=0.005 * radius)


def test_thickness_is_laid_off_at_right_angles_to_a_mean_line_of_two_parabolas():
    foil, camber, place = Naca("4415"), 0.04, 0.4
    for x in (0.2, 0.4, 0.7):
        span = place if x < place else 1.0 - place
        line = camber - camber * ((x - place) / span) ** 2
        slope = 2.0 * camber / span**2 * (place - x)
        normal = np.array([-slope, 1.0]) / math.hypot(slope, 1.0)
        half = half_thickness(np.array(x), 0.15) - 0.15 / 0.2 * 0.0021 * x**4  # closed: -0.1036
        for sign in (1.0, -1.0):
            point = np.array([x - 0.5, line]) + sign * half * normal
            assert foil.distance(point) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", FOILS)
def test_the_area_is_that_inside_the_edge(name):
    foil = FOILS[name]
    assert foil.volume == pytest.approx(measure(foil).volume, rel=1e-6)


def test_a_closed_trailing_edge_is_sharp_and_an_open_one_is_blunt():
    above = np.array([0.5 + 1e-4, 1.0e-3])
    assert Naca("0012", closed=False).distance(above) == pytest.approx(1e-4, rel=1e-9)
    assert Naca("0012").distance(above) == pytest.approx(math.hypot(*(above - (0.5, 0))), rel=2e-2)
    inside = np.array([0.5 - 1e-4, 0.0])
    assert Naca("0012", closed=False).distance(inside) == pytest.approx(-1e-4, rel=1e-6)


def test_a_mirrored_camberless_foil_is_itself_and_camber_is_upward():
    points = np.random.default_rng(2).uniform(-0.7, 0.7, (2, 500))
    foil = Naca("0018")
    assert foil.distance(points) == pytest.approx(foil.distance(points * [[1], [-1]]), abs=1e-14)
    assert measure(Naca("4412")).center[1] > 0.02


@pytest.mark.parametrize("name", FOILS)
def test_chord_and_centre_scale_and_shift_and_the_bounds_hold(name):
    foil = FOILS[name]
    unit = Naca(foil.digits, closed=foil.closed)
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (2, 500))
    seen = (points - np.array(foil.center)[:, None]) / foil.chord
    assert foil.distance(points) == pytest.approx(foil.chord * unit.distance(seen), abs=1e-13)
    lower, upper = (np.array(corner) for corner in foil.bounds())
    edge = foil.outline(3000)
    assert np.all(edge >= lower)
    assert np.all(edge <= upper)
    assert foil.distance(edge.T) == pytest.approx(0.0, abs=1e-11)


def test_single_precision_stays_single_and_agrees():
    points = np.random.default_rng(3).uniform(-1, 1, (2, 9, 7))
    single = FOILS["cambered"].distance(points.astype(np.float32))
    assert single.dtype == np.float32
    assert single.shape == (9, 7)
    assert single == pytest.approx(FOILS["cambered"].distance(points), abs=2e-6)


@pytest.mark.parametrize(
    ("digits", "said"),
    [
        ("241", "must be four digits, got '241'"),
        ("24a2", "must be four digits"),
        (2412, "must be four digits, got 2412"),
        ("2400", "has no thickness"),
        ("2012", "camber at the nose"),
    ],
)
def test_what_are_not_the_digits_of_an_aerofoil_is_refused(digits, said):
    with pytest.raises(InputError, match=said):
        Naca(digits)
    with pytest.raises(InputError, match="chord must be a positive length"):
        Naca("0012", chord=0.0)
