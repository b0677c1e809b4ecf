"""Arrays of work that a step takes and gives back: fresh memory costs three times its use."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

Array = NDArray[np.floating[Any]]


class Buffers:
    """Arrays to take and give back, of one mesh: those of another shape are let go."""

    def __init__(self) -> None:
        self._spare: list[Array] = []
        self._lock = threading.Lock()

    def take(self, shape: Sequence[int], dtype: DTypeLike) -> Array:
        """An array with any values in it."""
        wanted, kind = tuple(shape), np.dtype(dtype)
        with self._lock:
            self._spare = [one for one in self._spare if _mesh(one.shape) == _mesh(wanted)]
            for number, one in enumerate(self._spare):
                if one.shape == wanted and one.dtype == kind:
                    return self._spare.pop(number)
        return np.empty(wanted, kind)

    def give(self, array: Array | None) -> None:
        """Give an array back that nobody else holds."""
        with self._lock:
            if array is not None and not any(array is one for one in self._spare):
                self._spare.append(array)


def _mesh(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The mesh of a plane scalar, or of any vector."""
    return shape if len(shape) == 2 else shape[1:]
