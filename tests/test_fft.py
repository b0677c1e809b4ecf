"""The FFT wrapper: every backend gives NumPy's transform, in the buffers it was handed."""

import numpy as np
import pytest

from pmesh.spectral.fft import aligned, check_backend, default_backend, fast_length, plan
from remesh.errors import InputError

BACKENDS = ["scipy", *{default_backend()} - {"scipy"}]
try:
    import ducc0  # noqa: F401

    BACKENDS.append("ducc0")
except ImportError:
    pass


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("dtype", "tolerance"), [("complex128", 1e-13), ("complex64", 1e-5)])
@pytest.mark.parametrize("inverse", [False, True])
def test_complex_lines_are_transformed_in_place(backend, dtype, tolerance, inverse):
    buffer = aligned((5, 60), dtype)
    execute = plan(buffer, buffer, inverse=inverse, backend=backend)
    data = np.random.default_rng(1).standard_normal((2, 5, 60))
    buffer[...] = data[0] + 1j * data[1]
    exact = np.fft.fft(buffer.astype(complex), axis=-1)
    if inverse:
        exact = 60 * np.fft.ifft(buffer.astype(complex), axis=-1)
    execute()
    assert np.abs(buffer - exact).max() <= tolerance * np.abs(exact).max()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-13), ("float32", 1e-5)])
@pytest.mark.parametrize("length", [48, 45])
def test_real_lines_go_to_half_complex_and_back_times_the_length(backend, dtype, tolerance, length):
    real = aligned((4, 3, length), dtype)
    half = aligned((4, 3, length // 2 + 1), np.result_type(dtype, np.complex64))
    there = plan(real, half, backend=backend)
    back = plan(half, real, inverse=True, backend=backend)
    data = np.random.default_rng(2).standard_normal(real.shape).astype(dtype)
    real[...] = data
    there()
    exact = np.fft.rfft(data.astype(float))
    assert np.abs(half - exact).max() <= tolerance * np.abs(exact).max()
    back()
    assert np.abs(real - length * data).max() <= tolerance * length * np.abs(data).max()


def test_fast_lengths_are_even_smooth_and_the_smallest_such():
    smooth = sorted(
        2**a * 3**b * 5**c * 7**d
        for a in range(1, 13)
        for b in range(8)
        for c in range(6)
        for d in range(5)
    )
    for least in range(1, 3000, 7):
        assert fast_length(least) == next(n for n in smooth if n >= least)


def test_buffers_start_on_a_cache_line_and_hold_zeros():
    for shape in [(3, 7), (1, 5, 9)]:
        buffer = aligned(shape, "complex64")
        assert buffer.shape == shape
        assert buffer.ctypes.data % 64 == 0
        assert not buffer.any()


def test_an_unknown_backend_is_refused():
    with pytest.raises(InputError, match="mkl"):
        check_backend("mkl")
