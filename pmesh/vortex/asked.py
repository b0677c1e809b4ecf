"""Fields by name that are computed when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


class AskedFields(Mapping[str, Array]):
    """A mapping of laws without arguments: each is called once, the first time it is asked for.

    To tell the names, their number, and whether one is there computes nothing; values computed are
    kept as long as the mapping.
    """

    def __init__(self, laws: Mapping[str, Callable[[], Array]]) -> None:
        self._laws = dict(laws)
        self._found: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        """The field; computed if this is the first time."""
        if name not in self._found:
            self._found[name] = self._laws[name]()
        return self._found[name]

    def __contains__(self, name: object) -> bool:
        """Whether there is such a field."""
        return name in self._laws

    def __iter__(self) -> Iterator[str]:
        """The names."""
        return iter(self._laws)

    def __len__(self) -> int:
        """How many fields there are."""
        return len(self._laws)
