"""Ghosts of blocks: against a NumPy text of their rule, exact for polynomials."""

import numpy as np
import pytest
from nested_blocks import nested, recipe
from scattered_blocks import SIDES, cube, noise, scattered

from remesh.errors import InputError
from remesh.multires.blocks import ABSENT, OUTSIDE
from remesh.multires.ghosts import padded
from remesh.multires.wavelets import WAVELETS

WEIGHTS = {
    2: [1 / 2, 1 / 2],
    4: [-1 / 16, 9 / 16, 9 / 16, -1 / 16],
    6: [3 / 256, -25 / 256, 150 / 256, 150 / 256, -25 / 256, 3 / 256],
}  # Deslauriers & Dubuc, Constr. Approx. 5 (1989) 49


def complete(values, blocks, level):
    """A level's values on its uniform grid, not a number where there are no blocks."""
    mesh = blocks.mesh
    dense = np.full(mesh.level_grid(level).shape, np.nan)
    for n in range(*blocks.starts[level : level + 2]):
        start = blocks.places[n] * mesh.block
        dense[tuple(slice(s, s + mesh.block) for s in start)] = values[n]
    return dense


def around(dense, mesh, width):
    """With so many nodes around it: periodic, or zeros."""
    for axis, wraps in enumerate(mesh.grid.periodic):
        pads = [(0, 0)] * mesh.ndim
        pads[axis] = (width, width)
        dense = np.pad(dense, pads, mode="wrap" if wraps else "constant")
    return dense


def rule(values, blocks, width, weights):
    """The rule of ghosts on whole levels: what is known, else predicted from even nodes."""
    mesh, reach = blocks.mesh, len(weights)
    result = []
    for level in range(blocks.finest + 1):
        own = complete(values, blocks, level)
        if level:
            even = own[(slice(None, None, 2),) * mesh.ndim]
            even = np.where(np.isnan(even), complete(values, blocks, level - 1), even)
            fine = around(even, mesh, reach)
            for axis in range(mesh.ndim):
                count = own.shape[axis]
                line = np.moveaxis(fine, axis, 0)
                longer = np.empty((count, *line.shape[1:]))
                longer[::2] = line[reach : reach + count // 2]
                first = reach - len(weights) // 2 + 1
                longer[1::2] = sum(
                    w * line[first + t : first + t + count // 2] for t, w in enumerate(weights)
                )
                fine = np.moveaxis(longer, 0, axis)
            own = np.where(np.isnan(own), fine, own)
        wide = around(own, mesh, width)
        for n in range(*blocks.starts[level : level + 2]):
            start = blocks.places[n] * mesh.block
            result.append(wide[tuple(slice(s, s + mesh.block + 2 * width) for s in start)])
    return np.array(result)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("side", SIDES)
def test_ghosts_are_what_the_rule_says(side, dtype, tolerance):
    blocks = scattered(side)
    assert (blocks.neighbours == -1).any()
    values = noise(blocks, 2, dtype=dtype)
    found = padded(values, blocks, 4)
    assert found.dtype == dtype
    for part, given in zip(found, values, strict=True):
        assert np.allclose(part, rule(given, blocks, 4, WEIGHTS[4]), rtol=0, atol=tolerance)


@pytest.mark.parametrize("order", [2, 4, 6])
@pytest.mark.parametrize("side", ["2-D periodic", "3-D"])
def test_ghosts_of_any_order_and_of_the_widest_kind_follow_the_rule(side, order):
    blocks = scattered(side, seed=3)
    values = noise(blocks)
    found = padded(values, blocks, 8 - order, order=order)
    want = rule(values, blocks, 8 - order, WEIGHTS[order])
    assert np.allclose(found, want, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["2.2", "6.2"])
def test_the_prediction_is_the_wavelets_own_unless_told(name):
    blocks = scattered("2-D", wavelet=name)
    values = noise(blocks)
    order = WAVELETS[name].order
    own, told = padded(values, blocks, 2), padded(values, blocks, 2, order=order)
    assert np.allclose(own, told, rtol=0, atol=1e-14)


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("ndim", [2, 3])
def test_polynomials_below_the_order_pass_jumps_exactly(ndim, order):
    blocks = cube(ndim, 1, block=16)
    mesh = blocks.mesh
    factors = np.random.default_rng(order).uniform(-1, 1, (ndim, order))

    def law(points):
        """A product of polynomials of degree order - 1 along each axis."""
        return np.prod([np.polyval(f, x) for f, x in zip(factors, points, strict=True)], axis=0)

    width = 8
    found = padded(law(blocks.points()), blocks, width, order=order)[-1]
    assert (blocks.neighbours[-1] == -1).sum() == 3**ndim - 1
    local = np.arange(-width, mesh.block + width)
    axes = [(place * mesh.block + local) * mesh.spacing(1) for place in blocks.places[-1]]
    want = law(np.array(np.meshgrid(*axes, indexing="ij")))
    assert np.allclose(found, want, rtol=0, atol=1e-12 * abs(want).max())


def test_ghosts_beyond_unbounded_ends_are_zero():
    blocks = scattered("2-D")
    found = padded(np.ones(blocks.shape), blocks, 3)
    corner = blocks.numbers_of(0, np.zeros((1, 2), np.int64))[0]
    assert (found[corner, :3] == 0).all()
    assert (found[corner, :, :3] == 0).all()
    assert (found[corner, 3:, 3:] == 1).all()


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-4)])
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_constants_stay_constant_beyond_ends_where_the_last_value_goes_on(
    side, seed, dtype, tolerance
):
    blocks = scattered(side, seed)
    found = padded(np.full((2, *blocks.shape), 3, dtype), blocks, 4, outside="last")
    assert abs(found - 3).max() < tolerance


@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
def test_where_the_last_value_goes_on_cubics_pass_jumps_beside_ends_exactly(ndim, nodes, place):
    mesh = recipe(nodes, ndim, 2, "unbounded", 8)
    blocks = nested(mesh, (place, 0.4, place)[:ndim], 0.05)
    jumps = (blocks.neighbours == ABSENT).any(axis=1) & (blocks.neighbours == OUTSIDE).any(axis=1)
    assert jumps[blocks.of(2)].any()

    def law(points):
        return sum((k + 1) * (x - 0.3) ** 3 for k, x in enumerate(points))

    found = padded(law(blocks.points()), blocks, 4, outside="last")
    local = np.arange(-4, mesh.block + 4)
    for n in np.nonzero(jumps)[0]:
        level = int(blocks.levels[n])
        last = np.array(mesh.level_grid(level).shape) - 1
        nodes_of = [
            np.clip(p * mesh.block + local, 0, end)
            for p, end in zip(blocks.places[n], last, strict=True)
        ]
        want = law(np.array(np.meshgrid(*nodes_of, indexing="ij")) * mesh.spacing(level))
        assert np.allclose(found[n], want, rtol=0, atol=1e-12)


def test_the_width_may_be_nothing():
    blocks = scattered("3-D")
    values = noise(blocks)
    assert (padded(values, blocks, 0) == values).all()


@pytest.mark.parametrize("side", ["2-D", "3-D mixed"])
def test_bits_do_not_depend_on_threads(side):
    blocks = scattered(side)
    values = noise(blocks, 3)
    assert (padded(values, blocks, 4, threads=1) == padded(values, blocks, 4, threads=3)).all()


def test_what_has_no_ghosts_is_refused():
    blocks = scattered("2-D")
    with pytest.raises(InputError, match="values must have shape"):
        padded(np.ones((3, 8, 8)), blocks, 2)
    for width in (5, -1, 1.5):
        with pytest.raises(InputError, match="width must be a whole number from 0 to 4"):
            padded(noise(blocks), blocks, width)
    with pytest.raises(InputError, match="outside must be 'zero' or 'last', got 'wall'"):
        padded(noise(blocks), blocks, 2, outside="wall")
    with pytest.raises(InputError, match="order must be one of"):
        padded(noise(blocks), blocks, 2, order=3)
    with pytest.raises(InputError, match="values must be real numbers, got complex128"):
        padded(1j * noise(blocks), blocks, 2)
