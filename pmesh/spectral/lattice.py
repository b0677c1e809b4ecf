"""Lattice Green's functions: exact inverses of the 3-, 5- and 7-point Laplacian, unit spacing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, special

Array = NDArray[Any]

_NEAR = 64  # offsets up to here by quadrature, beyond by the asymptotic series
PLANE_CONSTANT = (np.euler_gamma + 1.5 * math.log(2)) / (2 * math.pi)


def lattice_greens(shape: tuple[int, ...], screening: Array) -> Array:
    """G(n) with (-laplace_h + screening) G = delta_0, for offsets 0 <= n_i < shape_i.

    ``screening``: non-negative number, or for one axis an array that broadcasts. Without it the
    plane's G is shifted to approach -ln(r) / (2 pi), and the line's is -n/2. Source: Liska &
    Colonius, J. Comput. Phys. 279 (2014) 76; the integrals are standard.
    """
    if len(shape) == 1:
        return lattice_line(np.arange(shape[0]), np.asarray(screening, dtype=float))
    if len(shape) == 2:
        held = float(np.asarray(screening).item())
        return _screened_plane(shape, held) if held > 0 else _plane(shape)
    return _space(shape)


def lattice_line(n: Any, screening: Array) -> Array:
    """G of a line: exp(-n s) / (2 sinh s), cosh s = 1 + screening/2; -n/2 without screening."""
    s = 2 * np.arcsinh(np.sqrt(screening) / 2)
    moving = s > 0
    s_safe = np.where(moving, s, 1.0)
    G: Array = np.where(moving, np.exp(-n * s_safe) / (2 * np.sinh(s_safe)), -n / 2)
    return G


def _screened_plane(shape: tuple[int, ...], screening: float) -> Array:
    """Sum over the wavenumbers of axis 1 (a ring long enough to hold the decay) of the line's G."""
    width = 2 * math.asinh(math.sqrt(screening) / 2)
    half = fft.next_fast_len(int(max(shape[1], math.ceil(20 / width))) + 1)
    rows = 2 - 2 * np.cos(np.pi * np.arange(half + 1) / half)
    lines = lattice_line(np.arange(shape[0])[:, None], screening + rows)
    summed: Array = fft.dct(lines, type=1, axis=1)[:, : shape[1]] / (2 * half)
    return summed


def _plane(shape: tuple[int, ...]) -> Array:
    """Minus the potential kernel a(n, m) of the plane, plus its asymptotic constant."""
    n, m = np.meshgrid(*(np.arange(size, dtype=float) for size in shape), indexing="ij")
    r2 = n**2 + m**2
    r2[0, 0] = 1.0
    n2, m2 = n**2, m**2
    quartic = (n2**2 - 6 * n2 * m2 + m2**2) / (24 * np.pi * r2**3)
    octic = (
        43 * n2**4 - 772 * n2**3 * m2 + 1570 * n2**2 * m2**2 - 772 * n2 * m2**3 + 43 * m2**4
    ) / (480 * np.pi * r2**6)
    G: Array = -np.log(r2) / (4 * np.pi) + quartic + octic
    near = [min(size, _NEAR + 1) for size in shape]
    top = max(near)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    panels = np.pi / 24 * np.arange(24)[:, None]
    k = (panels + np.pi / 48 * (nodes + 1)).ravel()
    weights = np.tile(np.pi / 48 * weights, 24)
    s = 2 * np.arcsinh(np.sin(k / 2))
    decay = np.exp(-np.arange(top)[:, None] * s)
    wave = np.cos(np.arange(top)[:, None] * k)
    measure = weights / (2 * np.pi * np.sinh(s))
    potential = measure.sum() - (decay * measure) @ wave.T
    potential = np.where(np.tri(top, dtype=bool), potential, potential.T)
    potential[0, 0] = 0.0
    G[: near[0], : near[1]] = PLANE_CONSTANT - potential[: near[0], : near[1]]
    return G


def _space(shape: tuple[int, ...]) -> Array:
    """Integral of prod exp(-2t) I_n(2t) near the origin, 1/(4 pi r) and a correction beyond."""
    squares = np.meshgrid(*(np.arange(size, dtype=float) ** 2 for size in shape), indexing="ij")
    r2 = squares[0] + squares[1] + squares[2]
    r2[0, 0, 0] = 1.0
    quartic = sum(square**2 for square in squares)
    G: Array = 1 / (4 * np.pi * np.sqrt(r2)) + (5 * quartic / r2**2 - 3) / (32 * np.pi * r2**1.5)
    near = tuple(min(size, _NEAR + 1) for size in shape)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    end = 1e7
    panels = np.arange(-32.0, math.log(end), 0.5)
    steps = np.diff(np.append(panels, math.log(end)))
    v = (panels[:, None] + steps[:, None] * (nodes + 1) / 2).ravel()
    t = np.exp(v)
    measure = (steps[:, None] * weights / 2).ravel() * t
    order = np.arange(max(near))[:, None]
    bessel = special.ive(order, 2 * t)
    pairs = (bessel[: near[0], None, :] * bessel[None, : near[1], :] * measure).reshape(-1, t.size)
    inner = (pairs @ bessel[: near[2]].T).reshape(near)
    spread = 4 * r2[: near[0], : near[1], : near[2]] - 3
    spread[0, 0, 0] = -3
    tail = (2 / math.sqrt(end) - spread / 16 * 2 / 3 / end**1.5) / (4 * np.pi) ** 1.5
    G[: near[0], : near[1], : near[2]] = inner + tail
    return G
