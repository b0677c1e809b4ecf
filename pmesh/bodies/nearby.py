"""Where two bodies in space are near each other, by their signed distances alone.

The sum of both distances is the gap on the shortest way between two surfaces, and more elsewhere
about it. So places where it is least on a lattice are near such a way; projections to and fro
between surfaces a little below the two, where they converge fast and an overlap is no hindrance,
then find its ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pmesh.bodies.gaps import Contact, Placed

Values = NDArray[np.float64]
FINE = 2  # steps of the lattice in a reach
PICKED = 6  # places on the lattice that are narrowed
ROUNDS = 40  # of projections to and fro
NUDGE = 1e-4  # of differences, in reaches
OUTWARD = 1e-3  # of the distance from the centre: the ends of flat faces are told, not the middle
THIN = 1e-6  # gap below which the surfaces give no direction, in reaches


def nearby(one: Placed, other: Placed, numbers: tuple[int, int], reach: float) -> list[Contact]:
    """Places where two bodies in space are nearer than ``reach`` [L], some of them perhaps twice.

    The gap is exact where the distances are, if the bodies are thicker than four reaches and no
    smaller a curvature radius than one faces the other; sharp corners and edges are met exactly
    while they are apart.
    """
    from pmesh.bodies.gaps import Contact

    start = _starts(one, other, reach)
    if not start.size:
        return []
    found = []
    first, second = _ends(one, other, start, reach, depth=reach)
    way, apart = _unit(first - second)
    gap = apart - 2.0 * reach
    clear = gap > THIN * reach
    if clear.any():  # corners are rounder below the surface: once more at the surfaces themselves
        middle = 0.5 * (first + second)[:, clear]
        first[:, clear], second[:, clear] = _ends(one, other, middle, reach, depth=0.0)
        way[:, clear], gap[clear] = _unit((first - second)[:, clear])
    point = 0.5 * (first + second)
    for k in np.flatnonzero(gap < reach):
        place, normal = (tuple(float(x) for x in row[:, k]) for row in (point, way))
        found.append(Contact(*numbers, place, normal, float(gap[k])))
    return found


def _starts(one: Placed, other: Placed, reach: float) -> Values:
    """Points (3, n) of a lattice near the shortest ways between two bodies."""
    low = np.maximum(one.low, other.low) - reach
    high = np.minimum(one.high, other.high) + reach
    counts = np.maximum(np.ceil((high - low) * FINE / reach).astype(int), 1) + 1
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij")).reshape(3, -1)
    mine = one.distance(points)
    points, mine = points[:, np.abs(mine) < 2.0 * reach], mine[np.abs(mine) < 2.0 * reach]
    yours = other.distance(points)
    level = np.abs(mine - yours) < 2.0 * reach / FINE  # about midway
    near = level & (mine + yours < 2.0 * reach)
    points, total = points[:, near], (mine + yours)[near]
    arm = np.linalg.norm(points - np.array(one.pose.center)[:, None], axis=0)
    order = np.argsort(total - OUTWARD * arm, kind="stable")
    picked: list[int] = []
    for k in order:
        arms = points[:, picked] - points[:, [k]]
        if len(picked) < PICKED and not np.any(np.sum(arms**2, axis=0) < 4.0 * reach**2):
            picked.append(int(k))
    return np.asarray(points[:, picked])


def _ends(
    one: Placed, other: Placed, start: Values, reach: float, depth: float
) -> tuple[Values, Values]:
    """The ends (3, n) of the shortest ways between surfaces so deep [L] below the two."""
    nudge, place = NUDGE * reach, start
    for _ in range(ROUNDS):
        first = one.landed(place, nudge, depth)
        second = other.landed(first, nudge, depth)
        if np.abs(second - place).max() < 1e-9 * reach:
            break
        place = second
    return one.landed(second, nudge, depth), second


def _unit(vectors: Values) -> tuple[Values, Values]:
    """Directions (3, n) and lengths (n)."""
    length = np.linalg.norm(vectors, axis=0)
    return vectors / np.where(length > 0.0, length, 1.0), length
