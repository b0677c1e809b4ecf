"""Adaptation: where blocks are, moments, the cap, several fields, both precisions."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires import pyramid
from remesh.multires.adapt import adapt
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh


def recipe(ndim, levels=None, block=8, boundary="unbounded", **more):
    nodes, depth = (256, 3) if ndim == 2 else (96, 2)
    if ndim == 3 and block == 16:
        nodes, depth = 64, 1
    grid = Grid((nodes,) * ndim, 1 / nodes, boundary=boundary)
    return AdaptiveMesh(grid=grid, levels=levels or depth, block=block, **more)


def bump(points, center=0.5, width=0.04):
    """A Gaussian."""
    away = sum((x - center - 0.01 * a) ** 2 for a, x in enumerate(points))
    return np.exp(-away / width**2)


def everywhere(mesh, law=bump):
    """A law on all blocks there can be."""
    blocks = Blocks.uniform(mesh, mesh.levels)
    return blocks, pyramid.restricted(law(blocks.points()), blocks)


def moments(values, blocks, count):
    """Sums over the coarsest nodes of f x^a y^b z^c, exponents below ``count``."""
    own = blocks.of(0)
    x = blocks.points()[:, own]
    return np.array([
        (values[own] * np.prod([x[a] ** p for a, p in enumerate(powers)], axis=0)).sum()
        for powers in product(range(count), repeat=blocks.mesh.ndim)
    ])  # fmt: skip


@pytest.mark.parametrize(("name", "count"), [("2.2", 2), ("4.2", 2), ("4.4", 4)])
@pytest.mark.parametrize("ndim", [2, 3])
def test_moments_stay_through_any_number_of_adaptations(ndim, name, count):
    mesh = recipe(ndim, tolerance=1e-3, wavelet=name)
    blocks, fields = everywhere(mesh)
    x = mesh.grid.points()
    part = 2.0 ** (-ndim * mesh.levels)
    want = np.array([
        (bump(x) * np.prod([x[a] ** p for a, p in enumerate(powers)], axis=0)).sum() * part
        for powers in product(range(count), repeat=ndim)
    ])  # fmt: skip
    for tolerance in (1e-3, 1e-2, 1e-4, 5e-2):
        blocks = Blocks(replace(mesh, tolerance=tolerance), blocks.places, blocks.starts)
        blocks, fields, *_ = adapt(fields, blocks)
        assert blocks.size < 0.7 * Blocks.uniform(mesh, mesh.levels).size
        found = moments(fields, blocks, count)
        assert np.allclose(found, want, rtol=1e-12, atol=1e-12 * want[0])


@pytest.mark.parametrize("ndim", [2, 3])
def test_moments_stay_when_values_were_changed_up_to_the_edges_of_the_blocks(ndim):
    blocks, fields = everywhere(recipe(ndim, tolerance=1e-2))
    blocks, fields, *_ = adapt(fields, blocks)
    far = abs(blocks.points() - 0.5).max(axis=0) < 0.3
    fields = fields + 1e-3 * np.random.default_rng(2).standard_normal(blocks.shape) * far
    before = moments(pyramid.forward(fields, blocks, spill=True).smooth, blocks, 4)
    target, result, *_ = adapt(fields, blocks)
    assert np.allclose(moments(result, target, 4), before, rtol=1e-12, atol=1e-12 * before[0])
    again = moments(pyramid.forward(result, target, spill=True).smooth, target, 4)
    assert np.allclose(again, before, rtol=1e-12, atol=1e-12 * before[0])


@pytest.mark.parametrize("ndim", [2, 3])
def test_fields_on_the_new_blocks_are_consistent_and_adapting_again_changes_nothing(ndim):
    blocks, fields = everywhere(recipe(ndim))
    first = adapt(fields, blocks)
    assert np.allclose(
        pyramid.restricted(first.fields, first.blocks), first.fields, rtol=0, atol=1e-14
    )
    second = adapt(first.fields, first.blocks)
    assert (second.blocks.keys == first.blocks.keys).all()
    assert np.allclose(second.fields, first.fields, rtol=0, atol=1e-14)


@pytest.mark.parametrize("block", [8, 16, 32])
def test_each_detail_beyond_the_tolerance_has_eight_nodes_of_its_level_around_it(block):
    mesh = AdaptiveMesh(grid=Grid((512, 512), 1 / 512), levels=2, block=block, tolerance=1e-6)
    blocks, fields = everywhere(mesh)
    details = pyramid.forward(fields, blocks).details
    target = adapt(fields, blocks, scale=1.0).blocks
    number, *local = np.nonzero(abs(details) > 1e-6)
    assert set(blocks.levels[number]) == {1, 2}
    for level in (1, 2):
        own = blocks.levels[number] == level
        nodes = (blocks.places[number] * block + np.transpose(local))[own]
        for step in product((-8, 0, 8), repeat=2):
            assert (target.numbers_of(level, (nodes + step) // block) >= 0).all()


@pytest.mark.parametrize("ndim", [2, 3])
def test_details_beyond_the_refinement_threshold_make_finer_blocks_ahead(ndim):
    mesh = recipe(ndim, tolerance=1e-3)
    blocks = Blocks.uniform(mesh, 1)
    details = np.zeros(blocks.shape)
    place = np.array(mesh.counts(1)) // 2
    number = blocks.numbers_of(1, place[None])[0]
    details[number][(3,) * ndim] = 3.9e-3
    few = adapt(pyramid.inverse(np.zeros(blocks.shape), details, blocks), blocks, scale=1.0).blocks
    assert few.finest == 1
    details[number][(3,) * ndim] = 4.1e-3
    more = adapt(pyramid.inverse(np.zeros(blocks.shape), details, blocks), blocks, scale=1.0).blocks
    assert more.finest == 2
    within = np.array(list(product((-1, 0, 1), repeat=ndim)))  # 4 nodes around node 3: -1 to 7
    assert set(map(tuple, more.places[more.of(2)])) == set(map(tuple, 2 * place + within))


@pytest.mark.parametrize("ndim", [2, 3])
def test_nothing_but_the_coarsest_level_is_kept_for_a_smooth_or_empty_field(ndim):
    mesh = recipe(ndim, boundary="periodic")
    for law in (lambda x: 0 * x[0], lambda x: 0 * x[0] + 2.5):
        found = adapt(*everywhere(mesh, law)[::-1])
        assert found.blocks.finest == 0
        assert not found.busy.any()


def test_every_field_has_its_say_relative_to_its_scale():
    mesh = recipe(2)
    blocks, left = everywhere(mesh, lambda x: bump(x, 0.3))
    right = everywhere(mesh, lambda x: 1e-6 * bump(x, 0.7))[1]
    both = adapt(np.stack([left, right]), blocks)
    one, other = (adapt(part, blocks).blocks for part in (left, right))
    assert both.fields.shape == (2, *both.blocks.shape)
    assert set(both.blocks.keys) == set(one.keys) | set(other.keys)
    same = adapt(np.stack([left, right]), blocks, scale=1.0)
    assert (same.blocks.keys == one.keys).all()
    given = adapt(np.stack([left, right]), blocks, scale=(1.0, 1e-6))
    assert (given.blocks.keys == both.blocks.keys).all()


def test_blocks_that_are_always_wanted_stay():
    mesh = recipe(2)
    blocks, fields = everywhere(mesh, lambda x: bump(x, 0.3))
    none, place = np.empty((0, 2), np.int64), np.array([[30, 30]])
    found = adapt(fields, blocks, always=[none, none, none, place])
    assert found.blocks.numbers_of(3, place)[0] >= 0
    plain = adapt(fields, blocks).blocks
    assert plain.numbers_of(3, place)[0] < 0
    assert set(plain.keys) < set(found.blocks.keys)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_cap_on_blocks_raises_the_tolerance_no_more_than_needed(ndim):
    mesh = recipe(ndim, tolerance=1e-5)
    blocks, fields = everywhere(mesh)
    free = adapt(fields, blocks)
    assert free.tolerance == 1e-5
    most = free.blocks.size // 2
    capped = adapt(fields, Blocks(replace(mesh, most_blocks=most), blocks.places, blocks.starts))
    assert capped.blocks.size <= most
    assert capped.tolerance > 1e-5
    same, less = (
        adapt(fields, Blocks(replace(mesh, tolerance=tolerance), blocks.places, blocks.starts))
        for tolerance in (capped.tolerance, capped.tolerance * (1 - 1e-6))
    )
    assert (same.blocks.keys == capped.blocks.keys).all()
    assert less.blocks.size > most


def test_no_rounding_of_the_raised_tolerance_passes_the_cap():
    mesh = recipe(2, tolerance=1e-3, most_blocks=16)
    blocks, fields = everywhere(mesh)
    for scale in np.random.default_rng(0).uniform(0.5, 1.0, 30):
        assert adapt(fields, blocks, scale=scale).blocks.size == 16


def test_a_cap_below_what_is_always_kept_is_refused():
    mesh = recipe(2, most_blocks=17)
    blocks, fields = everywhere(mesh)
    with pytest.raises(InputError, match="more than most_blocks 17"):
        adapt(
            fields, blocks, always=[np.empty((0, 2), np.int64), np.array([[0, 0], [2, 5], [7, 7]])]
        )


@pytest.mark.parametrize("ndim", [2, 3])
def test_busy_cells_hold_the_details_beyond_the_tolerance(ndim):
    mesh = recipe(ndim)
    found = adapt(*everywhere(mesh)[::-1])
    blocks = found.blocks
    details = abs(pyramid.forward(found.fields, blocks).details) / abs(found.fields).max()
    parts = details.reshape(blocks.size, *(2, 4) * ndim)
    cells = parts.max(axis=tuple(range(2, 2 + 2 * ndim, 2)))
    assert found.busy.shape == cells.shape == (blocks.size, *(2,) * ndim)
    held = cells > found.tolerance
    assert held.any()
    assert found.busy[held].all()
    for n in np.unique(np.nonzero(found.busy & ~held)[0]):  # over large details of a coarser level
        assert cells[blocks.coarser[n, 3**ndim // 2]].max() > mesh.thresholds[1]
    assert not found.busy[blocks.of(0)].any()


@pytest.mark.parametrize("ndim", [2, 3])
def test_single_precision_stays_and_gives_the_same_blocks_and_fields(ndim):
    blocks, fields = everywhere(recipe(ndim))
    double, single = adapt(fields, blocks), adapt(fields.astype(np.float32), blocks)
    assert single.fields.dtype == np.float32
    assert (single.blocks.keys == double.blocks.keys).all()
    assert np.allclose(single.fields, double.fields, rtol=0, atol=1e-6)


@pytest.mark.parametrize("ndim", [2, 3])
def test_bits_do_not_depend_on_threads(ndim):
    blocks, fields = everywhere(recipe(ndim))
    one, three = (adapt(np.stack([fields, fields**2]), blocks, threads=n) for n in (1, 3))
    assert (one.blocks.keys == three.blocks.keys).all()
    assert (one.fields == three.fields).all()
    assert (one.busy == three.busy).all()


def test_what_cannot_be_weighed_is_refused():
    blocks, fields = everywhere(recipe(2))
    for bad in (np.nan, np.inf):
        broken = fields.copy()
        broken[-1, 3, 3] = bad
        for scale in (None, 1.0):
            with pytest.raises(InputError, match="must be finite"):
                adapt(broken, blocks, scale=scale)
    for scale in (0.0, -1.0, (1.0, 2.0), np.nan):
        with pytest.raises(InputError, match="scale must be"):
            adapt(fields, blocks, scale=scale)


def test_cells_over_large_coarse_details_are_followed_before_they_have_their_own() -> None:
    """A block made ahead holds no details yet; a flow must take it along all the same."""
    mesh = AdaptiveMesh(grid=Grid((256, 256), 1 / 256), levels=3, tolerance=1e-4)
    blocks = Blocks.uniform(mesh, 2)
    x, y = blocks.points()
    values = pyramid.restricted(np.exp(-((x - 0.5) ** 2 + (y - 0.5) ** 2) / (2 * 0.02**2)), blocks)
    found = adapt(values, blocks)
    finest = found.blocks.of(3)
    assert finest.stop > finest.start
    details = pyramid.forward(found.fields, found.blocks).details[finest]
    assert np.abs(details).max() < 1e-12
    marked = found.busy[finest]
    assert marked.any()
    assert not marked.all()
