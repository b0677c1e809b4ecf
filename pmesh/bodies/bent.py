"""A swimmer at a pose: its lines, its distance and the velocity of its matter, in the user's units.

A body in space is looked at in its own axes: it bends in their plane z = 0, and all its slices
z = const move alike.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.shape import rotation
from pmesh.bodies.body import Bounds
from pmesh.bodies.gait import Gait, Shape, shape
from pmesh.bodies.pose import Pose
from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
MARGIN = 0.05  # [L] beyond the outline up to which the velocity follows its law, then stays
NEAR = 0.3  # [L] from the midline up to which the distance is told from the smooth one


class Scaled(NamedTuple):
    """A gait in the user's units."""

    gait: Gait
    length: float  # [L]
    period: float  # [T]

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return 2 if self.gait.profile is None else 3


class Bent(NamedTuple):
    """The lines of a body at a pose: of a plane one in world axes, of one in space in its own."""

    shape: Shape
    line: Values  # (m, 2) midline
    angle: Values  # (m,)
    velocity: Values  # (m, 2)
    ring: Values  # (n, 2)


@lru_cache(maxsize=256)
def bent(body: Scaled, pose: Pose) -> Bent:
    """Its lines."""
    now, length = shape(body.gait, pose.time / body.period), body.length
    plane = body.ndim == 2
    angle = pose.angle[0] if plane else 0.0
    turn = rotation((angle,)).T
    center = np.asarray(pose.center) if plane else np.zeros(2)
    return Bent(
        shape=now,
        line=now.place @ turn * length + center,
        angle=now.angle + angle,
        velocity=now.velocity @ turn * (length / body.period),
        ring=now.ring @ turn * length + center,
    )


def seen(line: Values, body: Scaled, pose: Pose) -> Values:
    """A line (n, 2) of ``bent`` in the world, (n, ndim)."""
    if body.ndim == 2:
        return line
    return np.asarray(pose.placed(np.column_stack((line, np.zeros(len(line)))).T).T)


def box(body: Scaled, pose: Pose) -> Bounds:
    """Lower and upper corner of a box that holds the body: its sections in rectangles."""
    ring: Array = bent(body, pose).ring
    if body.ndim == 3:
        rise = body.gait.sheet.rise * body.length
        heights = np.concatenate((rise, rise[-2:0:-1]))
        corners = np.concatenate([np.column_stack((ring, z)) for z in (-heights, heights)])
        ring = pose.placed(corners.T).T
    low, high = ring.min(axis=0), ring.max(axis=0)
    return tuple(map(float, low)), tuple(map(float, high))


def distance(body: Scaled, points: Array, pose: Pose) -> Array:
    """Signed distance [L] at ``points`` (ndim, ...), negative inside."""
    _check_points(body, points)
    return (
        _plane_distance(body, points, pose)
        if body.ndim == 2
        else _solid_distance(body, points, pose)
    )


def _plane_distance(body: Scaled, points: Array, pose: Pose) -> Array:
    from pmesh.bodies._swimmer import ring_distance

    flat = np.ascontiguousarray(points.reshape(2, -1))
    result = np.empty(points[0].size, points.dtype)
    ring = bent(body, pose).ring
    ring = np.concatenate((ring, ring[:1]))
    ring_distance(flat, ring, result)
    return result.reshape(points.shape[1:])


def _solid_distance(body: Scaled, points: Array, pose: Pose) -> Array:
    from pmesh.bodies._solid import bent_distance
    from pmesh.bodies.solid import table

    now, straight = shape(body.gait, pose.time / body.period), table(body.gait)
    own = pose.seen(points).reshape(3, -1).astype(np.float64)
    own /= body.length
    result = np.empty(own.shape[1])
    bent_distance(
        own,
        now.stations,
        now.place,
        now.angle,
        now.curvature,
        straight.values,
        *straight.steps,
        straight.first,
        NEAR,
        result,
    )
    result *= body.length
    return result.reshape(points.shape[1:]).astype(points.dtype)


def matter(body: Scaled, points: Array, pose: Pose, solenoidal: bool) -> tuple[Values, Values]:
    """Velocity (ndim, ...) [L/T] beyond the rigid motion at ``points``, and its divergence."""
    from pmesh.bodies import _swimmer as loops

    _check_points(body, points)
    lines, length, period = bent(body, pose), body.length, body.period
    flat = points if body.ndim == 2 else pose.seen(points)[:2]
    now, result = lines.shape, np.empty((3, points[0].size))
    loops.matter(
        np.ascontiguousarray(flat.reshape(2, -1)),
        now.stations * length,
        lines.line,
        lines.angle,
        lines.velocity,
        now.spin / period,
        now.curvature / length,
        now.rate / (length * period),
        now.below * length,
        now.above * length,
        MARGIN * length,
        solenoidal,
        result,
    )
    velocity, source = result[:2], result[2].reshape(points.shape[1:])
    if body.ndim == 3:
        velocity = pose.turned(np.concatenate((velocity, np.zeros_like(result[:1]))))
    return velocity.reshape(points.shape), source


def inertia(body: Scaled, pose: Pose) -> float | Values:
    """Polar moment in the plane; in space int (|r|^2 I - r r) dV, (3, 3) in world axes."""
    now, size = shape(body.gait, pose.time / body.period), body.length ** (body.ndim + 2)
    if body.ndim == 2:
        return now.inertia * size
    turn = rotation(pose.angle)
    tensor = np.trace(now.second) * np.eye(3) - now.second
    return np.asarray(turn @ tensor @ turn.T * size)


def _check_points(body: Scaled, points: Array) -> None:
    """Refuse points of another dimension."""
    if points.shape[0] != body.ndim:
        raise InputError(
            f"this swimmer is seen at points ({body.ndim}, ...), got {points.shape}",
            hint="grid.points()",
        )
