"""Where bodies are near each other."""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from levelset.contour import contour
from levelset.shape import Array, Bounds, Shape
from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free
from pmesh.bodies.pose import Pose, still

Values = NDArray[np.float64]
SAMPLES = 4  # of an edge, in a reach
FINEST = 1024  # samples along the longest side of a body, at most
MOST = 6  # places at which one pair is told to be near
CORNERS = 1e-3  # slope below which a face is flat: its ends are told, not its middle
WIDTHS = (1.0, 0.2, 0.04)  # in samples, of the search for the nearest place
NUDGE = 1e-3  # of a difference, in samples


@dataclass(frozen=True)
class Contact:
    """A place where two bodies are near: midway between their edges.

    ``normal``: unit vector from the second to the first; ``gap`` [L]: negative if they overlap.
    """

    first: int
    second: int
    point: tuple[float, ...]  # [L]
    normal: tuple[float, ...]
    gap: float


def contacts(bodies: Sequence[Body], poses: Sequence[Pose], reach: float) -> tuple[Contact, ...]:
    """Where bodies are nearer than ``reach`` [L], if at least one of the two is free.

    Every local minimum of the gap along either edge, the ends of flat stretches, at most 6 a pair,
    no two within a reach. Edges are sampled four times in a reach and the places then narrowed,
    so that the gap is exact where the distances are. In space the places are sought on a lattice
    of steps of half a reach between the two, see `nearby`. Pairs whose boxes are apart cost
    nothing.
    """
    free = [isinstance(body.motion, Free) for body in bodies]
    if not any(free):
        return ()
    placed = [
        Placed(body, pose, *map(np.array, body.bounds(pose)))
        for body, pose in zip(bodies, poses, strict=True)
    ]
    found: list[Contact] = []
    for i, j in itertools.combinations(range(len(bodies)), 2):
        one, other = placed[i], placed[j]
        apart = np.any(one.low > other.high + reach) or np.any(other.low > one.high + reach)
        if (free[i] or free[j]) and not apart:
            found += _pair(one, other, (i, j), reach)
    return tuple(found)


def _pair(one: Placed, other: Placed, numbers: tuple[int, int], reach: float) -> list[Contact]:
    """The nearest places of two bodies, from the edge of each against the distance of the other."""
    if one.body.ndim == 3:
        from pmesh.bodies.nearby import nearby

        return _kept(nearby(one, other, numbers, reach), reach)
    found = []
    for mine, yours, sign in ((one, other, 1.0), (other, one, -1.0)):
        edge, gaps, slope = _nearest(mine, yours, reach)
        middle = edge - 0.5 * gaps * slope
        for k in np.flatnonzero(gaps < reach):
            point = (float(middle[0, k]), float(middle[1, k]))
            normal = (float(sign * slope[0, k]), float(sign * slope[1, k]))
            found.append(Contact(*numbers, point, normal, float(gaps[k])))
    return _kept(found, reach)


def _kept(found: Sequence[Contact], reach: float) -> list[Contact]:
    """The nearest places, at most 6, that are not one place."""
    kept: list[Contact] = []
    for contact in sorted(found, key=lambda contact: contact.gap):
        if len(kept) < MOST and not any(_same(contact, one, reach) for one in kept):
            kept.append(contact)
    return kept


def _same(one: Contact, other: Contact, reach: float) -> bool:
    """Whether two contacts are within a reach, and push alike."""
    arm = np.subtract(one.point, other.point)
    return bool(np.dot(arm, arm) < reach**2 and np.dot(one.normal, other.normal) > 0.5)


class Placed(NamedTuple):
    """A body at a pose, in a box."""

    body: Body
    pose: Pose
    low: Values
    high: Values

    def distance(self, points: Values) -> Values:
        """Signed distance [L] at points (ndim, ...)."""
        return np.asarray(self.body.distance(points, self.pose), np.float64)

    def felt(self, points: Values, nudge: float) -> tuple[Values, Values]:
        """Distance at points (ndim, ...) and its unit gradient, by central differences."""
        n = len(points)
        shifts = np.zeros((n, 2 * n + 1))
        shifts[:, 1::2], shifts[:, 2::2] = nudge * np.eye(n), -nudge * np.eye(n)
        column = shifts.reshape(n, 2 * n + 1, *(1,) * (points.ndim - 1))
        values = self.distance(points[:, None] + column)
        slope = values[1::2] - values[2::2]
        length = np.hypot(slope[0], slope[1])
        if n == 3:
            length = np.hypot(length, slope[2])
        return values[0], slope / np.where(length > 0, length, 1.0)

    def landed(self, points: Values, nudge: float, depth: float = 0.0) -> Values:
        """Points brought to the edge, or to a surface so deep [L] below it."""
        away, slope = self.felt(points, nudge)
        return points - (away + depth) * slope


def _nearest(mine: Placed, yours: Placed, reach: float) -> tuple[Values, Values, Values]:
    """Places (2, n) of an edge nearest to another body, the gaps (n), and their slopes (2, n)."""
    low, high = yours.low[:, None] - reach, yours.high[:, None] + reach
    time = mine.pose.time if mine.body.deforming else 0.0
    edges, tangents, starts = [np.empty((2, 0))], [np.empty((2, 0))], [np.empty(0)]
    for ring in _rings(cast(Hashable, mine.body), time, reach / SAMPLES):
        points = np.asarray(mine.pose.placed(ring), np.float64)
        near = np.all((points > low) & (points < high), axis=0)
        if not near.any():
            continue
        gaps = np.full(points.shape[1], np.inf)
        gaps[near] = yours.distance(points[:, near])
        rank = gaps - CORNERS * np.hypot(ring[0], ring[1])
        least = (rank <= np.roll(rank, 1)) & (rank <= np.roll(rank, -1))
        picked = np.flatnonzero(least & (gaps < (1.0 + 1.0 / SAMPLES) * reach))
        ahead = (picked + 1) % points.shape[1]
        edges.append(points[:, picked])
        tangents.append(0.5 * (points[:, ahead] - points[:, picked - 1]))
        starts.append(gaps[picked])
    edge, tangent = np.concatenate(edges, axis=1), np.concatenate(tangents, axis=1)
    if not edge.size:
        return edge, edge[0], edge
    return _narrowed(mine, yours, edge, tangent, np.concatenate(starts))


def _narrowed(
    mine: Placed, yours: Placed, edge: Values, tangent: Values, start: Values
) -> tuple[Values, Values, Values]:
    """Places moved along the edge to where the gap is least: by parabolas, then to and fro."""
    nudge = NUDGE * float(np.hypot(tangent[0], tangent[1]).max())
    best = np.zeros(edge.shape[1])
    for width in WIDTHS:
        sides = width * np.array([[-1.0], [0.0], [1.0]])
        gaps = yours.distance(mine.landed(edge[:, None] + tangent[:, None] * (best + sides), nudge))
        bend = gaps[0] - 2.0 * gaps[1] + gaps[2]
        curved = bend > 1e-6 * np.abs(gaps[0] - gaps[2])
        vertex = 0.5 * (gaps[0] - gaps[2]) / np.where(curved, bend, 1.0)
        lower = gaps.argmin(axis=0) - 1.0
        best = best + width * np.where(curved, np.clip(vertex, -1.0, 1.0), lower)
    place = mine.landed(edge + tangent * best, nudge)
    place = mine.landed(yours.landed(place, nudge), nudge)  # finds the other edge's corners
    gap, slope = yours.felt(place, nudge)
    if np.any(gap > start):
        place = np.where(gap > start, edge, place)
        gap, slope = yours.felt(place, nudge)
    return place, gap, slope


@lru_cache(maxsize=128)
def _rings(body: Hashable, time: float, step: float) -> tuple[Values, ...]:
    """The edge (2, n) in the body's own axes, sampled about every step."""
    shape = _Seen(cast(Body, body), still((0.0, 0.0), time))
    low, high = shape.bounds()
    longest = max(b - a for a, b in zip(low, high, strict=True))
    cells = min(max(int(np.ceil(longest / step)), 16), FINEST)
    return tuple(np.ascontiguousarray(ring.T) for ring in contour(shape, cells=cells))


@dataclass(frozen=True)
class _Seen(Shape):
    """A body at a pose, as a shape."""

    body: Body
    pose: Pose

    @property
    def ndim(self) -> int:
        """2."""
        return self.body.ndim

    @property
    def volume(self) -> float:
        """That of the body."""
        return self.body.measure.volume

    def bounds(self) -> Bounds:
        """The body's box."""
        return self.body.bounds(self.pose)

    def _distance(self, points: Array) -> Array:
        return self.body.distance(points, self.pose)
