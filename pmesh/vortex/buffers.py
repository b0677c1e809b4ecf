"""Arrays of work that a step takes and gives back: fresh memory costs three times its use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

Array = NDArray[np.floating[Any]]


class Buffers:
    """Arrays to take and give back, of one mesh: those of another shape are let go."""

    def __init__(self) -> None:
        self._spare: list[Array] = []

    def take(self, shape: Sequence[int], dtype: DTypeLike) -> Array:
        """An array with any values in it."""
        wanted, kind = tuple(shape), np.dtype(dtype)
        self._spare = [one for one in self._spare if one.shape[-1:] == wanted[-1:]]
        for number, one in enumerate(self._spare):
            if one.shape == wanted and one.dtype == kind:
                return self._spare.pop(number)
        return np.empty(wanted, kind)

    def give(self, array: Array | None) -> None:
        """Give an array back that nobody else holds."""
        if array is not None and not any(array is one for one in self._spare):
            self._spare.append(array)
