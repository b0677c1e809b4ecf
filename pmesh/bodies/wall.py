"""The penalised wall: a smooth indicator of the body, and where such a wall really acts.

A Brinkman layer ``laplace(u) = strength * chi * u / h^2`` on a mesh does not stop the flow where
``chi`` is one half, but a known fraction of a spacing further out. One dimension tells: the flow
between two penalised walls is a parabola whose roots are where the walls act. The indicator is
drawn in by that offset, so that the flow sees the wall at distance zero.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


def indicator(distance: Array, width: float) -> Array:
    """Smooth indicator of ``distance < 0``: 1 inside, 0 outside, sine ramp over +-``width`` [L]."""
    scaled = np.clip(distance / width, -1.0, 1.0)
    ramp = 0.5 * (1.0 - scaled - np.sin(np.pi * scaled) / np.pi)
    return np.asarray(np.where(scaled < 1.0, np.maximum(ramp, 0.0), 0.0), distance.dtype)


@lru_cache(maxsize=32)
def wall_offset(width: float, strength: float, order: int, radius: float) -> float:
    """How far outside ``chi = 1/2`` a penalised wall acts, in spacings.

    ``width``: half width of the indicator in spacings; ``strength`` = lambda h^2 / nu; ``order``
    and ``radius``: of the Gaussian-regularised velocity (HEJ), which the wall feels. Solves
    ``k^2 v + (D/k) strength chi (zeta v) = const`` for a channel on a periodic line, the steady
    state of the time step for any dt, and averages over the place of the wall between nodes.
    """
    return float(
        np.mean([_channel(float(shift), width, strength, order, radius) for shift in _SHIFTS])
    )


@lru_cache(maxsize=32)
def start_offset(width: float, rate: float, order: int, radius: float) -> float:
    """How far outside ``chi = 1/2`` an impulsive start puts its vortex sheet, in spacings.

    ``rate`` = lambda tau of the start. The momentum taken from a uniform stream along a wall, less
    what stays inside as slip, says where the sheet is.
    """
    places = [_sheet(float(shift), width, rate, order, radius) for shift in _SHIFTS]
    return float(np.mean(places))


_SHIFTS = tuple(np.arange(4) / 4)
_NODES, _SOLID = 96, 16  # nodes of the line, of which the walls take 2 * _SOLID


def _channel(shift: float, width: float, strength: float, order: int, radius: float) -> float:
    """Offset of one wall, from the root of the parabola between two."""
    k, zeta, chi, curled = _line(shift, width, order, radius)
    raw = np.linalg.solve(
        _matrix(k**2) + curled @ (strength * chi[:, None] * zeta), np.ones(_NODES)
    )
    middle = slice(_NODES // 2 - 12, _NODES // 2 + 12)
    parabola = np.polyfit(np.arange(_NODES)[middle] - _NODES / 2, (zeta @ raw)[middle], 2)
    return float(min(np.roots(parabola).real)) + _NODES / 2 - _SOLID - shift


def _sheet(shift: float, width: float, rate: float, order: int, radius: float) -> float:
    """Offset of the sheet on one wall, from the momentum that a uniform stream loses."""
    _, zeta, chi, curled = _line(shift, width, order, radius)
    raw = np.linalg.solve(np.eye(_NODES) + curled @ (rate * chi[:, None] * zeta), np.ones(_NODES))
    taken = float(np.sum(1.0 - raw)) * (1.0 + 1.0 / rate)
    return (taken - 2 * _SOLID) / 2


def _line(shift: float, width: float, order: int, radius: float) -> tuple[Values, ...]:
    """Wavenumbers, regularisation, indicator and curl ratio of a channel on a periodic line."""
    nodes = np.arange(_NODES, dtype=np.float64)
    k = np.asarray(2 * np.pi * np.fft.fftfreq(_NODES), np.float64)
    low, high = _SOLID + shift, _NODES - _SOLID + shift
    chi = np.asarray(indicator(np.minimum(nodes - low, high - nodes), width), np.float64)
    return k, _matrix(_regularisation(k, order, radius)), chi, _matrix(_curl_ratio(k))


def _matrix(symbol: Values) -> Values:
    """The matrix that multiplies each wavenumber of a periodic line by ``symbol``."""
    rows = np.fft.ifft(symbol[:, None] * np.fft.fft(np.eye(len(symbol)), axis=0), axis=0)
    return np.asarray(rows.real, np.float64)


def _regularisation(k: Values, order: int, radius: float) -> Values:
    """Fourier transform of the Gaussian regularisation of the velocity, k in units of 1/h."""
    half = 0.5 * (radius * k) ** 2
    term, total = np.exp(-half), np.zeros_like(k)
    for n in range(1, order // 2 + 1):
        total = total + term
        term = term * half / n
    return total


def _curl_ratio(k: Values) -> Values:
    """Fourth-order central difference over the exact derivative, per wavenumber."""
    safe = np.where(k == 0, 1.0, k)
    ratio = (4 / 3 * np.sin(k) - 1 / 6 * np.sin(2 * k)) / safe
    return np.where(k == 0, 1.0, ratio)
