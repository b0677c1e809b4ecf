"""Remeshing of a band: nodes look up, through the particles' map, what they get."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from levelset.lookup import Lattice, places, remeshed
from levelset.profile import LEVEL, profile
from levelset.shape import rotation
from levelset.shapes import Disk, Ellipse, Shape, Sphere
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.particles import distortion

PLANE = Grid((81, 81), 0.05, (-2.0, -2.0))
SPACE = Grid((41, 41, 41), 0.1, (-2.0, -2.0, -2.0))
WIDTHS = {2: 0.4, 3: 0.6}


def band_of(shape: Shape, grid: Grid, wider: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Nodes near a shape, and their profile values."""
    width = WIDTHS[grid.ndim]
    distance = shape.distance(grid.points()).ravel()
    nodes = np.flatnonzero(np.abs(distance) < wider * width)
    return nodes, profile(distance[nodes], width)


def carried(
    shape: Shape, grid: Grid, move: callable, kernel: str = "M6'", threads: int | None = None
):
    nodes, values = band_of(shape, grid, 1.6)
    return remeshed(
        grid, nodes, move(places(grid, nodes)), values, kernel, WIDTHS[grid.ndim], threads=threads
    )


def near(band, exact: np.ndarray, grid: Grid) -> float:
    """Largest error of a band's values where they are not level."""
    expected = profile(exact, WIDTHS[grid.ndim])
    inner = np.abs(exact) < 0.5 * WIDTHS[grid.ndim]
    assert inner.sum() > 100
    return float(np.abs(band.values - expected)[inner].max())


@settings(max_examples=15, deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
def test_a_disk_turned_and_shifted_arrives_where_it_should(angle, x, y):
    """A rigid motion is a linear map: Newton is exact, the error is that of one interpolation."""
    turn, shift = rotation((angle,)), np.array([x, y])
    shape = Ellipse((0.9, 0.6), center=(0.1, -0.2))
    band = carried(shape, PLANE, lambda at: at @ turn.T + shift)
    exact = shape.moved((x, y), angle).distance(places(PLANE, band.nodes).T)
    assert near(band, exact, PLANE) < 2e-4


def test_nothing_changes_where_no_particle_moved():
    for grid, shape in ((PLANE, Disk(1.0)), (SPACE, Sphere(1.0))):
        band = carried(shape, grid, lambda at: at)
        exact = profile(shape.distance(places(grid, band.nodes).T), WIDTHS[grid.ndim])
        inner = np.abs(exact) < 0.99 * LEVEL * WIDTHS[grid.ndim]
        np.testing.assert_allclose(band.values[inner], exact[inner], atol=1e-14)


@pytest.mark.parametrize("kernel", ["M4'", "M6'", "L4,4", "L6,4"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_the_error_of_one_remeshing_falls_with_the_order_of_the_kernel(kernel, ndim):
    """A strong smooth deformation with a known inverse: a shear that varies, x += a sin(y)."""

    def bend(at: np.ndarray, sign: float) -> np.ndarray:
        moved = at.copy()
        moved[:, 0] += sign * 0.7 * np.sin(1.3 * at[:, 1])
        return moved

    errors = []
    for cells in (32, 64) if ndim == 3 else (64, 128):
        grid = Grid((cells + 1,) * ndim, 4.4 / cells, (-2.2,) * ndim)
        shape = Disk(1.0) if ndim == 2 else Sphere(1.0)
        # a profile as wide as the shape, so that it is smooth on both meshes
        distance = shape.distance(grid.points()).ravel()
        nodes = np.flatnonzero(np.abs(distance) < 0.75)
        band = remeshed(
            grid, nodes, bend(places(grid, nodes), 1.0), profile(distance[nodes], 0.8), kernel, 0.8
        )
        exact = shape.distance(bend(places(grid, band.nodes), -1.0).T)
        inner = np.abs(exact) < 0.15
        errors.append(np.sqrt(np.mean((band.values - profile(exact, 0.8))[inner] ** 2)))
    claimed = {"M4'": 3, "M6'": 5, "L4,4": 5, "L6,4": 7}[kernel]
    assert math.log2(errors[0] / errors[1]) > claimed - (0.35 if ndim == 2 else 0.8)


@pytest.mark.parametrize("ndim", [2, 3])
def test_rigid_motion_has_no_distortion_and_stretching_by_a_its_logarithm(ndim):
    grid = PLANE if ndim == 2 else SPACE
    shape = Disk(1.0) if ndim == 2 else Sphere(1.0)
    nodes, values = band_of(shape, grid)
    at = places(grid, nodes)
    turn = rotation((2.0,) if ndim == 2 else (0.5, -1.0, 2.0))
    assert Lattice(grid, nodes, at @ turn.T + 5.0, values).distortion() < 1e-12
    stretch = np.diag([1.25, 0.8, 1.0][:ndim])
    found = Lattice(grid, nodes, at @ (turn @ stretch).T, values).distortion()
    assert found == pytest.approx(math.log(1.25), abs=1e-12)
    folded = at * np.array([-1.0, 1.0, 1.0][:ndim])
    assert Lattice(grid, nodes, folded, values).distortion() == math.inf


def test_distortion_agrees_with_that_of_a_whole_lattice():
    x, y = PLANE.points()
    displacement = np.stack([0.1 * np.sin(2 * y), 0.2 * np.cos(x)])
    nodes = np.arange(PLANE.size)
    moved = places(PLANE, nodes) + displacement.reshape(2, -1).T
    found = Lattice(PLANE, nodes, moved, np.zeros(PLANE.size)).distortion()
    assert found == pytest.approx(distortion(displacement, PLANE), rel=2e-3)


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_velocity_gradient_is_found_on_particles_wherever_they_are(ndim):
    grid = PLANE if ndim == 2 else SPACE
    nodes, values = band_of(Disk(1.0) if ndim == 2 else Sphere(1.0), grid)
    at = places(grid, nodes)
    moved = at @ rotation((0.7,) if ndim == 2 else (0.7, 0.2, -0.4)).T
    matrix = np.array([[0.5, -2.0, 0.25], [1.0, -0.5, 0.0], [0.0, 3.0, 1.0]])[:ndim, :ndim]
    found = Lattice(grid, nodes, moved, values).gradient(moved @ matrix.T)
    assert found == pytest.approx(np.abs(matrix).sum(axis=1).max(), rel=1e-10)


def test_interfaces_cross_the_seam_of_a_periodic_axis():
    grid = Grid((80, 81), 0.05, (-2.0, -2.0), boundary=("periodic", "unbounded"))
    shift = np.array([1.7, 0.0])
    nodes, values = band_of(Disk(0.8), grid, 1.6)
    band = remeshed(grid, nodes, places(grid, nodes) + shift, values, "M6'", WIDTHS[2])
    at = places(grid, band.nodes)
    images = [Disk(0.8, center=(1.7 - 4.0 * k, 0.0)).distance(at.T) for k in (0, 1)]
    assert near(band, np.minimum(*images), grid) < 2e-4


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_same_bits_for_any_number_of_threads(ndim):
    grid = PLANE if ndim == 2 else SPACE
    shape = Disk(1.0) if ndim == 2 else Sphere(1.0)

    def swirl(at: np.ndarray) -> np.ndarray:
        moved = at.copy()
        moved[:, 0] += 0.3 * np.sin(2 * at[:, 1])
        moved[:, 1] += 0.2 * np.cos(3 * at[:, 0])
        return moved

    one, three = (carried(shape, grid, swirl, threads=threads) for threads in (1, 3))
    np.testing.assert_array_equal(one.nodes, three.nodes)
    np.testing.assert_array_equal(one.values, three.values)


def test_nodes_ascend_and_hold_the_interface_with_all_its_neighbours():
    band = carried(Disk(1.0), PLANE, lambda at: at + 0.013)
    assert (np.diff(band.nodes) > 0).all()
    exact = Disk(1.0, center=(0.013, 0.013)).distance(PLANE.points()).ravel()
    wanted = np.flatnonzero(np.abs(exact) < 0.75 * WIDTHS[2])
    assert np.isin(wanted, band.nodes).all()
    kernel_margin = 3 + 1  # spacings on either side, the width is 8
    assert len(band.nodes) < (6 + kernel_margin) / 6 * len(wanted) * 1.1


def test_particles_that_have_crossed_are_refused():
    with pytest.raises(InputError, match="particles have crossed each other in"):
        carried(Disk(1.0), PLANE, lambda at: at * np.array([-1.0, 1.0]))


def test_a_level_set_that_changes_side_from_node_to_node_stays_in_the_band():
    """Filaments are squeezed until both neighbours of the contour are level."""
    nodes = np.arange(PLANE.size)
    at = places(PLANE, nodes)
    values = np.where(Disk(1.0).distance(at.T) < 0, -LEVEL, LEVEL) * WIDTHS[2]
    band = remeshed(PLANE, nodes, at.copy(), values, "M6'", WIDTHS[2])
    inside = Disk(1.0).distance(at.T) < 0
    np.testing.assert_array_equal(band.filled(LEVEL * WIDTHS[2]).ravel() < 0, inside)
