"""Quadrature along a swimmer's midline, and the places at which its shape is sampled."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from pmesh.bodies.outline import Outline
from pmesh.bodies.profile import Profile

Values = NDArray[np.float64]
PANEL = 0.1  # [L] longest piece of the midline that gets one set of nodes
NODES = 16  # per piece of the midline
TURN = 0.1  # [L] of outline that a turn by one radian counts for when it is sampled
SLICES = 12  # of the upper half of a body in space, and as many of the lower


class Sheet(NamedTuple):
    """Quadrature along the midline, and where it is sampled."""

    nodes: Values  # (n,)
    weights: Values  # (n,)
    inner: Values  # (n, n): values at nodes -> integrals from the head to the nodes
    width: Values  # (n,) half-width at the nodes
    stations: Values  # (m,) from 0 to 1, denser where the outline is round
    outer: Values  # (m, n): values at nodes -> integrals from the head to the stations
    spread: Values  # (m,) half-width at the stations
    shares: Values  # (k,) half-widths of the slices z = const, of that of the section
    layers: Values  # (k, n) how thick the slices are at the nodes; a plane body has one, of 1
    levels: Values  # (k, n) their heights, those below the midline counted with those above
    rise: Values  # (m,) half-height at the stations; zeros for a plane body


@lru_cache(maxsize=32)
def sheet(
    breaks: tuple[float, ...], outline: Outline, samples: int, profile: Profile | None = None
) -> Sheet:
    """Nodes, weights and integrals; pieces end at the ``breaks`` and where the outline has a kink.

    On the first and last piece the place is the square of the variable: a round end is smooth.
    With a ``profile`` the sections are ellipses, cut in slices z = const at Chebyshev's nodes of
    the second kind: a law that is smooth across the body is integrated to round-off.
    """
    kinks = () if profile is None else profile.breaks
    marks = sorted({0.0, 1.0, *breaks, *outline.breaks, *kinks})
    edges = split(marks, PANEL)
    stations = _stations(outline, samples, edges)
    x, w = legendre.leggauss(NODES)
    count, last = len(edges) - 1, len(edges) - 2
    mapped = [_mapped(x, edges[p], edges[p + 1], p == 0, p == last) for p in range(count)]
    nodes = np.concatenate([places for places, _ in mapped])
    weights = np.concatenate([w * slope for _, slope in mapped])
    stations[-1] = 1.0
    shares, layers, levels = _slices(nodes, profile)
    return Sheet(
        nodes=nodes,
        weights=weights,
        inner=_integrals(nodes, edges, weights),
        width=outline.half_width(nodes),
        stations=stations,
        outer=_integrals(stations, edges, weights),
        spread=np.where((stations > 0) & (stations < 1), outline.half_width(stations), 0.0),
        shares=shares,
        layers=layers,
        levels=levels,
        rise=np.zeros_like(stations) if profile is None else profile.half_height(stations),
    )


def _slices(nodes: Values, profile: Profile | None) -> tuple[Values, Values, Values]:
    """Shares of the width, thicknesses and heights of the slices of the sections at the nodes."""
    if profile is None:
        return np.ones(1), np.ones((1, len(nodes))), np.zeros((1, len(nodes)))
    step = math.pi / (2 * SLICES + 1)
    turn = step * np.arange(1, SLICES + 1)
    height = profile.half_height(nodes)
    return (
        np.sin(turn),
        np.outer(2 * step * np.sin(turn), height),
        np.outer(np.cos(turn), height),
    )


def _integrals(places: Values, edges: Values, weights: Values) -> Values:
    """Matrix from values at the nodes to integrals from 0 to the places."""
    x, w = legendre.leggauss(NODES)
    matrix = np.zeros((len(places), len(weights)))
    to_series = (legendre.legvander(x, NODES - 1) * w[:, None]).T * (np.arange(NODES) + 0.5)[
        :, None
    ]
    series = legendre.legint(to_series, lbnd=-1, axis=0)  # (NODES + 1, NODES)
    panels = np.clip(np.searchsorted(edges, places, side="right") - 1, 0, len(edges) - 2)
    for i, (s, p) in enumerate(zip(places, panels, strict=True)):
        here = slice(p * NODES, (p + 1) * NODES)
        share = (s - edges[p]) / (edges[p + 1] - edges[p])
        u = 2 * share - 1
        if p == 0:
            u = 2 * math.sqrt(share) - 1
        elif p == len(edges) - 2:
            u = 1 - 2 * math.sqrt(1 - share)
        matrix[i, : here.start] = weights[: here.start]
        matrix[i, here] = legendre.legvander(np.array([u]), NODES)[0] @ series * weights[here] / w
    return matrix


def _mapped(x: Values, a: float, b: float, head: bool, tail: bool) -> tuple[Values, Values]:
    """Places of x in -1 ... 1 on a piece of the midline, and ds/dx."""
    u = (x + 1) / 2
    if head:
        return a + (b - a) * u**2, (b - a) * u
    if tail:
        return b - (b - a) * (1 - u) ** 2, (b - a) * (1 - u)
    return a + (b - a) * u, np.full_like(x, (b - a) / 2)


def _stations(outline: Outline, samples: int, edges: Values) -> Values:
    """Places evenly along the outline of the straight body, more where it is round."""
    fine = 0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, 20 * samples + 1))
    apart = np.abs(fine[:, None] - edges).min(axis=1) > 1e-9  # a tiny step has no direction
    fine = np.union1d(fine[apart], edges)
    width = outline.half_width(fine)
    step = np.hypot(np.diff(fine), np.diff(width))
    turn = np.abs(np.diff(np.arctan2(np.diff(width), np.diff(fine)), prepend=0.0))
    turn[0] = 0.0
    turn[np.isin(fine[:-1], edges)] = 0.0  # a kink needs no samples
    far = np.concatenate(([0.0], np.cumsum(step + TURN * turn)))
    marks = np.interp(edges, fine, far)
    along = split(list(marks), far[-1] / samples)
    return np.interp(along, far, fine)


def split(marks: Sequence[float] | Values, longest: float) -> Values:
    """The marks, with even steps of at most ``longest`` between them."""
    pieces = [
        np.linspace(a, b, max(1, math.ceil((b - a) / longest - 1e-9)) + 1)[:-1]
        for a, b in pairwise(marks)
    ]
    return np.concatenate((*pieces, marks[-1:]))
