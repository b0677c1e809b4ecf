"""A level set on a mesh as a shape: interpolated inside its mesh, a bound beyond."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.contour import contour
from levelset.measure import measure
from levelset.shapes import Box, Disk, Ellipse, Sampled, Sphere
from remesh.errors import InputError
from remesh.grid import Grid


def sampled(shape, cells, dtype=np.float64, **options):
    grid = Grid((cells + 1,) * shape.ndim, 4.0 / cells, (-2.0,) * shape.ndim)
    return Sampled(shape.distance(grid.points().astype(dtype)), grid, **options)


@pytest.mark.parametrize("shape", [Ellipse((1.2, 0.7)), Sphere(1.1, center=(0.1, 0, -0.2))])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_distance_near_the_edge_is_that_of_the_shape(shape, dtype):
    found = sampled(shape, 64, dtype)
    points = np.random.default_rng(1).uniform(-1.6, 1.6, (shape.ndim, 4000)).astype(dtype)
    true = shape.distance(points)
    near = np.abs(true) < 0.05
    assert found.distance(points).dtype == dtype
    assert found.distance(points)[near] == pytest.approx(true[near], abs=5e-6)


def test_the_default_kernel_is_of_fifth_order_where_the_distance_is_smooth():
    shape = Ellipse((1.2, 0.9))
    turn = np.linspace(0, 2 * np.pi, 5000)
    edge = np.stack([1.2 * np.cos(turn), 0.9 * np.sin(turn)])
    coarse, fine = (np.abs(sampled(shape, n).distance(edge)).max() for n in (64, 128))
    assert 2**4.8 < coarse / fine < 2**6.2


def test_beyond_its_mesh_it_is_a_bound_without_a_jump():
    shape = Disk(0.9, center=(0.5, 0.2))
    found = sampled(shape, 64)
    points = np.random.default_rng(1).uniform(-6, 6, (2, 4000))
    true, value = shape.distance(points), found.distance(points)
    beyond = np.abs(points).max(axis=0) > 2.0
    assert np.all(value[beyond] <= true[beyond] + 1e-6)
    assert np.all(value[beyond] >= 0.7 * true[beyond])
    for side in (2.0, -2.0):
        edge = np.stack([np.full(50, side), np.linspace(-2, 2, 50)])
        step = 1e-9 * np.array([[np.sign(side)], [0]])
        assert found.distance(edge + step) == pytest.approx(found.distance(edge - step), abs=1e-8)


@pytest.mark.parametrize("shape", [Ellipse((1.2, 0.7)), Sphere(1.1), Box((1.1, 1.7))])
def test_it_is_measured_and_bounded_like_the_shape(shape):
    found = sampled(shape, 64)
    a, b = measure(found), measure(shape)
    tolerance = 1e-3
    assert a.volume == pytest.approx(b.volume, rel=tolerance)
    assert a.center == pytest.approx(b.center, abs=tolerance)
    assert a.inertia == pytest.approx(b.inertia, rel=2 * tolerance)
    h = found.grid.spacing
    for mine, true, sign in zip(found.bounds(), shape.bounds(), (-1, 1), strict=True):
        beyond = sign * np.subtract(mine, true)
        assert np.all(beyond >= 0)
        assert np.all(beyond <= h * (1 + 1e-12))


def test_the_outermost_cells_are_no_worse_than_second_order():
    shape = Disk(0.9)
    for cells, most in ((32, 2e-3), (64, 5e-4)):
        found = sampled(shape, cells)
        line = np.linspace(-2, 2, 500)
        edge = np.stack([np.full(500, 2 - 0.3 * found.grid.spacing), line])
        assert found.distance(edge) == pytest.approx(shape.distance(edge), abs=most)


def test_points_that_are_no_numbers_have_no_distance():
    found = sampled(Disk(0.8), 32)
    points = np.array([[0.0, np.nan, 1.0, np.inf], [0.5, 0.0, np.nan, 0.0]])
    assert np.array_equal(np.isnan(found.distance(points)), [False, True, True, False])
    assert found.distance(np.zeros((2, 0))).shape == (0,)


def test_it_is_drawn_and_joined_like_any_shape():
    found = sampled(Disk(0.8), 64)
    (ring,) = contour(found)
    assert np.hypot(*ring.T) == pytest.approx(0.8, abs=1e-4)
    hole = measure(found - Disk(0.4))
    assert hole.volume == pytest.approx(np.pi * (0.64 - 0.16), rel=1e-4)
    moved = found.moved((3.0, 0.0), 0.3)
    assert moved.distance(np.array([3.0, 0.0])) == pytest.approx(found.distance(np.zeros(2)))


def test_it_is_equal_to_itself_only_and_keeps_its_own_values():
    grid = Grid((33, 33), 1 / 8, (-2.0, -2.0))
    phi = Disk(1.0).distance(grid.points())
    one, other = Sampled(phi, grid), Sampled(phi, grid)
    assert one == one
    assert one != other
    assert len({one, other, one}) == 2
    before = one.distance(np.array([0.9, 0.1]))
    phi[:] = 1.0
    assert one.distance(np.array([0.9, 0.1])) == before
    with pytest.raises(ValueError, match="read-only"):
        one.phi[0, 0] = 0.0


GRID = Grid((9, 9), 0.5, (-2.0, -2.0))


@pytest.mark.parametrize(
    ("phi", "said"),
    [
        (np.ones((9, 8)), r"phi must have shape \(9, 9\), got \(9, 8\)"),
        (np.ones((9, 9)), "the level set has no inside: no node is negative"),
        (np.full((9, 9), np.nan), "phi must be finite, 81 nodes are not"),
        (-np.ones((9, 9)), "the inside reaches the edge of the mesh"),
        (Disk(1.0, center=(2, 0)).distance(GRID.points()), "the inside reaches the edge"),
    ],
)
def test_what_is_no_level_set_of_a_body_is_refused(phi, said):
    with pytest.raises(InputError, match=said):
        Sampled(phi, GRID)
