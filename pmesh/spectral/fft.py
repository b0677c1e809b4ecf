"""Fourier transforms of many lines at once, in buffers of the caller, with plans that are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from remesh.errors import InputError

BACKENDS = ("pyfftw", "ducc0", "scipy")
_ALIGNMENT = 64

Transform = Callable[[], Any]


@lru_cache(maxsize=1)
def default_backend() -> str:
    """Fastest backend that can be imported: FFTW (GPL), ducc0 (GPL), else SciPy."""
    for name in BACKENDS[:2]:
        try:
            import_module(name)
        except ImportError:
            continue
        return name
    return "scipy"


def check_backend(name: str | None) -> str:
    """Name of the backend to use; refuses one that is unknown."""
    if name is None:
        return default_backend()
    if name not in BACKENDS:
        raise InputError(f"unknown FFT backend {name!r}", hint=f"one of {', '.join(BACKENDS)}")
    return name


@lru_cache(maxsize=1024)
def fast_length(least: int) -> int:
    """Smallest even number >= ``least`` whose prime factors are 2, 3, 5 and 7."""
    length = max(2, least + least % 2)
    while True:
        rest = length
        for prime in (2, 3, 5, 7):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return length
        length += 2


def aligned(shape: Sequence[int], dtype: DTypeLike) -> NDArray[Any]:
    """Zeroed buffer that starts on a cache line, as SIMD plans want it."""
    kind = np.dtype(dtype)
    raw = np.zeros(int(np.prod(shape)) * kind.itemsize + _ALIGNMENT, dtype=np.uint8)
    start = -raw.ctypes.data % _ALIGNMENT
    return raw[start : raw.size - _ALIGNMENT + start].view(kind).reshape(tuple(shape))


def plan(
    source: NDArray[Any], target: NDArray[Any], *, inverse: bool = False, backend: str = "pyfftw"
) -> Transform:
    """Transform of every line (last axis) of ``source`` into ``target``; call it to execute.

    Complex to complex (``source`` may be ``target``), real to half-complex, or back, told by the
    dtypes. Neither direction is scaled: a round trip multiplies by the length. One thread. Real
    output may overwrite ``source``. Plans are estimated, never timed, so that the same call gives
    the same bits in every process. Cost 5 n log2 n flops a line.
    """
    if backend == "pyfftw":
        return _plan_fftw(source, target, inverse)
    if backend == "ducc0":
        return _plan_ducc(source, target, inverse)
    return _plan_scipy(source, target, inverse)


def _plan_fftw(source: NDArray[Any], target: NDArray[Any], inverse: bool) -> Transform:
    import pyfftw

    made = pyfftw.FFTW(
        source,
        target,
        axes=(-1,),
        direction="FFTW_BACKWARD" if inverse else "FFTW_FORWARD",
        flags=("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"),
        threads=1,
    )
    execute: Transform = made.execute
    return execute


def _plan_ducc(source: NDArray[Any], target: NDArray[Any], inverse: bool) -> Transform:
    from ducc0 import fft

    axes = (source.ndim - 1,)
    if source.dtype.kind == "f":
        return lambda: fft.r2c(source, axes=axes, out=target, nthreads=1)
    if target.dtype.kind == "f":
        return lambda: fft.c2r(
            source, axes=axes, lastsize=target.shape[-1], forward=False, out=target, nthreads=1
        )
    return lambda: fft.c2c(source, axes=axes, forward=not inverse, out=target, nthreads=1)


def _plan_scipy(source: NDArray[Any], target: NDArray[Any], inverse: bool) -> Transform:
    from scipy import fft

    def execute() -> None:
        if source.dtype.kind == "f":
            target[...] = fft.rfft(source)
        elif target.dtype.kind == "f":
            target[...] = fft.irfft(source, n=target.shape[-1], norm="forward")
        elif inverse:
            target[...] = fft.ifft(source, norm="forward")
        else:
            target[...] = fft.fft(source)

    return execute
