"""Where bodies are near each other."""

from __future__ import annotations

import itertools
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

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
WIDTHS = (1.0, 0.25, 0.0625)  # in samples, of the search for the nearest place
BOUNCES = 2  # between both edges, after it
NUDGE = 1e-3  # of a difference, in reaches


@dataclass(frozen=True)
class Contact:
    """A place where two bodies are near: midway between their edges.

    ``normal``: unit vector from the second to the first; ``gap`` [L]: negative if they overlap.
    """

    first: int
    second: int
    point: tuple[float, float]  # [L]
    normal: tuple[float, float]
    gap: float


def contacts(bodies: Sequence[Body], poses: Sequence[Pose], reach: float) -> tuple[Contact, ...]:
    """Where plane bodies are nearer than ``reach`` [L], if at least one of the two is free.

    Every local minimum of the gap along either edge, the ends of flat stretches, at most 6 a pair,
    no two within a reach. Edges are sampled four times in a reach and the places then narrowed,
    so that the gap is exact where the distances are. Pairs whose boxes are apart cost nothing.
    """
    free = np.array([isinstance(body.motion, Free) for body in bodies])
    if not free.any():
        return ()
    boxes = [body.bounds(pose) for body, pose in zip(bodies, poses, strict=True)]
    low, high = np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes])
    found: list[Contact] = []
    for i, j in itertools.combinations(range(len(bodies)), 2):
        if not (free[i] or free[j]):
            continue
        if np.any(low[i] > high[j] + reach) or np.any(low[j] > high[i] + reach):
            continue
        found += _pair(i, j, bodies, poses, reach)
    return tuple(found)


def _pair(
    i: int, j: int, bodies: Sequence[Body], poses: Sequence[Pose], reach: float
) -> list[Contact]:
    """The nearest places of two bodies, from the edge of each against the distance of the other."""
    found = []
    for a, b, sign in ((i, j, 1.0), (j, i, -1.0)):
        edge, gaps, slope = _nearest((bodies[a], poses[a]), (bodies[b], poses[b]), reach)
        middle = edge - 0.5 * gaps * slope
        for k in range(gaps.size):
            point = (float(middle[0, k]), float(middle[1, k]))
            normal = (float(sign * slope[0, k]), float(sign * slope[1, k]))
            found.append(Contact(i, j, point, normal, float(gaps[k])))
    kept: list[Contact] = []
    for one in sorted(found, key=lambda contact: contact.gap):
        if len(kept) < MOST and not any(_same(one, other, reach) for other in kept):
            kept.append(one)
    return kept


def _same(one: Contact, other: Contact, reach: float) -> bool:
    """Whether two contacts are within a reach, and push alike."""
    arm = np.subtract(one.point, other.point)
    return bool(np.dot(arm, arm) < reach**2 and np.dot(one.normal, other.normal) > 0.5)


def _nearest(
    one: tuple[Body, Pose], other: tuple[Body, Pose], reach: float
) -> tuple[Values, Values, Values]:
    """Places (2, n) of one's edge nearest to the other, gaps (n), slopes of them (2, n)."""
    (body, pose), (target, aim) = one, other
    low, high = (np.array(corner)[:, None] for corner in target.bounds(aim))
    starts, tangents = [], []
    time = pose.time if body.deforming else 0.0
    for ring in _rings(cast(Hashable, body), time, reach / SAMPLES):
        points = np.asarray(pose.placed(ring), np.float64)
        near = np.all((points > low - reach) & (points < high + reach), axis=0)
        if not near.any():
            continue
        gaps = np.full(points.shape[1], np.inf)
        gaps[near] = target.distance(points[:, near], aim)
        rank = gaps - CORNERS * np.hypot(ring[0], ring[1])
        least = (rank <= np.roll(rank, 1)) & (rank <= np.roll(rank, -1))
        picked = np.flatnonzero(least & (gaps < 2.0 * reach))
        ahead = (picked + 1) % points.shape[1]
        starts.append(points[:, picked])
        tangents.append(0.5 * (points[:, ahead] - points[:, picked - 1]))
    if not starts:
        return np.empty((2, 0)), np.empty(0), np.empty((2, 0))
    edge = _narrowed(np.concatenate(starts, axis=1), np.concatenate(tangents, axis=1), one, other)
    gaps = np.asarray(target.distance(edge, aim), np.float64)
    edge, gaps = edge[:, gaps < reach], gaps[gaps < reach]
    return edge, gaps, _slopes(target, aim, edge, NUDGE * reach)


def _narrowed(
    edge: Values, tangent: Values, one: tuple[Body, Pose], other: tuple[Body, Pose]
) -> Values:
    """Each place moved along its edge to where the gap is least, by ever narrower parabolas."""
    (body, pose), (target, aim) = one, other
    nudge = 1e-3 * float(np.abs(tangent).max(initial=1e-300))

    def landed(points: Values) -> Values:
        """Points brought to the edge."""
        return points - body.distance(points, pose) * _slopes(body, pose, points, nudge)

    best = np.zeros(edge.shape[1])
    for width in WIDTHS:
        sides = width * np.array([[-1.0], [0.0], [1.0]])
        gaps = target.distance(landed(edge[:, None] + tangent[:, None] * (best + sides)), aim)
        bend = gaps[0] - 2.0 * gaps[1] + gaps[2]
        curved = bend > 1e-6 * np.abs(gaps[0] - gaps[2])
        vertex = 0.5 * (gaps[0] - gaps[2]) / np.where(curved, bend, 1.0)
        lower = gaps.argmin(axis=0) - 1.0
        best = best + width * np.where(curved, np.clip(vertex, -1.0, 1.0), lower)
    place = landed(edge + tangent * best)
    for _ in range(BOUNCES):  # off the other edge and back: finds its corners
        place = landed(place - target.distance(place, aim) * _slopes(target, aim, place, nudge))
    better = target.distance(place, aim) < target.distance(edge, aim)
    return np.asarray(np.where(better, place, edge))


def _slopes(body: Body, pose: Pose, points: Values, nudge: float) -> Values:
    """Unit gradients of the distance at points (2, ...), by central differences."""
    shifts = nudge * np.eye(2).reshape(2, 2, *(1,) * (points.ndim - 1))
    sides = np.stack([points + s for s in (*shifts, *-shifts)], axis=1)
    values = np.asarray(body.distance(sides, pose), np.float64)
    slope = values[:2] - values[2:]
    length = np.hypot(slope[0], slope[1])
    return np.asarray(slope / np.where(length > 0, length, 1.0))


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
