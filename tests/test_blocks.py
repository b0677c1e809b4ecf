"""Blocks: balance, tables of neighbours against a plain search, where nodes are."""

from itertools import product

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import ABSENT, OUTSIDE, Blocks
from remesh.multires.mesh import AdaptiveMesh

MESHES = [
    AdaptiveMesh(grid=Grid((256, 128), 0.1, (1.0, 2.0)), levels=3, block=8),
    AdaptiveMesh(grid=Grid((128, 256), 0.1, boundary="periodic"), levels=4, block=8),
    AdaptiveMesh(
        grid=Grid((64, 64, 128), 0.1, boundary=("periodic", "unbounded", "unbounded")),
        levels=2,
        block=8,
    ),
    AdaptiveMesh(grid=Grid((64, 64, 64), 0.1, boundary="periodic"), levels=3, block=8),
]
SIDES = ["2-D", "2-D periodic", "3-D mixed", "3-D periodic"]
meshes = pytest.mark.parametrize("mesh", MESHES, ids=SIDES)


def scattered(mesh, seed=0, number=3):
    rng = np.random.default_rng(seed)
    none = np.empty((0, mesh.ndim), np.int64)
    return [none] + [
        rng.integers(0, mesh.counts(level), (number, mesh.ndim))
        for level in range(1, mesh.levels + 1)
    ]


def numbers(blocks):
    """Level and place to number."""
    levels = blocks.levels.tolist()
    return {
        (lv, *p): n for n, (lv, p) in enumerate(zip(levels, blocks.places.tolist(), strict=True))
    }


def placed(mesh, level, place):
    """The place with periodic axes wrapped, or None outside."""
    result = []
    for p, count, wraps in zip(place, mesh.counts(level), mesh.grid.periodic, strict=True):
        if not wraps and not 0 <= p < count:
            return None
        result.append(p % count)
    return tuple(result)


@meshes
def test_wanted_blocks_are_there_and_each_level_is_in_c_order(mesh):
    wanted = scattered(mesh)
    blocks = Blocks.around(mesh, wanted)
    for level, places in enumerate(wanted):
        assert (blocks.numbers_of(level, places) >= 0).all()
        own = blocks.places[blocks.of(level)]
        keys = np.ravel_multi_index(tuple(own.T), mesh.counts(level))
        assert (np.diff(keys) > 0).all()
    assert (np.diff(blocks.keys) > 0).all()
    assert blocks.starts[1] == np.prod(mesh.counts(0))


@meshes
def test_under_each_block_and_its_neighbours_lies_a_coarser_block(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    known = numbers(blocks)
    for level, *place in known:
        for step in product((-1, 0, 1), repeat=mesh.ndim):
            beside = placed(mesh, level, np.add(place, step))
            if level and beside is not None:
                assert (level - 1, *(p // 2 for p in beside)) in known


@meshes
def test_no_block_is_there_without_need(mesh):
    wanted = scattered(mesh)
    blocks = Blocks.around(mesh, wanted)
    needed = {(0, *p) for p in product(*(range(n) for n in mesh.counts(0)))}
    needed |= {(lv, *p) for lv, places in enumerate(wanted) for p in places.tolist()}
    for level in range(mesh.levels, 0, -1):
        for _, *place in [some for some in needed if some[0] == level]:
            for step in product((-1, 0, 1), repeat=mesh.ndim):
                beside = placed(mesh, level, np.add(place, step))
                if beside is not None:
                    needed.add((level - 1, *(p // 2 for p in beside)))
    assert set(numbers(blocks)) == needed


@meshes
def test_tables_tell_what_a_plain_search_finds(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    known = numbers(blocks)
    steps = list(product((-1, 0, 1), repeat=mesh.ndim))
    for (level, *place), n in known.items():
        for k, step in enumerate(steps):
            beside = placed(mesh, level, np.add(place, step))
            if beside is None:
                assert blocks.neighbours[n, k] == blocks.coarser[n, k] == OUTSIDE
                continue
            assert blocks.neighbours[n, k] == known.get((level, *beside), ABSENT)
            under = known[level - 1, *(p // 2 for p in beside)] if level else OUTSIDE
            assert blocks.coarser[n, k] == under
        for k, corner in enumerate(product((0, 1), repeat=mesh.ndim)):
            finer = (level + 1, *(2 * p + q for p, q in zip(place, corner, strict=True)))
            assert blocks.children[n, k] == known.get(finer, ABSENT)
    assert (blocks.sides[:, 3 - mesh.ndim :] == blocks.places % 2).all()


@meshes
def test_numbers_are_found_by_place_with_periodic_axes_wrapped(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    known = numbers(blocks)
    rng = np.random.default_rng(1)
    for level in range(mesh.levels + 1):
        count = np.array(mesh.counts(level))
        places = rng.integers(-2, count + 2, (50, mesh.ndim))
        for place, found in zip(places, blocks.numbers_of(level, places), strict=True):
            inside = placed(mesh, level, place.tolist())
            want = OUTSIDE if inside is None else known.get((level, *inside), ABSENT)
            assert found == want


@meshes
def test_blocks_find_themselves_in_another_mesh(mesh):
    one, other = (Blocks.around(mesh, scattered(mesh, seed)) for seed in (0, 1))
    known = numbers(other)
    found = one.found_in(other)
    assert found.tolist() == [known.get(key, ABSENT) for key in numbers(one)]


@meshes
def test_places_alone_make_the_same_blocks_again(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    again = Blocks(mesh, blocks.places.copy(), blocks.starts)
    assert (again.keys == blocks.keys).all()
    assert (again.neighbours == blocks.neighbours).all()


@meshes
def test_active_nodes_are_those_that_no_finer_block_covers(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    leaves = blocks.leaves()
    assert leaves.sum() == blocks.active
    volume = sum(
        leaves[blocks.of(level)].sum() * mesh.spacing(level) ** mesh.ndim
        for level in range(mesh.levels + 1)
    )
    assert volume == pytest.approx(mesh.grid.size * mesh.grid.spacing**mesh.ndim, rel=1e-12)
    assert blocks.compression == mesh.grid.size / blocks.active


@meshes
def test_nodes_of_a_block_are_nodes_of_its_level(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    points = blocks.points()
    for n in (0, blocks.size // 2, blocks.size - 1):
        axes = mesh.level_grid(int(blocks.levels[n])).axes()
        for axis in range(mesh.ndim):
            start = blocks.places[n, axis] * mesh.block
            along = np.moveaxis(points[axis, n], axis, -1)
            want = axes[axis][start : start + mesh.block]
            assert np.allclose(along, want, rtol=0, atol=1e-12)


def test_a_uniform_mesh_is_complete_up_to_its_level():
    mesh = MESHES[0]
    blocks = Blocks.uniform(mesh, 2)
    assert blocks.starts == (0, 8, 8 + 32, 8 + 32 + 128, 8 + 32 + 128)
    assert blocks.finest == 2
    assert blocks.active == mesh.grid.size // 4


def test_places_for_more_levels_than_there_are_are_refused():
    none = np.empty((0, 2), np.int64)
    with pytest.raises(InputError, match="levels 0 to 3"):
        Blocks.around(MESHES[0], [none] * 5)


@meshes
def test_places_of_another_number_of_axes_are_refused(mesh):
    for wrong in ((3, mesh.ndim + 1), (mesh.ndim,), (2, 2, mesh.ndim)):
        with pytest.raises(InputError, match=r"places of blocks must have shape"):
            Blocks.around(mesh, [np.zeros(wrong, int)])


@meshes
def test_each_block_knows_the_spacing_of_its_level(mesh):
    blocks = Blocks.around(mesh, scattered(mesh))
    for level in range(mesh.levels + 1):
        assert (blocks.spacings[blocks.of(level)] == mesh.spacing(level)).all()
