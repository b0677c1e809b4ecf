"""The compiled algebra of cubics is that of polynomials."""

from __future__ import annotations

import numpy as np
import pytest

from levelset import _bernstein as b

RNG = np.random.default_rng(5)


def lagrange(nodal, leads, point):
    """The tensor product of the cubics through four nodes each, by NumPy."""
    total = nodal
    for lead, x in zip(reversed(leads), reversed(point), strict=True):
        nodes = np.arange(4.0) - lead
        weights = [np.prod([(x - m) / (n - m) for m in nodes if m != n]) for n in nodes]
        total = total @ np.array(weights)
    return total


@pytest.mark.parametrize("leads", [(1, 1, 1), (0, 1, 2), (2, 0, 1)])
def test_coefficients_are_those_of_the_cubics_through_the_nodes(leads):
    nodal = RNG.normal(size=(4, 4, 4))
    found = nodal.copy()
    for axis in range(3):
        b.along(found, axis, b.MATRICES[leads[axis]])
    for point in RNG.uniform(size=(5, 3)):
        assert b.value(found, *point) == pytest.approx(lagrange(nodal, leads, point), abs=1e-12)


@pytest.mark.parametrize("lead", [0, 1, 2])
def test_the_ends_are_nodal_values_to_the_last_bit(lead):
    nodal = RNG.normal(size=4)
    found = b.MATRICES[lead] @ nodal
    assert found[0] == nodal[lead]
    assert found[3] == nodal[lead + 1]


@pytest.mark.parametrize(("row", "low"), [(b.LINE, 0), (b.WITHOUT_LAST, -1), (b.WITHOUT_FIRST, 0)])
def test_lines_and_parabolas_go_through_their_nodes(row, low):
    degree = 1 if row == b.LINE else 2
    law = np.polynomial.Polynomial(RNG.normal(size=degree + 1))
    nodal = np.full(4, 1e3)
    first = 1 if row == b.WITHOUT_FIRST else 0
    nodal[first : first + degree + 1] = law(np.arange(degree + 1) + low)
    weights = np.where(np.arange(4) < first + degree + 1, np.arange(4) >= first, False)
    found = b.MATRICES[row] @ np.where(weights, nodal, 7.0)
    for x in (0.0, 0.3, 1.0):
        assert np.dot(b.basis(x), found) == pytest.approx(law(x))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_halves_are_the_same_polynomial(axis):
    whole = RNG.normal(size=(4, 4, 4))
    for upper in (False, True):
        half = whole.copy()
        b.halve(half, axis, upper)
        point = RNG.uniform(size=3)
        place = point.copy()
        place[axis] = 0.5 * (point[axis] + upper)
        assert b.value(half, *point) == pytest.approx(b.value(whole, *place), abs=1e-12)


def test_all_roots_of_a_cubic_in_a_cell_are_found_in_order():
    for _ in range(200):
        places = np.sort(RNG.uniform(-0.5, 1.5, 3))
        law = np.polynomial.Polynomial.fromroots(places) * RNG.choice([-1.0, 1.0])
        a = np.append(law.coef, np.zeros(4 - len(law.coef)))
        c = [a[0], a[0] + a[1] / 3, a[0] + 2 * a[1] / 3 + a[2] / 3, a.sum()]
        found = np.zeros(8)
        count = b.roots(*c, found, 0)
        inside = places[(places > 0) & (places < 1)]
        assert count == len(inside)
        np.testing.assert_allclose(found[:count], inside, atol=1e-6)


@pytest.mark.parametrize("deep", [1, 4])
def test_slopes_are_those_at_the_middle(deep):
    cell = RNG.normal(size=(4, 4, deep))
    for axis in range(2 if deep == 1 else 3):
        steep, least, most = b.slope(cell, axis)
        step = np.zeros(3)
        step[axis] = 1e-6
        ahead, behind = b.value(cell, *(0.5 + step)), b.value(cell, *(0.5 - step))
        assert steep == pytest.approx((ahead - behind) / 2e-6, rel=1e-6)
        steps = 3 * np.diff(cell, axis=axis)
        assert (least, most) == (steps.min(), steps.max())
