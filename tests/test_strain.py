"""Laws of the largest velocity gradient on an adaptive mesh."""

import math

import numpy as np
import pytest
from nested_blocks import nested, recipe

from remesh.errors import InputError
from remesh.multires.blocks import OUTSIDE, Blocks
from remesh.multires.strain import gradient_norm


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
def test_the_norm_of_waves_is_that_of_their_gradient(ndim, boundary):
    errors = []
    for nodes in (32, 64):
        blocks = Blocks.uniform(recipe(nodes, ndim, 1, boundary), 1)
        x = blocks.points()
        velocity = [np.sin(2 * np.pi * (x[1] + 0.5)), *np.zeros((ndim - 1, *blocks.shape))]
        velocity[-1] = 0.5 * np.cos(2 * np.pi * (x[0] - x[1]))
        errors.append(abs(gradient_norm(np.stack(velocity), blocks) - 2 * np.pi))
    assert errors[0] < 0.02
    assert errors[1] < errors[0] / 14  # fourth order


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 128)])
def test_linear_velocities_are_told_exactly_up_to_unbounded_ends(ndim, nodes, dtype):
    blocks = nested(recipe(nodes, ndim, 2, "unbounded"), (0.5,) * ndim, 0.05)
    rates = np.array([[1.0, -2.0, 0.5], [0.0, 3.0, 1.5], [0.2, 0.1, 0.3]])[:ndim, :ndim]
    velocity = np.tensordot(rates, blocks.points(), 1)
    expected = np.abs(rates).sum(axis=1).max()
    tolerance = 2e-13 if dtype == np.float64 else 3e-3  # of values of size 1 over fine spacings
    ends = np.all((blocks.points() > 0.1) & (blocks.points() < 0.9), axis=0)
    assert ends.any()
    # one-sided at the ends, ghosts across jumps of levels: all exact for linear fields
    assert abs(gradient_norm(velocity.astype(dtype), blocks) - expected) < tolerance * nodes


@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
def test_a_constant_velocity_deforms_nothing_where_finer_blocks_touch_ends(ndim, nodes, place):
    blocks = nested(recipe(nodes, ndim, 2, "unbounded", 8), (place, 0.4, place)[:ndim], 0.05)
    assert (blocks.neighbours[blocks.of(2)] == OUTSIDE).any()
    assert gradient_norm(np.ones((ndim, *blocks.shape)), blocks) < 1e-12 * nodes
    rates = np.array([[1.0, -2.0, 0.5], [0.0, 3.0, 1.5], [0.2, 0.1, 0.3]])[:ndim, :ndim]
    velocity = np.tensordot(rates, blocks.points(), 1)
    expected = np.abs(rates).sum(axis=1).max()
    assert abs(gradient_norm(velocity, blocks) - expected) < 2e-13 * nodes


def test_only_active_nodes_count():
    blocks = nested(recipe(256, 2, 2), (0.5, 0.5), 0.08)
    velocity = np.zeros((2, *blocks.shape))
    deep = blocks.neighbours.min(axis=1) >= 0
    covered = ~blocks.leaves()[: blocks.starts[1]].any(axis=(1, 2))
    number = int(np.nonzero(covered)[0][0])
    velocity[0, number, 8, 8] = 1.0
    assert deep[number]
    assert gradient_norm(velocity, blocks) == 0.0


def test_what_is_no_number_is_told():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    velocity = np.zeros((2, *blocks.shape))
    velocity[1, -1, 3, 3] = np.nan
    assert math.isnan(gradient_norm(velocity, blocks))


def test_the_norm_does_not_depend_on_threads():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    velocity = np.random.default_rng(0).normal(size=(2, *blocks.shape))
    assert gradient_norm(velocity, blocks, threads=1) == gradient_norm(velocity, blocks, threads=3)


def test_other_shapes_are_refused():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    with pytest.raises(InputError, match="velocity must have shape"):
        gradient_norm(np.zeros(blocks.shape), blocks)
