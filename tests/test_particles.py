"""Laws of particles and of their distortion."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.particles import Particles, distortion
from remesh.transfer import p2m

PLANE = Grid((12, 14), 0.25, origin=(-1.5, -1.5))
SPACE = Grid((6, 7, 8), 0.25, origin=(-0.5, -0.5, -0.5))


@pytest.mark.parametrize("grid", [PLANE, SPACE])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("vector", [False, True])
def test_nodes_become_particles_and_back(grid, dtype, vector):
    shape = (grid.ndim, *grid.shape) if vector else grid.shape
    field = np.random.default_rng(0).normal(size=shape).astype(dtype)
    particles = Particles.on_grid(field, grid)
    assert len(particles) == grid.size
    assert particles.ndim == grid.ndim
    assert particles.positions.dtype == particles.strengths.dtype == dtype
    back = p2m(particles.positions, particles.strengths, grid)
    np.testing.assert_allclose(back, field, atol=1e-5 if dtype == np.float32 else 1e-12)


def test_moving_leaves_the_old_particles_as_they_were():
    old = Particles(np.zeros((3, 2)), np.ones(3))
    new = old.moved(np.ones((3, 2)))
    assert not old.positions.any()
    assert (new.positions == 1).all()
    assert new.strengths is old.strengths


def moved_by(matrix, grid):
    """Displacement of a linear map."""
    place = grid.points()
    return np.tensordot(np.asarray(matrix), place, 1) - place


@pytest.mark.parametrize("angle", [0.1, 1.0, 3.0])
def test_rigid_motion_does_not_distort(angle):
    c, s = np.cos(angle), np.sin(angle)
    flat = moved_by([[c, -s], [s, c]], PLANE) + 7.0
    assert distortion(flat, PLANE) < 1e-12
    solid = moved_by([[c, 0, s], [0, 1, 0], [-s, 0, c]], SPACE) - 3.0
    assert distortion(solid, SPACE) < 1e-12


def test_strain_distorts_by_the_logarithm_of_the_stretch():
    for a in (0.7, 1.3, 2.0):
        assert distortion(moved_by([[a, 0], [0, 1 / a]], PLANE), PLANE) == pytest.approx(
            abs(np.log(a))
        )
        stretched = moved_by(np.diag([1, a, 1]), SPACE)
        assert distortion(stretched, SPACE) == pytest.approx(abs(np.log(a)))


def test_shear_distorts_by_the_inverse_hyperbolic_sine_of_half_its_angle():
    for gamma in (0.1, 0.5, 2.0):
        sheared = moved_by([[1, gamma], [0, 1]], PLANE)
        assert distortion(sheared, PLANE) == pytest.approx(np.arcsinh(gamma / 2))


def test_a_folded_lattice_is_infinitely_distorted():
    assert distortion(moved_by([[-1, 0], [0, 1]], PLANE), PLANE) == np.inf


def test_only_the_nodes_that_count_are_measured():
    move = np.zeros((2, *PLANE.shape))
    move[0, 0, 0] = 0.1
    where = np.zeros(PLANE.shape, bool)
    assert distortion(move, PLANE, where=where) == 0.0
    where[6:, 6:] = True
    assert distortion(move, PLANE, where=where) == 0.0
    assert distortion(move, PLANE) > 0.1


def test_unusable_particles_are_refused():
    with pytest.raises(InputError, match="positions must have shape"):
        Particles(np.zeros((2, 9)), np.zeros(9))
    with pytest.raises(InputError, match="strengths must have shape"):
        Particles(np.zeros((9, 2)), np.zeros(8))
    with pytest.raises(InputError, match="field must have shape"):
        Particles.on_grid(np.zeros((3, 3)), PLANE)
    with pytest.raises(InputError, match="displacement must have shape"):
        distortion(np.zeros(PLANE.shape), PLANE)
    with pytest.raises(InputError, match="displacement must be finite"):
        distortion(np.full((2, *PLANE.shape), np.nan), PLANE)
