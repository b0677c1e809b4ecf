"""Fields on every second node: what is kept, what is wiped out, at which order they are told."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.halving import halved, halved_grid


def moments(field: NDArray[Any], grid: Grid) -> NDArray[np.float64]:
    """All sums of f x^a y^b (z^c), exponents below 4, times the cell volume."""
    powers = [np.stack([x**a for a in range(4)]) for x in grid.axes()]
    letters = "xyz"[: grid.ndim]
    words = ",".join(f"{up}{low}" for up, low in zip("abc", letters, strict=False))
    out = "abc"[: grid.ndim]
    return np.asarray(np.einsum(f"{letters},{words}->{out}", field, *powers)) * grid.cell_volume


@pytest.mark.parametrize(("shape", "first"), [((33, 26), (1, 0)), ((25, 31, 27), (0, 1, 3))])
@pytest.mark.parametrize("times", [1, 2])
def test_moments_below_four_are_kept_of_what_is_zero_at_the_edges(
    shape: tuple[int, ...], first: tuple[int, ...], times: int
) -> None:
    grid = Grid(shape, 0.1, (-1.0, 0.5, 2.0)[: len(shape)])
    first = tuple(start % 2**times for start in first)
    field = np.zeros(shape)
    inner = tuple(slice(12, -12) for _ in shape)
    field[inner] = np.random.default_rng(1).standard_normal(field[inner].shape)
    coarse = halved_grid(grid, times, first)
    found = moments(halved(field, grid, times, first), coarse)
    assert found == pytest.approx(moments(field, grid), rel=1e-11, abs=1e-11)


def test_kept_nodes_stand_where_they_stood() -> None:
    grid = Grid((32, 19), 0.25, (-1.0, 2.0), ("periodic", "unbounded"))
    coarse = halved_grid(grid, 2, (0, 3))
    assert (coarse.shape, coarse.spacing, coarse.origin) == ((8, 4), 1.0, (-1.0, 2.75))
    assert (coarse.boundary, coarse.length[0]) == (grid.boundary, grid.length[0])


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_a_straight_law_is_left_as_it_is_up_to_unbounded_edges_and_cubics_inside(
    dtype: str,
) -> None:
    grid = Grid((21, 16, 18), 0.1, (-1.0, 0.0, 0.0))
    coarse = halved_grid(grid, 1, (0, 1, 0))
    for law, edge in ((lambda x, y, z: 1 + x - 2 * y + z, 0), (lambda x, y, z: x * y + z**3, 2)):
        told = halved(law(*grid.points()).astype(dtype), grid, 1, (0, 1, 0))
        inner = tuple(slice(edge, n - edge) for n in coarse.shape)
        assert told.dtype == dtype
        assert told[inner] == pytest.approx(law(*coarse.points())[inner], abs=2e-6)


def test_waves_of_two_nodes_vanish_and_long_ones_are_told_to_order_four() -> None:
    grid = Grid((32, 32), 1 / 32, boundary="periodic")
    checker = (-1.0) ** np.arange(32)[:, None] * np.ones(32)
    assert not halved(checker, grid).any()
    errors = []
    for nodes in (32, 64):
        grid = Grid((nodes, nodes), 1 / nodes, boundary="periodic")
        wave = [np.sin(2 * np.pi * g.points().sum(axis=0)) for g in (grid, halved_grid(grid))]
        errors.append(np.abs(halved(wave[0], grid) - wave[1]).max())
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)


def test_each_component_of_a_vector_is_halved() -> None:
    grid = Grid((8, 12), 0.5, boundary="periodic")
    field = np.random.default_rng(0).standard_normal((2, 8, 12))
    both = halved(field, grid)
    for one, component in zip(both, field, strict=True):
        np.testing.assert_array_equal(one, halved(component, grid))


def test_what_cannot_be_halved_is_refused() -> None:
    for shape, times in (((10, 16), 2), ((14, 16), 2), ((6, 16), 1)):
        with pytest.raises(InputError, match="of axis 0 cannot be kept"):
            halved_grid(Grid(shape, 0.1, boundary="periodic"), times)
    with pytest.raises(InputError, match="of axis 1 cannot be kept: it needs 8 nodes or more"):
        halved(np.zeros((16, 6)), Grid((16, 6), 0.1))
    with pytest.raises(InputError, match="counts of nodes below 2"):
        halved_grid(Grid((16, 16), 0.1), 1, (0, 2))
