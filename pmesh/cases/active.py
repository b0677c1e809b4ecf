"""Active nodes of several levels, in snapshots that tell at every node which level is in use."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]


def active_nodes(known: NDArray[Any], finest: int) -> tuple[Numbers, Numbers]:
    """Indices of the active nodes (n, ndim) of levels 0 to ``finest``, and their levels (n,).

    ``known``: the finest level that has a node there, on all nodes of level ``finest``; other
    numbers where there is none, or one of a finer level.
    """
    found = []
    for level in range(finest + 1):
        part = 2 ** (finest - level)
        own = known[(slice(None, None, part),) * known.ndim] == level
        found.append(part * np.argwhere(own))
    levels = np.repeat(np.arange(finest + 1), [len(part) for part in found])
    return np.concatenate(found), levels
