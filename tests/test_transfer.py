"""Laws of the exchange between particles and mesh."""

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import KERNELS, get_kernel
from remesh.transfer import m2p, p2m, remesh

GRIDS = [
    Grid((13, 17), 0.25, origin=(-1.0, 2.0), boundary="periodic"),
    Grid((24, 11), 0.25, origin=(-1.0, 2.0), boundary=("unbounded", "periodic")),
    Grid((12, 11), 0.25, boundary="unbounded"),
    Grid((8, 9, 7), 0.5, boundary=("periodic", "unbounded", "periodic")),
    Grid((9, 8, 10), 0.5, origin=(1.0, -1.0, 0.0), boundary="unbounded"),
]
KINDS = ["M4'", "M6'", "M8'"]


def cloud(grid, n, seed=0, margin=0.0, dtype=np.float64):
    """Random particles inside the box, ``margin`` cells away from its unbounded edges."""
    rng = np.random.default_rng(seed)
    low = np.array(grid.origin) + margin * grid.spacing
    high = low + np.array(grid.length) - 2 * margin * grid.spacing
    return (low + (high - low) * rng.random((n, grid.ndim))).astype(dtype)


def numpy_p2m(positions, strengths, grid, kernel):
    """The same law in NumPy, and the strength that misses the mesh."""
    w = get_kernel(kernel)
    field, lost = np.zeros(grid.shape), 0.0
    cells = (positions - grid.origin) / grid.spacing
    home = np.floor(cells).astype(int)
    for offset in np.ndindex(*(w.width,) * grid.ndim):
        node = home + np.array(offset) - w.half_width + 1
        value = strengths * np.prod(w(cells - node), axis=1)
        inside = np.ones(len(node), bool)
        for axis, n in enumerate(grid.shape):
            if grid.periodic[axis]:
                node[:, axis] %= n
            else:
                inside &= (node[:, axis] >= 0) & (node[:, axis] < n)
        np.add.at(field, tuple(node[inside].T), value[inside])
        lost += value[~inside].sum()
    return field / grid.cell_volume, lost


@pytest.mark.parametrize("kernel", ["M4'", "M6'"])
@pytest.mark.parametrize("grid", GRIDS)
def test_p2m_equals_its_numpy_text(grid, kernel):
    x = cloud(grid, 300)
    q = np.random.default_rng(1).normal(size=300)
    field, lost = numpy_p2m(x, q, grid, kernel)
    found = remesh(x, q, grid, kernel)
    np.testing.assert_allclose(found.field, field, atol=1e-12 * np.abs(field).max())
    assert found.dropped_count == 0
    assert found.dropped_strength == pytest.approx(lost, abs=1e-12)


@pytest.mark.parametrize("kernel", KINDS)
@pytest.mark.parametrize("grid", GRIDS)
def test_p2m_is_the_adjoint_of_m2p(grid, kernel):
    x = cloud(grid, 400)
    rng = np.random.default_rng(2)
    q, g = rng.normal(size=400), rng.normal(size=grid.shape)
    one = (p2m(x, q, grid, kernel) * g).sum() * grid.cell_volume
    other = (q * m2p(g, x, grid, kernel)).sum()
    scale = np.abs(q).sum() * np.abs(g).max()
    assert abs(one - other) <= 1e-12 * scale


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 60), which=st.integers(0, len(GRIDS) - 1))
@settings(max_examples=60, deadline=None)
def test_strength_is_kept_or_counted(seed, n, which):
    grid = GRIDS[which]
    rng = np.random.default_rng(seed)
    x = cloud(grid, n, seed) + rng.normal(size=(n, grid.ndim)) * grid.spacing * 2
    q = rng.normal(size=n)
    found = remesh(x, q, grid, "M4'")
    total = found.field.sum() * grid.cell_volume + found.dropped_strength
    assert abs(total - q.sum()) <= 1e-12 * max(np.abs(q).sum(), 1e-300)


@pytest.mark.parametrize("kernel", KINDS)
@pytest.mark.parametrize("shape", [(20, 22), (14, 13, 12)])
def test_circulation_and_first_moments_are_kept(kernel, shape):
    grid = Grid(shape, 0.25, origin=(-1.0,) * len(shape))
    x = cloud(grid, 200, margin=4)
    q = np.random.default_rng(3).normal(size=200)
    density = p2m(x, q, grid, kernel) * grid.cell_volume
    scale = np.abs(q).sum()
    assert abs(density.sum() - q.sum()) <= 1e-12 * scale
    first = (density * grid.points()).reshape(grid.ndim, -1).sum(axis=1)
    np.testing.assert_allclose(first, q @ x, atol=1e-12 * scale * np.abs(x).max())


@pytest.mark.parametrize("kernel", KINDS)
def test_m2p_is_exact_for_polynomials_of_the_moments_kept(kernel):
    grid = Grid((16, 17), 0.125, origin=(-1.0, -1.0))
    x = cloud(grid, 100, margin=4)
    for degree in range(KERNELS[kernel].moments + 1):
        field = grid.points()[0] ** degree * (1 + grid.points()[1]) if degree else np.ones((16, 17))
        exact = x[:, 0] ** degree * (1 + x[:, 1]) if degree else np.ones(100)
        np.testing.assert_allclose(m2p(field, x, grid, kernel), exact, atol=1e-12)


def test_vectors_are_their_components():
    grid = GRIDS[3]
    x = cloud(grid, 100)
    q = np.random.default_rng(4).normal(size=(100, 3))
    field = p2m(x, q, grid)
    assert field.shape == (3, *grid.shape)
    for i in range(3):
        np.testing.assert_array_equal(field[i], p2m(x, q[:, i], grid))
        np.testing.assert_array_equal(m2p(field, x, grid)[:, i], m2p(field[i], x, grid))


@pytest.mark.parametrize("grid", [GRIDS[1], GRIDS[3], Grid((70, 12), 0.25)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_any_thread_count_gives_the_same_bits(grid, dtype):
    x = cloud(grid, 3000, dtype=dtype)
    q = np.random.default_rng(5).normal(size=3000).astype(dtype)
    once, again = (remesh(x, q, grid, threads=n) for n in (1, 3))
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        global_one = p2m(x, q, grid)
    finally:
        numba.set_num_threads(before)
    assert once.field.dtype == dtype
    assert np.array_equal(once.field, again.field)
    assert np.array_equal(once.field, global_one)
    assert np.array_equal(once.dropped_strength, again.dropped_strength)
    values = [m2p(once.field, x, grid, threads=n) for n in (1, 3)]
    assert np.array_equal(*values)


@pytest.mark.parametrize("grid", GRIDS)
def test_single_precision_follows_double(grid):
    x = cloud(grid, 200, dtype=np.float32)
    q = np.random.default_rng(6).normal(size=200).astype(np.float32)
    single, double = p2m(x, q, grid, "M6'"), p2m(x.astype(float), q.astype(float), grid, "M6'")
    assert np.abs(single - double).max() <= 2e-5 * np.abs(double).max()


@pytest.mark.parametrize("ndim", [2, 3])
def test_single_strengths_keep_positions_far_from_zero(ndim):
    h = 1 / 4096
    grid = Grid((24, 20, 22)[:ndim], h, origin=(100.0, -100.0, 50.0)[:ndim])
    x = cloud(grid, 200, margin=4)
    q = (1 + np.random.default_rng(7).random(200)).astype(np.float32)
    density = p2m(x, q, grid, "M6'").astype(float)
    assert density.dtype == np.float64
    offsets = grid.points() - np.reshape(grid.origin, (-1,) + (1,) * ndim)
    centroid = (density * offsets).reshape(ndim, -1).sum(axis=1) / density.sum()
    exact = q.astype(float) @ (x - grid.origin) / q.sum(dtype=float)
    assert np.abs(centroid - exact).max() <= 1e-5 * h
    double = p2m(x, q.astype(float), grid, "M6'")
    assert np.abs(density - double).max() <= 2e-5 * double.max()
    field = np.random.default_rng(8).normal(size=grid.shape)
    ours, exact = m2p(field.astype(np.float32), x, grid), m2p(field, x, grid)
    assert ours.dtype == np.float32
    assert np.abs(ours - exact).max() <= 2e-5 * np.abs(exact).max()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("spacing", [0.1, 1 / 3, 0.01])
@pytest.mark.parametrize("start", [0.0, 0.3, -2.35, 100.0])
def test_the_nodes_of_a_mesh_lie_inside_it(dtype, spacing, start):
    for nodes in (7, 24, 101):
        grid = Grid((nodes, 5), spacing, origin=(start, -start))
        x = grid.points().reshape(2, -1).T.astype(dtype)
        field = p2m(x, np.full(len(x), grid.cell_volume, dtype), grid)
        rounding = np.finfo(dtype).eps * (abs(start) / spacing + nodes)
        assert np.abs(field - 1).max() <= 20 * rounding
        with pytest.raises(InputError, match="outside the box"):
            p2m(x - np.array([0.01 * spacing + 1e-4 * abs(start), 0]), np.ones(len(x), dtype), grid)


def test_wrapping_is_translation_by_a_period():
    grid = GRIDS[0]
    x = cloud(grid, 100)
    q = np.ones(100)
    np.testing.assert_allclose(
        p2m(x + 3 * np.array(grid.length), q, grid), p2m(x, q, grid), atol=1e-9
    )


def test_no_particles_give_an_empty_field():
    grid = GRIDS[2]
    assert not p2m(np.empty((0, 2)), np.empty(0), grid).any()
    assert m2p(np.ones(grid.shape), np.empty((0, 2)), grid).shape == (0,)


def test_particles_outside_are_refused_or_counted():
    grid = GRIDS[2]
    x = np.array([[1.0, 1.0], [-0.1, 1.0], [1.0, 9.0]])
    q = np.array([1.0, 2.0, 4.0])
    with pytest.raises(InputError, match="2 of 3 particles lie outside the box"):
        p2m(x, q, grid)
    with pytest.raises(InputError, match="outside the box"):
        m2p(np.ones(grid.shape), x, grid)
    found = remesh(x, q, grid)
    assert (found.dropped_count, found.dropped_strength) == (2, 6.0)
    np.testing.assert_allclose(m2p(np.ones(grid.shape), x, grid, outside="drop"), [1, 0, 0])


def test_unusable_particles_are_refused():
    grid = GRIDS[2]
    x, q = np.ones((5, 2)), np.ones(5)
    with pytest.raises(InputError, match=r"\(n, 2\), got \(2, 5\)\n  try: positions.T"):
        p2m(x.T, q, grid)
    with pytest.raises(InputError, match="strengths must have shape"):
        p2m(x, np.ones(4), grid)
    with pytest.raises(InputError, match="positions must be finite, 1 of 5"):
        p2m(np.where(np.arange(10).reshape(5, 2) == 3, np.nan, x), q, grid)
    with pytest.raises(InputError, match="strengths must be finite"):
        p2m(x, q * np.inf, grid)
    with pytest.raises(InputError, match="unknown kernel"):
        p2m(x, q, grid, "M5'")
    with pytest.raises(InputError, match="field must have shape"):
        m2p(np.ones((3, 4)), x, grid)
    with pytest.raises(InputError, match="outside must be"):
        p2m(x, q, grid, outside="clip")
