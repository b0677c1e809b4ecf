"""The matched solve on a uniform mesh: exact flows, order, and every mix of ends."""

import numpy as np
import pytest

from pmesh.spectral.coarsest import CoarsestSolver
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid


def gaussian(grid, width, center):
    """A vortex of unit peak and its velocity."""
    x, y = (p - c for p, c in zip(grid.points(), center, strict=True))
    r2 = x**2 + y**2
    turn = width**2 * -np.expm1(-r2 / (2 * width**2)) / np.maximum(r2, 1e-300)
    return np.exp(-r2 / (2 * width**2)), np.stack([-turn * y, turn * x])


def solid(grid, width, center):
    """A vorticity in space and its velocity: curl curl of a Gaussian vector along (1, 2, -1)."""
    x = np.stack([p - c for p, c in zip(grid.points(), center, strict=True)]) / width
    a = np.array([1.0, 2.0, -1.0]).reshape(3, 1, 1, 1)
    r2 = (x**2).sum(axis=0)
    bell = np.exp(-r2 / 2)
    vorticity = np.cross(np.broadcast_to(a, x.shape), x, axis=0) * (5 - r2) * bell
    velocity = (2 * a + (a * x).sum(axis=0) * x - a * r2) * bell * width
    return vorticity, velocity


def error(grid, flow, order, dtype=np.float64):
    vorticity, velocity = flow
    solver = CoarsestSolver(grid, order=order, dtype=dtype, threads=1)
    found = solver.velocity(vorticity.astype(dtype))
    assert found.dtype == dtype
    return np.abs(found - velocity).max() / np.abs(velocity).max()


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_a_vortex_is_solved_to_the_order_of_the_scaling_function(order):
    errors = []
    for nodes in (64, 96):
        grid = Grid((nodes, nodes), 1 / nodes)
        errors.append(error(grid, gaussian(grid, 0.07, (0.5, 0.48)), order))
    assert np.log(errors[0] / errors[1]) / np.log(1.5) == pytest.approx(order, abs=0.5)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_vorticity_in_space_is_solved(dtype):
    grid = Grid((52, 48, 50), 1 / 48, (-0.1, 0.0, 0.0))
    assert error(grid, solid(grid, 0.085, (0.5, 0.5, 0.5)), 8, dtype) < 5e-5


def test_the_far_velocity_is_that_of_a_point_vortex():
    grid = Grid((96, 40), 1 / 32)
    vorticity, _ = gaussian(grid, 0.1, (0.5, 0.5))
    found = CoarsestSolver(grid, order=4, dtype="f8", threads=1).velocity(vorticity)
    circulation, distance = 2 * np.pi * 0.1**2, 95 / 32 - 0.5
    assert found[1, 95, 16] == pytest.approx(circulation / (2 * np.pi * distance), rel=1e-6)
    assert found[0, 95, 16] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "boundary", [("periodic", "periodic"), ("periodic", "unbounded"), ("unbounded", "periodic")]
)
def test_periodic_axes_agree_with_the_spectral_solve(boundary):
    grid = Grid((64, 48), 1 / 48, boundary=boundary)
    vorticity = gaussian(grid, 0.08, (0.55, 0.5))[0] - gaussian(grid, 0.08, (0.7, 0.4))[0]
    vorticity -= vorticity.mean()
    found = CoarsestSolver(grid, order=8, dtype="f8", threads=1).velocity(vorticity, (1.0, -2.0))
    known = VelocitySolver(grid, order=10, radius=1.2).velocity(vorticity, freestream=(1.0, -2.0))
    assert np.abs(found - known).max() < 1e-5 * np.abs(known).max()


def test_a_mean_in_a_periodic_box_is_refused():
    grid = Grid((16, 16), 1 / 16, boundary="periodic")
    with pytest.raises(InputError, match="zero mean"):
        CoarsestSolver(grid, order=4, dtype="f8", threads=1).velocity(np.ones((16, 16)))
