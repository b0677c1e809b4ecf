"""Taps of local corrections are short-ranged, symmetric, and tell what a coarser level cannot."""

from itertools import product

import numpy as np
import pytest

from pmesh.spectral.matched import kernel_values
from pmesh.spectral.taps import correction_taps, exact_taps
from remesh.multires.wavelets import WAVELETS


def radius(reach, ndim):
    span = np.arange(-reach, reach + 1)
    return np.sqrt(sum(n**2 for n in np.meshgrid(*(span,) * ndim, indexing="ij")))


@pytest.mark.parametrize(("name", "decay"), [("4.4", 5), ("4.2", 3), ("6.2", 3)])
def test_exact_taps_decay_by_one_power_more_than_the_wavelet_has_moments(name, decay):
    r = radius(46, 2)
    taps = exact_taps(WAVELETS[name], 4, 2, 46)
    rings = [
        max(np.abs(values[(r > low) & (r <= low + 3)]).max() for values in taps.values())
        for low in (20, 40)
    ]
    assert np.log2(rings[0] / rings[1]) == pytest.approx(decay, abs=0.5)


@pytest.mark.parametrize("ndim", [2, 3])
def test_on_even_targets_taps_are_the_kernel_less_that_of_the_restriction(ndim):
    wavelet = WAVELETS["4.0"]  # it restricts by taking every other value
    taps = exact_taps(wavelet, 4, ndim, 6)[(0,) * ndim]
    fine = kernel_values(4, ndim, 6)[(slice(None, None, -1),) * ndim]
    coarse = np.zeros_like(fine)
    even = (slice(0, None, 2),) * ndim
    coarse[even] = 2 * kernel_values(4, ndim, 3)[(slice(None, None, -1),) * ndim]
    assert np.allclose(taps, fine - coarse, atol=1e-15)


@pytest.mark.parametrize("ndim", [2, 3])
def test_taps_are_odd_along_their_axis_and_even_along_others(ndim):
    taps = correction_taps(WAVELETS["4.4"], 8, ndim, 6)
    exact = exact_taps(WAVELETS["4.4"], 8, ndim, 6)
    assert set(taps) == set(product((0, 1), repeat=ndim))
    for parity, values in taps.items():
        for some in (values, exact[parity]):
            assert np.allclose(some, -some[::-1], atol=1e-14)
            assert np.allclose(some, some[:, ::-1], atol=1e-14)
        assert np.all(values[radius(6, ndim) > 6.5] == 0)


@pytest.mark.parametrize(("reach", "allowed"), [(6, 5e-3), (8, 1e-3), (10, 1e-4), (12, 1e-5)])
@pytest.mark.parametrize("width", [1.0, 1.5, 3.0, 6.0])
def test_the_cut_costs_less_than_a_small_part_of_the_velocity(reach, allowed, width):
    wide, n = 28, np.arange(-40, 41)
    cut = correction_taps(WAVELETS["4.4"], 8, 2, reach)
    whole = exact_taps(WAVELETS["4.4"], 8, 2, wide)
    vortex = np.exp(-((n[:, None] - 0.3) ** 2 + (n + 0.2) ** 2) / (2 * width**2))
    largest = 0.4513 * width  # of the velocity: 0.6382 of circulation / (2 pi width sqrt(2))
    kernel = np.fft.rfft2(vortex, (160, 160))
    for parity, values in whole.items():
        lost = values.copy()
        near = slice(wide - reach, wide + reach + 1)
        lost[near, near] -= cut[parity]
        found = np.fft.irfft2(kernel * np.conj(np.fft.rfft2(lost, (160, 160))), (160, 160))
        own = found[parity[0] :: 2, parity[1] :: 2]
        assert np.abs(own).max() < allowed * largest


def test_folding_what_lies_beyond_is_better_than_dropping_it():
    r = radius(24, 2)
    n = np.arange(-60, 61)
    vortex = np.exp(-(n[:, None] ** 2 + n**2) / (2 * 3.0**2))
    transform = np.fft.rfft2(vortex, (192, 192))
    whole = exact_taps(WAVELETS["4.4"], 4, 2, 24)[(1, 0)]
    dropped = np.where(r > 8.5, whole, 0)
    folded = whole.copy()
    folded[16:33, 16:33] -= correction_taps(WAVELETS["4.4"], 4, 2, 8)[(1, 0)]
    errors = [
        np.abs(np.fft.irfft2(transform * np.conj(np.fft.rfft2(lost, (192, 192))))).max()
        for lost in (dropped, folded)
    ]
    assert errors[1] < errors[0] / 5
