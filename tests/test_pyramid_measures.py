"""Volume, area and centroid over bands of several spacings: each place counts once."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from levelset.band import Band
from levelset.lookup import places
from levelset.profile import profile
from levelset.pyramid import Pyramid, started
from levelset.pyramid_measures import pyramid_measures
from levelset.quadrature import measures
from levelset.shapes import Box, Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh


def mesh(ndim: int, cells: int = 64, tolerance: float = 1e-2) -> AdaptiveMesh:
    return AdaptiveMesh(
        grid=Grid((cells,) * ndim, 1 / cells), levels=2, tolerance=tolerance, block=8
    )


def nested(phi: Any, where: Any, ndim: int) -> Pyramid:
    """Bands of a function of places: all of level 0, the children of nodes within boxes above."""
    fine = mesh(ndim)
    bands = []
    nodes = np.arange(fine.level_grid(0).size)
    for level in range(3):
        grid = fine.level_grid(level)
        at = places(grid, nodes)
        bands.append(Band(grid, nodes, phi(at)))
        if level < 2:
            inner = np.stack(np.unravel_index(nodes[where[level](at)], grid.shape), axis=1)
            steps = np.stack(np.meshgrid(*[[0, 1]] * ndim, indexing="ij"), -1).reshape(-1, ndim)
            above = (2 * inner[:, None, :] + steps).reshape(-1, ndim)
            nodes = np.sort(np.ravel_multi_index(above.T, fine.level_grid(level + 1).shape))
    return Pyramid(fine, tuple(bands))


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_flat_interface_across_jumps_of_the_spacing_is_measured_exactly(ndim):
    slope = np.array([0.23, -0.11])[: ndim - 1]

    def plane(at: np.ndarray) -> np.ndarray:
        return at[:, -1] - 0.41 - at[:, : ndim - 1] @ slope

    boxes = [
        lambda at: (at[:, 0] > 0.3) & (at[:, -1] > 0.1) & (at[:, -1] < 0.8),
        lambda at: (at[:, 0] > 0.55) & (at[:, -1] > 0.25) & (at[:, -1] < 0.65),
    ]
    found = pyramid_measures(nested(plane, boxes, ndim))
    side = 15 / 16  # of the box, from the first node to the last of level 0
    middle = 0.41 + 0.5 * side * slope.sum()
    assert found.volume == pytest.approx(side ** (ndim - 1) * middle, rel=1e-12)
    tilt = math.sqrt(1 + (slope**2).sum())
    assert found.area == pytest.approx(side ** (ndim - 1) * tilt, rel=1e-12)
    moment = side ** (ndim - 1) * (0.5 * middle**2 + (slope**2).sum() * side**2 / 24)
    assert found.centroid[-1] * found.volume == pytest.approx(moment, rel=1e-10)


def test_without_finer_bands_it_is_the_measure_of_the_band():
    fine = mesh(2)
    shape = Disk(0.3, center=(0.5, 0.45))
    pyramid = started(fine, lambda at: profile(shape.distance(at.T), 0.4), 0.4, 3)
    assert pyramid.finest == 0
    found, known = pyramid_measures(pyramid), measures(pyramid.bands[0])
    assert found.volume == pytest.approx(known.volume, rel=1e-14)
    assert found.area == pytest.approx(known.area, rel=1e-14)
    np.testing.assert_allclose(found.centroid, known.centroid, rtol=1e-13)


@pytest.mark.parametrize("ndim", [2, 3])
def test_round_bodies_are_measured_to_the_tolerance_of_their_mesh(ndim):
    shape: Any = Sphere(0.21, center=(0.5, 0.47, 0.5))
    if ndim == 2:
        shape = Disk(0.21, center=(0.5, 0.47))
    off = []
    for tolerance in (1e-2, 1e-4):
        pyramid = started(
            mesh(ndim, tolerance=tolerance), lambda at: profile(shape.distance(at.T), 0.3), 0.3, 3
        )
        found = pyramid_measures(pyramid)
        off.append(abs(found.volume / shape.volume - 1))
        assert found.area == pytest.approx(shape.surface, rel=5e-3)
        np.testing.assert_allclose(found.centroid, (0.5, 0.47, 0.5)[:ndim], atol=2e-4)
    assert pyramid.finest == 2
    assert off[1] < min(0.2 * off[0], 2e-4)


def test_what_is_inside_far_from_the_interface_is_counted():
    shape = Box((0.8, 0.8), center=(0.47, 0.47))
    pyramid = started(mesh(2), lambda at: profile(shape.distance(at.T), 0.1), 0.1, 3)
    assert len(pyramid.bands[0].nodes) < 16**2  # the middle is in no band
    assert pyramid_measures(pyramid).volume == pytest.approx(0.64, rel=5e-3)


def test_no_inside_has_no_volume_and_no_centre():
    pyramid = started(mesh(2), lambda at: np.ones(len(at)), 0.1, 3)
    found = pyramid_measures(pyramid)
    assert (found.volume, found.area) == (0.0, 0.0)
    assert np.isnan(found.centroid).all()


def test_the_same_bits_for_any_number_of_threads():
    shape = Box((0.5, 0.4), center=(0.5, 0.47))
    pyramid = started(mesh(2), lambda at: profile(shape.distance(at.T), 0.2), 0.2, 3)
    one, three = (pyramid_measures(pyramid, threads=n) for n in (1, 3))
    assert one[:2] == three[:2]


def test_a_level_set_that_is_not_finite_is_refused():
    shape = Disk(0.3, center=(0.5, 0.5))
    pyramid = started(mesh(2), lambda at: profile(shape.distance(at.T), 0.2), 0.2, 3)
    pyramid.bands[0].values[5] = np.nan
    with pytest.raises(InputError, match="must be finite"):
        pyramid_measures(pyramid)
