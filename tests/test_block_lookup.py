"""Laws of fields on an adaptive mesh that are looked up at displaced nodes."""

import numpy as np
import pytest
from nested_blocks import dense, nested, recipe

from remesh.errors import InputError
from remesh.multires.blocks import OUTSIDE, Blocks
from remesh.multires.lookup import sampled_at
from remesh.nodes import sample_nodes


def waves(points, size):
    """A smooth displacement, a few times ``size``."""
    terms = [np.sin(2 * np.pi * (x + 0.1 * k)) for k, x in enumerate(points)]
    return size * np.stack([np.roll(terms, k, axis=0)[0] + 1.3 for k in range(len(terms))])


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
@pytest.mark.parametrize(
    ("ndim", "kernel", "dtype"),
    [
        (2, "M4'", np.float64),
        (2, "M6'", np.float64),
        (2, "M6'", np.float32),
        (2, "L8,4", np.float64),
        (3, "M6'", np.float64),
        (3, "M4'", np.float32),
    ],
)
def test_on_a_complete_level_fields_are_sampled_as_on_a_uniform_grid(ndim, kernel, boundary, dtype):
    mesh = recipe(64, ndim, 1, boundary)
    blocks = Blocks.uniform(mesh, 1)
    field = np.random.default_rng(0).normal(size=(ndim, *blocks.shape)).astype(dtype)
    move = waves(blocks.points(), 0.2).astype(dtype)
    found = sampled_at(field, blocks, blocks, move, kernel)
    uniform = [np.stack([dense(part, blocks, 1) for part in some]) for some in (field, move)]
    expected = sample_nodes(*uniform, mesh.grid, kernel)
    own = np.stack([dense(part, blocks, 1) for part in found])
    np.testing.assert_allclose(own, expected, atol=100 * np.finfo(dtype).eps)
    assert found.dtype == dtype


@pytest.mark.parametrize(("ndim", "nodes", "block"), [(2, 256, 16), (2, 256, 8), (3, 128, 16)])
@pytest.mark.parametrize("size", [0.0, 0.004, 0.11])
def test_cubics_are_exact_on_whatever_level_a_place_lies(ndim, nodes, block, size):
    mesh = recipe(nodes, ndim, 2, "unbounded", block)
    blocks = nested(mesh, (0.4, 0.5, 0.6)[:ndim], 0.06)
    source = nested(mesh, (0.5, 0.45, 0.5)[:ndim], 0.05)

    def law(points):
        return 1 + sum((k + 1) * (x - 0.3) ** 3 for k, x in enumerate(points))

    points = source.points()
    move = waves(points, size)
    found = sampled_at(law(blocks.points()), blocks, source, move)
    places = points + move
    margin = 6 * mesh.spacing(0)
    inside = np.all((places > margin) & (places < 1 - margin), axis=0)
    assert inside.mean() > 0.05
    np.testing.assert_allclose(found[inside], law(places)[inside], atol=1e-12)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
def test_constants_are_read_as_they_are_where_finer_blocks_touch_ends(ndim, nodes, place, dtype):
    blocks = nested(recipe(nodes, ndim, 2, "unbounded", 8), (place, 0.4, place)[:ndim], 0.05)
    assert (blocks.neighbours[blocks.of(2)] == OUTSIDE).any()
    field = np.ones((2, *blocks.shape), dtype)
    for size in (0.3 / nodes, 0.03, 0.4):
        move = waves(blocks.points(), size).astype(dtype)
        found = sampled_at(field, blocks, blocks, np.concatenate([-move[:1], move[1:]]))
        assert np.abs(found - 1).max() < (1e-12 if dtype == np.float64 else 1e-5)


def test_each_place_is_read_on_the_finest_level_up_to_its_own():
    mesh = recipe(256, 2, 2)
    blocks = nested(mesh, (0.4, 0.5), 0.06)
    marks = np.broadcast_to(blocks.levels[:, None, None].astype(float), blocks.shape)
    source = Blocks.uniform(mesh, 2)
    move = np.zeros((2, *source.shape))
    found = sampled_at(marks.copy(), blocks, source, move, "M4'")
    for level in range(3):
        own = source.of(level)
        number = blocks.numbers_of(level, source.places[own])
        read = found[own][number >= 0]
        np.testing.assert_allclose(read[:, 4:-4, 4:-4], level, atol=1e-12)
        assert np.all(found[own] < level + 0.3)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_places_just_below_a_node_are_read_as_that_node(dtype):
    mesh = recipe(256, 2, 2, "unbounded")
    blocks = nested(mesh, (0.4, 0.5), 0.06)
    source = Blocks.uniform(mesh, 2)
    field = (blocks.points()[0] + 2 * blocks.points()[1]).astype(dtype)
    exact = source.points()[0] + 2 * source.points()[1]
    inside = np.abs(source.points() - 0.5).max(axis=0) < 0.3
    for below in (0.0, -1e-25, -3e-8 / 256, -6e-8 / 256):  # whole nodes once rounded
        found = sampled_at(field, blocks, source, np.full((2, *source.shape), below, dtype))
        np.testing.assert_allclose(found[inside], exact[inside], atol=2e-6)


def test_beyond_unbounded_ends_the_last_value_goes_on():
    mesh = recipe(64, 2, 1, "unbounded")
    blocks = Blocks.uniform(mesh, 1)
    field = 3 + blocks.points()[1]
    move = np.zeros((2, *blocks.shape))
    move[1] = 5.0
    np.testing.assert_allclose(sampled_at(field, blocks, blocks, move)[blocks.of(1)], 3 + 63 / 64)
    move[1] = -5.0
    np.testing.assert_allclose(sampled_at(field, blocks, blocks, move)[blocks.of(1)], 3)


def test_results_do_not_depend_on_threads_nor_on_fields_beside():
    mesh = recipe(256, 2, 2)
    blocks = nested(mesh, (0.4, 0.5), 0.06)
    field = np.random.default_rng(0).normal(size=(2, *blocks.shape))
    move = waves(blocks.points(), 0.1)
    both = sampled_at(field, blocks, blocks, move, threads=3)
    np.testing.assert_array_equal(both[1], sampled_at(field[1], blocks, blocks, move, threads=1))


def test_unusable_input_is_refused():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    field, move = np.ones(blocks.shape), np.zeros((2, *blocks.shape))
    with pytest.raises(InputError, match="displacement must have shape"):
        sampled_at(field, blocks, blocks, move[0])
    with pytest.raises(InputError, match="one mesh"):
        sampled_at(field, blocks, Blocks.uniform(recipe(64), 0), np.zeros((2, 4, 16, 16))[:, :1])
    move[0, 0, 0, 0] = np.nan
    with pytest.raises(InputError, match="must be finite"):
        sampled_at(field, blocks, blocks, move)
