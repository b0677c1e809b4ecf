"""Fields on a box of finest nodes: each level gets their restriction, moments stay."""

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.adapt import adapt
from remesh.multires.blocks import Blocks
from remesh.multires.boxed import added
from remesh.multires.mesh import AdaptiveMesh

H = 1 / 256


def mesh(ndim: int, wavelet: str = "4.4") -> AdaptiveMesh:
    shape = (256,) * ndim if ndim == 2 else (64,) * 3
    return AdaptiveMesh(
        grid=Grid(shape, H), levels=3 if ndim == 2 else 2, wavelet=wavelet,
        block=16 if ndim == 2 else 8,
    )  # fmt: skip


def blob(first: tuple[int, ...], shape: tuple[int, ...]) -> np.ndarray:
    """A bump in the middle of a box, zero at its ends."""
    result = np.ones(())
    for start, n in zip(first, shape, strict=True):
        x = (np.arange(n) - 0.5 * (n - 1)) / (0.1 * n)
        result = np.multiply.outer(result, np.exp(-0.5 * x**2) * (1 + 0.01 * start))
    return result


def moment(values: np.ndarray, blocks: Blocks, powers: tuple[int, ...]) -> float:
    """Sum of f x^a y^b over the coarsest level."""
    own, points = blocks.of(0), blocks.points()
    weight = np.prod([x[own] ** p for x, p in zip(points, powers, strict=True)], axis=0)
    cell = blocks.mesh.spacing(0) ** blocks.mesh.ndim
    return float(np.sum(values[own] * weight)) * cell


def test_on_the_finest_blocks_the_field_is_added_as_it_is() -> None:
    blocks = Blocks.uniform(mesh(2), 3)
    first, shape = (37, 90), (50, 63)
    field = blob(first, shape)
    start = np.random.default_rng(0).normal(size=blocks.shape)
    found = (added(start, blocks, field, first) - start)[blocks.of(3)]
    dense = np.zeros((256, 256))
    dense[37:87, 90:153] = field
    where = blocks.places[blocks.of(3)]
    for place, block in zip(where, found, strict=True):
        low = place * 16
        part = dense[low[0] : low[0] + 16, low[1] : low[1] + 16]
        np.testing.assert_allclose(block, part, atol=1e-14)


@pytest.mark.parametrize("wavelet", ["2.2", "4.2", "4.4"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_what_the_mesh_does_not_resolve_is_let_go_with_its_moments_kept(
    ndim: int, wavelet: str
) -> None:
    one = mesh(ndim, wavelet)
    first, shape = ((101, 90), (37, 44)) if ndim == 2 else ((21, 20, 30), (15, 22, 17))
    field = blob(first, shape)
    for blocks in (Blocks.uniform(one), Blocks.uniform(one, 1)):
        found = added(np.zeros(blocks.shape), blocks, field, first)
        axes = [H * (start + np.arange(n)) for start, n in zip(first, shape, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"))
        kept = int(wavelet[-1])
        for powers in np.ndindex(*(kept,) * ndim):
            weight = np.prod([x**p for x, p in zip(points, powers, strict=True)], axis=0)
            exact = float(np.sum(field * weight)) * H**ndim
            assert moment(found, blocks, powers) == pytest.approx(exact, rel=1e-12)


def test_a_box_may_stick_out_of_the_mesh_where_the_field_is_zero() -> None:
    blocks = Blocks.uniform(mesh(2), 3)
    field = blob((40, 100), (60, 40))
    wide = np.pad(field, ((70, 0), (0, 0)))
    near = added(np.zeros(blocks.shape), blocks, field, (40, 100))
    far = added(np.zeros(blocks.shape), blocks, wide, (-30, 100))
    np.testing.assert_allclose(far, near, atol=1e-14)


def test_no_moment_is_lost_where_a_field_reaches_past_the_finest_blocks() -> None:
    one = mesh(2)
    blocks = Blocks.uniform(one).joined(3, np.array([[7, 8]]))
    rough = blob((100, 110), (40, 44)) * np.random.default_rng(0).normal(size=(40, 44))
    found = added(np.zeros(blocks.shape), blocks, rough, (100, 110))
    again = adapt(found, blocks)
    axes = [H * (100 + np.arange(40)), H * (110 + np.arange(44))]
    x, y = np.meshgrid(*axes, indexing="ij")
    for powers in ((0, 0), (1, 0), (0, 1), (2, 1)):
        exact = float(np.sum(rough * x ** powers[0] * y ** powers[1])) * H**2
        assert moment(found, blocks, powers) == pytest.approx(exact, abs=1e-13)
        assert moment(again.fields, again.blocks, powers) == pytest.approx(exact, abs=1e-13)


def test_a_box_wraps_round_a_periodic_axis() -> None:
    one = AdaptiveMesh(grid=Grid((128, 128), H, None, "periodic"), levels=2)
    blocks = Blocks.uniform(one, 2)
    field = blob((0, 0), (40, 40))
    far = added(np.zeros(blocks.shape), blocks, field, (-20, 50))
    near = added(np.zeros(blocks.shape), blocks, field, (108, 50))
    np.testing.assert_array_equal(far, near)
    assert far[blocks.of(2)].sum() == pytest.approx(field.sum(), rel=1e-13)
    assert 16 * far[blocks.of(0)].sum() == pytest.approx(field.sum(), rel=1e-13)


@pytest.mark.parametrize("boundary", [("periodic", "unbounded"), ("periodic", "periodic")])
@pytest.mark.parametrize("length", [70, 120, 300])
def test_a_box_of_any_length_goes_round_a_periodic_axis(length: int, boundary: tuple) -> None:
    """On each level: the parts of the box, each shorter than half the coarse period, added up."""
    one = AdaptiveMesh(grid=Grid((128, 256), H, None, boundary), levels=3)
    blocks = Blocks.uniform(one, 1).joined(3, np.array([[2, 7], [3, 8]]))
    field = np.random.default_rng(1).normal(size=(length, 60)) + 0.3
    zeros = np.zeros(blocks.shape)
    found = added(zeros, blocks, field, (50, 100))
    dense = np.zeros((128, 256))
    np.add.at(dense, (50 + np.arange(length)) % 128, np.pad(field, ((0, 0), (100, 96))))
    pieces = sum(added(zeros, blocks, dense[k : k + 1], (k, 0)) for k in range(128))
    np.testing.assert_allclose(found, pieces, atol=1e-12)
    total = 64 * found[blocks.of(0)].sum()
    assert total == pytest.approx(field.sum(), rel=1e-12)
    y = H * np.arange(256)
    first = np.einsum("nij,nj->", found[blocks.of(0)], blocks.points()[1, blocks.of(0), 0])
    if boundary[1] == "unbounded":
        assert 64 * first == pytest.approx(float((dense * y).sum()), rel=1e-12)


def test_a_box_round_two_periodic_axes_keeps_its_sum_in_space() -> None:
    grid = Grid((32, 64, 32), H, None, ("periodic", "unbounded", "periodic"))
    blocks = Blocks.uniform(AdaptiveMesh(grid=grid, levels=2, block=8), 1)
    field = np.random.default_rng(2).normal(size=(24, 10, 40)) + 0.3
    found = added(np.zeros(blocks.shape), blocks, field, (20, 30, -5))
    assert 64 * found[blocks.of(0)].sum() == pytest.approx(field.sum(), rel=1e-12)


def test_float32_stays_float32() -> None:
    blocks = Blocks.uniform(mesh(2), 1)
    values = np.zeros(blocks.shape, np.float32)
    found = added(values, blocks, blob((5, 5), (64, 64)).astype(np.float32), (5, 5))
    assert found.dtype == np.float32


def test_fields_of_other_dimensions_are_refused() -> None:
    blocks = Blocks.uniform(mesh(2), 1)
    with pytest.raises(InputError, match="2 axes, got a field of shape"):
        added(np.zeros(blocks.shape), blocks, np.zeros((4, 4, 4)), (0, 0, 0))
