"""Midlines: curvature laws and their rates, amplitudes, ramps, stages."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pmesh.bodies.midline import (
    ANGUILLIFORM,
    CARANGIFORM,
    CARLING,
    CSTART,
    Bends,
    Curved,
    Stage,
    Wave,
    ramp,
)
from remesh.errors import InputError

S = np.linspace(0.0, 1.0, 101)
LAWS = {
    "carling": CARLING,
    "sine": replace(CARLING, ramp="sine"),
    "anguilliform": ANGUILLIFORM,
    "carangiform": CARANGIFORM,
    "cstart": CSTART,
    "own": Curved(law=lambda s, t: 2 * s * np.cos(2 * math.pi * (s - t))),
}


def rate_of(law, time, step=2e-4):
    """Difference of order four of what a law gives."""
    before = [law(time + n * step) for n in (-2, -1, 1, 2)]
    return (before[0] - 8 * before[1] + 8 * before[2] - before[3]) / (12 * step)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("time", [0.31, 1.23, 2.87])
def test_rates_are_derivatives_in_time(name, time):
    law = LAWS[name]
    told = law.bending(S, time)
    assert told.rate == pytest.approx(
        rate_of(lambda t: law.bending(S, t).curvature, time), abs=1e-7
    )
    assert told.head_rate == pytest.approx(
        rate_of(lambda t: law.bending(S, t).head, time), abs=1e-9
    )


@pytest.mark.parametrize("name", LAWS)
def test_laws_repeat_every_period_once_they_have_settled(name):
    law = LAWS[name]
    last = max(law.times)
    one, two = law.bending(S, last + 0.37), law.bending(S, last + 3.37)
    assert one.curvature == pytest.approx(two.curvature, abs=1e-10)
    assert one.rate == pytest.approx(two.rate, abs=1e-8)


@pytest.mark.parametrize(
    ("law", "head", "tail"),
    [
        (CARLING, 0.125 * 0.03125 / 1.03125, 0.125),
        (ANGUILLIFORM, 0.025, 0.125),
        (CARANGIFORM, 0.02, 0.1),
    ],
)
def test_waves_have_the_published_amplitudes(law, head, tail):
    times = 1.0 + np.linspace(0, 1, 401)
    swing = np.array([law.lateral(np.array([0.0, 1.0]), float(t)) for t in times])
    assert np.abs(swing).max(axis=0) == pytest.approx([head, tail], rel=1e-4)


def test_the_wave_runs_from_head_to_tail():
    s, time = np.array([0.4]), 1.3
    ahead = CARLING.lateral(s + 0.01, time + 0.01) / np.polyval(CARLING.amplitude[::-1], s + 0.01)
    assert ahead == pytest.approx(CARLING.lateral(s, time) / np.polyval(CARLING.amplitude[::-1], s))


@pytest.mark.parametrize("law", [CARLING, ANGUILLIFORM, CARANGIFORM])
def test_the_curvature_is_that_of_the_lateral_displacement(law):
    time, h = 1.37, 1e-3
    slope = (law.lateral(S + h, time) - law.lateral(S - h, time)) / (2 * h)
    second = (law.lateral(S + h, time) - 2 * law.lateral(S, time) + law.lateral(S - h, time)) / h**2
    told = law.bending(S, time)
    assert told.curvature == pytest.approx(second / np.sqrt(1 - slope**2), abs=1e-3)
    assert told.head == pytest.approx(math.asin(slope[0]), abs=1e-4)


@pytest.mark.parametrize(("kind", "jolt"), [("smooth", 0.0), ("sine", math.pi / 4)])
def test_ramps_go_from_none_to_all(kind, jolt):
    assert ramp(kind, 0.0, 2.0) == pytest.approx((0.0, jolt))
    assert ramp(kind, 2.0, 2.0) == (1.0, 0.0)
    assert ramp(kind, 1.9999999, 2.0) == pytest.approx((1.0, 0.0), abs=1e-6)


def test_a_wave_without_a_start_is_bent_at_once():
    told = replace(CARLING, start=0.0).bending(S, 0.0)
    assert told.curvature == pytest.approx(CARLING.bending(S, 1.0).curvature)


def test_bends_reach_their_values_at_the_points_at_the_end_of_each_stage():
    s = np.array(CSTART.points)
    base, bend = np.array(CSTART.stages[0].baseline), np.array(CSTART.stages[0].undulation)
    wave = np.sin(2 * math.pi * (0.7 - 0.74 * s + 0.176))
    assert CSTART.bending(s, 0.7).curvature == pytest.approx(base + bend * wave, abs=1e-12)
    wave = np.sin(2 * math.pi * (1.7 - 0.74 * s + 0.176))
    assert CSTART.bending(s, 1.7).curvature == pytest.approx(bend * wave, abs=1e-12)
    assert not CSTART.bending(s, 0.0).curvature.any()


def test_a_curvature_of_ones_own_is_that_of_the_same_wave():
    full = replace(CARLING, start=0.0)
    own = Curved(law=lambda s, t: full.bending(s, t).curvature)
    assert own.bending(S, 0.4).rate == pytest.approx(full.bending(S, 0.4).rate, abs=1e-5)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Wave(amplitude=()), "finite"),
        (lambda: Wave(amplitude=(0.1, math.nan)), "finite"),
        (lambda: Wave(amplitude=(0.0, 0.2)), "too high"),
        (lambda: Wave(amplitude=(0.01,), wavelength=0.0), "wavelength"),
        (lambda: Wave(amplitude=(0.01,), start=-1.0), "start"),
        (lambda: Wave(amplitude=(0.01,), ramp="fast"), "ramp"),
        (lambda: Bends(points=(0, 1), stages=()), "points"),
        (lambda: Bends(points=(0, 0.5, 1), stages=()), "at least one"),
        (lambda: Bends(points=(0, 0.5, 1), stages=(Stage(1.0, (0, 0), (0, 0), 0.0),)), "3 values"),
        (lambda: Curved(law=lambda s, t: 1.0).bending(S, 0.0), "finite numbers"),
    ],
)
def test_midlines_that_are_none_are_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()
