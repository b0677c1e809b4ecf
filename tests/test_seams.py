"""What lies across the seam of a periodic axis."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.seams import across_seams, image_distance
from levelset.shapes import Disk, Sphere
from remesh.errors import InputError
from remesh.grid import Grid

GRID = Grid((32, 33), 1 / 16, (-1.0, -1.0), boundary=("periodic", "unbounded"))


def test_the_distance_is_that_of_the_nearest_image():
    disk = Disk(0.4, center=(0.9, 0.2))
    found = image_distance(disk, GRID)
    x, y = GRID.points()
    exact = np.min([np.hypot(x - 0.9 - way, y - 0.2) for way in (-2.0, 0.0, 2.0)], axis=0) - 0.4
    np.testing.assert_allclose(found, exact, atol=1e-14)
    np.testing.assert_array_equal(
        image_distance(disk, Grid((33, 33), 1 / 16, (-1.0, -1.0))),
        disk.distance(Grid((33, 33), 1 / 16, (-1.0, -1.0)).points()),
    )


def test_a_shape_of_another_dimension_is_refused():
    with pytest.raises(InputError, match="the shape has 3 dimensions, the grid 2"):
        image_distance(Sphere(0.2), GRID)


def test_particles_that_went_round_are_found_again_with_their_images():
    places = np.array([[5.05, 0.3], [-1.02, 0.0], [0.0, 7.0]])
    points = np.array([[3.5, 0.0]])
    positions, values, targets = across_seams(places, np.array([1.0, 2.0, 3.0]), points, GRID, 0.1)
    np.testing.assert_allclose(targets, [[-0.5, 0.0]])
    np.testing.assert_allclose(positions[:3], [[-0.95, 0.3], [0.98, 0.0], [0.0, 7.0]])
    images = sorted(zip(positions[3:, 0].round(3), values[3:], strict=True))
    assert images == [(-1.02, 2.0), (1.05, 1.0)]
    assert (places[0] == [5.05, 0.3]).all()
