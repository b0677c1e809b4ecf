"""Bands of several spacings: where there are which, what they hold, how they are remeshed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from levelset.laws import Rotation
from levelset.lookup import places
from levelset.profile import LEVEL, profile
from levelset.pyramid import Pyramid, remeshed, started, to_uniform
from levelset.shapes import Box, Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.wavelets import get_wavelet

WIDTH = 0.2  # half width of the profile
CORNERED = Box((0.4, 0.4), center=(0.5, 0.5))


def mesh(ndim: int = 2, tolerance: float = 5e-3, ends: Any = "periodic", **more: Any):
    grid = Grid((64,) * ndim, 1 / 64, boundary=ends)
    return AdaptiveMesh(grid=grid, levels=2, tolerance=tolerance, block=8, **more)


def around(shape: Any, fine: AdaptiveMesh) -> Pyramid:
    return started(fine, lambda at: profile(shape.distance(at.T), WIDTH), WIDTH, 4)


def still(pyramid: Pyramid) -> list[Any]:
    return [(b.nodes, places(b.grid, b.nodes), b.values) for b in pyramid.bands]


@pytest.mark.parametrize("ends", ["periodic", "unbounded"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_bands_are_nested_and_hold_one_level_set(ndim, ends):
    shape: Any = CORNERED if ndim == 2 else Box((0.4, 0.4, 0.5), center=(0.5,) * 3)
    pyramid = around(shape, mesh(ndim, ends=ends))
    assert pyramid.finest == 2
    for coarse, fine in zip(pyramid.bands, pyramid.bands[1:], strict=False):
        assert (np.diff(fine.nodes) > 0).all()
        at = np.stack(np.unravel_index(fine.nodes, fine.grid.shape), axis=1)
        even = (at % 2 == 0).all(axis=1)
        assert even.sum() * 2**ndim == len(at)
        under = np.ravel_multi_index((at[even] // 2).T, coarse.grid.shape)
        place = np.searchsorted(coarse.nodes, under)
        np.testing.assert_array_equal(coarse.nodes[place], under)
        np.testing.assert_array_equal(coarse.values[place], fine.values[even])


def test_each_place_is_active_once():
    pyramid = around(CORNERED, mesh())
    every = [
        np.stack(np.unravel_index(b.nodes, b.grid.shape), axis=1) * 2 ** (2 - level)
        for level, b in enumerate(pyramid.bands)
    ]
    assert pyramid.active == len(np.unique(np.concatenate(every), axis=0))
    assert pyramid.stored == sum(map(len, every)) > pyramid.active


def test_a_place_is_refined_where_every_second_node_would_not_do():
    """The details by their definition: what is off along both axes, over the slope."""
    fine = mesh(tolerance=2e-3, refinement=2e-3)
    shape = Disk(0.3, center=(0.5, 0.5)) - Disk(0.25, center=(0.5, 0.28))
    pyramid = around(shape, fine)
    weights = [float(w) for w in get_wavelet("4.4").predict]
    for level in (0, 1):
        grid = fine.level_grid(level)
        phi = profile(shape.distance(grid.points()), WIDTH)
        total, slope = np.zeros(grid.shape), np.zeros(grid.shape)
        for axis in (0, 1):
            guess = sum(
                w * np.roll(phi, -step, axis)
                for w, step in zip(weights, (-3, -1, 1, 3), strict=True)
            )
            total += np.abs(phi - guess)
            steps = [np.abs(np.roll(phi, s, axis) - phi) for s in (1, -1)]
            slope += np.maximum(*steps) ** 2
        sizes = grid.spacing * total / np.sqrt(np.maximum(slope, 1e-30))
        near = np.abs(phi) < 0.4 * grid.spacing
        rough = near & (sizes > 1.01 * 2e-3 * WIDTH)
        assert rough.any()
        above = fine.level_grid(level + 1)
        held = np.zeros(above.shape, bool)
        held.reshape(-1)[pyramid.bands[level + 1].nodes] = True
        assert held[::2, ::2][rough].all()


def test_particles_that_stay_keep_their_values_and_their_bands():
    pyramid = around(CORNERED, mesh())
    again = remeshed(pyramid.mesh, still(pyramid), "L6,4", WIDTH)
    for one, other in zip(pyramid.bands, again.bands, strict=True):
        both, i, j = np.intersect1d(one.nodes, other.nodes, return_indices=True)
        assert len(both) > 0.8 * len(one.nodes)
        near = np.abs(one.values[i]) < 0.02
        np.testing.assert_allclose(other.values[j][near], one.values[i][near], atol=1e-12)


def test_a_turn_of_all_levels_brings_the_interface_where_it_goes():
    law = Rotation(center=(0.5, 0.5), rate=1.0)
    pyramid = around(CORNERED, mesh(tolerance=1e-3))
    moved = [(n, law.flow(at, 0.0, 0.6), v) for n, at, v in still(pyramid)]
    turned = remeshed(pyramid.mesh, moved, "L6,4", WIDTH)
    c, s = np.cos(0.6), np.sin(0.6)
    there = CORNERED.moved((0.5 - 0.5 * c + 0.5 * s, 0.5 - 0.5 * s - 0.5 * c), 0.6)
    assert turned.finest == 2
    for band in turned.bands:
        exact = there.distance(places(band.grid, band.nodes).T)
        near = np.abs(exact) < 0.5 * band.grid.spacing
        np.testing.assert_allclose(band.values[near], exact[near], atol=0.4 / 64)


def test_details_between_the_thresholds_neither_refine_nor_coarsen():
    shape = Disk(0.2, center=(0.5, 0.5))
    loose, tight = mesh(tolerance=1e-4, refinement=0.9), mesh(tolerance=1e-4, refinement=1e-4)
    assert around(shape, loose).finest == 0
    fine = around(shape, tight)
    assert fine.finest > 0
    kept = remeshed(loose, still(Pyramid(loose, fine.bands)), "L6,4", WIDTH)
    assert kept.finest == fine.finest
    let_go = remeshed(mesh(tolerance=0.5, refinement=0.9), still(fine), "L6,4", WIDTH)
    assert let_go.finest == 0


@pytest.mark.parametrize("ends", ["periodic", "unbounded"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_on_uniform_nodes_it_is_what_the_bands_hold_and_interpolates_between(ndim, ends):
    shape: Any = Disk(0.3, center=(0.5,) * 2) if ndim == 2 else Sphere(0.3, center=(0.5,) * 3)
    fine = mesh(ndim, tolerance=1e-2, ends=ends)
    pyramid = around(shape, fine)
    for level in range(3):
        grid = fine.level_grid(level)
        field = to_uniform(pyramid, level, LEVEL * WIDTH)
        band = pyramid.bands[level]
        np.testing.assert_array_equal(field.reshape(-1)[band.nodes], band.values)
        exact = profile(shape.distance(grid.points()), WIDTH)
        part = (slice(2**level * 3, 2**level * 13),) * ndim  # away from the ends of open axes
        off = np.abs(field - exact)[part]
        assert off.max() < 0.02 * WIDTH
        assert off[np.abs(exact[part]) < 0.02].max() < 1e-2 * WIDTH


def test_particles_that_cross_each_other_are_refused():
    pyramid = around(CORNERED, mesh())
    folded = [(n, at[:, ::-1].copy(), v) for n, at, v in still(pyramid)]
    with pytest.raises(InputError, match="particles have crossed each other"):
        remeshed(pyramid.mesh, folded, "L6,4", WIDTH)
