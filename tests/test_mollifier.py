"""Laws of mollified particles."""

import math

import numpy as np
import pytest
import sympy

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.mollifier import CUTOFFS, cutoff, mollify

CASES = sorted(CUTOFFS)


@pytest.mark.parametrize(("ndim", "order"), CASES)
def test_cutoffs_have_exactly_the_moments_of_their_order(ndim, order):
    r = sympy.symbols("r", positive=True)
    a, b, c = (sympy.nsimplify(v) for v in CUTOFFS[ndim, order])
    zeta = (a + b * r**2 + c * r**4) * sympy.exp(-(r**2)) / sympy.pi ** sympy.Rational(ndim, 2)
    shell = 2 * sympy.pi * r if ndim == 2 else 4 * sympy.pi * r**2
    found = [
        sympy.simplify(sympy.integrate(sympy.expand(zeta * shell * r**k), (r, 0, sympy.oo)))
        for k in range(0, order + 2, 2)
    ]
    assert found[: order // 2] == [1] + [0] * (order // 2 - 1)  # odd moments vanish by symmetry
    assert found[order // 2] != 0


@pytest.mark.parametrize(("ndim", "order"), CASES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_sums_over_cells_equal_the_sum_over_all_pairs(ndim, order, dtype):
    rng = np.random.default_rng(0)
    x = rng.normal(size=(150, ndim)) * 3
    points = rng.normal(size=(80, ndim)) * 4
    q = rng.normal(size=(150, 2)).astype(dtype)
    volumes = rng.random(150)
    distance = np.linalg.norm(points[:, None] - x, axis=-1)
    for radius in (0.1, 0.7, 5.0):
        exact = cutoff(distance / radius, ndim, order) @ (q * volumes[:, None]) / radius**ndim
        found = mollify(x, q, volumes, points, radius, order=order)
        assert found.dtype == dtype
        tolerance = 1e-13 if dtype is np.float64 else 1e-6
        peak = cutoff(0.0, ndim, order) / radius**ndim * np.abs(q).sum()
        np.testing.assert_allclose(found, exact, atol=tolerance * peak)


@pytest.mark.parametrize(("ndim", "order"), CASES)
def test_a_constant_field_of_overlapping_particles_is_kept(ndim, order):
    h = 1.0
    n = 30 if ndim == 2 else 22
    x = np.stack(np.meshgrid(*[np.arange(n) * h] * ndim), -1).reshape(-1, ndim)
    middle = np.full((1, ndim), (n - 0.7) * h / 2)
    # Poisson's summation: lattice errors fall as exp(-(pi radius / h)^2) times a polynomial
    found = mollify(x, np.ones(len(x)), h**ndim, middle, 1.5 * h, order=order)
    assert found[0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("ndim", "order"), CASES)
def test_the_error_falls_with_the_order_of_the_cutoff(ndim, order):
    # the peak of exp(-r^2) from particles at radius = 2 h, where the lattice adds below 1e-15
    errors = []
    radii = (0.2, 0.1)
    for radius in radii:
        h = radius / 2
        half = 14  # beyond 6.5 radii nothing is seen
        lattice = np.arange(-half, half + 1) * h
        x = np.stack(np.meshgrid(*[lattice] * ndim), -1).reshape(-1, ndim)
        q = np.exp(-(x**2).sum(axis=1))
        points = np.zeros((1, ndim))
        errors.append(abs(mollify(x, q, h**ndim, points, radius, order=order)[0] - 1))
    measured = math.log(errors[0] / errors[1]) / math.log(radii[0] / radii[1])
    assert measured == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_mollified_gaussian_is_a_wider_gaussian(ndim):
    h, s, radius = 0.25, 1.0, 0.5
    lattice = np.arange(-20, 21) * h
    x = np.stack(np.meshgrid(*[lattice] * ndim), -1).reshape(-1, ndim)
    q = np.exp(-(x**2).sum(axis=1) / s**2)
    points = np.random.default_rng(1).normal(size=(20, ndim)) * 0.7
    wide = s**2 + radius**2
    exact = (s**2 / wide) ** (ndim / 2) * np.exp(-(points**2).sum(axis=1) / wide)
    np.testing.assert_allclose(mollify(x, q, h**ndim, points, radius), exact, atol=1e-12)


def test_particles_that_do_not_overlap_are_seen_one_by_one():
    grid = Grid((12, 12), 1.0)
    x = grid.points().reshape(2, -1).T
    on, between = np.array([[5.0, 5.0]]), np.array([[5.5, 5.5]])
    for radius, spread in ((0.3, 3.0), (1.5, 1e-6)):
        one = mollify(x, np.ones(144), 1.0, on, radius)[0]
        other = mollify(x, np.ones(144), 1.0, between, radius)[0]
        assert (abs(one - other) > spread) if radius < 1 else (abs(one - other) < spread)


def test_any_thread_count_gives_the_same_bits():
    rng = np.random.default_rng(2)
    x, q, points = rng.normal(size=(500, 3)), rng.normal(size=500), rng.normal(size=(300, 3))
    results = [mollify(x, q, 1.0, points, 0.3, threads=n) for n in (1, 2, 3)]
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])


def test_no_particles_or_points_give_nothing():
    assert not mollify(np.empty((0, 2)), np.empty(0), 1.0, np.ones((3, 2)), 0.5).any()
    assert mollify(np.ones((3, 2)), np.ones(3), 1.0, np.empty((0, 2)), 0.5).shape == (0,)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 0.0}, "radius must be a positive length"),
        ({"radius": float("nan")}, "radius must be a positive length"),
        ({"order": 3}, "cutoffs exist of order 2, 4 and 6"),
        ({"positions": np.ones((2, 5))}, r"positions must have shape"),
        ({"points": np.ones((4, 3))}, r"points must have shape \(m, 2\)"),
        ({"points": np.full((4, 2), np.inf)}, "points must be finite"),
        ({"values": np.ones(4)}, r"values must have shape \(5,\)"),
        ({"values": np.full(5, np.nan)}, "values and volumes must be finite"),
        ({"volumes": np.ones(3)}, "volumes must be one number"),
    ],
)
def test_unusable_requests_are_refused(changes, message):
    usual = {
        "positions": np.ones((5, 2)),
        "values": np.ones(5),
        "volumes": 1.0,
        "points": np.ones((4, 2)),
        "radius": 0.5,
    }
    with pytest.raises(InputError, match=message):
        mollify(**(usual | changes))
