"""Values carried to other blocks: copies where both have them, subdivisions elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from scattered_blocks import SIDES, noise, scattered

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires import pyramid
from remesh.multires.blocks import Blocks
from remesh.multires.carrying import transferred
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled
from remesh.multires.uniform import to_uniform


def joined(one, other):
    return Blocks.of_keys(one.mesh, np.concatenate([one.keys, other.keys]))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("side", SIDES)
def test_blocks_of_both_meshes_are_copied_bit_for_bit(side, dtype):
    one, other = scattered(side, seed=0), scattered(side, seed=1)
    values = noise(one, 2, dtype=dtype)
    found = transferred(values, one, other)
    number = other.found_in(one)
    assert found.dtype == dtype
    assert (found[:, number >= 0] == values[:, number[number >= 0]]).all()
    assert np.isfinite(found).all()


@pytest.mark.parametrize("side", SIDES)
def test_to_more_blocks_and_back_is_no_change(side):
    one = scattered(side, seed=0)
    more = joined(one, scattered(side, seed=1))
    values = noise(one)
    assert more.size > one.size
    assert (transferred(transferred(values, one, more), more, one) == values).all()


@pytest.mark.parametrize("ndim", [2, 3])
def test_more_blocks_hold_the_same_field_and_stay_consistent(ndim):
    nodes = 256 if ndim == 2 else 64
    mesh = AdaptiveMesh(grid=Grid((nodes,) * ndim, 1 / nodes), levels=2, block=8, tolerance=1e-3)
    blocks, values = sampled(lambda x: np.exp(-((x - 0.5) ** 2).sum(axis=0) / 0.08**2), mesh)
    none = np.empty((0, ndim), np.int64)
    places = np.random.default_rng(0).integers(0, mesh.counts(2), (5, ndim))
    more = joined(blocks, Blocks.around(mesh, [none, none, places]))
    assert more.size > blocks.size
    found = transferred(values, blocks, more)
    assert np.allclose(to_uniform(found, more), to_uniform(values, blocks), rtol=0, atol=1e-14)
    assert np.allclose(pyramid.restricted(found, more), found, rtol=0, atol=1e-14)


def test_bits_do_not_depend_on_threads():
    one, other = scattered("3-D", seed=0), scattered("3-D", seed=1)
    values = noise(one)
    assert (
        transferred(values, one, other, threads=1) == transferred(values, one, other, threads=3)
    ).all()


def test_meshes_may_differ_in_their_thresholds_only():
    one, other = scattered("2-D", seed=0), scattered("2-D", seed=1)
    values = noise(one)
    finer = Blocks(replace(one.mesh, tolerance=1e-5), other.places, other.starts)
    assert (transferred(values, one, finer) == transferred(values, one, other)).all()
    strange = Blocks(replace(one.mesh, wavelet="2.2"), other.places, other.starts)
    with pytest.raises(InputError, match="must be blocks of one mesh"):
        transferred(values, one, strange)
