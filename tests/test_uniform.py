"""Uniform fields from blocks and back: copies, subdivisions, boxes."""

import numpy as np
import pytest
from nested_blocks import nested, recipe
from scattered_blocks import SIDES, cube, noise, scattered

from remesh.errors import InputError
from remesh.multires import pyramid, transform
from remesh.multires.blocks import ABSENT, OUTSIDE, Blocks
from remesh.multires.uniform import on_blocks, to_uniform


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("side", SIDES)
def test_nodes_of_blocks_are_copied_on_every_level(side, dtype):
    blocks = scattered(side)
    mesh = blocks.mesh
    values = noise(blocks, 2, dtype=dtype)
    for level in range(mesh.levels + 1):
        field = to_uniform(values, blocks, level)
        assert field.shape == (2, *mesh.level_grid(level).shape)
        assert field.dtype == dtype
        for n in range(*blocks.starts[level : level + 2]):
            start = blocks.places[n] * mesh.block
            box = tuple(slice(s, s + mesh.block) for s in start)
            assert (field[(slice(None), *box)] == values[:, n]).all()


@pytest.mark.parametrize("side", ["2-D periodic", "3-D"])
def test_without_finer_blocks_the_field_is_subdivided_without_details(side):
    mesh = scattered(side).mesh
    blocks = Blocks.uniform(mesh, 0)
    values = noise(blocks)
    field = to_uniform(values, blocks, 1)
    even = (slice(None, None, 2),) * mesh.ndim
    assert (field[even] == to_uniform(values, blocks, 0)).all()
    if side == "2-D periodic":
        details = transform.forward(field, mesh.level_grid(1), "4.0", 1)
        details[even] = 0
        assert abs(details).max() < 1e-13


@pytest.mark.parametrize("ndim", [2, 3])
def test_it_is_the_inverse_transform_of_details_kept_away_from_jumps(ndim):
    blocks = cube(ndim, 3)
    mesh = blocks.mesh
    inner = (blocks.neighbours != -1).all(axis=1)
    details = pyramid.forward(noise(blocks), blocks).details
    details[~inner] = 0
    smooth = noise(blocks)
    values = pyramid.inverse(smooth, details, blocks)
    complete = Blocks.uniform(mesh, 1)
    number = complete.found_in(blocks)
    parts = [
        np.where((number >= 0).reshape(-1, *(1,) * ndim), p[number], 0) for p in (smooth, details)
    ]
    want = pyramid.inverse(*parts, complete)
    found = to_uniform(values, blocks)
    assert np.allclose(found, to_uniform(want, complete), rtol=0, atol=1e-12)


@pytest.mark.parametrize("side", SIDES)
def test_a_box_is_that_part_of_the_whole_bit_for_bit(side):
    blocks = scattered(side)
    values = noise(blocks)
    whole = to_uniform(values, blocks)
    rng = np.random.default_rng(4)
    for _ in range(5):
        ends = [np.sort(rng.choice(n + 1, 2, replace=False)) for n in whole.shape]
        box = tuple(slice(int(a), int(b)) for a, b in ends)
        assert (to_uniform(values, blocks, region=box) == whole[box]).all()
        same = tuple(range(*part.indices(10**6)) for part in box)
        assert (to_uniform(values, blocks, region=same) == whole[box]).all()


def test_ranges_pass_periodic_ends_and_find_zeros_beyond_others():
    blocks = scattered("3-D mixed")
    values = noise(blocks)
    whole = to_uniform(values, blocks)
    region = (range(-5, 3), range(-4, 4), range(90, 100))
    found = to_uniform(values, blocks, region=region)
    assert (found[:, :4] == 0).all()
    want = np.take(
        np.take(whole[:, :4], region[0], axis=0, mode="wrap"), region[2], axis=2, mode="wrap"
    )
    assert (found[:, 4:] == want).all()


@pytest.mark.parametrize("side", SIDES)
def test_a_field_on_all_finest_nodes_comes_back_as_it_was(side):
    mesh = scattered(side).mesh
    field = np.random.default_rng(0).standard_normal((2, *mesh.grid.shape))
    blocks = Blocks.uniform(mesh, mesh.levels)
    assert (to_uniform(on_blocks(field, blocks), blocks) == field).all()


@pytest.mark.parametrize("wavelet", ["2.2", "4.4", "6.2"])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
@pytest.mark.parametrize("place", [0.0, 1.0])
def test_constants_and_cubics_go_on_to_unbounded_ends_which_finer_blocks_touch(
    ndim, nodes, place, wavelet
):
    mesh = recipe(nodes, ndim, 2, "unbounded", 8, wavelet=wavelet)
    blocks = nested(mesh, (place, 0.4, place)[:ndim], 0.05)
    assert (blocks.neighbours[blocks.of(2)] == OUTSIDE).any()
    assert (blocks.neighbours[blocks.of(1)] == ABSENT).any()
    one = to_uniform(np.ones(blocks.shape), blocks, outside="last")
    assert abs(one - 1).max() < 1e-12
    degree = 1 if wavelet == "2.2" else 3

    def law(points):
        return sum((k + 1) * (x - 0.3) ** degree for k, x in enumerate(points))

    for level in (1, 2):
        found = to_uniform(law(blocks.points()), blocks, level, outside="last")
        assert abs(found - law(mesh.level_grid(level).points())).max() < 1e-12


@pytest.mark.parametrize("side", ["2-D", "3-D mixed"])
def test_beyond_ends_the_last_node_goes_on_where_asked_for(side):
    blocks = scattered(side)
    values = noise(blocks, 2)
    whole = to_uniform(values, blocks, outside="last")
    region = [range(-5, 30), range(40, whole.shape[2] + 7), range(90, 100)][: whole.ndim - 1]
    found = to_uniform(values, blocks, region=region, outside="last")
    for axis, nodes in enumerate(region):
        mode = "wrap" if blocks.mesh.grid.periodic[axis] else "clip"
        whole = whole.take(nodes, axis=1 + axis, mode=mode)
    assert (found == whole).all()
    far = [range(-9, -5), range(1000, 1003), range(5, 7)][: found.ndim - 1]
    ends = to_uniform(values, blocks, region=far, outside="last")
    assert ends.shape[1:] == tuple(len(part) for part in far)
    assert np.ptp(ends, axis=2).max() == 0


def test_what_does_not_lie_on_the_mesh_is_refused():
    blocks = scattered("2-D")
    values = noise(blocks)
    with pytest.raises(InputError, match="level must be a whole number from 0 to 3"):
        to_uniform(values, blocks, 4)
    with pytest.raises(InputError, match="outside must be 'zero' or 'last', got 'wall'"):
        to_uniform(values, blocks, outside="wall")
    with pytest.raises(InputError, match="level must be a whole number"):
        to_uniform(values, blocks, float("nan"))
    with pytest.raises(InputError, match="region must hold slices or ranges of nodes, got \\(0"):
        to_uniform(values, blocks, region=[(0, 4), (0, 4)])
    with pytest.raises(InputError, match="region must be 2 slices"):
        to_uniform(values, blocks, region=(slice(0, 3),))
    for part in (slice(0, 8, 2), slice(5, 5), range(4, 0, -1)):
        with pytest.raises(InputError, match="region must hold whole runs"):
            to_uniform(values, blocks, region=(part, slice(0, 3)))
