"""The forced wall: where the outermost markers of a body lie, so that its wall is at distance zero.

Markers in a plane stop the flow a known way outside of them, and let a known flow pass beside the
wall. One dimension tells both, as it does for the penalised wall.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.markers import KERNEL
from pmesh.bodies.wall import curl_ratio, matrix, regularisation
from remesh.kernels import get_kernel

Values = NDArray[np.float64]
SHIFTS = (0.0, 0.25, 0.5, 0.75)
NODES, SOLID, DRIVE = 144, 24, 3.0  # of the line; half of the wall's; width of the drive


class Calibration(NamedTuple):
    """What puts a forced wall at distance zero, in spacings and their square."""

    retraction: float  # of the first line of markers from the outline
    sharpening: float  # b of the felt velocity u - b h^2 laplace(u)


@lru_cache(maxsize=32)
def calibrated(strength: float, order: int, radius: float) -> Calibration:
    """Where the markers lie and what they feel.

    ``order`` and ``radius``: of the Gaussian-regularised velocity. From the steady shear between
    two walls driven from mid channel, averaged over the place of the markers between nodes: the
    shear must vanish at the outline, and no more fluid pass between it and the body than in a
    shear that ends there. The first fault moves the wall by a part of h, the second blows through
    it in proportion to h^2.
    """
    low, high = 0.0, 0.1
    faults = [_faults(strength, sharp, order, radius)[1] for sharp in (low, high)]
    sharp = low - faults[0] * (high - low) / (faults[1] - faults[0])  # it is linear
    return Calibration(float(_faults(strength, sharp, order, radius)[0]), float(sharp))


@lru_cache(maxsize=32)
def sheet_retraction(rate: float, order: int, radius: float) -> float:
    """How far outside its first markers an impulsive start puts its vortex sheet, in spacings.

    ``rate`` = lambda tau of the start. From the momentum that a uniform stream along a wall loses.
    """
    return float(np.mean([_sheet(shift, rate, order, radius) for shift in SHIFTS]))


def _faults(strength: float, sharp: float, order: int, radius: float) -> Values:
    channels = [_channel(shift, strength, sharp, order, radius) for shift in SHIFTS]
    return np.asarray(np.mean(channels, axis=0), np.float64)


def _channel(
    shift: float, strength: float, sharp: float, order: int, radius: float
) -> tuple[float, float]:
    """Place of the wall outside its first marker, and the flow beside it, in a channel."""
    k, weights = _line(shift)
    nodes = np.arange(NODES, dtype=np.float64)
    inverse = np.where(k == 0, 0.0, 1.0 / np.where(k == 0, 1.0, k) ** 2)
    zeta, felt = regularisation(k, order, radius), 1.0 + 2.0 * sharp * (1.0 - np.cos(k))
    push = np.exp(-0.5 * ((nodes - NODES / 2) / DRIVE) ** 2)
    free = matrix(zeta * inverse) @ (push / push.sum())
    response = matrix(zeta * curl_ratio(k) * inverse) @ weights.T
    count = len(weights)
    system = np.ones((count + 1, count + 1))  # a mean flow, and forces that balance the drive
    system[:count, :count] = weights @ matrix(felt) @ response + np.eye(count) / strength
    system[count, count] = 0.0
    *q, mean = np.linalg.solve(system, np.append(-weights @ matrix(felt) @ free, -1.0))
    u = free + mean + response @ np.array(q)
    near = slice(SOLID + 14, NODES // 2 - 14)
    lower = np.polyfit(nodes[near], u[near], 1)
    upper = np.polyfit(nodes[near], u[::-1][near], 1)
    first, last = -lower[1] / lower[0], NODES - 1 + upper[1] / upper[0]
    middle = NODES / 2
    area = 0.5 * (lower[0] * (middle - first) ** 2 + upper[0] * (last - middle) ** 2)
    return float(first - SOLID - shift), float(u.sum() - area + 0.5 * DRIVE**2)


def _sheet(shift: float, rate: float, order: int, radius: float) -> float:
    """Place of the sheet on one wall outside its first marker, from the momentum lost."""
    k, weights = _line(shift)
    felt = weights @ matrix(regularisation(k, order, radius) * curl_ratio(k)) @ weights.T
    q = np.linalg.solve(felt + np.eye(len(felt)) / rate, np.ones(len(felt)))
    return float(0.5 * q.sum() * (1.0 + 1.0 / rate) - SOLID)


def _line(shift: float) -> tuple[Values, Values]:
    """Wavenumbers of a periodic line, and the weights of the nodes for markers in two walls."""
    nodes, depth = np.arange(NODES), np.arange(SOLID)
    places = np.concatenate([SOLID + shift - depth, NODES - SOLID + shift + depth])
    away = places[:, None] - nodes
    weights = get_kernel(KERNEL)(away - NODES * np.round(away / NODES))
    k = np.asarray(2 * np.pi * np.fft.fftfreq(NODES), np.float64)
    return k, np.asarray(weights, np.float64)
