"""The uniform mesh: where its nodes are and which of its axes are periodic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Boundary = Literal["periodic", "unbounded"]
BOUNDARIES: tuple[Boundary, ...] = ("periodic", "unbounded")


@dataclass(frozen=True, init=False)
class Grid:
    """Nodes at ``origin + i * spacing`` in 2-D or 3-D, one spacing [L] for all axes.

    ``boundary`` is ``"periodic"`` or ``"unbounded"``, one word for all axes or one per axis.
    A periodic axis is ``shape * spacing`` long (its last node is not a copy of its first);
    an unbounded axis spans ``(shape - 1) * spacing`` and the fields go on, as zero, beyond it.
    Refuses fewer than 4 nodes on an axis, a spacing that is not positive, and any other dimension.
    """

    shape: tuple[int, ...]
    spacing: float
    origin: tuple[float, ...]
    boundary: tuple[Boundary, ...]

    def __init__(
        self,
        shape: Sequence[int],
        spacing: float,
        origin: Sequence[float] | None = None,
        boundary: Boundary | Sequence[Boundary] = "unbounded",
    ) -> None:
        nodes = tuple(int(n) for n in shape)
        if len(nodes) not in (2, 3):
            raise InputError(
                f"a Grid has 2 or 3 axes, got shape {tuple(shape)}", hint="shape=(256, 128)"
            )
        if any(n != m for n, m in zip(nodes, shape, strict=True)) or min(nodes) < 4:
            raise InputError(
                f"shape must hold whole numbers of at least 4 nodes, got {tuple(shape)}",
                hint="a finer spacing, or a longer domain",
            )
        if not (math.isfinite(spacing) and spacing > 0):
            raise InputError(
                f"spacing must be a positive length, got {spacing}", hint="spacing=1/64"
            )
        start = (0.0,) * len(nodes) if origin is None else tuple(float(x) for x in origin)
        if len(start) != len(nodes) or not all(math.isfinite(x) for x in start):
            raise InputError(
                f"origin must hold {len(nodes)} finite numbers, got {origin}",
                hint=f"origin={(0.0,) * len(nodes)}",
            )
        sides = (boundary,) * len(nodes) if isinstance(boundary, str) else tuple(boundary)
        if len(sides) != len(nodes) or any(side not in BOUNDARIES for side in sides):
            raise InputError(
                f"boundary must be 'periodic' or 'unbounded', one or {len(nodes)}, "
                f"got {boundary!r}",
                hint="boundary='unbounded', or one word per axis",
            )
        object.__setattr__(self, "shape", nodes)
        object.__setattr__(self, "spacing", float(spacing))
        object.__setattr__(self, "origin", start)
        object.__setattr__(self, "boundary", sides)

    @property
    def ndim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of nodes."""
        return math.prod(self.shape)

    @property
    def periodic(self) -> tuple[bool, ...]:
        """For each axis, whether it wraps around."""
        return tuple(side == "periodic" for side in self.boundary)

    @property
    def length(self) -> tuple[float, ...]:
        """Extent of each axis [L]: ``shape * spacing`` if periodic, else first to last node."""
        return tuple(
            (n if wraps else n - 1) * self.spacing
            for n, wraps in zip(self.shape, self.periodic, strict=True)
        )

    @property
    def cell_volume(self) -> float:
        """Area or volume that one node stands for [L^ndim]."""
        return self.spacing**self.ndim

    def axes(self) -> tuple[NDArray[np.float64], ...]:
        """Node coordinates along each axis [L]."""
        return tuple(
            start + self.spacing * np.arange(n, dtype=np.float64)
            for start, n in zip(self.origin, self.shape, strict=True)
        )

    def points(self) -> NDArray[np.float64]:
        """Node positions, shape ``(ndim, *shape)`` [L]."""
        return np.stack(np.meshgrid(*self.axes(), indexing="ij"))
