"""Laws of the divergence-free part of a vorticity in space."""

import numpy as np
import pytest

from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import divergence_ratio

GRIDS = [
    Grid((12, 15, 16), 0.1, boundary="periodic"),
    Grid((14, 12, 13), 0.1, boundary="unbounded"),
    Grid((12, 13, 14), 0.1, boundary=("unbounded", "periodic", "unbounded")),
]


@pytest.mark.parametrize(("dtype", "most"), [(np.float64, 1e-13), (np.float32, 1e-6)])
@pytest.mark.parametrize("grid", GRIDS)
def test_no_divergence_is_left_inside_the_mesh(grid, dtype, most):
    given = np.random.default_rng(0).normal(size=(3, *grid.shape)).astype(dtype)
    found = VelocitySolver(grid, dtype=dtype).solenoidal(given)
    assert found.dtype == dtype
    assert divergence_ratio(given, grid) > 0.3
    assert divergence_ratio(found, grid) < most


def test_in_a_periodic_box_it_is_a_projection_that_keeps_sums_and_curls():
    grid = GRIDS[0]
    solver = VelocitySolver(grid)
    given, other = np.random.default_rng(1).normal(size=(2, 3, *grid.shape))
    found = solver.solenoidal(given)
    np.testing.assert_allclose(solver.solenoidal(found), found, atol=1e-13)
    np.testing.assert_allclose(found.sum((1, 2, 3)), given.sum((1, 2, 3)), atol=1e-11)
    left = (found * other).sum()
    assert left == pytest.approx((given * solver.solenoidal(other)).sum(), abs=1e-11)
    x, y, z = 2 * np.pi * grid.points() / np.reshape(grid.length, (3, 1, 1, 1))
    curls = np.stack([np.sin(y) + np.cos(z), np.sin(z), np.cos(x) * np.sin(2 * y)])
    np.testing.assert_allclose(solver.solenoidal(curls), curls, atol=1e-13)
    slopes = np.stack([np.cos(x), 0 * y, 0 * z])  # of sin x: all of it goes
    assert np.abs(solver.solenoidal(slopes)).max() < 1e-13


def test_in_place_gives_the_same_bits_with_any_number_of_threads():
    grid = GRIDS[1]
    given = np.random.default_rng(2).normal(size=(3, *grid.shape))
    one, two = VelocitySolver(grid, threads=1), VelocitySolver(grid, threads=2)
    for law in ("solenoidal", "velocity"):
        expected = getattr(one, law)(given)
        own = given.copy()
        assert getattr(two, law)(own, out=own) is own
        assert np.array_equal(own, expected)


def test_a_ring_in_free_space_keeps_its_impulse():
    """A Gaussian ring whose strengths are off by a little of a gradient gets its impulse back."""
    grid = Grid((48, 48, 32), 1 / 16, origin=(-1.5, -1.5, -1.0), boundary="unbounded")
    x, y, z = grid.points()
    rho = np.hypot(x, y)
    core = np.exp(-((rho - 0.6) ** 2 + z**2) / 0.15**2) / np.maximum(rho, 1e-12)
    ring = np.stack([-y * core, x * core, 0 * z])
    bump = np.exp(-((x - 0.5) ** 2 + y**2 + z**2) / 0.3**2)
    slope = 0.02 * np.stack([-(x - 0.5) * bump, -y * bump, -z * bump])
    found = VelocitySolver(grid).solenoidal(ring + slope)

    def impulse(w):
        return 0.5 * np.cross(grid.points(), w, axis=0).sum((1, 2, 3)) * grid.cell_volume

    scale = np.linalg.norm(impulse(ring))
    assert np.abs(impulse(found) - impulse(ring + slope)).max() < 1e-4 * scale
    assert np.abs(found - ring).max() < 2e-3 * np.abs(ring).max()


def test_the_plane_is_refused():
    with pytest.raises(InputError, match="in the plane vorticity is a scalar"):
        VelocitySolver(Grid((8, 8), 0.1)).solenoidal(np.zeros((8, 8)))
