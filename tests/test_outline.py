"""Outlines: half-widths of published swimmers, of foils and of one's own."""

import math

import numpy as np
import pytest

from pmesh.bodies.gait import Gait, straight
from pmesh.bodies.midline import CARLING
from pmesh.bodies.outline import Drawn, Eel, Foil, Larva
from remesh.errors import InputError

LAWS = [Eel(), Eel(exponent=2.0), Larva(), Foil(), Foil(thickness=0.2)]


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_outlines_are_closed_at_both_ends_and_wide_between(law):
    s = np.linspace(0.0, 1.0, 4001)
    w = law.half_width(s)
    assert w[0] == 0.0
    assert abs(w[-1]) <= 1e-12
    assert (w[1:-1] > 0).all()
    assert np.abs(np.diff(w))[50:].max() < 1e-3  # no jumps


def test_the_eel_has_the_published_half_widths():
    s = np.array([0.01, 0.02, 0.03, 0.98, 0.99])
    published = [0.026457513110645904, 0.034641016151377546, 0.03872983346207417, 0.004, 0.002]
    assert Eel().half_width(s) == pytest.approx(published, rel=1e-12)
    middle = 0.5 * (0.04 + 0.95)
    assert Eel().half_width(np.array([middle]))[0] == pytest.approx(0.025)
    assert Eel(exponent=2.0).half_width(np.array([middle]))[0] == pytest.approx(0.04 - 0.03 / 4)


def test_the_eel_has_the_exact_area_centre_and_polar_moment():
    area, middle, inertia = straight(Gait(midline=CARLING, outline=Eel()))
    exact = 2 * (math.pi * 0.04**2 / 4 + 0.91 * 0.025 + 0.05 * 0.01 / 2)
    assert area == pytest.approx(exact, rel=1e-13)
    assert area == pytest.approx(0.0485132741, abs=1e-10)
    assert middle == pytest.approx(0.3900623, abs=5e-8)
    assert inertia == pytest.approx(0.0032910, abs=5e-8)


def test_the_foil_has_the_area_of_its_polynomial():
    area, _, _ = straight(Gait(midline=CARLING, outline=Foil(thickness=0.12)))
    terms = 0.2969 * 2 / 3 - 0.1260 / 2 - 0.3516 / 3 + 0.2843 / 4 - 0.1036 / 5
    assert area == pytest.approx(2 * 5 * 0.12 * terms, rel=1e-12)


def test_the_larva_has_its_widths_where_they_are_given():
    law = Larva()
    given = law.half_width(np.array([law.shoulder, law.body]))
    assert given == pytest.approx([0.0635, 0.0254], rel=1e-12)


def test_a_drawn_outline_of_an_ellipse_is_that_ellipse():
    places = tuple(0.5 - 0.5 * np.cos(np.linspace(0, math.pi, 41)))
    law = Drawn(
        places=places, half_widths=(0, *(0.1 * np.sin(np.linspace(0, math.pi, 41)))[1:-1], 0)
    )
    s = np.linspace(0, 1, 301)
    assert law.half_width(s) == pytest.approx(0.2 * np.sqrt(s * (1 - s)), abs=1e-4)
    area, middle, _ = straight(Gait(midline=CARLING, outline=law))
    assert area == pytest.approx(math.pi * 0.5 * 0.1, rel=1e-3)
    assert middle == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Eel(head=0.0), "head"),
        (lambda: Eel(peduncle=1.2), "peduncle"),
        (lambda: Foil(thickness=0.0), "thickness"),
        (lambda: Drawn(places=(0, 1), half_widths=(0, 0)), "places"),
        (lambda: Drawn(places=(0, 0.6, 0.5, 1), half_widths=(0, 0.1, 0.1, 0)), "rise"),
        (lambda: Drawn(places=(0, 0.5, 1), half_widths=(0, -0.1, 0)), "positive"),
        (lambda: Drawn(places=(0, 0.5, 1), half_widths=(0, 0.1, 0.1)), "zero at both ends"),
    ],
)
def test_outlines_that_are_none_are_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()
