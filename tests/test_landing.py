"""Laws of the blocks that a flow carries along."""

import numpy as np
import pytest
from nested_blocks import cells, nested, recipe

from remesh.errors import InputError
from remesh.multires.blocks import Blocks
from remesh.multires.landing import landing


def places(blocks, level):
    """The places of a level's blocks, as a set."""
    return {tuple(map(int, place)) for place in blocks.places[blocks.of(level)]}


def touched(blocks, displacement, busy, level, buffer):
    """The same law in Python: blocks of a level that boxes around moved busy cells touch."""
    mesh, block = blocks.mesh, blocks.mesh.block
    found = set()
    for number in range(blocks.starts[level], blocks.starts[level + 1]):
        for cell in np.argwhere(busy[number]):
            part = (number, *(slice(4 * c, 4 * c + 4) for c in cell))
            local = np.indices((4,) * mesh.ndim) + 4 * cell.reshape(-1, *(1,) * mesh.ndim)
            start = blocks.places[number].reshape(-1, *(1,) * mesh.ndim) * block
            nodes = start + local + displacement[(slice(None), *part)] / mesh.spacing(level)
            nodes = nodes.reshape(mesh.ndim, -1)
            low = (np.floor(nodes.min(axis=1)) - buffer) // block
            high = (np.floor(nodes.max(axis=1)) + 1 + buffer) // block
            for offset in np.ndindex(*(high - low + 1).astype(int)):
                place = [int(a + o) for a, o in zip(low, offset, strict=True)]
                for axis, count in enumerate(mesh.counts(level)):
                    if mesh.grid.periodic[axis]:
                        place[axis] %= count
                if all(0 <= p < n for p, n in zip(place, mesh.counts(level), strict=True)):
                    found.add(tuple(place))
    return found


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
@pytest.mark.parametrize(("ndim", "nodes", "block"), [(2, 256, 16), (2, 128, 8), (3, 64, 8)])
@pytest.mark.parametrize("buffer", [0, 8])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_blocks_are_wanted_where_moved_busy_cells_and_their_buffer_lie(
    ndim, nodes, block, boundary, buffer, dtype
):
    mesh = recipe(nodes, ndim, 2, boundary, block)
    blocks = nested(mesh, (0.3, 0.6, 0.5)[:ndim], 0.05)
    rng = np.random.default_rng(3)
    busy = rng.uniform(size=(blocks.size, *(block // 4,) * ndim)) < 0.1
    x = blocks.points()
    move = np.stack([0.21 + 0.2 * np.sin(3 * x[1] + k) * x[0] for k in range(ndim)]).astype(dtype)
    target = landing(blocks, move, busy, buffer=buffer)
    wanted = [touched(blocks, move, busy, level, buffer) for level in range(1, 3)]
    balanced = Blocks.around(
        mesh,
        [np.empty((0, ndim), int)]
        + [np.array(sorted(some), int).reshape(-1, ndim) for some in wanted],
    )
    np.testing.assert_array_equal(target.places, balanced.places)
    assert all(some <= places(target, level) for level, some in enumerate(wanted, 1))


def test_a_region_goes_with_the_flow_and_leaves_nothing_behind():
    mesh = recipe(512, 2, 3)
    blocks = nested(mesh, (0.25, 0.25), 0.03)
    points = blocks.points()
    busy = cells(np.hypot(points[0] - 0.25, points[1] - 0.25) < 0.02, blocks)
    move = np.full((2, *blocks.shape), 0.5)  # 256 finest cells
    target = landing(blocks, move, busy)
    still = landing(blocks, 0 * move, busy)
    for level in (1, 2, 3):
        shift = int(0.5 / mesh.spacing(level)) // mesh.block
        moved = {
            tuple((c + shift) % mesh.counts(level)[0] for c in p) for p in places(still, level)
        }
        assert places(target, level) == moved


def test_nothing_busy_leaves_the_coarsest_level():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    target = landing(blocks, np.zeros((2, *blocks.shape)), np.zeros((blocks.size, 4, 4), bool))
    assert target.size == target.starts[1]


def test_particles_beyond_unbounded_ends_are_followed_no_more():
    blocks = nested(recipe(128, boundary="unbounded"), (0.5, 0.5), 0.1)
    busy = np.ones((blocks.size, 4, 4), bool)
    target = landing(blocks, np.full((2, *blocks.shape), 3.0), busy)
    assert target.size == target.starts[1]


def test_a_flow_that_goes_round_many_times_takes_the_whole_level_once():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    move = 40 * blocks.points()
    target = landing(blocks, move, np.ones((blocks.size, 4, 4), bool))
    assert target.size == Blocks.uniform(blocks.mesh, 2).size


def test_unusable_input_is_refused():
    blocks = nested(recipe(128), (0.5, 0.5), 0.1)
    busy = np.ones((blocks.size, 4, 4), bool)
    move = np.zeros((2, *blocks.shape))
    with pytest.raises(InputError, match="displacement must have shape"):
        landing(blocks, move[:, 1:], busy)
    with pytest.raises(InputError, match="busy must have shape"):
        landing(blocks, move, busy[1:])
    move[0, -1] = np.inf
    with pytest.raises(InputError, match="must be finite"):
        landing(blocks, move, busy)
    busy[-1] = False
    landing(blocks, move, busy)  # where nothing is busy nothing is read
