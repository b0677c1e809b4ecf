"""A swimmer's shape: inextensible, of constant area, its deformation without momentum."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pmesh.bodies import gait as gaits
from pmesh.bodies.gait import Gait, check, offsets, shape, straight
from pmesh.bodies.midline import ANGUILLIFORM, CARANGIFORM, CARLING, CSTART
from pmesh.bodies.outline import Drawn, Eel, Foil, Larva
from remesh.errors import InputError

GAITS = {
    "carling": Gait(midline=CARLING, outline=Eel()),
    "rigid": Gait(midline=CARLING, outline=Eel(), section="rigid"),
    "anguilliform": Gait(midline=ANGUILLIFORM, outline=Eel()),
    "carangiform": Gait(midline=CARANGIFORM, outline=Foil()),
    "cstart": Gait(midline=CSTART, outline=Larva()),
}
TIMES = [0.31, 0.93, 1.62, 4.17]


def polygon(ring):
    """Area and centroid of a closed line."""
    there = np.roll(ring, -1, axis=0)
    cross = ring[:, 0] * there[:, 1] - there[:, 0] * ring[:, 1]
    area = cross.sum() / 2
    return area, (cross[:, None] * (ring + there)).sum(axis=0) / (6 * area)


def integrals(body, section):
    """Area, momentum, angular momentum, inertia and source: points across, trapezia along."""
    x, w = np.polynomial.legendre.leggauss(6)
    rho = body.below[:, None] + (body.above - body.below)[:, None] * (x + 1) / 2
    kappa, spin = body.curvature[:, None], body.spin[:, None]
    area = (1 - kappa * rho) * (body.above - body.below)[:, None] / 2 * w
    swell = body.rate[:, None] * rho**2 / (2 * (1 - kappa * rho)) * (section == "incompressible")
    way = np.stack((np.cos(body.angle), np.sin(body.angle)))[..., None]
    normal = np.stack((-way[1], way[0]))
    place = body.place.T[..., None] + rho * normal
    velocity = body.velocity.T[..., None] - rho * spin * way + swell * normal
    source = -body.rate[:, None] * rho / (1 - kappa * rho) * (section == "rigid")
    turning = place[0] * velocity[1] - place[1] * velocity[0]
    terms = (np.ones_like(rho), *velocity, turning, (place**2).sum(axis=0), source)
    return [np.trapezoid((term * area).sum(axis=1), body.stations) for term in terms]


@pytest.mark.parametrize("name", GAITS)
def test_the_midline_keeps_its_length(name):
    fine = replace(GAITS[name], samples=4000)
    for time in TIMES:
        body = shape(fine, time)
        chord = np.linalg.norm(np.diff(body.place, axis=0), axis=1)
        bend = 0.5 * (body.curvature[1:] + body.curvature[:-1])
        arc = chord * (1 + (bend * np.diff(body.stations)) ** 2 / 24)  # of a circle, to order 4
        assert arc.sum() == pytest.approx(1.0, abs=1e-10)


@pytest.mark.parametrize("name", GAITS)
def test_the_area_is_constant_and_its_centre_the_origin(name):
    fine = replace(GAITS[name], samples=4000)
    for time in TIMES:
        area, center = polygon(shape(fine, time).ring)
        assert area == pytest.approx(straight(fine)[0], rel=2e-6)
        assert center == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("name", GAITS)
@pytest.mark.parametrize("time", TIMES)
def test_the_deformation_has_no_momentum_and_no_angular_momentum(name, time):
    fine = replace(GAITS[name], samples=4000)
    body = shape(fine, time)
    area, *momentum, angular, inertia, source = integrals(body, fine.section)
    speed = np.abs(body.velocity).max()
    assert area == pytest.approx(straight(fine)[0], rel=1e-5)
    assert inertia == pytest.approx(body.inertia, rel=1e-5)
    assert momentum == pytest.approx([0.0, 0.0], abs=2e-6 * area * speed)
    assert angular == pytest.approx(0.0, abs=1e-5 * inertia)
    assert source == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("name", GAITS)
@pytest.mark.parametrize("time", TIMES)
def test_the_velocity_is_the_rate_of_the_shape(name, time):
    step = 5e-4
    near = [shape(GAITS[name], time + n * step) for n in (-2, -1, 1, 2)]
    body = shape(GAITS[name], time)

    def rate(field):
        one, two, three, four = (getattr(b, field) for b in near)
        return (one - 8 * two + 8 * three - four) / (12 * step)

    assert rate("place") == pytest.approx(body.velocity - body.drift, abs=1e-8)
    assert rate("angle") == pytest.approx(body.spin, abs=1e-8)


def test_only_a_rigid_section_moves_its_centre_without_momentum():
    soft, rigid = shape(GAITS["carling"], 1.62), shape(GAITS["rigid"], 1.62)
    assert soft.drift == (0.0, 0.0)
    assert 1e-4 < math.hypot(*rigid.drift) < 1e-2
    assert np.abs(soft.ring - rigid.ring).max() < 2e-3  # the shapes differ by kappa w^2 / 2


def test_an_incompressible_section_keeps_the_area_of_each_side():
    kappa, width = np.array([-4.0, 0.0, 3.0]), np.array([0.03, 0.04, 0.05])
    low, high = offsets("incompressible", kappa, width)
    assert high - kappa * high**2 / 2 == pytest.approx(width)
    assert low - kappa * low**2 / 2 == pytest.approx(-width)


@pytest.mark.parametrize("name", ["carling", "anguilliform", "carangiform"])
def test_half_a_period_later_the_shape_is_the_mirror_image(name):
    gait = GAITS[name]
    turns = []
    for time in (1.07, 1.31, 6.4):
        one, two = shape(gait, time), shape(gait, time + 0.5)
        turns.append(0.5 * (one.turn + two.turn))
        for now, sign in ((one, 1.0), (two, -1.0)):
            c, s = math.cos(now.turn), math.sin(now.turn)
            seen = now.place @ np.array([[c, s], [-s, c]]) * [1.0, sign]
            if sign > 0:
                first = seen
        assert seen == pytest.approx(first, abs=1e-12)
        assert shape(gait, time + 1.0).turn == pytest.approx(one.turn, abs=1e-10)
    assert turns == pytest.approx([turns[0]] * 3, abs=1e-10)


@pytest.mark.parametrize("name", ["carling", "anguilliform", "carangiform"])
def test_the_midline_is_the_lateral_displacement_asked_for(name):
    gait, time = GAITS[name], 1.37
    body = shape(gait, time)
    c, s = math.cos(body.turn), math.sin(body.turn)
    seen = body.place @ np.array([[c, s], [-s, c]])
    y = gait.midline.lateral(body.stations, time)
    assert seen[:, 1] - seen[0, 1] == pytest.approx(y - y[0], abs=1e-12)
    assert (np.diff(seen[:, 0]) > 0).all()


def test_the_turn_is_the_integral_of_its_rate_and_the_same_in_any_order():
    gait = replace(GAITS["cstart"], samples=101)
    late = shape(gait, 7.3).turn
    gaits._turning.cache_clear()
    gaits.shape.cache_clear()
    assert shape(gait, 7.3).turn == late
    times = np.linspace(0.0, 0.7, 71)  # the first stage: smooth
    spins = [gaits._moments(gait, gaits._raw(gait, float(t))).spin for t in times]
    from scipy.interpolate import CubicSpline

    turns = CubicSpline(times, spins).antiderivative()(times)
    assert [shape(gait, float(t)).turn for t in times] == pytest.approx(turns, abs=1e-7)


def test_before_the_start_it_rests():
    body = shape(replace(GAITS["carling"], midline=replace(CARLING, ramp="sine")), -0.3)
    assert not body.velocity.any()
    assert not body.spin.any()
    assert not body.place[:, 1].any()


def test_a_body_that_would_fold_is_refused():
    thick = Drawn(places=(0.0, 0.5, 1.0), half_widths=(0.0, 0.2, 0.0))
    with pytest.raises(InputError, match=r"folds at s = 0\.\d+ L"):
        check(Gait(midline=CARLING, outline=thick))
