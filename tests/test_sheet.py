"""Quadrature along a midline: exact where it should be, also at a round nose."""

import math

import numpy as np
import pytest

from pmesh.bodies.outline import Eel, Foil
from pmesh.bodies.profile import Arch
from pmesh.bodies.sheet import sheet, split


@pytest.mark.parametrize("outline", [Eel(), Foil()], ids=str)
@pytest.mark.parametrize("breaks", [(), (0.0, 0.2, 0.5, 0.75, 0.95, 1.0)])
def test_integrals_along_the_midline_are_those_of_known_functions(outline, breaks):
    along = sheet(breaks, outline, 400)
    wave = np.cos(2 * math.pi * along.nodes)
    assert along.weights.sum() == pytest.approx(1.0, rel=1e-14)
    assert along.outer @ wave == pytest.approx(
        np.sin(2 * math.pi * along.stations) / (2 * math.pi), abs=1e-12
    )
    assert along.inner @ wave == pytest.approx(
        np.sin(2 * math.pi * along.nodes) / (2 * math.pi), abs=1e-12
    )


def test_a_root_at_the_nose_is_integrated_to_round_off():
    along = sheet((), Foil(), 400)
    assert along.weights @ np.sqrt(along.nodes) == pytest.approx(2 / 3, rel=1e-12)


@pytest.mark.parametrize("samples", [100, 400])
def test_stations_are_closer_at_the_nose_and_hold_the_kinks(samples):
    along = sheet((), Eel(), samples)
    assert along.stations[0] == 0.0
    assert along.stations[-1] == 1.0
    for kink in Eel().breaks:
        assert np.abs(along.stations - kink).min() <= 1e-14
    far = np.hypot(np.diff(along.stations), np.diff(along.spread))
    assert far.max() <= 1.4 / samples
    assert far[: samples // 8].max() <= 0.5 / samples
    assert far.min() >= 0.05 / samples
    assert samples <= len(far) <= samples + 15


def test_splitting_keeps_the_marks_and_the_longest_step():
    edges = split([0.0, 0.3, 1.0], 0.1)
    assert np.diff(edges).max() <= 0.1 + 1e-12
    assert edges[3] == 0.3
    assert edges[-1] == 1.0


def test_slices_of_an_ellipse_have_its_area_and_second_moments():
    along = sheet((), Eel(exponent=2.0), 100, Arch())
    w, h = along.width, Arch().half_height(along.nodes)
    widths = along.shares[:, None] * w
    area = (along.layers * 2 * widths).sum(axis=0)
    across = (along.layers * 2 / 3 * widths**3).sum(axis=0)
    up = (along.layers * 2 * widths * along.levels**2).sum(axis=0)
    assert area == pytest.approx(math.pi * w * h, rel=1e-13)
    assert across == pytest.approx(math.pi / 4 * w**3 * h, rel=1e-13)
    assert up == pytest.approx(math.pi / 4 * w * h**3, rel=1e-13)
    assert along.weights @ area == pytest.approx(0.0059326147, abs=5e-11)
