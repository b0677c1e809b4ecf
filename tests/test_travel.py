"""Laws of particles that are carried and remeshed on an adaptive mesh."""

import numpy as np
import pytest
from nested_blocks import at_nodes, cells, dense, nested, recipe

from remesh.errors import InputError
from remesh.multires.adapt import adapt
from remesh.multires.blocks import Blocks
from remesh.multires.landing import landing
from remesh.multires.pyramid import forward, restricted
from remesh.multires.travel import carried
from remesh.nodes import advect_nodes

CENTER = (0.4, 0.45, 0.5)


def gaussian(points, width, center=CENTER):
    """A Gaussian of height one."""
    return np.exp(-sum((x - c) ** 2 for x, c in zip(points, center, strict=False)) / 2 / width**2)


def swirl(points, way, angle, shear=0.0, center=CENTER):
    """Displacement: a turn and a shear about the centre, then ``way``; smooth and periodic."""
    near = [np.sin(2 * np.pi * (x - c)) / (2 * np.pi) for x, c in zip(points, center, strict=False)]
    fade = np.exp(-sum(x**2 for x in near[:2]) / 2 / 0.1**2)
    result = np.zeros_like(points)
    result[0] = fade * ((np.cos(angle) - 1) * near[0] - (np.sin(angle) - shear) * near[1])
    result[1] = fade * (np.sin(angle) * near[0] + (np.cos(angle) - 1) * near[1])
    return result + np.reshape(way, (-1,) + (1,) * (points.ndim - 1))


def spot(ndim, nodes, width, levels=2, **more):
    """Blocks around a Gaussian so wide that nothing of it is left where they end; its values."""
    mesh = recipe(nodes, ndim, levels, **more)
    blocks = nested(mesh, CENTER[:ndim], 6.5 * width)
    return blocks, restricted(gaussian(blocks.points(), width), blocks)


def move(blocks, values, displacement, kernel="M6'"):
    """Values on the blocks where what is not negligible lands."""
    target = landing(blocks, displacement, cells(np.abs(values) > 1e-9, blocks))
    return target, carried(values, displacement, blocks, target, kernel)


@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
@pytest.mark.parametrize(
    ("ndim", "kernel", "dtype"),
    [
        (2, "M4'", np.float64), (2, "M6'", np.float64), (2, "M6'", np.float32),
        (2, "L8,4", np.float64), (3, "M6'", np.float64), (3, "M4'", np.float32),
    ],
)  # fmt: skip
def test_on_a_complete_level_nodes_are_remeshed_as_on_a_uniform_grid(ndim, kernel, boundary, dtype):
    mesh = recipe(64, ndim, levels=1, boundary=boundary)
    blocks = Blocks.uniform(mesh, 1)
    field = np.random.default_rng(0).normal(size=blocks.shape).astype(dtype)
    moves = swirl(blocks.points(), [0.31, -0.07, -0.4][:ndim], 0.3).astype(dtype)
    found = carried(field, moves, blocks, blocks, kernel)
    uniform = np.stack([dense(part, blocks, 1) for part in moves])
    expected = advect_nodes(dense(field, blocks, 1), uniform, mesh.grid, kernel)
    np.testing.assert_allclose(
        dense(found.values, blocks, 1), expected.field, atol=100 * np.finfo(dtype).eps
    )
    assert found.values.dtype == dtype


@pytest.mark.parametrize("cells_moved", [0, 1, 8, 20, 37.3])
def test_a_spot_moved_any_distance_is_as_good_as_on_the_finest_uniform_grid(cells_moved):
    blocks, values = spot(2, 512, 5 / 512, levels=3)
    mesh, way = blocks.mesh, np.array([1.0, 0.3]) * cells_moved / 512
    moves = swirl(blocks.points(), way, 0.0)
    target, found = move(blocks, values, moves)
    points = mesh.grid.points()
    uniform = advect_nodes(
        gaussian(points, 5 / 512), swirl(points, way, 0.0), mesh.grid, "M6'"
    ).field
    leaves = target.leaves()
    for level in range(mesh.levels + 1):
        own = target.of(level)
        error = np.abs(found.values[own] - at_nodes(uniform, target, level))
        assert error[leaves[own]].max(initial=0) < 1e-7
    before, after = values[blocks.of(0)].sum(), found.values[target.of(0)].sum()
    assert abs(after - before) < 1e-8 * before


@pytest.mark.parametrize(("ndim", "nodes", "levels"), [(2, 256, 2), (3, 128, 1)])
@pytest.mark.parametrize(("angle", "shear"), [(0.4, 0.0), (0.0, 0.4)])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 2e-6), (np.float32, 6e-6)])
def test_turned_and_sheared_spots_agree_with_the_uniform_grid(
    ndim, nodes, levels, angle, shear, dtype, tolerance
):
    blocks, values = spot(ndim, nodes, 4 / nodes, levels)
    mesh, way = blocks.mesh, np.array([0.1, 0.03, 0.01])[:ndim]
    moves = swirl(blocks.points(), way, angle, shear).astype(dtype)
    target, found = move(blocks, values.astype(dtype), moves)
    points = mesh.grid.points()
    uniform = advect_nodes(
        gaussian(points, 4 / nodes), swirl(points, way, angle, shear), mesh.grid, "M6'"
    ).field
    own = target.of(levels)
    error = np.abs(found.values[own] - at_nodes(uniform, target, levels))
    assert error[target.leaves()[own]].max() < tolerance


@pytest.mark.parametrize(
    ("ndim", "nodes", "levels", "block"),
    [(2, 256, 3, 16), (2, 256, 3, 8), (3, 64, 1, 16), (3, 128, 2, 8)],
)
@pytest.mark.parametrize(("kernel", "degree"), [("M4'", 2), ("M6'", 3)])
@pytest.mark.parametrize("cells_moved", [1.3, 9.6])
def test_polynomials_are_carried_exactly_across_the_ends_of_refined_regions(
    ndim, nodes, levels, block, kernel, degree, cells_moved
):
    mesh = recipe(nodes, ndim, levels, "unbounded", block)
    blocks = nested(mesh, CENTER[:ndim], 0.05)
    way = np.array([1.0, -0.4, 0.7])[:ndim] * cells_moved / nodes

    def law(points):
        return 1 + sum((k + 1) * (x - 0.3) ** degree for k, x in enumerate(points))

    moves = swirl(blocks.points(), way, 0.0)
    target = landing(blocks, moves, np.ones((blocks.size, *(block // 4,) * ndim), bool))
    found = carried(law(blocks.points()), moves, blocks, target, kernel)
    places = target.points()
    expected = law(places - way.reshape(-1, *(1,) * (ndim + 1)))
    for level in range(1, mesh.levels + 1):
        own = target.of(level)
        inside = np.all(np.abs(places[:, own] - 0.5) < 0.2, axis=0)  # far from the ends
        assert inside.any()
        error = np.abs(found.values[own] - expected[own])[inside]
        assert error.max() < 1e-12


@pytest.mark.parametrize("wavelet", ["2.2", "4.2", "4.4", "6.2"])
def test_details_vanish_where_their_lifting_reaches_past_a_region(wavelet):
    mesh = recipe(256, 2, 2, wavelet=wavelet)
    blocks = nested(mesh, CENTER[:2], 0.12)
    values = restricted(gaussian(blocks.points(), 0.1), blocks)  # goes on past the regions
    moves = swirl(blocks.points(), (0.03, 0.01), 0.2)
    target = landing(blocks, moves, cells(values > 0.99, blocks))  # ends within what is moved
    found = carried(values, moves, blocks, target)
    spilt = forward(found.values, target, spill=True).smooth
    np.testing.assert_allclose(spilt, forward(found.values, target).smooth, atol=1e-14)


def test_shifts_by_whole_nodes_of_all_levels_change_nothing():
    blocks, values = spot(2, 256, 4 / 256)
    way = np.array([8, -4]) / 256
    target, found = move(blocks, values, swirl(blocks.points(), way, 0.0))
    expected = gaussian(target.points() - way.reshape(2, 1, 1, 1), 4 / 256)
    own = target.of(2)
    assert np.abs(found.values[own] - expected[own]).max() < 1e-8


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_many_steps_keep_sums_and_errors_to_the_tolerance(tolerance):
    mesh = recipe(256, 2, 3, "unbounded", tolerance=tolerance)
    points = mesh.grid.points()
    uniform = gaussian(points, 0.02, (0.5, 0.45))
    full = Blocks.uniform(mesh, 3)
    state = adapt(restricted(gaussian(full.points(), 0.02, (0.5, 0.45)), full), full)
    first = state.fields[state.blocks.of(0)].sum()
    for _ in range(10):
        moves = swirl(state.blocks.points(), (0.02, 0.01), 0.3)
        target = landing(state.blocks, moves, state.busy)
        found = carried(state.fields, moves, state.blocks, target)
        state = adapt(found.values, target)
        uniform = advect_nodes(uniform, swirl(points, (0.02, 0.01), 0.3), mesh.grid, "M6'").field
    last = state.fields[state.blocks.of(0)].sum()
    assert abs(last - first) < 0.5 * tolerance * first
    leaves = state.blocks.leaves()
    for level in range(mesh.levels + 1):
        own = state.blocks.of(level)
        error = np.abs(state.fields[own] - at_nodes(uniform, state.blocks, level))
        assert error[leaves[own]].max(initial=0) < 10 * tolerance


@pytest.mark.parametrize(("ndim", "nodes"), [(2, 128), (3, 64)])
def test_what_leaves_through_unbounded_ends_is_told(ndim, nodes):
    mesh = recipe(nodes, ndim, 1, "unbounded")
    blocks = Blocks.uniform(mesh, 0)
    values = np.random.default_rng(1).normal(size=(2, *blocks.shape))
    moves = swirl(blocks.points(), [0.4, -0.2, 0.1][:ndim], 0.0)
    found = carried(values, moves, blocks, blocks)
    axes = tuple(range(1, ndim + 2))
    volume = mesh.spacing(0) ** ndim
    np.testing.assert_allclose(
        found.lost, volume * (values.sum(axis=axes) - found.values.sum(axis=axes)), atol=1e-13
    )
    assert np.all(found.lost != 0)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("place", [0.02, 0.98])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 128)])
def test_what_crosses_an_end_is_told_where_finer_blocks_touch_it(ndim, nodes, place, dtype):
    mesh = recipe(nodes, ndim, 2, "unbounded", 8)
    blocks = nested(mesh, (place, *(0.5,) * (ndim - 1)), 20 / nodes)
    middle = np.array([place, *(0.5,) * (ndim - 1)]).reshape(-1, *(1,) * (ndim + 1))
    spot = np.exp(-(((blocks.points() - middle) * nodes / 4) ** 2).sum(axis=0) / 2)
    values = restricted(np.stack([spot, 0 * spot]), blocks).astype(dtype)
    moves = np.zeros((ndim, *blocks.shape), dtype)
    total, lost = values[0, blocks.of(0)].sum() * mesh.spacing(0) ** ndim, 0.0
    kept = 1e-12 if dtype == np.float64 else 3e-6
    for _ in range(3):
        moves[0] = (3.4 if place > 0.5 else -3.4) / nodes
        found = carried(values, moves, blocks, blocks)
        values, lost = found.values, lost + found.lost[0]
        now = values[0, blocks.of(0)].sum() * mesh.spacing(0) ** ndim
        assert now + lost == pytest.approx(total, rel=kept)
        assert found.lost[1] == 0
    assert now < 0.7 * total
    moves[0] *= 9  # the rest
    assert carried(values, moves, blocks, blocks).lost[0] == pytest.approx(now, rel=0.02)


def test_nothing_is_lost_where_nothing_leaves():
    blocks, values = spot(2, 256, 4 / 256, boundary="unbounded")
    _, found = move(blocks, values, swirl(blocks.points(), (0.1, 0.1), 0.3))
    assert abs(found.lost) < 1e-12
    assert found.lost.shape == ()


def test_results_do_not_depend_on_threads_nor_on_fields_beside():
    blocks, values = spot(2, 256, 4 / 256)
    moves = swirl(blocks.points(), (0.1, 0.03), 0.3)
    target, alone = move(blocks, values, moves)
    both = carried(np.stack([values, values**2]), moves, blocks, target, threads=3)
    np.testing.assert_array_equal(both.values[0], alone.values)


def test_periodic_axes_wrap():
    blocks, values = spot(2, 256, 4 / 256)
    near = move(blocks, values, swirl(blocks.points(), (0.25, 0.5), 0.0))
    far = move(blocks, values, swirl(blocks.points(), (3.25, -1.5), 0.0))
    np.testing.assert_array_equal(near[0].places, far[0].places)
    np.testing.assert_allclose(near[1].values, far[1].values, atol=1e-13)


def test_unusable_input_is_refused():
    blocks, values = spot(2, 128, 4 / 128)
    moves = swirl(blocks.points(), (0.1, 0.0), 0.0)
    other = Blocks.uniform(recipe(256), 0)
    with pytest.raises(InputError, match="one mesh"):
        carried(values, moves, blocks, other)
    with pytest.raises(InputError, match="displacement must have shape"):
        carried(values, moves[0], blocks, blocks)
    with pytest.raises(InputError, match="values must have shape"):
        carried(values[1:], moves, blocks, blocks)
    moves[1, 3, 2, 1] = np.nan
    with pytest.raises(InputError, match="must be finite"):
        carried(values, moves, blocks, blocks)
    torn = np.random.default_rng(0).normal(size=moves.shape)
    for size in (9.0, 1e6):
        with pytest.raises(InputError, match="smaller time step"):
            carried(values, torn * size, blocks, blocks)
