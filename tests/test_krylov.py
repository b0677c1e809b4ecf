"""Generalised conjugate residuals: definite, indefinite and nearly symmetric systems."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.bodies.krylov import solve

RNG = np.random.default_rng(3)


def system(eigenvalues: np.ndarray, skew: float = 0.0) -> np.ndarray:
    n = len(eigenvalues)
    basis, _ = np.linalg.qr(RNG.standard_normal((n, n)))
    noise = RNG.standard_normal((n, n))
    return basis * eigenvalues @ basis.T + skew * (noise - noise.T) / np.sqrt(n)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(
    "matrix",
    [
        system(np.linspace(0.05, 1.0, 60)),
        system(np.concatenate([[-2.0, -0.5], np.linspace(0.05, 1.0, 58)])),
        system(np.linspace(0.05, 1.0, 60), skew=1e-3),
    ],
    ids=["definite", "indefinite", "nearly symmetric"],
)
def test_the_residual_is_met_and_is_the_true_one(matrix, dtype):
    matrix = matrix.astype(dtype)
    right = RNG.standard_normal(60).astype(dtype)
    target = float(right @ right) * (1e-3 if dtype == np.float32 else 1e-8) ** 2
    done = solve(lambda x: matrix @ x, np.zeros(60, dtype), right, target=target, iterations=400)
    assert done.residual <= target
    rest = right - matrix @ done.solution
    np.testing.assert_allclose(done.rest, rest, atol=1e-3 if dtype == np.float32 else 1e-7)
    assert done.solution.dtype == dtype


def test_a_start_that_solves_costs_nothing():
    matrix = system(np.linspace(0.1, 1.0, 20))
    start = RNG.standard_normal(20)
    done = solve(lambda x: matrix @ x, start, np.zeros(20), target=1e-12, iterations=9)
    assert done.iterations == 0
    np.testing.assert_array_equal(done.solution, start)


def test_one_iteration_is_one_product_and_iterations_are_bounded():
    matrix, asked = system(np.linspace(1e-4, 1.0, 50)), []

    def apply(x: np.ndarray) -> np.ndarray:
        asked.append(1)
        return matrix @ x

    done = solve(apply, np.zeros(50), RNG.standard_normal(50), target=0.0, iterations=7)
    assert done.iterations == len(asked) == 7


def test_the_residual_never_grows():
    matrix, right = system(np.linspace(-0.5, 1.0, 40)), RNG.standard_normal(40)
    norms = [
        solve(lambda x: matrix @ x, np.zeros(40), right, target=0.0, iterations=k).residual
        for k in range(12)
    ]
    assert (np.diff(norms) <= 1e-12).all()
