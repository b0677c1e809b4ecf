"""Measures of rings about the z axis, beside exact rings."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.cases.coaxial import (
    Ring,
    cores,
    half_plane_flux,
    ring_below,
    swirl_profile,
    waves,
    whole_ring,
)
from pmesh.vortex.exact import GaussianRing, VortexRing, head_on, leapfrogging
from remesh.grid import Grid

CORE, SPACING = 0.25, 0.08
GRID = Grid((56, 56, 40), SPACING, (-28 * SPACING, -28 * SPACING, -20 * SPACING))


def law(ring, grid=GRID):
    return ring.vorticity(grid.points())


def test_the_flux_through_the_half_plane_is_the_circulation():
    """Gamma [1 - exp(-R^2/a^2)], on lattices that begin anywhere."""
    ring = VortexRing(core=CORE, circulation=-2.0, center=(0.0, 0.0, 0.1))
    known = -2.0 * (1.0 - np.exp(-1.0 / CORE**2))
    assert half_plane_flux(law(ring), GRID) == pytest.approx(known, rel=1e-6)
    wider = Grid((64, 60, 40), SPACING, (-34 * SPACING, -30 * SPACING, -20 * SPACING))
    assert half_plane_flux(law(ring, wider), wider) == pytest.approx(known, rel=1e-6)


def test_half_of_the_first_moment_of_the_swirl_is_the_impulse():
    ring = GaussianRing(core=CORE)
    moment = 0.5 * swirl_profile(law(ring), GRID, 1).sum()
    assert moment == pytest.approx(float(ring.impulse[2]), rel=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_thin_ring_is_where_it_is(dtype):
    """The smoothed ring is 1 + O(a^2/R^2) in radius, exact in height."""
    place = whole_ring(law(VortexRing(core=CORE, center=(0.0, 0.0, 0.13))).astype(dtype), GRID)
    assert place.height == pytest.approx(0.13, abs=1e-5)
    assert place.radius == pytest.approx(1.0, rel=CORE**2)


def test_the_ring_below_is_told_from_its_mirror_image():
    tall = Grid((56, 56, 64), SPACING, (-28 * SPACING, -28 * SPACING, -32 * SPACING))
    place = ring_below(law(head_on(core=CORE, gap=2.2), tall), tall)
    assert place.height == pytest.approx(-1.1, abs=1e-3)
    assert place.radius == pytest.approx(1.0, rel=CORE**2)


def test_two_cores_are_found_between_the_nodes():
    tall = Grid((56, 56, 64), SPACING, (-28 * SPACING, -28 * SPACING, -32 * SPACING))
    found = cores(law(leapfrogging(core=CORE, gap=1.17), tall), tall, CORE)
    heights = sorted(one.height for one in found)
    assert heights == pytest.approx([-0.585, 0.585], abs=0.01)
    assert [one.radius for one in found] == pytest.approx([1.0, 1.0], abs=CORE**2)


def test_a_core_that_is_not_there_is_nan():
    first, second = cores(law(VortexRing(core=CORE)), GRID, CORE)
    assert first.height == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(second.radius)


def test_waves_are_told_by_their_number_and_grow_with_the_amplitude():
    """w of a wavy ring is linear in small waves; a round ring has none but of the mesh (4, 8)."""
    sizes = []
    for amplitude in (0.0, 0.01, 0.02):
        ring = VortexRing(core=CORE, amplitude=amplitude, modes=(3,) if amplitude else ())
        sizes.append(waves(law(ring), GRID, Ring(1.0, 0.0), 2.5 * CORE, 6, 0.25 * CORE))
    assert sizes[0][0] == 1.0
    assert sizes[0][[1, 2, 3, 5, 6]].max() < 1e-10
    assert sizes[2][3] / sizes[1][3] == pytest.approx(2.0, rel=1e-2)
    assert np.argmax(sizes[1][1:]) + 1 == 3
