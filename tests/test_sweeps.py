"""The compiled loops of the spectral solves against the same laws written in NumPy."""

import numpy as np
import pytest
from scipy import integrate

from pmesh.spectral.sweeps import crop, pad, scale, screened_integrals, to_modes, to_rows, transpose


def spread(table, rows, columns, odd_rows, odd_columns):
    """The full table from its non-negative wavenumbers."""
    full = np.zeros((rows, columns))
    for r in range(rows):
        for c in range(columns):
            near_r, near_c = r < table.shape[0], c < table.shape[1]
            sign = (1 if near_r else odd_rows) * (1 if near_c else odd_columns)
            full[r, c] = sign * table[r if near_r else rows - r, c if near_c else columns - c]
    return full


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-14), ("float32", 1e-6)])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("add", [False, True])
@pytest.mark.parametrize("shape", [(6, 10), (5, 7)])
def test_scale_multiplies_by_the_mirrored_table(dtype, tolerance, turned, add, shape):
    rng = np.random.default_rng(3)
    rows, columns = shape
    tables = rng.standard_normal((2, rows // 2 + 1, columns // 2 + 1)).astype(dtype)
    kind = np.result_type(dtype, np.complex64)
    spectrum = (rng.standard_normal((2, *shape)) + 1j).astype(kind)
    before = (rng.standard_normal((2, *shape)) - 2j).astype(kind)
    for signs in ([1, 1, 1], [-1, -1, 1], [1, 1, -1]):
        out = before.copy()
        scale(spectrum, tables, np.array(signs, dtype), turned, add, out)
        full = np.array([signs[0] * spread(t, rows, columns, *signs[1:]) for t in tables])
        exact = (1j if turned else 1) * full * spectrum + (before if add else 0)
        assert np.abs(out - exact).max() <= 10 * tolerance


def test_modes_and_rows_are_each_others_transposes():
    rng = np.random.default_rng(4)
    rows = rng.standard_normal((3, 4, 5)) + 1j
    modes = np.zeros((5, 4, 3), complex)
    to_modes(rows, modes)
    assert np.array_equal(modes, rows.transpose(2, 1, 0))
    back = np.zeros_like(rows)
    to_rows(modes, back)
    assert np.array_equal(back, rows)
    flat = rng.standard_normal((2, 37, 21))
    turned = np.ones((2, 21, 40))
    transpose(flat, turned)
    assert np.array_equal(turned[..., :37], flat.swapaxes(1, 2))
    assert not turned[..., 37:].any()


def test_padding_fills_with_zeros_and_cropping_scales_and_shifts():
    lines = np.random.default_rng(5).standard_normal((2, 3, 5))
    wide = np.ones((4, 3, 8))
    pad(lines, wide)
    assert np.array_equal(wide[:2, :, :5], lines)
    assert not wide[:2, :, 5:].any()
    assert np.all(wide[2:] == 1)
    back = np.empty_like(lines)
    crop(wide, 2.0, 0.5, back)
    assert np.allclose(back, 2 * lines + 0.5)


@pytest.mark.parametrize("a", [1e-6, 1e-2, 1.0, 20.0])
@pytest.mark.parametrize("x", [0.0, 0.3, 8.0])
def test_screened_integrals_agree_with_adaptive_quadrature(a, x):
    nodes, weights = np.polynomial.legendre.leggauss(12)
    first, second = screened_integrals(np.array([x]), a, (nodes + 1) / 2, weights / 2)

    def kernel(s, power):
        return np.exp(-a * np.exp(s) - x * np.exp(-s) - power * s)

    end = np.log(60 / a) if a < 60 else 1.0
    for power, value in ((0, first[0]), (1, second[0])):
        exact = integrate.quad(kernel, 0, end, (power,), epsabs=1e-16, epsrel=1e-12, limit=200)[0]
        assert abs(value - exact) <= 1e-11 * max(exact, 1e-3)
