"""Velocity from vorticity: sign, order, gradients, diffusion, mixes of axes, and refusals."""

import hashlib
import math
import subprocess
import sys

import numpy as np
import pytest

from pmesh.spectral.smoothing import widest
from pmesh.spectral.symbols import Box
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid

KERNELS = [("HEJ", 2), ("HEJ", 4), ("HEJ", 6), ("HEJ", 8), ("HEJ", 10), ("LGF", 2), ("HE", 2)]


def square(cells, half=1.0, boundary="unbounded"):
    h = 2 * half / cells
    return Grid((cells, cells), h, (-half + h / 2,) * 2, boundary)


def gaussian(grid, variance, circulation=1.0):
    """Lamb-Oseen vortex: vorticity and velocity of a Gaussian of this variance per axis."""
    x, y = grid.points()
    r2 = x**2 + y**2
    vorticity = circulation * np.exp(-r2 / (2 * variance)) / (2 * math.pi * variance)
    turn = -circulation * np.expm1(-r2 / (2 * variance)) / (2 * math.pi * r2)
    return vorticity, np.stack([-y * turn, x * turn])


def swirl(grid, width):
    """Solenoidal field curl(0, 0, exp(-r^2 / 2 width^2)) and its curl, in space."""
    x, y, z = grid.points() / width
    bell = np.exp(-(x**2 + y**2 + z**2) / 2)
    velocity = np.stack([-y * bell, x * bell, 0 * bell]) / width
    vorticity = np.stack([x * z * bell, y * z * bell, (2 - x**2 - y**2) * bell]) / width**2
    return velocity, vorticity


@pytest.mark.parametrize(("kernel", "order"), KERNELS)
def test_positive_vorticity_turns_counterclockwise(kernel, order):
    grid = Grid((9, 9), 0.5)
    blob = np.zeros(grid.shape)
    blob[4, 4] = 1.0
    u, v = VelocitySolver(grid, kernel=kernel, order=order).velocity(blob)
    assert v[7, 4] > 0 > v[1, 4]
    assert u[4, 1] > 0 > u[4, 7]
    grid = Grid((9, 9, 9), 0.5)
    solver = VelocitySolver(grid, kernel=kernel, order=order)
    for axis in range(3):
        ahead, beside = (axis + 1) % 3, (axis + 2) % 3
        blob = np.zeros((3, 9, 9, 9))
        blob[axis, 4, 4, 4] = 1.0
        place = [4, 4, 4]
        place[ahead] = 7
        assert solver.velocity(blob)[(beside, *place)] > 0  # right-hand rule


@pytest.mark.parametrize(("kernel", "order"), KERNELS)
def test_the_order_of_the_velocity_is_the_claimed_one(kernel, order):
    errors = []
    for cells in (192, 256):
        grid = square(cells)
        vorticity, exact = gaussian(grid, 0.0185)
        velocity = VelocitySolver(grid, kernel=kernel, order=order).velocity(vorticity)
        errors.append(np.abs(velocity - exact).max())
    assert abs(math.log(errors[0] / errors[1]) / math.log(256 / 192) - order) <= 0.3, errors


@pytest.mark.parametrize(("kernel", "order"), KERNELS[:4] + KERNELS[5:])
def test_the_order_of_the_velocity_in_space_is_the_claimed_one(kernel, order):
    errors, cells = [], {6: (96, 112), 8: (112, 128)}.get(order, (80, 96))
    for n in cells:
        h = 2 / n
        grid = Grid((n,) * 3, h, (-1 + h / 2,) * 3)
        exact, vorticity = swirl(grid, 0.155)
        solver = VelocitySolver(grid, kernel=kernel, order=order, radius=1.25)
        errors.append(np.abs(solver.velocity(vorticity) - exact).max())
    assert abs(math.log(errors[0] / errors[1]) / math.log(cells[1] / cells[0]) - order) <= 0.3


def test_perlmans_patch_is_within_a_thousandth_at_a_64th():
    grid = square(192, half=1.5)
    x, y = grid.points()
    r2 = x**2 + y**2
    vorticity = np.where(r2 < 1, (1 - np.minimum(r2, 1)) ** 7, 0.0)
    turn = (1 - np.where(r2 < 1, 1 - r2, 0.0) ** 8) / (16 * r2)
    exact = np.stack([-y * turn, x * turn])
    velocity = VelocitySolver(grid).velocity(vorticity)
    assert np.linalg.norm(velocity - exact) <= 1e-5 * np.linalg.norm(exact)
    for kernel in ("LGF", "HE"):
        velocity = VelocitySolver(grid, kernel=kernel).velocity(vorticity)
        assert np.linalg.norm(velocity - exact) <= 1e-3 * np.linalg.norm(exact)


@pytest.mark.parametrize(
    "boundary",
    [("periodic", "periodic"), ("periodic", "unbounded"), ("unbounded", "periodic")],
)
def test_a_wave_of_vorticity_in_any_mix_of_axes(boundary):
    grid = Grid((64, 96), 1 / 32, (-1.0, -1.5), boundary)
    x, y = grid.points()
    k, s = math.pi, 0.2
    if boundary == ("periodic", "periodic"):
        k, q = math.pi, 2 * math.pi / 3
        psi = np.sin(k * x) * np.cos(q * y)
        vorticity = (k**2 + q**2) * psi
        exact = np.stack([-q * np.sin(k * x) * np.sin(q * y), -k * np.cos(k * x) * np.cos(q * y)])
    else:
        swap = boundary[0] == "unbounded"
        along, across = (y, x) if swap else (x, y)
        k = 2 * math.pi / grid.length[1 if swap else 0]
        bell = np.exp(-(across**2) / (2 * s**2))
        psi = np.cos(k * along) * bell
        vorticity = psi * (k**2 + 1 / s**2 - across**2 / s**4)
        d_along, d_across = -k * np.sin(k * along) * bell, -across / s**2 * psi
        exact = np.stack([d_along, -d_across]) if swap else np.stack([d_across, -d_along])
    velocity = VelocitySolver(grid, order=10).velocity(vorticity)
    assert np.abs(velocity - exact).max() <= 2e-5 * np.abs(exact).max()


def test_a_sheet_of_vorticity_drives_shear_on_both_sides():
    grid = Grid((8, 64), 0.05, (0.0, -1.6), ("periodic", "unbounded"))
    y = grid.points()[1]
    vorticity = np.exp(-(y**2) / 0.02) / math.sqrt(
        0.02 * math.pi
    )  # one unit of circulation per length
    u, v = VelocitySolver(grid).velocity(vorticity)
    assert np.allclose(u[:, 0], 0.5, atol=1e-9)
    assert np.allclose(u[:, -1], -0.5, atol=1e-9)
    assert np.abs(v).max() <= 1e-14


@pytest.mark.parametrize("mixed", [0, 1, 2])
def test_in_space_any_axis_may_be_periodic(mixed):
    boundary = ["unbounded"] * 3
    boundary[mixed] = "periodic"
    shape = [60, 60, 60]
    shape[mixed] = 24
    grid = Grid(shape, 1 / 24, [-n / 48 for n in shape], boundary)
    points = grid.points()
    i, j = (axis for axis in range(3) if axis != mixed)
    k, s = 2 * math.pi, 0.22
    x, y, z = points[i], points[j], points[mixed]
    bell = np.exp(-(x**2 + y**2) / (2 * s**2))
    wave, slope = np.cos(k * z), -k * np.sin(k * z)
    # velocity = curl(bell wave e), e along the periodic axis; its curl is grad d/dz - e laplace
    turn = 1 if (i, j) != (0, 2) else -1
    exact = np.zeros((3, *grid.shape))
    exact[i], exact[j] = -turn * y / s**2 * bell * wave, turn * x / s**2 * bell * wave
    vorticity = np.zeros_like(exact)
    vorticity[i], vorticity[j] = -x / s**2 * bell * slope, -y / s**2 * bell * slope
    vorticity[mixed] = bell * wave * (2 / s**2 - (x**2 + y**2) / s**4)
    velocity = VelocitySolver(grid, order=10).velocity(vorticity)
    assert np.abs(velocity - exact).max() <= 2e-3 * np.abs(exact).max()


@pytest.mark.parametrize(("kernel", "tolerance"), [("HEJ", 5e-6), ("LGF", 3e-3), ("HE", 3e-3)])
def test_the_gradient_is_the_gradient_of_the_velocity(kernel, tolerance):
    grid, s = square(128), 0.0225
    vorticity, velocity = gaussian(grid, s)
    x, y = grid.points()
    r2 = x**2 + y**2
    turn = velocity[1] / x
    bend = (vorticity - 2 * turn) / r2  # (d turn / d r) / r
    exact = np.array([[-x * y * bend, -turn - y**2 * bend], [turn + x**2 * bend, x * y * bend]])
    solver = VelocitySolver(grid, kernel=kernel)
    gradient = solver.gradient(vorticity)
    assert np.abs(gradient - exact).max() <= tolerance * np.abs(exact).max()
    assert np.abs(gradient[0, 0] + gradient[1, 1]).max() == 0
    both = solver.velocity_and_gradient(vorticity)
    assert np.array_equal(both[0], solver.velocity(vorticity))
    assert np.array_equal(both[1], gradient)


def test_the_gradient_in_space_is_the_gradient_of_the_velocity():
    h = 2 / 56
    grid = Grid((56, 54, 52), h, (-1.0, -0.96, -0.92))
    _, vorticity = swirl(grid, 0.17)
    solver = VelocitySolver(grid)
    velocity, gradient = solver.velocity_and_gradient(vorticity)
    for axis in range(3):
        inner = np.moveaxis(velocity, axis + 1, -1)
        slope = 45 * (inner[..., 4:-2] - inner[..., 2:-4]) - 9 * (
            inner[..., 5:-1] - inner[..., 1:-5]
        )
        slope = (slope + inner[..., 6:] - inner[..., :-6]) / (60 * h)
        ours = np.moveaxis(gradient[:, axis], axis + 1, -1)[..., 3:-3]
        assert np.abs(ours - slope).max() <= 2e-3 * np.abs(gradient).max()


def test_the_stream_function_is_minus_the_poisson_solution():
    grid = Grid((20, 24), 0.1, boundary=("unbounded", "periodic"))
    vorticity = np.random.default_rng(0).standard_normal(grid.shape)
    solver = VelocitySolver(grid)
    assert np.allclose(solver.stream(vorticity), -solver.poisson(vorticity), atol=1e-14)
    grid = Grid((8, 9, 10), 0.1)
    vorticity = np.random.default_rng(0).standard_normal((3, *grid.shape))
    solver = VelocitySolver(grid)
    assert np.allclose(solver.stream(vorticity), -solver.poisson(vorticity), atol=1e-14)


def spread_error(nodes, boundary):
    """Error of a diffused Gaussian vortex, relative to its peak; variance grows by 2 nu t."""
    grid = square(nodes, half=1.5, boundary=boundary)
    before, amount = 0.02, 0.007
    after = gaussian(grid, before + 2 * amount)[0]
    found = VelocitySolver(grid).diffuse(gaussian(grid, before)[0], amount)
    return np.abs(found - after).max() / after.max()


def test_diffusion_is_exact_on_periodic_axes_and_of_order_8_on_unbounded_ones():
    assert spread_error(96, "periodic") <= 1e-10
    coarse, fine = spread_error(96, "unbounded"), spread_error(192, "unbounded")
    assert abs(math.log2(coarse / fine) - 8) <= 0.5
    assert fine <= 1e-6


def test_one_forward_transform_gives_diffused_vorticity_and_its_velocity():
    grid = square(96, half=1.5)
    vorticity = gaussian(grid, 0.02)[0]
    _, velocity = gaussian(grid, 0.02 + 2 * 0.007)
    solver = VelocitySolver(grid)
    field, speed = solver.diffuse_and_velocity(vorticity, 0.007, freestream=(0.5, 0.0))
    assert np.array_equal(field, solver.diffuse(vorticity, 0.007))
    assert np.abs(speed[0] - 0.5 - velocity[0]).max() <= 1e-4 * np.abs(velocity).max()
    assert np.abs(speed[1] - velocity[1]).max() <= 1e-4 * np.abs(velocity).max()


def test_what_is_diffused_keeps_to_its_place():
    grid = square(128, half=1.0)
    spike = np.zeros(grid.shape)
    spike[64, 64] = 1.0
    far = VelocitySolver(grid).diffuse(spike, 0.05 * grid.spacing**2)[64, 64 + 16 :]
    assert np.abs(far).max() <= 1e-13


def test_diffusion_in_space_spreads_each_component():
    grid = Grid((40, 44, 36), 0.07, (-1.4, -1.55, -1.25))
    x, y, z = grid.points()
    r2 = x**2 + y**2 + z**2
    weights = np.array([1.0, -2.0, 0.5])[:, None, None, None]
    before, amount = 0.03, 0.005

    def blob(variance):
        return weights * np.exp(-r2 / (2 * variance)) / (2 * math.pi * variance) ** 1.5

    field, velocity = VelocitySolver(grid).diffuse_and_velocity(blob(before), amount)
    after = blob(before + 2 * amount)
    assert np.abs(field - after).max() <= 5e-5 * np.abs(after).max()  # 2.5 nodes per deviation
    assert np.allclose(velocity, VelocitySolver(grid).velocity(field), atol=1e-12)


@pytest.mark.parametrize("kind", ["heat", "phi1"])
@pytest.mark.parametrize("shape", [(24, 30), (16, 18, 20)])
def test_what_spreads_beyond_the_edges_never_comes_back(shape, kind):
    lead, grid = (() if len(shape) == 2 else (3,)), Grid(shape, 0.1)
    most = widest(Box.around(grid))
    assert math.sqrt(2 * most) == pytest.approx(min(shape) * 0.1 / 5.26, rel=0.1)
    corner = np.zeros((*lead, *shape))
    corner[(0,) * corner.ndim] = 1.0
    roomy = Grid([4 * n for n in shape], 0.1)
    wide = np.zeros((*lead, *roomy.shape))
    wide[(0,) * len(lead) + tuple(2 * n for n in shape)] = 1.0
    inside = (..., *(slice(2 * n, 3 * n) for n in shape))
    exact = VelocitySolver(roomy).smoothed(wide, 0.999 * most, kind)[inside]
    found = VelocitySolver(grid).smoothed(corner, 0.999 * most, kind)
    assert np.abs(found - exact).max() <= 2e-6 * exact.max()
    for law in (VelocitySolver(grid).smoothed, VelocitySolver(grid, dtype="f4").smoothed):
        with pytest.raises(InputError, match="come back on the other side"):
            law(corner, 1.001 * most, kind)
        assert not law(0 * corner, 100 * most, kind).any()  # nothing to come back


def test_on_periodic_axes_any_spread_is_exact():
    grid = Grid((16, 12), 0.1, boundary="periodic")
    field = np.random.default_rng(4).standard_normal(grid.shape)
    flat = VelocitySolver(grid).diffuse(field, 100.0)
    assert np.allclose(flat, field.mean(), atol=1e-14)


def test_phi1_is_the_mean_of_the_heat_flow():
    grid = square(48)
    vorticity, amount = gaussian(grid, 0.02)[0], 0.004
    solver = VelocitySolver(grid)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    mean = sum(
        w / 2 * solver.diffuse(vorticity, amount * (x + 1) / 2)
        for x, w in zip(nodes, weights, strict=True)
    )
    smooth = solver.smoothed(vorticity, amount, "phi1")
    assert np.abs(smooth - mean).max() <= 1e-11 * mean.max()
    ours = solver.velocity(vorticity, smoothing=("phi1", amount))
    assert np.abs(ours - solver.velocity(mean)).max() <= 1e-6


@pytest.mark.parametrize("shape", [(40, 50), (50, 38, 20)])
@pytest.mark.parametrize("boundary", ["unbounded", "mixed"])
def test_every_thread_count_gives_the_same_bits(shape, boundary):
    sides = boundary if boundary == "unbounded" else ("periodic", "unbounded", "periodic")
    grid = Grid(shape, 0.1, boundary=sides if isinstance(sides, str) else sides[: len(shape)])
    lead = () if len(shape) == 2 else (3,)
    vorticity = np.random.default_rng(7).standard_normal((*lead, *shape))
    results = []
    for threads in (1, 2, 3):
        solver = VelocitySolver(grid, threads=threads)
        solver._convolver.threads = threads  # small boxes would use one
        results.append(solver.diffuse_and_velocity(vorticity, 1e-3))
    for field, velocity in results[1:]:
        assert np.array_equal(field, results[0][0])
        assert np.array_equal(velocity, results[0][1])


def test_every_process_gives_the_same_bits():
    code = (
        "import numpy as np, hashlib\n"
        "from remesh.grid import Grid\n"
        "from pmesh.spectral.velocity import VelocitySolver\n"
        "w = np.random.default_rng(1).standard_normal((72, 90))\n"
        "u = VelocitySolver(Grid((72, 90), 0.1), threads=2).velocity(w)\n"
        "print(hashlib.sha256(u.tobytes()).hexdigest())\n"
    )
    vorticity = np.random.default_rng(1).standard_normal((72, 90))
    here = VelocitySolver(Grid((72, 90), 0.1), threads=1).velocity(vorticity)
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert there.stdout.strip() == hashlib.sha256(here.tobytes()).hexdigest()


@pytest.mark.parametrize("backend", ["scipy", "pyfftw", "ducc0"])
def test_every_backend_gives_the_same_velocity(backend):
    pytest.importorskip(backend)
    grid = Grid((40, 30), 0.1, boundary=("unbounded", "periodic"))
    vorticity = np.random.default_rng(3).standard_normal(grid.shape)
    ours = VelocitySolver(grid, backend=backend).velocity(vorticity)
    assert np.allclose(ours, VelocitySolver(grid).velocity(vorticity), atol=1e-14)


@pytest.mark.parametrize("ndim", [2, 3])
def test_single_precision_keeps_its_digits(ndim):
    grid = Grid((40, 36, 32)[:ndim], 0.05)
    lead = () if ndim == 2 else (3,)
    vorticity = np.random.default_rng(2).standard_normal((*lead, *grid.shape))
    double = VelocitySolver(grid).velocity(vorticity)
    single = VelocitySolver(grid, dtype=np.float32).velocity(vorticity.astype(np.float32))
    assert single.dtype == np.float32
    assert np.abs(single - double).max() <= 2e-6 * np.abs(double).max()


def test_results_are_new_arrays_unless_out_is_given():
    grid = Grid((16, 12), 0.1)
    solver = VelocitySolver(grid)
    vorticity = np.random.default_rng(2).standard_normal(grid.shape)
    kept = vorticity.copy()
    first = solver.velocity(vorticity)
    copy = first.copy()
    solver.velocity(2 * vorticity)
    assert np.array_equal(first, copy)
    assert np.array_equal(vorticity, kept)
    out = np.empty_like(first)
    assert solver.velocity(vorticity, out=out) is out
    assert np.array_equal(out, first)
    field, speed = np.empty_like(vorticity), np.empty_like(first)
    given = solver.diffuse_and_velocity(vorticity, 0.0, out=(field, speed))
    assert given[0] is field
    assert given[1] is speed
    assert np.allclose(field, vorticity, atol=1e-14)
    assert np.allclose(solver.diffuse(vorticity, 1e-3, out=vorticity), solver.diffuse(kept, 1e-3))


def test_what_cannot_be_solved_is_refused():
    grid = Grid((8, 8), 0.1)
    solver = VelocitySolver(grid)
    field = np.zeros((8, 8))
    for words, call in {
        r"shape \(8, 8\)": lambda: solver.velocity(np.zeros((2, 8, 8))),
        "not finite": lambda: solver.diffuse(np.full((8, 8), np.nan), 1e-3),
        "not negative": lambda: solver.diffuse(field, -0.1),
        "unknown smoothing": lambda: solver.smoothed(field, 0.1, "box"),
        "freestream": lambda: solver.velocity(field, freestream=(1.0,)),
        "out must be": lambda: solver.velocity(field, out=np.zeros((8, 8))),
        "float32 or float64": lambda: VelocitySolver(grid, dtype="i4"),
        "FFT backend": lambda: VelocitySolver(grid, backend="mkl"),
        "smoothing radius": lambda: VelocitySolver(grid, radius=-1),
        "threads": lambda: VelocitySolver(grid, threads=0),
        r"\(3, 8, 8, 8\)": lambda: VelocitySolver(Grid((8,) * 3, 0.1)).velocity(np.zeros((8,) * 3)),
        "zero mean": lambda: VelocitySolver(Grid((8, 8), 0.1, boundary="periodic")).velocity(
            field + 1
        ),
    }.items():
        with pytest.raises(InputError, match=words):
            call()


@pytest.mark.parametrize("shape", [(40, 24), (20, 12, 16)])
@pytest.mark.parametrize("rows", [(0, 5), (7, 19), (12, 20)])
def test_a_velocity_wanted_on_some_rows_is_the_same_there(shape, rows):
    grid = Grid(shape, 0.1)
    vorticity = np.random.default_rng(4).standard_normal(shape if len(shape) == 2 else (3, *shape))
    solver = VelocitySolver(grid)
    field, speed = solver.diffuse_and_velocity(vorticity, 1e-3)
    again, part = solver.diffuse_and_velocity(vorticity, 1e-3, rows=rows)
    np.testing.assert_array_equal(again, field)
    inside = (slice(None), slice(*rows))
    np.testing.assert_array_equal(part[inside], speed[inside])


def test_idle_storage_is_lent_between_solves_and_changes_no_result():
    grid = Grid((10, 12, 14), 0.1)
    solver = VelocitySolver(grid, threads=1)
    vorticity = np.random.default_rng(4).standard_normal((3, *grid.shape))
    with solver.lent(vorticity.shape) as room:  # nothing is there yet
        assert room.shape == vorticity.shape
    first = solver.velocity(vorticity)
    with solver.lent(vorticity.shape) as room:
        assert room.dtype == solver.dtype
        assert room.flags.c_contiguous
        room[...] = np.nan
        assert np.shares_memory(room, solver._convolver._storage)
    np.testing.assert_array_equal(solver.velocity(vorticity), first)
    with solver.lent((30, *grid.shape)) as room:  # more than there is
        assert room.shape == (30, *grid.shape)
