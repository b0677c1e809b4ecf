"""Arrays of a mesh's size that are used again: to get their pages costs more than to use them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

_KEPT: dict[str, NDArray[Any]] = {}  # one of each name; who takes it has it alone


def borrow(name: str, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of that shape: the kept one as it was given back, or a new one of zeros."""
    kept = _KEPT.pop(name, None)
    if kept is not None and kept.shape == shape and kept.dtype == dtype:
        return kept
    return np.zeros(shape, dtype)


def give_back(name: str, array: NDArray[Any]) -> None:
    """Keep an array for the next who asks, who expects the same where it counts: say, zeros."""
    _KEPT[name] = array
