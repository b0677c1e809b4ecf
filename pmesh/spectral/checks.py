"""What a spectral solve refuses: wrong shapes, values not finite, a mean where none can be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from remesh.errors import InputError

Field = NDArray[Any]


def check_field(field: Any, shape: tuple[int, ...], dtype: DTypeLike, name: str) -> Field:
    """The field as an array of ``dtype``; refuses another shape, complex numbers and no numbers."""
    array = np.asarray(field)
    if array.dtype.kind not in "fiub":
        raise InputError(f"{name} must hold real numbers, got {array.dtype}", hint="a float array")
    if array.shape != shape:
        raise InputError(
            f"{name} must have shape {shape}, got {array.shape}", hint="a field on this very grid"
        )
    return np.asarray(array, dtype=dtype)


def output(out: Field | None, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Field:
    """``out`` if it fits, or a new array."""
    if out is None:
        return np.empty(shape, dtype=dtype)
    if out.shape != shape or out.dtype != dtype or not out.flags.c_contiguous:
        raise InputError(
            f"out must be a contiguous {dtype} array of shape {shape}, got {out.dtype} {out.shape}",
            hint=f"np.empty({shape}, np.{dtype})",
        )
    return out


def check_freestream(freestream: Sequence[float] | None, ndim: int) -> list[float]:
    """The free stream as numbers, zero if none is given."""
    if freestream is None:
        return [0.0] * ndim
    values = [float(value) for value in freestream]
    if len(values) != ndim or not all(math.isfinite(value) for value in values):
        raise InputError(
            f"freestream must hold {ndim} finite numbers, got {freestream!r}",
            hint=f"freestream={(1.0,) + (0.0,) * (ndim - 1)}",
        )
    return values


def check_mean(means: list[float], sources: list[Field], *, periodic: bool) -> None:
    """Refuse sources that are not finite and, in a fully periodic box, means beyond round-off."""
    if not all(math.isfinite(mean) for mean in means):
        raise InputError(
            "the field holds values that are not finite", hint="np.isfinite(field).all()"
        )
    mean = max(means, key=abs)
    if not periodic or mean == 0.0:
        return
    largest = max(float(max(source.max(), -source.min())) for source in sources)
    if abs(mean) > (1e-3 if sources[0].dtype == np.float32 else 1e-6) * largest:
        raise InputError(
            f"in a fully periodic box the field must have zero mean, got {mean:.3e} "
            f"where the largest value is {largest:.3e}",
            hint="field - field.mean(), or an unbounded axis",
        )
