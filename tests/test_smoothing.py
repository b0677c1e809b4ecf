"""Smoothing multipliers: the exact symbols of the heat flow and of its mean."""

import numpy as np
import pytest

from pmesh.spectral.smoothing import make_smoothing
from pmesh.spectral.symbols import Box
from remesh.errors import InputError


def squared(box):
    """|k|^2 on the non-negative wavenumbers, axes reversed."""
    return sum(box.along(i, box.spread(i)) for i in range(len(box.shape))).T


@pytest.mark.parametrize(("dtype", "tolerance"), [("f8", 1e-14), ("f4", 1e-6)])
@pytest.mark.parametrize("shape", [(6, 9), (6, 5, 8)])
def test_blocks_hold_the_exact_symbols(dtype, tolerance, shape):
    box = Box(shape, 0.2, (True, False, False)[: len(shape)])
    z = 0.03 * squared(box)
    symbols = {"heat": np.exp(-z), "phi1": -np.expm1(-z) / np.where(z > 0, z, 1)}
    symbols["phi1"].flat[0] = 1.0
    for kind, exact in symbols.items():
        smoothing = make_smoothing(box, (kind, 0.03), dtype)
        for low in range(box.half[-1]):
            block = smoothing.block(low, low + 1)
            assert block.dtype == np.dtype(dtype)
            assert np.abs(block - exact[low]).max() <= tolerance
        if len(shape) == 2:
            assert np.abs(smoothing.block(2, 5) - exact[2:5]).max() <= tolerance


def test_nothing_flows_in_no_time():
    box = Box((6, 9), 0.2, (True, False))
    for kind in ("heat", "phi1"):
        assert np.all(make_smoothing(box, (kind, 0.0), "f8").block(0, 9) == 1.0)


def test_no_factor_is_so_small_that_it_slows_the_loops():
    box = Box((64, 64), 0.01, (True, True))
    for dtype in ("f4", "f8"):
        block = make_smoothing(box, ("heat", 0.01), dtype).block(0, 33)
        assert not np.any((block > 0) & (block < np.finfo(dtype).tiny))


@pytest.mark.parametrize("smoothing", [("heat", -1.0), ("phi1", float("nan")), ("box", 1.0)])
def test_what_is_no_smoothing_is_refused(smoothing):
    with pytest.raises(InputError):
        make_smoothing(Box((6, 9), 0.2, (True, False)), smoothing, "f8")
