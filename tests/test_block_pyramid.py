"""Transforms on blocks: undone whatever the values and the neighbours, sums kept, parity."""

from itertools import product

import numpy as np
import pytest
from scattered_blocks import SIDES, cube, noise, scattered

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires import pyramid, transform
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.uniform import on_blocks, to_uniform
from remesh.multires.wavelets import WAVELETS


def round_trip(values, blocks):
    consistent = pyramid.restricted(values, blocks)
    back = pyramid.inverse(*pyramid.forward(consistent, blocks), blocks)
    return consistent, back


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 2e-5)])
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", WAVELETS)
def test_inverse_undoes_forward_for_any_values(name, side, dtype, tolerance):
    blocks = scattered(side, wavelet=name)
    values = noise(blocks, 2, dtype=dtype)
    consistent, back = round_trip(values, blocks)
    assert back.dtype == dtype
    assert np.allclose(back, consistent, rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", ["2.2", "4.4", "6.2"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_every_two_level_neighbourhood_of_a_corner_goes_there_and_back(ndim, name):
    mesh = AdaptiveMesh(grid=Grid((64,) * ndim, 1.0), levels=1, block=8, wavelet=name)
    middle = np.array(list(product((1, 2), repeat=ndim)))
    corners = np.array(list(product((0, 1), repeat=ndim)))
    none = np.empty((0, ndim), np.int64)
    step = 1 if ndim == 2 or name == "4.4" else 7
    for pattern in range(0, 2 ** len(middle), step):
        fine = middle[[bool(pattern >> k & 1) for k in range(len(middle))]]
        places = (2 * fine[:, None] + corners).reshape(-1, ndim)
        blocks = Blocks.around(mesh, [none, places])
        assert blocks.size == 4**ndim + len(fine) * 2**ndim
        consistent, back = round_trip(noise(blocks, seed=pattern), blocks)
        assert np.allclose(back, consistent, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", WAVELETS)
@pytest.mark.parametrize("shape", [(64, 96), (32, 32, 48)], ids=["2-D", "3-D"])
def test_on_a_complete_periodic_mesh_it_is_the_transform_of_the_uniform_field(name, shape):
    grid = Grid(shape, 1.0, boundary="periodic")
    levels = 2 if len(shape) == 2 else 1
    mesh = AdaptiveMesh(grid=grid, levels=levels, block=8, wavelet=name)
    blocks = Blocks.uniform(mesh, levels)
    field = np.random.default_rng(3).standard_normal(shape)
    for spill in (False, True):
        smooth, details = pyramid.forward(on_blocks(field, blocks), blocks, spill=spill)
        want = field
        for level in range(levels, 0, -1):
            want = transform.forward(want, mesh.level_grid(level), name, 1)
            even = (slice(None, None, 2),) * mesh.ndim
            coarse = want[even].copy()
            want[even] = 0
            found = to_uniform(details, blocks, level)
            assert np.allclose(found, want, rtol=0, atol=1e-12)
            assert np.allclose(to_uniform(smooth, blocks, level - 1), coarse, rtol=0, atol=1e-12)
            want = coarse


@pytest.mark.parametrize("side", SIDES)
def test_active_nodes_keep_their_bits_and_others_become_consistent(side):
    blocks = scattered(side)
    values = noise(blocks)
    once = pyramid.restricted(values, blocks)
    assert (once[blocks.leaves()] == values[blocks.leaves()]).all()
    assert (pyramid.restricted(once, blocks) == once).all()
    below = once.copy()
    below[~blocks.leaves()] = np.nan
    assert (pyramid.restricted(below, blocks) == once).all()


@pytest.mark.parametrize("name", WAVELETS)
@pytest.mark.parametrize("ndim", [2, 3])
def test_polynomials_below_the_order_have_no_details(ndim, name):
    blocks = cube(ndim, 1, wavelet=name)
    factors = np.random.default_rng(4).uniform(-1, 1, (ndim, WAVELETS[name].order))
    law = [np.polyval(f, x) for f, x in zip(factors, blocks.points(), strict=True)]
    details = pyramid.forward(np.prod(law, axis=0), blocks).details
    assert abs(details).max() < 1e-13


@pytest.mark.parametrize(("name", "count"), [("2.2", 2), ("4.2", 2), ("4.4", 4), ("6.2", 2)])
@pytest.mark.parametrize("ndim", [2, 3])
def test_with_spill_sums_stay_what_they_are_on_the_finest_nodes(ndim, name, count):
    blocks = cube(ndim, 2, wavelet=name)
    mesh, fine = blocks.mesh, blocks.of(1)
    values = np.zeros(blocks.shape)  # zero on all coarser active nodes
    values[fine] = noise(blocks)[fine]
    smooth = pyramid.forward(values, blocks, spill=True).smooth
    # the same field on all fine nodes: interpolated beside the blocks, without details there
    within = (slice(5 * mesh.block, 7 * mesh.block),) * ndim
    whole = np.zeros(mesh.grid.shape)
    whole[within] = to_uniform(values, blocks)[within]
    grid, plain = Grid(mesh.grid.shape, 1.0, boundary="periodic"), name.split(".")[0] + ".0"
    details = np.zeros_like(whole)
    details[within] = transform.forward(whole, grid, plain, 1)[within]
    whole = transform.inverse(details, grid, plain, 1)
    assert np.allclose(whole[within], to_uniform(values, blocks)[within], rtol=0, atol=1e-12)
    coarse = smooth[blocks.of(0)]
    want = moments(whole, mesh.grid.points(), mesh, count) / 2**ndim
    found = moments(coarse, blocks.points()[:, blocks.of(0)], mesh, count)
    assert np.allclose(found, want, rtol=0, atol=1e-12 * abs(whole).sum())


def moments(field, points, mesh, count):
    """Sums of f x^a y^b z^c for exponents below ``count``."""
    x = points / max(mesh.grid.length)
    return np.array([
        (field * np.prod([x[a] ** p for a, p in enumerate(powers)], axis=0)).sum()
        for powers in product(range(count), repeat=mesh.ndim)
    ])  # fmt: skip


@pytest.mark.parametrize("name", WAVELETS)
@pytest.mark.parametrize("ndim", [2, 3])
def test_without_details_beside_jumps_nothing_spills(ndim, name):
    blocks = cube(ndim, 3, wavelet=name)
    inner = (blocks.neighbours != -1).all(axis=1)
    assert inner[blocks.of(1)].sum() == 1
    details = pyramid.forward(noise(blocks), blocks).details
    details[~inner] = 0
    values = pyramid.inverse(noise(blocks), details, blocks)
    plain, spilt = (pyramid.forward(values, blocks, spill=some) for some in (False, True))
    assert abs(details).max() > 0.1
    assert np.allclose(plain.smooth, spilt.smooth, rtol=0, atol=1e-12)
    for found in (plain, spilt):
        assert np.allclose(found.details, details, rtol=0, atol=1e-12)


@pytest.mark.parametrize("side", ["2-D", "3-D mixed"])
def test_bits_do_not_depend_on_threads(side):
    blocks = scattered(side)
    values = noise(blocks, 2)
    one, three = (pyramid.forward(values, blocks, spill=True, threads=n) for n in (1, 3))
    assert (one.smooth == three.smooth).all()
    assert (one.details == three.details).all()
    back = [pyramid.inverse(*one, blocks, threads=n) for n in (1, 3)]
    assert (back[0] == back[1]).all()


def test_arguments_are_left_as_they_are():
    blocks = scattered("2-D")
    values = noise(blocks)
    given = values.copy()
    smooth, details = pyramid.forward(values, blocks, spill=True)
    kept = smooth.copy(), details.copy()
    pyramid.inverse(smooth, details, blocks)
    assert (values == given).all()
    assert (smooth == kept[0]).all()
    assert (details == kept[1]).all()


def test_parts_that_do_not_agree_are_refused():
    blocks = scattered("2-D")
    with pytest.raises(InputError, match="must agree"):
        pyramid.inverse(noise(blocks), noise(blocks, 2), blocks)
    with pytest.raises(InputError, match="values must have shape"):
        pyramid.forward(np.ones((2, 2)), blocks)
