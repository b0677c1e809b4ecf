"""Laws of the waves that keep their shape along a surface."""

import numpy as np
import pytest

from levelset.surface_operators import laplace_beltrami
from pmesh.cases.surface_modes import sphere, torus
from remesh.grid import Grid

BOTH = pytest.mark.parametrize("modes", [sphere, torus])


@BOTH
def test_the_waves_are_orthogonal_and_their_amplitudes_found(modes):
    found = modes()
    known = np.array([mode(found.points.T) for mode in found.modes])
    gram = known @ (found.weights * known).T
    np.testing.assert_allclose(gram - np.diag(np.diag(gram)), 0, atol=1e-9 * gram.max())
    mixed = 3.0 - 2.0 * known[0] + 0.5 * known[2]
    np.testing.assert_allclose(found.amplitudes(mixed), [-2.0, 0.0, 0.5], atol=1e-10)
    np.testing.assert_allclose(found.amplitudes(found.start(found.points.T)), 1.0, rtol=1e-10)


@BOTH
def test_the_points_are_on_the_shape_and_the_rule_is_its_area(modes):
    found = modes()
    np.testing.assert_allclose(found.shape.distance(found.points.T), 0, atol=1e-12)
    share = found.weights / found.weights.sum() * found.shape.surface
    second = share @ found.points[:, 2] ** 2
    exact = 4 * np.pi / 3 if modes is sphere else np.pi**2 * 2 * 0.5**3
    assert second == pytest.approx(exact, rel=1e-10)


@BOTH
def test_the_waves_are_eigenfunctions_of_the_laplace_beltrami_operator(modes):
    found = modes()
    grid = Grid((81, 81, 81), 0.04, (-1.61, -1.6, -1.59))
    points = grid.points()
    distance = found.shape.distance(points)
    nodes = np.flatnonzero(np.abs(distance) < 0.15)
    near = np.abs(distance.ravel()[nodes]) < 0.004
    for mode, rate in zip(found.modes, found.rates, strict=True):
        unit = points / np.sqrt((points**2).sum(axis=0)).clip(0.1) if modes is sphere else points
        values = mode(unit)
        law = laplace_beltrami(values, distance, grid, nodes=nodes)[near]
        expected = -rate * values.ravel()[nodes][near]
        np.testing.assert_allclose(law, expected, atol=0.02 * rate)


def test_the_rates_of_the_torus_are_converged():
    np.testing.assert_allclose(torus().rates, torus(96).rates, rtol=1e-10)
