"""Velocity on adaptive meshes: exact vortices, the uniform solve, and what must not matter."""

import numpy as np
import pytest

from pmesh.spectral.corrections import AdaptiveSolver
from pmesh.spectral.taps import correction_taps
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.pyramid import restricted
from remesh.multires.sampling import sampled
from remesh.multires.wavelets import get_wavelet

RNG = np.random.default_rng(7)


def vortices(points, table):
    """Gaussian vortices (x, y, width, peak): vorticity and velocity."""
    vorticity, velocity = 0.0, 0.0
    for a, b, width, peak in table:
        x, y = points[0] - a, points[1] - b
        r2 = np.maximum(x**2 + y**2, 1e-300)
        turn = peak * width**2 * -np.expm1(-r2 / (2 * width**2)) / r2
        vorticity = vorticity + peak * np.exp(-r2 / (2 * width**2))
        velocity = velocity + np.stack([-turn * y, turn * x])
    return vorticity, velocity


def solid(points, width, center):
    """A vorticity in space and its velocity: curl curl of a Gaussian vector along (1, 2, -1)."""
    x = np.stack([p - c for p, c in zip(points, center, strict=True)]) / width
    a = np.array([1.0, 2.0, -1.0]).reshape(3, *(1,) * (x.ndim - 1))
    r2 = (x**2).sum(axis=0)
    bell = np.exp(-r2 / 2)
    vorticity = np.cross(np.broadcast_to(a, x.shape), x, axis=0) * (5 - r2) * bell
    return vorticity, (2 * a + (a * x).sum(axis=0) * x - a * r2) * bell * width


def patch(ndim=2, dtype=np.float64, boundary="unbounded", tolerance=1e-3):
    """A mesh of three levels, fine in a part of it, and random smooth vorticity on it."""
    mesh = AdaptiveMesh(
        grid=Grid((128,) * ndim, 1 / 128, boundary=boundary), levels=2, tolerance=tolerance
    )
    fine = np.array([place for place in np.ndindex(*(8,) * ndim) if 3 <= sum(place) <= ndim + 3])
    blocks = Blocks.around(mesh, [np.empty((0, ndim), int)] * 2 + [fine[:8]])
    shape = blocks.shape if ndim == 2 else (3, *blocks.shape)
    return blocks, restricted(RNG.normal(size=shape), blocks).astype(dtype)


def worst(found, blocks, exact):
    """Largest error at active nodes over the largest velocity."""
    leaves = blocks.leaves()
    scale = np.abs(exact[:, leaves]).max()
    return np.abs(found - exact)[:, leaves].max() / scale


TABLE = [(0.42, 0.5, 0.012, 1.0), (0.6, 0.45, 0.03, -0.4), (0.5, 0.62, 0.08, 0.15)]


@pytest.mark.parametrize(
    ("wavelet", "tolerance"),
    [*(("4.4", t) for t in (1e-2, 1e-3, 1e-4, 1e-5)), ("4.2", 1e-4), ("6.2", 1e-3)],
)
def test_vortices_are_solved_within_five_tolerances(wavelet, tolerance):
    grid = Grid((512, 512), 1 / 512)
    mesh = AdaptiveMesh(grid=grid, levels=4, tolerance=tolerance, wavelet=wavelet)
    blocks, vorticity = sampled(lambda points: vortices(points, TABLE)[0], mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    assert worst(found, blocks, vortices(blocks.points(), TABLE)[1]) < 5 * tolerance


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_the_adaptive_solve_agrees_with_the_uniform_one_within_five_tolerances(tolerance):
    grid = Grid((512, 256), 1 / 256)
    table = [
        (*RNG.uniform((0.7, 0.35), (1.3, 0.65)), np.exp(w), p)
        for w, p in zip(RNG.uniform(-4.2, -2.8, 8), RNG.choice((-1, 1), 8), strict=True)
    ]
    mesh = AdaptiveMesh(grid=grid, levels=3, tolerance=tolerance)
    blocks, vorticity = sampled(lambda points: vortices(points, table)[0], mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    uniform = VelocitySolver(grid).velocity(vortices(grid.points(), table)[0])
    i, j = np.rint(blocks.points() * 256).astype(int)
    assert worst(found, blocks, uniform[:, i, j]) < 5 * tolerance


@pytest.mark.parametrize(
    ("dtype", "tolerance"), [(np.float64, 1e-2), (np.float32, 1e-3), (np.float64, 1e-4)]
)
def test_a_vorticity_in_space_is_solved_within_five_tolerances(dtype, tolerance):
    grid = Grid((128, 128, 128), 1 / 128)
    mesh = AdaptiveMesh(grid=grid, levels=2, tolerance=tolerance)
    flow = 0.035, (0.5, 0.48, 0.52)
    blocks, vorticity = sampled(lambda points: solid(points, *flow)[0], mesh)
    assert blocks.finest > 0
    found = AdaptiveSolver(mesh).velocity(vorticity.astype(dtype), blocks)
    assert found.dtype == dtype
    assert worst(found, blocks, solid(blocks.points(), *flow)[1]) < 5 * tolerance


def test_positive_vorticity_turns_counterclockwise():
    mesh = AdaptiveMesh(grid=Grid((128, 128), 1 / 128), levels=2, tolerance=1e-3)
    table = [(0.5, 0.5, 0.03, 1.0)]
    blocks, vorticity = sampled(lambda points: vortices(points, table)[0], mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    x, y = blocks.points() - 0.5
    assert np.all(found[1][(x > 0.05) & (abs(y) < 0.01)] > 0)
    assert np.all(found[0][(y > 0.05) & (abs(x) < 0.01)] < 0)


def test_far_away_the_velocity_is_that_of_the_circulation():
    mesh = AdaptiveMesh(grid=Grid((1024, 128), 1 / 128), levels=3, tolerance=1e-3)
    blocks, vorticity = sampled(lambda p: vortices(p, [(0.5, 0.5, 0.03, 2.0)])[0], mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    x, y = blocks.points() - 0.5
    far = x > 4
    known = np.stack([-y, x]) * (2.0 * 0.03**2 / np.where(far, x**2 + y**2, 1))
    assert np.allclose(found[:, far], known[:, far], rtol=0, atol=1e-4 * known[1, far].max())


@pytest.mark.parametrize("boundary", ["periodic", ("periodic", "unbounded")])
def test_periodic_axes_agree_with_the_spectral_solve(boundary):
    grid = Grid((256, 256), 1 / 256, boundary=boundary)
    mesh = AdaptiveMesh(grid=grid, levels=3, tolerance=1e-4)

    def law(points):
        near = (points[0] + 0.4) % 1.0, points[1]  # the vortices go through the end
        return vortices(near, [(0.42, 0.5, 0.03, 1.0), (0.6, 0.5, 0.03, -1.0)])[0]

    blocks, vorticity = sampled(law, mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks, freestream=(0.5, 0.0))
    uniform = VelocitySolver(grid, order=10).velocity(law(grid.points()), freestream=(0.5, 0.0))
    i, j = np.rint(blocks.points() * 256).astype(int)
    assert worst(found, blocks, uniform[:, i, j]) < 5e-4


def test_a_vortex_beside_an_unbounded_end_is_solved():
    mesh = AdaptiveMesh(grid=Grid((256, 256), 1 / 256), levels=3, tolerance=1e-3)
    table = [(0.86, 0.12, 0.018, 1.0)]
    blocks, vorticity = sampled(lambda points: vortices(points, table)[0], mesh)
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    assert worst(found, blocks, vortices(blocks.points(), table)[1]) < 5e-3


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_compiled_corrections_are_the_convolution_with_the_taps(ndim, dtype):
    grid = Grid((32,) * ndim, 1 / 32, boundary="periodic")
    mesh = AdaptiveMesh(grid=grid, levels=1, tolerance=1e-2)
    blocks = Blocks.uniform(mesh, 1)
    field = RNG.normal(size=(32,) * ndim if ndim == 2 else (3, *(32,) * ndim))
    places = tuple(np.rint(blocks.points() * 32).astype(int))
    values = np.ascontiguousarray(field[(..., *places)], dtype)
    solver = AdaptiveSolver(mesh, reach=6)
    out = np.zeros((ndim, *blocks.shape), dtype)
    solver._correct(_five(values, blocks), blocks, _five(out, blocks))
    taps = correction_taps(get_wavelet("4.4"), 8, ndim, 6)
    spectra = np.fft.fftn(field, axes=range(-ndim, 0))
    expected = np.zeros((ndim, *(32,) * ndim))
    for parity in taps:
        own = tuple(slice(p, None, 2) for p in parity)
        grad = [_along(taps, parity, axis, spectra) for axis in range(ndim)]
        if ndim == 2:
            expected[(0, *own)] = grad[1][own]
            expected[(1, *own)] = -grad[0][own]
        else:
            for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
                expected[(i, *own)] = grad[j][k][own] - grad[k][j][own]
    fine = out[:, blocks.of(1)] * 32
    known = expected[(slice(None), *(p[blocks.of(1)] for p in places))]
    assert np.allclose(fine, known, rtol=0, atol=(1e-12 if dtype == np.float64 else 1e-5))


def _five(values, blocks):
    size = values.shape[-1]
    return values.reshape(-1, blocks.size, size if blocks.mesh.ndim == 3 else 1, size, size)


def _along(taps, parity, axis, spectra):
    """The taps of d_axis G for targets of this parity, applied to periodic fields."""
    swapped = list(parity)
    swapped[0], swapped[axis] = swapped[axis], swapped[0]
    ndim, reach = len(parity), 6
    kernel = np.zeros((32,) * ndim)
    span = np.arange(-reach, reach + 1)
    kernel[np.ix_(*(span % 32,) * ndim)] = np.swapaxes(taps[tuple(swapped)], 0, axis)
    axes = range(-ndim, 0)
    return np.fft.ifftn(spectra * np.conj(np.fft.fftn(kernel)), axes=axes).real


@pytest.mark.parametrize("ndim", [2, 3])
def test_threads_leave_every_bit(ndim):
    blocks, vorticity = patch(ndim)
    one, two, three = (
        AdaptiveSolver(blocks.mesh, threads=n).velocity(vorticity, blocks) for n in (1, 2, 3)
    )
    assert np.array_equal(one, two)
    assert np.array_equal(one, three)


def test_the_velocity_is_linear_in_the_vorticity_and_takes_a_free_stream():
    blocks, first = patch()
    second = patch()[1]
    solver = AdaptiveSolver(blocks.mesh)
    a, b, both = (solver.velocity(w, blocks) for w in (first, second, first - 2 * second))
    assert np.allclose(both, a - 2 * b, atol=1e-12)
    moved = solver.velocity(first, blocks, freestream=(0.3, -2.0))
    assert np.allclose(moved, a + np.reshape((0.3, -2.0), (2, 1, 1, 1)), atol=1e-12)


def test_float32_agrees_with_float64():
    blocks, vorticity = patch()
    solver = AdaptiveSolver(blocks.mesh)
    double = solver.velocity(vorticity, blocks)
    single = solver.velocity(vorticity.astype(np.float32), blocks)
    assert single.dtype == np.float32
    assert np.abs(single - double).max() < 2e-5 * np.abs(double).max()


@pytest.mark.parametrize("ndim", [2, 3])
def test_coarse_levels_hold_the_velocity_of_the_finer_ones(ndim):
    blocks, vorticity = patch(ndim)
    found = AdaptiveSolver(blocks.mesh).velocity(vorticity, blocks)
    even = (slice(None), slice(None), *(slice(0, None, 2),) * ndim)
    for n in range(blocks.size):
        for q, child in enumerate(blocks.children[n]):
            if child >= 0:
                where = np.unravel_index(q, (2,) * ndim)
                part = tuple(slice(8 * k, 8 * k + 8) for k in where)
                fine = found[:, child : child + 1][even][:, 0]
                assert np.array_equal(found[(slice(None), n, *part)], fine)


def test_a_mesh_without_refinement_is_the_coarsest_solve():
    mesh = AdaptiveMesh(grid=Grid((128, 128), 1 / 128), levels=2, tolerance=1e-2)
    blocks = Blocks.uniform(mesh, 0)
    vorticity, velocity = vortices(blocks.points(), [(0.5, 0.5, 0.11, 1.0)])
    found = AdaptiveSolver(mesh).velocity(vorticity, blocks)
    assert worst(found, blocks, velocity) < 2e-3


def test_what_does_not_fit_is_refused():
    blocks, vorticity = patch()
    solver = AdaptiveSolver(blocks.mesh)
    with pytest.raises(InputError, match="vorticity must have shape"):
        solver.velocity(vorticity[1:], blocks)
    other = AdaptiveMesh(grid=blocks.mesh.grid, levels=1)
    with pytest.raises(InputError, match="the solver's mesh"):
        AdaptiveSolver(other).velocity(vorticity, blocks)
    for wavelet in ("4.4", "2.2"):
        small = AdaptiveMesh(grid=blocks.mesh.grid, levels=2, block=8, wavelet=wavelet)
        with pytest.raises(InputError, match="blocks of at least 16 nodes, got block=8"):
            AdaptiveSolver(small)
    for wavelet in ("2.0", "4.0", "6.0"):
        far = AdaptiveMesh(grid=blocks.mesh.grid, levels=2, wavelet=wavelet)
        with pytest.raises(InputError, match=f"at least 2 moments, '{wavelet}' keeps 0"):
            AdaptiveSolver(far)
    with pytest.raises(InputError, match="reach must be one of"):
        AdaptiveSolver(blocks.mesh, reach=16)
    with pytest.raises(InputError, match="not finite"):
        solver.velocity(vorticity * np.nan, blocks)


def test_with_a_radius_the_finest_level_is_solved_as_the_uniform_mesh_even_if_barely_resolved():
    grid = Grid((256, 256), 1 / 256)
    mesh = AdaptiveMesh(grid=grid, levels=3, tolerance=1e-4)
    table = [(0.5, 0.48, 0.006, 1.0), (0.55, 0.52, 0.03, 0.1)]  # the first one of 1.5 spacings
    blocks, vorticity = sampled(lambda points: vortices(points, table)[0], mesh)
    uniform = VelocitySolver(grid).velocity(vortices(grid.points(), table)[0])
    i, j = np.rint(blocks.points() * 256).astype(int)
    alike, exact = (
        worst(AdaptiveSolver(mesh, radius=r).velocity(vorticity, blocks), blocks, uniform[:, i, j])
        for r in (2.0, None)
    )
    assert alike < 5e-4
    assert exact > 1e-2
