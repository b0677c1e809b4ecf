"""Multiplier tables: symmetric, cached, equal to the transform of the sampled kernel."""

import math
from collections import OrderedDict

import numpy as np
import pytest

from pmesh.spectral import symbols
from pmesh.spectral.greens import hej
from pmesh.spectral.symbols import Box, Greens, multipliers
from remesh.errors import InputError


def full_transform(box, sample):
    """Plain FFT of a kernel sampled at every wrapped node offset; half, axes reversed."""
    offsets = np.meshgrid(*(box.spacing * p * np.fft.fftfreq(p) for p in box.padded), indexing="ij")
    spectrum = np.fft.fftn(sample(*offsets)) * box.spacing ** len(box.shape)
    return spectrum[tuple(slice(0, half) for half in box.half)].T


@pytest.mark.parametrize(("dtype", "tolerance"), [("f8", 1e-14), ("f4", 1e-6)])
def test_tables_are_the_transform_of_the_sampled_green_function(dtype, tolerance):
    box = Box((10, 13), 0.3, (False, False))
    sigma = 0.6

    def green(x, y):
        return hej(x**2 + y**2, np.zeros(()), 2, sigma=sigma, order=4)

    def first(x, y):
        slope = x * green(x, y)[1]
        slope[box.padded[0] // 2] = 0.0  # the offset that is its own mirror image
        return slope

    value, slope = multipliers(box, Greens(order=4), [(0, 0), (1, 0)], dtype)
    exact = full_transform(box, lambda x, y: green(x, y)[0])
    assert value.dtype == np.dtype(dtype)
    assert np.abs(value - exact.real).max() <= tolerance * np.abs(exact).max()
    assert np.abs(exact.imag).max() <= 1e-12
    exact = full_transform(box, first)
    assert np.abs(slope - exact.imag).max() <= tolerance * np.abs(exact).max()


def test_periodic_axes_have_waves_and_no_derivative_at_nyquist():
    box = Box((8, 9, 10), 0.5, (True, True, True))
    tables = multipliers(box, Greens(), [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 1)], "f8")
    k = 2 * math.pi * np.arange(5) / 4.0
    assert tables[0][0, 0, 0] == 0.0
    assert tables[0][0, 0, 1:] == pytest.approx(1 / k[1:] ** 2)
    assert tables[1][0, 0] == pytest.approx([0.0, *(1 / k[1:4]), 0.0])
    assert tables[2][0, :, 0] == pytest.approx([0.0, -1.0, -1.0, -1.0, -1.0])
    assert not tables[3][-1].any()


def test_tables_are_computed_once():
    box = Box((8, 8), 0.1, (False, True))
    again = [multipliers(box, Greens(), [(1, 0)], "f8")[0] for _ in range(2)]
    assert again[0] is again[1]
    assert multipliers(box, Greens(order=4), [(1, 0)], "f8")[0] is not again[0]


def test_unbounded_axes_are_doubled_and_periodic_ones_kept():
    assert Box((10, 45, 17), 1.0, (False, True, False)).padded == (20, 45, 36)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"kernel": "hej"}, "unknown Green's function 'hej'"),
        ({"order": 12}, "2, 4, 6, 8, 10"),
        ({"kernel": "HE", "order": 8}, "order 2"),
        ({"radius": float("nan")}, "smoothing radius"),
    ],
)
def test_unknown_green_functions_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        Greens(**options)


def test_large_tables_of_one_box_are_made_once_and_go_when_another_box_comes(monkeypatch):
    monkeypatch.setattr(symbols, "_KEPT", OrderedDict())
    monkeypatch.setattr(symbols, "_KEPT_BYTES", 100)
    box, other = (Box((n, 6), 0.25, (False, True)) for n in (9, 11))
    slopes = multipliers(box, Greens(), [(1, 0), (0, 1)], "f8")
    (stream,) = multipliers(box, Greens(), [(0, 0)], "f8")
    again = multipliers(box, Greens(), [(1, 0), (0, 1), (0, 0)], "f8")
    assert all(one is two for one, two in zip(again, [*slopes, stream], strict=True))
    multipliers(other, Greens(), [(0, 0)], "f8")
    assert {key[0] for key in symbols._KEPT} == {other}
