"""Smoothing multipliers: the heat semigroup exp(-a k^2) and its mean over a step, phi1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pmesh.spectral.convolve import Multiplier
from pmesh.spectral.symbols import Box
from remesh.errors import InputError

Smoothing = tuple[str, float]

SMOOTHINGS = ("heat", "phi1")
WRAPPED = 1e-6  # largest part of the peak that may come around the padding of an unbounded axis


class Heat:
    """exp(-amount k^2), the flow of d/dt = laplace for ``amount`` [L^2]; a product of axes.

    Exact on periodic axes, of order 8 in the spacing on unbounded ones (see ``Box.spread``).

    Factors far below the round-off are zero, so that no denormal numbers slow the loops.
    """

    def __init__(self, box: Box, amount: float, dtype: DTypeLike) -> None:
        decays = [np.exp(-amount * box.spread(axis)) for axis in range(len(box.shape))]
        for decay in decays:
            decay[decay < float(np.finfo(dtype).eps) ** 1.5] = 0.0
        first = decays[0] if len(decays) == 2 else np.outer(decays[1], decays[0])
        self.first = first.astype(dtype)
        self.last = decays[-1].astype(dtype)

    def block(self, low: int, high: int) -> NDArray[Any]:
        """Values for the wavenumbers ``low:high`` of the last axis."""
        product: NDArray[Any] = np.multiply.outer(self.last[low:high], self.first)
        return product


class Phi1:
    """(1 - exp(-z)) / z with z = amount k^2: the mean of the heat semigroup over the step."""

    def __init__(self, box: Box, amount: float, dtype: DTypeLike) -> None:
        z = sum(box.along(axis, amount * box.spread(axis)) for axis in range(len(box.shape)))
        z = np.asarray(z).T
        safe = np.where(z > 0, z, 1.0)
        values = np.where(z > 0, -np.expm1(-safe) / safe, 1.0)
        self.values = np.ascontiguousarray(values, dtype=dtype)

    def block(self, low: int, high: int) -> NDArray[Any]:
        """Values for the wavenumbers ``low:high`` of the last axis."""
        return self.values[low:high]


def make_smoothing(box: Box, smoothing: Smoothing, dtype: DTypeLike) -> Multiplier:
    """Multiplier of ``("heat", a)`` or ``("phi1", a)``, a = viscosity * time [L^2]."""
    kind, amount = smoothing
    if kind not in SMOOTHINGS:
        raise InputError(f"unknown smoothing {kind!r}", hint=f"one of {', '.join(SMOOTHINGS)}")
    if not (math.isfinite(amount) and amount >= 0):
        raise InputError(
            f"the amount of smoothing must be finite and not negative [L^2], got {amount!r}",
            hint="viscosity * dt, both not negative",
        )
    return Heat(box, amount, dtype) if kind == "heat" else Phi1(box, amount, dtype)


def widest(box: Box) -> float:
    """Largest amount [L^2] whose tail the padding holds: sqrt(2 a) is the axis' length / 5.26.

    A source at one edge then reaches the other through the padding with exp(-d^2 / 4a) = 1e-6 of
    its peak, d the padding's length. Infinite where all axes are periodic: there the tail belongs.
    """
    gaps = [box.padded[axis] - box.shape[axis] + 1 for axis in box.axes(periodic=False)]
    if not gaps:
        return math.inf
    return (min(gaps) * box.spacing) ** 2 / (4.0 * math.log(1.0 / WRAPPED))


def refuse_too_wide(box: Box, amount: float, sources: Sequence[NDArray[Any]]) -> None:
    """Refuse an amount whose tail would come around the padding, unless there is nothing at all."""
    if amount > widest(box) and any(source.any() for source in sources):
        raise InputError(
            f"smoothing by {amount:.3g} spreads {math.sqrt(2.0 * amount):.3g} far, more than a "
            "fifth of the shortest unbounded axis: what leaves would come back on the other side",
            hint=f"at most {widest(box):.3g}: a shorter step, or a larger mesh",
        )
