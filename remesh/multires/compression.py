"""Compression of fields: the wavelet coefficients that matter, and the error without the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.layout import check_field, precision
from remesh.multires.transform import check_levels, forward, inverse, node_levels
from remesh.multires.wavelets import Wavelet, get_wavelet

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Compressed:
    """A field on a mesh as its coarsest values and its details beyond a threshold.

    ``indices`` (flat, in C order, into ``(*components, *grid.shape)``), ``levels`` (0 for coarsest
    values, l + 1 for details d^l) and ``values`` are one entry per kept coefficient. ``depth`` is
    the number of levels below the finest. ``scale`` holds what the tolerance is relative to
    [unit of the field], one per component.
    ``error_bound`` is the largest difference between the field and `expand`, as measured.
    """

    grid: Grid
    wavelet: Wavelet
    depth: int
    tolerance: float
    components: tuple[int, ...]
    scale: NDArray[np.float64]
    indices: NDArray[np.int64]
    levels: NDArray[np.int8]
    values: Array
    error_bound: float

    @property
    def size(self) -> int:
        """Number of coefficients kept."""
        return self.indices.size

    @property
    def ratio(self) -> float:
        """Node values of the field per coefficient kept."""
        return int(np.prod(self.components)) * self.grid.size / self.size

    def counts(self) -> tuple[int, ...]:
        """Coefficients kept on each level, coarsest values first."""
        return tuple(np.bincount(self.levels, minlength=self.depth + 1).tolist())

    def expand(self, *, threads: int | None = None) -> Array:
        """The field on all nodes, ``(*components, *grid.shape)``; same bits every time."""
        field = np.zeros((*self.components, *self.grid.shape), self.values.dtype)
        field.reshape(-1)[self.indices] = self.values
        return inverse(field, self.grid, self.wavelet, self.depth, out=field, threads=threads)


def compress(
    field: Array,
    grid: Grid,
    *,
    tolerance: float,
    wavelet: str | Wavelet = "4.4",
    levels: int | None = None,
    scale: float | Sequence[float] | None = None,
    threads: int | None = None,
) -> Compressed:
    """The field's wavelet coefficients that are larger than ``tolerance * scale``.

    ``field`` has ``grid.shape`` or ``(c, *grid.shape)``; ``scale`` [unit of the field] is one for
    all or one per component, the largest absolute value of the field by default. All coarsest
    values are kept. The error is proportional to the tolerance and below 10 times tolerance *
    scale (measured on smooth and kinked fields; `Compressed.error_bound` is that of this one).
    Keeps the sums of f x^a y^b z^c over the nodes for a, b, c < N~ (on periodic axes for exponent
    0; for higher ones as far as no dropped wavelet reaches across the seam), whatever the
    tolerance. O(nodes). Refuses fields that are not finite, tolerances that are not in (0, 1),
    meshes that cannot be halved.
    Source: Gillis & van Rees, SIAM J. Sci. Comput. 44 (2022) C367.
    """
    values = check_field(field, grid)
    values = values.astype(precision(values), copy=False)
    found = get_wavelet(wavelet)
    if not 0 < tolerance < 1:
        raise InputError(f"tolerance must lie in (0, 1), got {tolerance}", hint="tolerance=1e-3")
    depth = check_levels(grid, found, levels)
    if levels is None and depth == 0:
        raise InputError(
            f"a mesh of {grid.shape} nodes ({', '.join(grid.boundary)}) cannot be halved for "
            f"wavelet {found.name!r}",
            hint="an even number of nodes on periodic axes, or more nodes",
        )
    components = values.shape[: -grid.ndim]
    scales = _scales(values, grid, scale)
    coefficients = forward(values, grid, found, depth, threads=threads)
    flat = coefficients.reshape(-1, grid.size)
    level = node_levels(grid, depth).reshape(-1)
    threshold = (tolerance * scales[:, None]).astype(flat.dtype)
    kept = flat > threshold
    kept |= flat < -threshold
    kept |= level == 0
    indices = np.flatnonzero(kept)
    result = flat.reshape(-1)[indices]
    np.copyto(flat, 0, where=~kept)
    inverse(coefficients, grid, found, depth, out=coefficients, threads=threads)
    coefficients -= values
    return Compressed(
        grid=grid, wavelet=found, depth=depth, tolerance=float(tolerance), components=components,
        scale=scales, indices=indices, levels=level[indices % grid.size], values=result,
        error_bound=_largest(coefficients),
    )  # fmt: skip


def _largest(values: Array) -> float:
    """Largest absolute value; not a number if one of them is not."""
    return float(np.maximum(values.max(), -values.min()))


def _scales(
    values: Array, grid: Grid, scale: float | Sequence[float] | None
) -> NDArray[np.float64]:
    """What the tolerance is relative to, one per component."""
    count = int(np.prod(values.shape[: -grid.ndim]))
    largest = _largest(values)
    if not np.isfinite(largest):
        raise InputError(
            "field must be finite, it is not at some nodes", hint="np.isfinite(field).all()"
        )
    given = np.atleast_1d(np.asarray(largest if scale is None else scale, np.float64))
    if given.ndim != 1 or given.size not in (1, count) or not np.isfinite(given).all():
        raise InputError(
            f"scale must be one finite number or {count}, one per component, got {scale}",
            hint="scale=None takes the largest absolute value of the field",
        )
    if scale is not None and not (given > 0).all():
        raise InputError(f"scale must be positive, got {scale}", hint="scale=1.0")
    return np.broadcast_to(given, (count,)).copy()
