"""Laws of the fused node-to-node steps."""

import numba
import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.nodes import advect_nodes, sample_nodes
from remesh.transfer import remesh

GRIDS = [
    Grid((40, 150), 0.1, boundary="periodic"),
    Grid((30, 21), 0.1, origin=(-1, 1), boundary=("unbounded", "periodic")),
    Grid((33, 22), 0.1, boundary="unbounded"),
    Grid((12, 9, 20), 0.1, boundary=("periodic", "unbounded", "periodic")),
    Grid((8, 9, 10), 0.1, boundary="unbounded"),
]
DTYPES = [np.float32, np.float64]


def smooth(grid, cells, dtype=np.float64, seed=0):
    """A displacement of up to ``cells`` cells: runs of equal whole cells of many lengths."""
    rng = np.random.default_rng(seed)
    place = grid.points().astype(float)
    waves = [
        np.sin(np.tensordot(rng.uniform(1, 6, grid.ndim), place, 1) + rng.uniform(0, 6))
        for _ in range(grid.ndim)
    ]
    return (cells * grid.spacing * np.stack(waves)).astype(dtype)


def numpy_sample(field, displacement, grid, kernel, outside):
    """The same law in NumPy."""
    w = get_kernel(kernel)
    index = np.indices(grid.shape)
    cells = displacement / grid.spacing
    home = np.floor(cells).astype(int)
    result = np.zeros(grid.shape)
    for offset in np.ndindex(*(w.width,) * grid.ndim):
        step = home + np.reshape(offset, (-1,) + (1,) * grid.ndim) - w.half_width + 1
        weight = np.prod(w(cells - step), axis=0)
        node = index + step
        for axis, n in enumerate(grid.shape):
            if grid.periodic[axis]:
                node[axis] %= n
            else:
                if outside == "zero":
                    weight = weight * ((node[axis] >= 0) & (node[axis] < n))
                node[axis] = np.clip(node[axis], 0, n - 1)
        result += weight * field[tuple(node)]
    return result


@pytest.mark.parametrize("cells", [0.4, 7.3])
@pytest.mark.parametrize("grid", GRIDS)
def test_advected_nodes_are_remeshed_particles(grid, cells):
    field = np.random.default_rng(1).normal(size=grid.shape)
    move = smooth(grid, cells)
    places = (grid.points() + move).reshape(grid.ndim, -1).T
    particles = remesh(places, field.ravel() * grid.cell_volume, grid)
    # the particle law drops whole particles outside the box, the nodes' law only stencil parts
    safe = [slice(None) if p else slice(2, -2) for p in grid.periodic]
    found = advect_nodes(field, move, grid)
    np.testing.assert_allclose(found.field[tuple(safe)], particles.field[tuple(safe)], atol=1e-11)


@pytest.mark.parametrize("kernel", ["M4'", "M6'"])
@pytest.mark.parametrize("outside", ["zero", "nearest"])
@pytest.mark.parametrize("grid", GRIDS)
def test_sampling_equals_its_numpy_text(grid, outside, kernel):
    field = np.random.default_rng(2).normal(size=(2, *grid.shape))
    move = smooth(grid, 3.1)
    found = sample_nodes(field, move, grid, kernel, outside=outside)
    expected = [numpy_sample(part, move, grid, kernel, outside) for part in field]
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("kernel", ["M4'", "M6'"])
@pytest.mark.parametrize("grid", GRIDS)
def test_advection_is_the_adjoint_of_sampling(grid, kernel):
    rng = np.random.default_rng(3)
    f, g = rng.normal(size=(2, *grid.shape))
    for cells in (0.3, 2.7, 30.0):
        move = smooth(grid, cells)
        one = (advect_nodes(f, move, grid, kernel).field * g).sum()
        other = (f * sample_nodes(g, move, grid, kernel, outside="zero")).sum()
        assert abs(one - other) <= 1e-12 * np.abs(f).sum() * np.abs(g).max()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("grid", GRIDS)
def test_strength_is_kept_or_counted(grid, dtype):
    field = np.random.default_rng(4).normal(size=(2, *grid.shape)).astype(dtype)
    before = field.sum(axis=tuple(range(1, grid.ndim + 1)), dtype=float) * grid.cell_volume
    for cells in (0.5, 9.0, 200.0):
        found = advect_nodes(field, smooth(grid, cells, dtype), grid)
        axes = tuple(range(1, grid.ndim + 1))
        after = found.field.sum(axis=axes, dtype=float) * grid.cell_volume + found.dropped
        scale = np.abs(field).sum() * grid.cell_volume
        assert np.abs(after - before).max() <= (1e-12 if dtype is np.float64 else 2e-6) * scale


def test_first_moments_are_kept():
    grid = Grid((50, 48), 0.1, origin=(-2.5, -2.4))
    field = np.zeros(grid.shape)
    field[20:30, 20:30] = np.random.default_rng(5).normal(size=(10, 10))
    move = smooth(grid, 4.0)
    found = advect_nodes(field, move, grid)
    first = (found.field * grid.points()).sum(axis=(1, 2))
    expected = (field * (grid.points() + move)).sum(axis=(1, 2))
    np.testing.assert_allclose(first, expected, atol=1e-12 * np.abs(field).sum() * 2.5)


@pytest.mark.parametrize("grid", [GRIDS[0], GRIDS[2], GRIDS[3]])
@pytest.mark.parametrize("dtype", DTYPES)
def test_any_thread_count_gives_the_same_bits(grid, dtype):
    field = np.random.default_rng(6).normal(size=grid.shape).astype(dtype)
    move = smooth(grid, 2.0, dtype)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        base = advect_nodes(field, move, grid)
    finally:
        numba.set_num_threads(before)
    assert base.field.dtype == dtype
    for threads in (1, 2, 3):
        again = advect_nodes(field, move, grid, threads=threads)
        assert np.array_equal(base.field, again.field)
        assert np.array_equal(base.dropped, again.dropped)
    samples = [sample_nodes(field, move, grid, threads=n) for n in (1, 2, 3)]
    assert np.array_equal(samples[0], samples[1])
    assert np.array_equal(samples[0], samples[2])


@pytest.mark.parametrize("kernel", ["M4'", "M6'", "L6,6"])
def test_moving_by_whole_cells_is_exact(kernel):
    grid = Grid((14, 16), 0.1, boundary="periodic")
    field = np.random.default_rng(7).normal(size=grid.shape)
    move = np.ones((2, 14, 16)) * np.array([0.3, -0.5]).reshape(2, 1, 1)
    shifted = np.roll(field, (3, -5), axis=(0, 1))
    np.testing.assert_allclose(advect_nodes(field, move, grid, kernel).field, shifted, atol=1e-12)
    np.testing.assert_allclose(sample_nodes(shifted, move, grid, kernel), field, atol=1e-12)


def test_a_kernel_of_the_users_own_works():
    hat = Kernel("hat", 1, 1, 0, ((1, -1),), True, "linear interpolation")
    grid = Grid((30, 40), 0.1, boundary="periodic")
    field, other = np.random.default_rng(9).normal(size=(2, *grid.shape))
    move = smooth(grid, 1.3)
    expected = numpy_sample(field, move, grid, hat, "zero")
    np.testing.assert_allclose(sample_nodes(field, move, grid, hat), expected, atol=1e-13)
    moved = advect_nodes(other, move, grid, hat).field
    assert (moved * field).sum() == pytest.approx((other * expected).sum(), abs=1e-11)


def test_displacements_point_along_their_own_axis():
    grid = Grid((10, 11, 12), 0.5)
    field = np.zeros(grid.shape)
    field[5, 5, 5] = 1
    for axis in range(3):
        move = np.zeros((3, *grid.shape))
        move[axis] = 2 * 0.5
        place = [5, 5, 5]
        place[axis] = 7
        assert advect_nodes(field, move, grid).field[tuple(place)] == pytest.approx(1.0)


@pytest.mark.parametrize(("kernel", "order"), [("M4'", 3), ("M6'", 5)])
def test_one_remeshing_has_the_order_of_the_moments_kept_plus_one(kernel, order):
    errors = []
    for n in (48, 96):
        grid = Grid((n, n), 2 * np.pi / n, boundary="periodic")
        x, y = grid.points()
        move = np.ones((2, n, n)) * (0.37 * grid.spacing)
        shift = 0.37 * grid.spacing
        exact = np.sin(x - shift) * np.cos(2 * (y - shift))
        found = advect_nodes(np.sin(x) * np.cos(2 * y), move, grid, kernel).field
        errors.append(np.abs(found - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize(("kernel", "order"), [("M4'", 2), ("M6'", 4)])
def test_many_remeshings_have_one_order_less_when_the_step_follows_the_spacing(kernel, order):
    errors = []
    for n in (64, 128):
        grid = Grid((n, n), 2 * np.pi / n, boundary="periodic")
        x, y = grid.points()
        field = np.sin(x) * np.cos(2 * y)
        step = 0.37 * grid.spacing
        steps = n // 4
        for _ in range(steps):
            field = advect_nodes(field, np.full((2, n, n), step), grid, kernel).field
        exact = np.sin(x - steps * step) * np.cos(2 * (y - steps * step))
        errors.append(np.abs(field - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


def test_single_precision_keeps_its_digits_far_from_the_origin():
    near = Grid((20, 600), 0.1)
    field = np.random.default_rng(8).normal(size=near.shape)
    move = smooth(near, 1.7, np.float32)
    double = advect_nodes(field, move.astype(float), near).field
    far = Grid((20, 600), 0.1, origin=(1e6, -1e6))
    single = advect_nodes(field.astype(np.float32), move, far).field
    assert np.abs(single - double).max() <= 1e-5 * np.abs(double).max()


def test_results_can_be_written_into_an_array_of_the_users():
    grid = GRIDS[2]
    field = np.ones(grid.shape)
    move = smooth(grid, 1.0)
    out = np.empty_like(field)
    assert advect_nodes(field, move, grid, out=out).field is out
    assert sample_nodes(field, move, grid, out=out) is out
    with pytest.raises(InputError, match="shares memory"):
        advect_nodes(field, move, grid, out=field)
    with pytest.raises(InputError, match="out must be"):
        sample_nodes(field, move, grid, out=out.astype(np.float32))


def test_unusable_nodes_are_refused():
    grid = GRIDS[2]
    field, move = np.ones(grid.shape), np.zeros((2, *grid.shape))
    for axis in (0, 1):
        for value in (np.nan, np.inf, 1e300):
            broken = move.copy()
            broken[axis, 3, 4] = value
            for law in (advect_nodes, sample_nodes):
                with pytest.raises(InputError, match="displacement must be finite"):
                    law(field, broken, grid)
    with pytest.raises(InputError, match="field must have shape"):
        advect_nodes(field[1:], move, grid)
    with pytest.raises(InputError, match="displacement must have shape"):
        advect_nodes(field, move[:1], grid)
    with pytest.raises(InputError, match="outside must be"):
        sample_nodes(field, move, grid, outside="wrap")
    with pytest.raises(InputError, match="threads must be"):
        sample_nodes(field, move, grid, threads=0)


@pytest.mark.parametrize("grid", [Grid((40, 300), 0.1), Grid((12, 14, 150), 0.1)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_displacements_must_be_numbers_where_the_field_is_not_zero(grid, dtype):
    field = np.zeros(grid.shape, dtype)
    field[5] = 1.0
    move = smooth(grid, 1.0, dtype)
    for axis in range(grid.ndim):
        broken = move.copy()
        broken[(axis, 5, *np.random.default_rng(axis).integers(grid.shape[1:]))] = np.nan
        with pytest.raises(InputError, match="displacement must be finite"):
            advect_nodes(field, broken, grid)
    idle = move.copy()
    idle[1:, 9] = np.nan
    assert np.array_equal(
        advect_nodes(field, idle, grid).field, advect_nodes(field, move, grid).field
    )
