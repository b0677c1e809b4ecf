"""The Poisson law: orders on every mix of axes, exact solutions and published errors."""

import itertools
import math

import numpy as np
import pytest
from scipy import special

import pmesh.spectral.poisson as laws
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid

KERNELS = [("HEJ", 2), ("HEJ", 4), ("HEJ", 6), ("HEJ", 8), ("HEJ", 10), ("LGF", 2), ("HE", 2)]
MIXES = [
    *itertools.product(("unbounded", "periodic"), repeat=2),
    *itertools.product(("unbounded", "periodic"), repeat=3),
]

# Largest error of psi at N = 128 and 256: bump exp(10 - 10/(1 - r^2)) on (-1, 1)^2, sigma = 2 h
# (the test of Hejlesen et al., J. Comput. Phys. 252 (2013) 458; converged errors)
BUMP = {
    ("HE", 2): (0.00036886037679872974, 9.246095473747218e-05),
    ("HEJ", 2): (0.019191992130096924, 0.004861418635870529),
    ("HEJ", 4): (0.0002977485195599927, 1.89566152754006e-05),
    ("HEJ", 6): (3.362412884788668e-06, 5.329926378028205e-08),
    ("HEJ", 8): (9.222749827644122e-08, 4.246981562001234e-10),
    ("HEJ", 10): (7.1129696462414964e-09, 1.0896194801198866e-11),
}


def bump(grid):
    """psi and laplace(psi) for psi = exp(c - c / (1 - r^2)), c = 10."""
    c, r2 = 10.0, (grid.points() ** 2).sum(0)
    inside = r2 < 1 - 1e-9
    gap = np.where(inside, 1 - r2, 1.0)
    psi = np.where(inside, np.exp(c - c / gap), 0.0)
    slope = -c / gap**2  # d ln psi / d(r^2)
    rhs = psi * (4 * slope + 4 * r2 * (slope**2 - 2 * c / gap**3))
    return psi, rhs


# Cells across the box and width of the Gaussian in 3-D: wide enough to be smooth at this spacing,
# narrow enough to vanish at the edge to the accuracy of the order.
CELLS = {2: (64, 80), 4: (64, 80), 6: (80, 96), 8: (112, 128), 10: (128, 144)}
WIDTH = {2: 0.16, 4: 0.16, 6: 0.155, 8: 0.14, 10: 0.137}


def manufactured(grid, width):
    """Gaussian of the unbounded axes times (1 +) waves of the periodic ones, and its Laplacian."""
    points, wraps = grid.points(), grid.periodic
    free = [axis for axis in range(grid.ndim) if not wraps[axis]]
    r2 = sum(((points[axis] - 0.02) ** 2 for axis in free), np.zeros(grid.shape))
    bell = np.exp(-r2 / (2 * width**2))
    waves = np.ones(grid.shape)
    k2 = 0.0
    for axis in set(range(grid.ndim)) - set(free):
        k = 2 * math.pi / grid.length[axis]
        waves *= np.cos(k * points[axis] + 0.3)
        k2 += k**2
    mean = 1.0 if free and k2 else 0.0
    steep = r2 / width**4 - len(free) / width**2
    return bell * (mean + waves), bell * (steep * (mean + waves) - k2 * waves)


def error(boundary, cells, kernel, order, radius, width):
    reach = (
        1.25 if boundary.count("unbounded") == 1 else 1.0
    )  # a line feels a cut more than a plane
    nodes = {"unbounded": int(reach * cells), "periodic": cells // 2}
    origin = [-reach] * len(boundary)
    grid = Grid([nodes[side] for side in boundary], 2 / cells, origin, boundary)
    exact, rhs = manufactured(grid, width)
    psi = VelocitySolver(grid, kernel=kernel, order=order, radius=radius).poisson(rhs)
    return np.abs(psi - exact).max()


@pytest.mark.parametrize("boundary", MIXES, ids="-".join)
def test_the_measured_order_is_the_claimed_one(boundary):
    flat = len(boundary) == 2
    spectral = set(boundary) == {"periodic"}
    for kernel, order in KERNELS:
        coarse, fine = (192, 256) if flat else CELLS[order]
        radius, width = (2.0, 0.137) if flat else (1.25, WIDTH[order])
        errors = [error(boundary, n, kernel, order, radius, width) for n in (coarse, fine)]
        if spectral and kernel != "LGF":
            assert max(errors) <= 1e-13
            continue
        measured = math.log(errors[0] / errors[1]) / math.log(fine / coarse)
        assert abs(measured - order) <= 0.3, (kernel, order, errors)


@pytest.mark.parametrize(("kernel", "order"), BUMP)
def test_errors_of_the_bump_are_the_published_ones(kernel, order):
    for cells, expected in zip((128, 256), BUMP[kernel, order], strict=True):
        h = 2 / cells
        grid = Grid((cells, cells), h, (-1 + h / 2,) * 2)
        exact, rhs = bump(grid)
        psi = laws.poisson(rhs, grid, kernel=kernel, order=order)
        assert expected / 1.5 <= np.abs(psi - exact).max() <= 1.5 * expected


@pytest.mark.parametrize("kernel", ["HEJ", "LGF", "HE"])
def test_a_charge_has_the_far_field_of_its_dimension(kernel):
    s, tolerance = 0.15, 1e-4 if kernel == "HEJ" else 4e-3
    for boundary in (("unbounded",) * 2, ("unbounded", "periodic"), ("unbounded",) * 3):
        axes = boundary.count("unbounded")
        shape = [96 if side == "unbounded" else 8 for side in boundary]
        shape = [64] * 3 if axes == 3 else shape
        h = 2 / shape[0]
        grid = Grid(shape, h, [-1 + h / 2] * len(shape), boundary)
        points = grid.points()[[axis for axis, side in enumerate(boundary) if side == "unbounded"]]
        r = np.sqrt((points**2).sum(0))
        charge = np.exp(-(r**2) / (2 * s**2)) / (s * math.sqrt(2 * math.pi)) ** axes
        if axes == 1:
            bell = s * math.sqrt(2 / math.pi) * np.exp(-(r**2) / (2 * s**2))
            exact = (r * special.erf(r / (s * math.sqrt(2))) + bell) / 2
        elif axes == 2:
            exact = (np.log(r) + special.exp1(r**2 / (2 * s**2)) / 2) / (2 * math.pi)
        else:
            exact = -special.erf(r / (s * math.sqrt(2))) / (4 * math.pi * r)
        psi = laws.poisson(charge, grid, kernel=kernel)
        assert np.abs(psi - exact).max() <= tolerance * max(1, np.abs(exact).max())


def test_a_stack_of_right_hand_sides_is_solved_one_by_one():
    grid = Grid((12, 10), 0.1, boundary=("periodic", "unbounded"))
    rhs = np.random.default_rng(0).standard_normal((2, 3, 12, 10))
    psi = laws.poisson(rhs, grid)
    assert psi.shape == rhs.shape
    assert np.array_equal(psi[1, 2], laws.poisson(rhs[1, 2], grid))


def test_single_precision_stays_single_and_is_as_exact_as_it_can_be():
    h = 2 / 64
    grid = Grid((64, 64), h, (-1 + h / 2,) * 2)
    _, rhs = bump(grid)
    double = laws.poisson(rhs, grid)
    single = laws.poisson(rhs.astype(np.float32), grid)
    assert single.dtype == np.float32
    assert np.abs(single - double).max() <= 2e-6 * np.abs(double).max()


def test_velocity_law_returns_the_gradient_on_demand_and_adds_the_free_stream():
    grid = Grid((20, 16), 0.1)
    vorticity = np.random.default_rng(5).standard_normal(grid.shape)
    still = laws.velocity(vorticity, grid)
    moving, gradient = laws.velocity(vorticity, grid, (1.0, -2.0), gradient=True)
    assert np.allclose(moving - still, np.array([1.0, -2.0])[:, None, None], atol=1e-14)
    assert gradient.shape == (2, 2, 20, 16)


def test_a_charge_in_a_fully_periodic_box_is_refused_but_round_off_is_not():
    grid = Grid((16, 16, 16), 0.1, boundary="periodic")
    wave = np.cos(2 * math.pi * np.arange(16) / 16)[:, None, None] * np.ones(grid.shape)
    with pytest.raises(InputError, match="zero mean"):
        laws.poisson(wave + 0.01, grid)
    psi = laws.poisson(wave + 1e-12, grid)
    assert np.allclose(psi, -wave * (1.6 / (2 * math.pi)) ** 2, atol=1e-12)


@pytest.mark.parametrize(
    ("field", "options", "words"),
    [
        (np.zeros((8, 9)), {}, r"shape \(8, 8\)"),
        (np.zeros(8), {}, r"shape \(8, 8\)"),
        (np.full((8, 8), np.nan), {}, "not finite"),
        (np.full((8, 8), np.inf), {}, "not finite"),
        (np.zeros((8, 8), complex), {}, "real numbers"),
        (np.zeros((8, 8)), {"kernel": "FMM"}, "FMM"),
        (np.zeros((8, 8)), {"order": 3}, "asked 3"),
        (np.zeros((8, 8)), {"kernel": "LGF", "order": 4}, "asked 4"),
        (np.zeros((8, 8)), {"threads": 0}, "threads"),
    ],
)
def test_what_cannot_be_solved_is_refused(field, options, words):
    with pytest.raises(InputError, match=words):
        laws.poisson(field, Grid((8, 8), 0.1), **options)
