"""Multipliers: Fourier tables of the Green's functions and their derivatives on a padded box."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from pmesh.spectral.fft import fast_length
from pmesh.spectral.greens import HEJ_ORDERS, Profiles, hej, hockney_eastwood
from pmesh.spectral.lattice import lattice_greens, lattice_line
from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[Any]
Derivative = tuple[int, ...]

KERNELS = ("HEJ", "LGF", "HE")
_EIGHTH = (8 / 5, -1 / 5, 8 / 315, -1 / 560)  # second difference of order 8, right half


@dataclass(frozen=True, kw_only=True)
class Greens:
    """Which Green's function: its name, its order, and for HEJ its smoothing radius in spacings.

    Order: HEJ 2, 4, 6, 8 or 10; LGF (lattice) and HE (Hockney-Eastwood) 2. Refuses all others.
    """

    kernel: str = "HEJ"
    order: int | None = None
    radius: float = 2.0

    def __post_init__(self) -> None:
        """Check the name, the order and the radius."""
        if self.kernel not in KERNELS:
            raise InputError(
                f"unknown Green's function {self.kernel!r}", hint=f"one of {', '.join(KERNELS)}"
            )
        orders = HEJ_ORDERS if self.kernel == "HEJ" else (2,)
        if self.order is None:
            object.__setattr__(self, "order", 8 if self.kernel == "HEJ" else 2)
        elif self.order not in orders:
            raise InputError(
                f"Green's function {self.kernel} has order {', '.join(map(str, orders))}, "
                f"asked {self.order!r}",
                hint=f"order={orders[-1]}",
            )
        if not (math.isfinite(self.radius) and self.radius > 0):
            raise InputError(
                f"the smoothing radius must be a positive number of spacings, got {self.radius!r}",
                hint="radius=2.0",
            )


@dataclass(frozen=True)
class Box:
    """The mesh as the transforms see it: unbounded axes are doubled, periodic ones are kept."""

    shape: tuple[int, ...]
    spacing: float
    periodic: tuple[bool, ...]

    @classmethod
    def around(cls, grid: Grid) -> Box:
        """Box of a grid; where its origin lies does not matter."""
        return cls(grid.shape, grid.spacing, grid.periodic)

    @property
    def padded(self) -> tuple[int, ...]:
        """Length of the transform along each axis."""
        return tuple(
            n if wraps else fast_length(2 * n - 1)
            for n, wraps in zip(self.shape, self.periodic, strict=True)
        )

    @property
    def half(self) -> tuple[int, ...]:
        """Number of non-negative wavenumbers along each axis."""
        return tuple(p // 2 + 1 for p in self.padded)

    def wavenumbers(self, axis: int) -> Array:
        """Non-negative wavenumbers of the transform along ``axis`` [1/L]."""
        step = 2 * math.pi / (self.padded[axis] * self.spacing)
        return step * np.arange(self.half[axis])

    def spread(self, axis: int) -> Array:
        """Symbol of -d^2/dx^2 for diffusion [1/L^2].

        The square of the wavenumber on a periodic axis. On an unbounded one the eighth-order
        central difference: its symbol is smooth across the shortest wave, so what is diffused
        keeps to its place, where the square would ring over the whole mesh.
        """
        k = self.wavenumbers(axis)
        if self.periodic[axis]:
            return np.asarray(k**2)
        angle = k * self.spacing
        waves = sum(2 * w * (1 - np.cos(j * angle)) for j, w in enumerate(_EIGHTH, start=1))
        return np.asarray(waves) / self.spacing**2

    def along(self, axis: int, values: Array) -> Array:
        """Values of one axis, shaped to broadcast against the whole table."""
        return values.reshape([-1 if other == axis else 1 for other in range(len(self.shape))])

    def axes(self, *, periodic: bool) -> list[int]:
        """Axes that are periodic, or those that are not."""
        return [axis for axis, wraps in enumerate(self.periodic) if wraps == periodic]


def multipliers(
    box: Box, greens: Greens, derivatives: list[Derivative], dtype: DTypeLike
) -> list[NDArray[Any]]:
    """Real tables T, axes reversed: i^(odd axes) T is the transform of the derivative of G.

    G solves -laplace G = delta. A derivative counts how often each axis is differentiated. Only
    wavenumbers >= 0 are kept: a table is odd along an axis with one derivative, else even. Tables
    are kept for the next call: those of the box and kernel just asked for, others up to 1 GB.
    """
    keys = [(box, greens, derivative, np.dtype(dtype).char) for derivative in derivatives]
    missing = [d for d, key in zip(derivatives, keys, strict=True) if key not in _KEPT]
    fresh = _tables(box, greens, missing, dtype) if missing else {}
    tables = []
    with _LOCK:
        for derivative, key in zip(derivatives, keys, strict=True):
            table = _KEPT.pop(key, None)
            if table is None:
                table = fresh.get(derivative)
            if table is None:  # dropped by another thread in the meantime
                table = _tables(box, greens, [derivative], dtype)[derivative]
            _KEPT[key] = table
            tables.append(table)
        others = [key for key in _KEPT if key[:2] != (box, greens)]
        while others and sum(table.nbytes for table in _KEPT.values()) > _KEPT_BYTES:
            del _KEPT[others.pop(0)]
    return tables


_KEPT: OrderedDict[Any, NDArray[Any]] = OrderedDict()
_KEPT_BYTES = 1 << 30
_LOCK = threading.Lock()


def _tables(
    box: Box, greens: Greens, derivatives: list[Derivative], dtype: DTypeLike
) -> dict[Derivative, NDArray[Any]]:
    lattice = greens.kernel == "LGF"

    def kept(table: Array) -> NDArray[Any]:
        return np.ascontiguousarray(np.broadcast_to(table, box.half).T, dtype=dtype)

    solved = {}
    if all(box.periodic):
        inverse = _inverse_laplacian(box, lattice)
        for d in derivatives:
            solved[d] = kept(inverse * _waves(box, d, range(len(box.shape)), lattice))
        return solved
    sample = _sample_lattice(box) if lattice else _sample_profiles(box, greens)
    for d in derivatives:
        table = sample(d) * _waves(box, d, box.axes(periodic=True), lattice)
        for axis in box.axes(periodic=False):
            table = _transform(table, axis, odd=d[axis] == 1)
            table *= box.spacing
        solved[d] = kept(table)
    return solved


def _inverse_laplacian(box: Box, lattice: bool) -> Array:
    total = sum(-_waves(box, d, [axis], lattice) for axis, d in enumerate(_twice(len(box.shape))))
    total = np.asarray(total)
    total.flat[0] = 1.0
    inverse: Array = 1.0 / total
    inverse.flat[0] = 0.0
    return inverse


def _twice(ndim: int) -> list[Derivative]:
    return [tuple(2 * (axis == other) for other in range(ndim)) for axis in range(ndim)]


def _waves(box: Box, derivative: Derivative, axes: Any, lattice: bool) -> Array:
    """Product of k (first derivative, zero at Nyquist) and -k^2 (second) over the axes."""
    product: Array = np.ones([1] * len(box.shape))
    h = box.spacing
    for axis in axes:
        k = box.wavenumbers(axis)
        if derivative[axis] == 1:
            wave = np.sin(k * h) / h if lattice else k
            if box.padded[axis] % 2 == 0:
                wave[-1] = 0.0
        elif derivative[axis] == 2:
            wave = -((2 * np.sin(k * h / 2) / h) ** 2) if lattice else -(k**2)
        else:
            continue
        product = product * box.along(axis, wave)
    return product


def _transform(values: Array, axis: int, *, odd: bool) -> Array:
    """Transform of the even or odd extension; the imaginary part for the odd one."""
    if not odd:
        even: Array = fft.dct(values, type=1, axis=axis)
        return even
    inner = [slice(None)] * values.ndim
    inner[axis] = slice(1, -1)
    table = np.zeros_like(values)
    table[tuple(inner)] = -fft.dst(values[tuple(inner)], type=1, axis=axis)
    return table


def _sample_profiles(box: Box, greens: Greens) -> Any:
    """Sampler of the derivatives of a radial Green's function at the node offsets."""
    free = box.axes(periodic=False)
    offsets = {axis: box.along(axis, box.spacing * np.arange(box.half[axis])) for axis in free}
    r2 = np.asarray(sum(x**2 for x in offsets.values()))
    waves = [box.along(axis, box.wavenumbers(axis) ** 2) for axis in box.axes(periodic=True)]
    kappa2 = np.asarray(sum(waves, start=np.zeros([1] * len(box.shape))))

    def profiles(screening: Array) -> Profiles:
        if greens.kernel == "HE":
            return hockney_eastwood(r2, screening, len(free), spacing=box.spacing)
        sigma = greens.radius * box.spacing
        return hej(r2, screening, len(free), sigma=sigma, order=int(greens.order or 8))

    if len(free) == 2 and len(box.shape) == 3:
        axis = box.axes(periodic=True)[0]
        each = [profiles(np.asarray(value)) for value in kappa2.ravel()]
        G, A, B = (np.concatenate([one[part] for one in each], axis=axis) for part in range(3))
    else:
        G, A, B = profiles(kappa2 if kappa2.size > 1 else np.zeros([1] * len(box.shape)))

    def sample(derivative: Derivative) -> Array:
        taken = [axis for axis in free for _ in range(derivative[axis])]
        if not taken:
            return np.asarray(G)
        if len(taken) == 1:
            return np.asarray(offsets[taken[0]] * A)
        first, second = taken
        cross: Array = offsets[first] * offsets[second] * B
        return np.asarray(cross + A) if first == second else cross

    return sample


def _sample_lattice(box: Box) -> Any:
    """Sampler of the central differences of the lattice Green's function."""
    free = box.axes(periodic=False)
    h = box.spacing
    lattice = {d: _waves(box, d, [axis], True) for axis, d in enumerate(_twice(len(box.shape)))}
    waves = [-table * h**2 for d, table in lattice.items() if box.periodic[d.index(2)]]
    screening = np.asarray(sum(waves, start=np.zeros([1] * len(box.shape))))
    shape = tuple(box.half[axis] for axis in free)
    if len(free) == 1:
        n = box.along(free[0], np.arange(float(shape[0])))
        G = lattice_line(n, screening) * h
    elif len(box.shape) == 3 and len(free) == 2:
        each = [lattice_greens(shape, np.asarray(value)) for value in screening.ravel()]
        G = np.stack(each, axis=box.axes(periodic=True)[0])
        # the mean along the periodic axis is the plane's own G, which knows the spacing by ln h
        _shift_plane(G, box, h)
    else:
        G = lattice_greens(shape, np.zeros(())) * h ** (2 - len(free))
        if len(free) == 2:
            G = G - math.log(h) / (2 * math.pi)

    def sample(derivative: Derivative) -> Array:
        values = G
        for axis in free:
            for _ in range(1 if derivative[axis] else 0):
                values = _difference(values, axis, derivative[axis], h)
        return values

    return sample


def _shift_plane(G: Array, box: Box, h: float) -> None:
    mean = [slice(None)] * 3
    mean[box.axes(periodic=True)[0]] = slice(0, 1)
    G[tuple(mean)] -= math.log(h) / (2 * math.pi)


def _difference(values: Array, axis: int, count: int, h: float) -> Array:
    """Central first or compact second difference of the even extension; last offset not used."""
    moved = np.moveaxis(values, axis, 0)
    result = np.zeros_like(moved)
    if count == 1:
        result[1:-1] = (moved[2:] - moved[:-2]) / (2 * h)
    else:
        result[1:-1] = (moved[2:] - 2 * moved[1:-1] + moved[:-2]) / h**2
        result[0] = 2 * (moved[1] - moved[0]) / h**2
        result[-1] = result[-2]
    return np.moveaxis(result, 0, axis)
