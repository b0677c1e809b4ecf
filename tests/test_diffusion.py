"""Laws of what spreads on an adaptive mesh."""

import numpy as np
import pytest
from nested_blocks import nested, recipe

from remesh.errors import InputError
from remesh.multires.blocks import Blocks
from remesh.multires.diffusion import spread
from remesh.multires.pyramid import restricted
from remesh.spreading import REACHES, plan, stencil


def gaussian(points, width, start=None):
    """A Gaussian of this width that had height one when it had the width ``start``."""
    square = sum((x - 0.5) ** 2 for x in points)
    return np.exp(-square / 2 / width**2) * ((start or width) / width) ** len(points)


@pytest.mark.parametrize(("reach", "most"), REACHES.items())
@pytest.mark.parametrize("part", [0.01, 0.3, 1.0])
def test_stencils_have_the_moments_of_the_heat_kernel_and_let_no_wave_grow(reach, most, part):
    diffused = part * most
    weights = stencil(diffused, reach)
    steps = np.arange(1, reach + 1.0)
    assert weights[0] + 2 * weights[1:].sum() == pytest.approx(1, abs=1e-14)
    expected = 1.0
    for half in range(1, reach + 1):
        expected *= (2 * half - 1) * 2 * diffused  # moment 2 half of a Gaussian
        found = 2 * (weights[1:] * steps ** (2 * half)).sum()
        size = 2 * (np.abs(weights[1:]) * steps ** (2 * half)).sum()
        assert abs(found - expected) < 1e-12 * size
    angles = np.linspace(0, np.pi, 200)
    symbol = weights[0] + 2 * np.cos(np.outer(angles, steps)) @ weights[1:]
    assert np.abs(symbol).max() <= 1 + 1e-14


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
def test_a_gaussian_widens_as_it_must_to_eighth_order(ndim, boundary):
    errors = []
    for nodes in (64, 128) if ndim == 2 else (32, 64):
        blocks = Blocks.uniform(recipe(nodes, ndim, 1, boundary), 1)
        h, start = 1 / nodes, 0.03 if ndim == 2 else 0.06
        diffused = 0.5 * h * h
        width = np.sqrt(start**2 + 2 * diffused)
        found = spread(gaussian(blocks.points(), start), blocks, diffused).values
        own = blocks.of(1)
        exact = gaussian(blocks.points(), width, start)
        errors.append(np.abs(found[own] - exact[own]).max())
    assert errors[1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 7.5


@pytest.mark.parametrize(("ndim", "nodes", "width"), [(2, 256, 0.08), (3, 64, 0.12)])
def test_every_level_spreads_alike_where_it_is_the_finest(ndim, nodes, width):
    """A Gaussian wider than the refined region: within 2 % of how much it changes on each level."""
    levels = 2 if ndim == 2 else 1
    blocks = nested(recipe(nodes, ndim, levels, "unbounded"), (0.5,) * ndim, 0.05)
    diffused = 1.9 / nodes**2
    values = restricted(gaussian(blocks.points(), width), blocks)
    found = spread(values, blocks, diffused).values
    exact = gaussian(blocks.points(), np.sqrt(width**2 + 2 * diffused), width)
    for level in range(levels + 1):
        own = blocks.of(level)
        active = blocks.leaves()[own]
        change = np.abs(exact - gaussian(blocks.points(), width))[own][active].max()
        error = np.abs(found - exact)[own][active].max()
        assert error < 0.02 * change


@pytest.mark.parametrize("diffused", [0.3, 1.0, 1.9, 7.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 128)])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 4e-6), (np.float32, 6e-6)])
def test_refined_regions_spread_as_if_all_were_fine(ndim, nodes, diffused, dtype, tolerance):
    width = 4 / nodes
    mesh = recipe(nodes, ndim, 2 if ndim == 2 else 1, "unbounded")
    blocks = nested(mesh, (0.5,) * ndim, 9 * width)
    values = restricted(gaussian(blocks.points(), width), blocks).astype(dtype)
    found = spread(values, blocks, diffused / nodes**2)
    wide = np.sqrt(width**2 + 2 * diffused / nodes**2)
    own = blocks.of(mesh.levels)
    exact = gaussian(blocks.points()[:, own], wide, width)
    assert np.abs(found.values[own] - exact).max() < tolerance
    before, after = values[blocks.of(0)].sum(), found.values[blocks.of(0)].sum()
    assert abs(after - before) < tolerance * before
    assert found.values.dtype == dtype


def test_what_spreads_across_unbounded_ends_is_told():
    blocks = Blocks.uniform(recipe(64, 2, 1, "unbounded"), 0)
    values = np.random.default_rng(0).normal(size=(2, *blocks.shape))
    found = spread(values, blocks, 0.02**2)
    volume = blocks.mesh.spacing(0) ** 2
    left = volume * (values - found.values).sum(axis=(1, 2, 3))
    np.testing.assert_allclose(found.lost, left, atol=1e-14)
    assert np.all(np.abs(found.lost) > 1e-8)
    periodic = Blocks.uniform(recipe(64, 2, 1), 0)
    kept = spread(values, periodic, 0.02**2)
    np.testing.assert_array_equal(kept.lost, 0)
    np.testing.assert_allclose(kept.values.sum(axis=(1, 2, 3)), values.sum(axis=(1, 2, 3)))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
def test_what_spreads_across_ends_is_told_where_finer_blocks_touch_them(ndim, nodes, place, dtype):
    mesh = recipe(nodes, ndim, 2 if ndim == 2 else 1, "unbounded")
    blocks = nested(mesh, (place, *(0.5,) * (ndim - 1)), 24 / nodes)
    x, width = blocks.points(), 4 / nodes
    middle = np.exp(-sum((x - 0.5)[1:] ** 2) / 2 / width**2)
    near = middle * np.exp(-((x[0] - place) ** 2) / 2 / width**2)
    values = restricted(np.stack([near, 0 * near]), blocks).astype(dtype)
    found = spread(values, blocks, 4.0 / nodes**2)
    volume, coarse = mesh.spacing(0) ** ndim, blocks.of(0)
    before, after = (volume * v[0, coarse].sum() for v in (values, found.values))
    assert found.lost[0] > 0.02 * before
    kept = 1e-12 if dtype == np.float64 else 2e-6
    assert after + found.lost[0] == pytest.approx(before, rel=kept)
    assert found.lost[1] == 0


@pytest.mark.parametrize("place", [0.0, 1.0])
def test_details_dropped_far_from_an_end_are_not_told_as_what_left(place):
    mesh = recipe(512, 2, 2, "unbounded")
    blocks = nested(mesh, (place, 0.5), 0.05).joined(2, np.array([[15, 15], [15, 16]]))
    x = blocks.points()
    values = np.exp(-((x[0] - 0.5) ** 2 + (x[1] - 0.5) ** 2) / 2 / 0.02**2)
    found = spread(restricted(values, blocks), blocks, 1.9 / 512**2)
    before, after = (v[blocks.of(0)].sum() for v in (restricted(values, blocks), found.values))
    assert abs(after - before) > 1e-10 * before  # at the jumps of levels around the spot
    assert abs(found.lost) < 1e-15


def test_noise_never_grows():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    values = restricted(np.random.default_rng(0).normal(size=blocks.shape), blocks)
    for diffused in (0.1, 0.6, 1.3, 2.0, 11.0):
        found = spread(values, blocks, diffused / 128**2).values
        assert np.abs(found).max() <= np.abs(values).max()


def test_substeps_are_as_few_as_the_ghosts_allow():
    assert plan(0.6, 12) == (4, 1)
    assert plan(0.61, 12) == (8, 1)
    assert plan(2.0, 12) == (12, 1)
    assert plan(4.1, 12) == (12, 3)
    assert plan(4.1, 4) == (4, 7)


def test_nothing_spreads_in_no_time():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    values = np.random.default_rng(0).normal(size=blocks.shape)
    found = spread(values, blocks, 0.0)
    np.testing.assert_array_equal(found.values, values)
    assert found.values is not values
    assert found.lost == 0


def test_results_do_not_depend_on_threads_nor_on_fields_beside():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    values = np.random.default_rng(0).normal(size=(2, *blocks.shape))
    both = spread(values, blocks, 1e-4, threads=3)
    np.testing.assert_array_equal(both.values[1], spread(values[1], blocks, 1e-4).values)


@pytest.mark.parametrize("diffused", [-1e-3, np.nan, np.inf])
def test_an_impossible_time_is_refused(diffused):
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    with pytest.raises(InputError, match="diffused must be finite and >= 0"):
        spread(np.ones(blocks.shape), blocks, diffused)
