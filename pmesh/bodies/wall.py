"""The penalised wall: a smooth indicator of the body, and where such a wall really acts.

A Brinkman layer ``laplace(u) = strength * chi * u / h^2`` on a mesh does not stop the flow where
the ramp of ``chi`` has its middle, but a known fraction of a spacing further out; and as the layer
is thick, a shear passes a little fluid beside the wall, which blows through it where the shear
changes. One dimension tells both, from the shear between two penalised walls. The indicator is
drawn in by the first, so that the flow sees the wall at distance zero. A sharp wall undoes the
second too, by the velocity that it feels, ``u + blur h^2 laplace(u)``; and its ``chi`` is the
square of the ramp, whose long foot makes the wall stand still when it moves between nodes: to
0.025 h at width 2.5, where a plain one of width 1.5 goes 0.16 h to and fro.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


def indicator(distance: Array, width: float) -> Array:
    """Smooth indicator of ``distance < 0``: 1 inside, 0 outside, sine ramp over +-``width`` [L]."""
    scaled = np.clip(distance / width, -1.0, 1.0)
    ramp = 0.5 * (1.0 - scaled - np.sin(np.pi * scaled) / np.pi)
    return np.asarray(np.where(scaled < 1.0, np.maximum(ramp, 0.0), 0.0), distance.dtype)


class Law(NamedTuple):
    """What puts a penalised wall at distance zero."""

    offset: float  # how far outside the middle of the ramp the wall acts, in spacings
    blur: float  # b of the felt velocity u + b h^2 laplace(u)


@lru_cache(maxsize=32)
def wall_law(width: float, strength: float, order: int, radius: float, *, sharp: bool) -> Law:
    """Where a penalised wall acts and, if sharp, what it must feel for no fluid to pass beside it.

    ``width``: half width of the ramp in spacings; ``strength`` = lambda h^2 / nu; ``order`` and
    ``radius``: of the Gaussian-regularised velocity (HEJ), which the wall feels. Solves
    ``k^2 v + (D/k) strength chi (zeta v) = drive`` for a channel on a periodic line, the steady
    state of the time step for any dt, and averages over the place of the wall between nodes.
    """
    wall = Ramp(width, strength, order, radius, sharp)
    blur = 0.0
    for _ in range(3 if sharp else 0):  # secants: the flow beside is nearly linear in the blur
        here, there = (beside(wall, b)[1] for b in (blur, blur + STEP))
        blur -= STEP * here / (there - here)
    return Law(float(beside(wall, blur)[0]), float(blur))


@lru_cache(maxsize=32)
def start_offset(width: float, rate: float, order: int, radius: float, *, sharp: bool) -> float:
    """How far outside the middle of the ramp an impulsive start puts its vortex sheet, in spacings.

    ``rate`` = lambda tau of the start. The momentum taken from a uniform stream along a wall, less
    what stays inside as slip, says where the sheet is.
    """
    wall = Ramp(width, rate, order, radius, sharp)
    places = [_sheet(float(shift), wall) for shift in SHIFTS]
    return float(np.mean(places))


class Ramp(NamedTuple):
    """A penalised wall on a line."""

    width: float  # half, in spacings
    strength: float  # lambda h^2 / nu; of a start lambda tau
    order: int  # of the regularised velocity
    radius: float
    sharp: bool


STEP = 0.02
SHIFTS = tuple(np.arange(4) / 4)
NODES, SOLID = 144, 24  # nodes of the line, of which the walls take 2 * SOLID
DRIVE = 3.0  # half width of the drive in mid channel


def beside(wall: Ramp, blur: float) -> Values:
    """Offset of a wall, and the flow beside it, as means over its places between nodes."""
    return np.asarray(np.mean([channel(float(s), wall, blur) for s in SHIFTS], axis=0), np.float64)


def channel(shift: float, wall: Ramp, blur: float) -> tuple[float, float]:
    """Offset of one wall, and the flow beside it in excess of a shear that ends there."""
    k, zeta, chi, curled = _line(shift, wall)
    felt = matrix(1.0 - 2.0 * blur * (1.0 - np.cos(k))) @ zeta
    nodes, middle = np.arange(NODES, dtype=np.float64), NODES / 2
    push = np.exp(-0.5 * ((nodes - middle) / DRIVE) ** 2)
    law = matrix(k**2) + curled @ (wall.strength * chi[:, None] * felt)
    u = zeta @ np.linalg.solve(law, push / push.sum())
    near = slice(SOLID + 14, NODES // 2 - 14)
    lower = np.polyfit(nodes[near], u[near], 1)
    upper = np.polyfit(nodes[near], u[::-1][near], 1)
    first, last = -lower[1] / lower[0], NODES - 1 + upper[1] / upper[0]
    area = 0.5 * (lower[0] * (middle - first) ** 2 + upper[0] * (last - middle) ** 2)
    return float(first - SOLID - shift), float(u.sum() - area + 0.5 * DRIVE**2)


def _sheet(shift: float, wall: Ramp) -> float:
    """Offset of the sheet on one wall, from the momentum that a uniform stream loses."""
    _, zeta, chi, curled = _line(shift, wall)
    rate = wall.strength
    raw = np.linalg.solve(np.eye(NODES) + curled @ (rate * chi[:, None] * zeta), np.ones(NODES))
    taken = float(np.sum(1.0 - raw)) * (1.0 + 1.0 / rate)
    return (taken - 2 * SOLID) / 2


def _line(shift: float, wall: Ramp) -> tuple[Values, ...]:
    """Wavenumbers, regularisation, indicator and curl ratio of a channel on a periodic line."""
    nodes = np.arange(NODES, dtype=np.float64)
    k = np.asarray(2 * np.pi * np.fft.fftfreq(NODES), np.float64)
    low, high = SOLID + shift, NODES - SOLID + shift
    ramp = np.asarray(indicator(np.minimum(nodes - low, high - nodes), wall.width), np.float64)
    chi = ramp**2 if wall.sharp else ramp
    return k, matrix(regularisation(k, wall.order, wall.radius)), chi, matrix(curl_ratio(k))


def matrix(symbol: Values) -> Values:
    """The matrix that multiplies each wavenumber of a periodic line by ``symbol``."""
    rows = np.fft.ifft(symbol[:, None] * np.fft.fft(np.eye(len(symbol)), axis=0), axis=0)
    return np.asarray(rows.real, np.float64)


def regularisation(k: Values, order: int, radius: float) -> Values:
    """Fourier transform of the Gaussian regularisation of the velocity, k in units of 1/h."""
    half = 0.5 * (radius * k) ** 2
    term, total = np.exp(-half), np.zeros_like(k)
    for n in range(1, order // 2 + 1):
        total = total + term
        term = term * half / n
    return total


def curl_ratio(k: Values) -> Values:
    """Fourth-order central difference over the exact derivative, per wavenumber."""
    safe = np.where(k == 0, 1.0, k)
    ratio = (4 / 3 * np.sin(k) - 1 / 6 * np.sin(2 * k)) / safe
    return np.where(k == 0, 1.0, ratio)
