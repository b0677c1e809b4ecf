"""Adaptive global mappings: geometry, finding back, and where a monitor draws the nodes."""

import numpy as np
import pytest

import remesh
from remesh.errors import InputError
from remesh.mapping import Mapping

THIN = remesh.Grid((64, 4), 1 / 64, boundary="periodic")
PLANE = remesh.Grid((48, 40), 1 / 40, boundary="periodic")
SPACE = remesh.Grid((20, 16, 24), 1 / 16, boundary="periodic")


def waves(grid, size=0.05):
    """A smooth periodic offset whose parts depend on all axes."""
    points = grid.points() / np.reshape(grid.length, (-1, *(1,) * grid.ndim))
    phases = 2 * np.pi * (points + np.roll(points, 1, axis=0))
    return size * np.sin(phases)


def test_the_identity_leaves_nodes_and_volumes_alone():
    mapping = Mapping.identity(PLANE)
    assert np.array_equal(mapping.points(), PLANE.points())
    assert np.array_equal(mapping.volume(), np.ones(PLANE.shape))


def test_volumes_sum_to_the_box_whatever_the_map_and_the_displacement():
    mapping = Mapping(PLANE, waves(PLANE))
    assert mapping.volume().mean() == pytest.approx(1.0, abs=1e-14)
    moved = mapping.volume(0.3 * waves(PLANE)[::-1])
    assert moved.mean() == pytest.approx(1.0, abs=1e-14)


def test_volumes_are_the_determinants_of_the_map_to_fourth_order():
    errors = []
    for nodes in (64, 128):
        grid = remesh.Grid((nodes, 4), 1 / nodes, boundary="periodic")
        x = grid.points()[0]
        mapping = Mapping(grid, np.stack([0.1 * np.sin(2 * np.pi * x), 0 * x]))
        errors.append(np.abs(mapping.volume() - 1 - 0.2 * np.pi * np.cos(2 * np.pi * x)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize("grid", [PLANE, SPACE])
def test_gradients_are_those_in_space(grid):
    errors = []
    for factor in (1, 2):
        finer = remesh.Grid([factor * n for n in grid.shape], grid.spacing / factor,
                            boundary="periodic")  # fmt: skip
        mapping = Mapping(finer, waves(finer, 0.02))
        x = 2 * np.pi * mapping.points()[0] / finer.length[0]
        found = mapping.gradient(np.sin(x))
        exact = np.zeros_like(found)
        exact[0] = 2 * np.pi / finer.length[0] * np.cos(x)
        errors.append(np.abs(found - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.25)


@pytest.mark.parametrize("grid", [PLANE, SPACE])
def test_places_are_found_back_on_the_map_however_far(grid):
    mapping = Mapping(grid, waves(grid, 0.03))
    shift = np.reshape([0.31, -0.22, 0.4][: grid.ndim], (-1, *(1,) * grid.ndim))
    goal = mapping.points() + shift + 0.2 * waves(grid)[::-1]
    found = mapping.pull_back(goal)
    there = remesh.sample_nodes(mapping.offset, found, grid, "L4,2")
    np.testing.assert_allclose(grid.points() + found + there, goal, atol=1e-11)


def test_nodes_that_stay_are_found_where_they_are():
    mapping = Mapping(PLANE, waves(PLANE))
    np.testing.assert_allclose(mapping.pull_back(mapping.points()), 0.0, atol=1e-13)


def test_in_one_dimension_a_strong_monitor_spreads_itself_evenly():
    mapping = Mapping.identity(THIN)
    for _ in range(60):
        monitor = 1.0 + 4.0 * np.exp(-(((mapping.points()[0] - 0.5) / 0.08) ** 2))
        mapping = mapping.driven(monitor, 0.3, smooth=0.0)
    gaps = np.diff(mapping.points()[0, :, 0], append=mapping.points()[0, 0, 0] + 1)
    between = 0.5 * (monitor + np.roll(monitor, -1, axis=0))[:, 0]
    np.testing.assert_allclose(gaps * between / (gaps * between).mean(), 1.0, atol=1e-6)
    assert gaps.max() / gaps.min() > 4.0


def test_an_even_monitor_leaves_the_identity_alone():
    mapping = Mapping.identity(SPACE).driven(np.full(SPACE.shape, 3.0), 10.0)
    assert np.abs(mapping.offset).max() < 1e-12


def test_nodes_gather_about_the_place_that_is_asked_for():
    mapping = Mapping.identity(PLANE)
    middle = np.reshape([0.6, 0.5], (2, 1, 1))
    for _ in range(20):
        near = np.exp(-(((mapping.points() - middle) / 0.1) ** 2).sum(axis=0))
        mapping = mapping.driven(1 + 6 * near, 0.05)
    finest = np.unravel_index(mapping.volume().argmin(), PLANE.shape)
    assert mapping.volume().min() < 0.3
    np.testing.assert_allclose(mapping.points()[:, *finest], middle.ravel(), atol=0.03)


def test_remeshing_on_the_map_conserves_strength():
    mapping = Mapping(PLANE, waves(PLANE, 0.03))
    values = np.exp(-(((mapping.points() - 0.5) / 0.1) ** 2).sum(axis=0))
    strength = values * mapping.volume()
    shift = mapping.pull_back(mapping.points() + 0.1 * waves(PLANE))
    moved = remesh.advect_nodes(strength, shift, PLANE, "L4,2").field
    assert moved.sum() == pytest.approx(strength.sum(), rel=1e-13)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Mapping(PLANE, waves(PLANE, 0.5)), "the mapping folds"),
        (lambda: Mapping(PLANE, waves(PLANE)[0]), "offset must have shape"),
        (lambda: Mapping.identity(remesh.Grid((8, 8), 1.0)), "needs periodic axes"),
        (lambda: Mapping.identity(PLANE).driven(np.zeros(PLANE.shape), 1.0), "monitor must be"),
        (lambda: Mapping.identity(PLANE).driven(np.ones(3), 1.0), "monitor must be positive at"),
        (lambda: Mapping.identity(PLANE).pull_back(np.full((2, 48, 40), np.nan)), "displacement"),
    ],
)
def test_what_makes_no_map_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
