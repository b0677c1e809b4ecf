"""The bodies on a box of the mesh: where their matter is, whose it is, and how it moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.motion import Free, coordinates
from pmesh.bodies.pose import Pose
from pmesh.bodies.wall import indicator
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
NODE = 1e-6  # a box ends on a node when it comes this close, in spacings: the same box on any mesh
MARGIN = 4  # nodes of a box beyond the indicator: the curl's stencil and one more
KEPT = 3  # fields of a step: at its start, where bodies are foreseen at its end, where they arrive
STRIDE = 8  # boxes around what moves have sides of so many nodes: few shapes, few solvers


class Mask(NamedTuple):
    """The bodies on a box of the mesh."""

    grid: Grid  # of the box
    chi: Array  # indicator, shape of the box
    root: Array  # its square root
    owner: NDArray[np.int16]  # index of the nearest body at every node
    velocity: Array  # of the bodies' matter, (ndim, *shape) [L/T]; of free ones the deformation
    drift: tuple[Array, ...]  # rigid velocity and spin that each deformation lost on the mesh


def mask_of(
    bodies: tuple[Body, ...],
    poses: tuple[Pose, ...],
    grid: Grid,
    width: float,
    offset: float,
    sharp: bool = False,
) -> Mask:
    """Bodies on a box: the indicator of ``distance < -offset`` over +-``width`` [L], and owners.

    ``sharp``: the square of that indicator.

    The deformation of a free body has no linear and no angular momentum on the mesh, to round-off:
    what it has is taken from it and told as ``drift``; locked coordinates keep theirs. Bodies that
    do not move are drawn once.
    """
    told = tuple(
        rest if isinstance(body.motion, Free) else replace(pose, time=rest.time)
        for body, pose, rest in zip(bodies, poses, at_rest(bodies, poses), strict=True)
    )
    return _mask(bodies, told, grid, width, offset, sharp)


@lru_cache(maxsize=KEPT)
def _mask(
    bodies: tuple[Body, ...],
    poses: tuple[Pose, ...],
    grid: Grid,
    width: float,
    offset: float,
    sharp: bool,
) -> Mask:
    points = grid.points()
    owner, distance = _nearest(bodies, at_rest(bodies, poses), grid)
    ramp = indicator(distance + offset, width)
    chi, root = (ramp**2, ramp) if sharp else (ramp, np.sqrt(ramp))
    velocity, drifts = np.zeros_like(points), []
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        own, motion = owner == number, body.motion
        matter = np.zeros_like(points) if isinstance(motion, Free) else pose.rigid(points)
        change = deformation_on(body, pose, grid)
        drift: Array = np.zeros(grid.ndim + len(pose.spin))
        if change is not None:
            if isinstance(motion, Free):
                loose = [name not in motion.locked for name in coordinates(grid.ndim)]
                drift[loose] = _momentum(change, points, pose, np.where(own, chi, 0.0), loose)
                change = change - _motion(drift, points, pose)
            matter = matter + change
        velocity = np.where(own, matter, velocity)
        drifts.append(drift)
    return Mask(grid, chi, root, owner, velocity, tuple(drifts))


@lru_cache(maxsize=2)  # at the start and at the end of a step
def swelling(
    bodies: tuple[Body, ...], poses: tuple[Pose, ...], grid: Grid, width: float
) -> Array | None:
    """Divergence [1/T] of the bodies' deformation on a box, of sum zero; None if there is none.

    What bends is longer on one side and shorter on the other: the fluid must make room.
    """
    if all(body.solenoidal for body in bodies):
        return None
    points = grid.points()
    owner, distance = _nearest(bodies, at_rest(bodies, poses), grid)
    chi = indicator(distance, width)
    total = np.zeros(grid.shape)
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        rate = body.divergence(points, pose)
        if rate is not None:
            own = np.where(owner == number, chi, 0.0)
            source = own * rate
            total += source - own * (source.sum() / own.sum())
    return total


def deformation_on(body: Body, pose: Pose, grid: Grid) -> Array | None:
    """Velocity [L/T] of a body's matter beyond the rigid motion, on the nodes; None if rigid."""
    if not body.deforming:
        return None
    return _deformation_of(body)(at_rest((body,), (pose,))[0], grid)


@lru_cache(maxsize=16)
def _deformation_of(body: Body) -> Callable[[Pose, Grid], Array | None]:
    """The law of one body, which keeps the last few fields it gave."""

    @lru_cache(maxsize=KEPT)
    def deformation(place: Pose, grid: Grid) -> Array | None:
        return body.deformation(grid.points(), place)

    return deformation


def box_around(bodies: tuple[Body, ...], poses: tuple[Pose, ...], grid: Grid, reach: float) -> Grid:
    """The part of the mesh's lattice that holds the bodies and ``reach`` [L] around them.

    A periodic axis is taken whole. The box may stick out of the mesh: the caller decides.
    """
    corners = [body.bounds(pose) for body, pose in zip(bodies, poses, strict=True)]
    moving = any(moves(body) for body in bodies)
    shape, origin = [], []
    for axis in range(grid.ndim):
        if grid.periodic[axis]:
            shape.append(grid.shape[axis])
            origin.append(grid.origin[axis])
            continue
        low = min(lower[axis] for lower, _ in corners) - reach - grid.origin[axis]
        high = max(upper[axis] for _, upper in corners) + reach - grid.origin[axis]
        first = int(np.floor(low / grid.spacing + NODE)) - MARGIN
        last = int(np.ceil(high / grid.spacing - NODE)) + MARGIN
        nodes = last - first + 1
        shape.append(-(-nodes // STRIDE) * STRIDE if moving else nodes)
        origin.append(grid.origin[axis] + first * grid.spacing)
    return Grid(shape, grid.spacing, origin, grid.boundary)


def moves(body: Body) -> bool:
    """Whether the body's place or shape changes."""
    return body.deforming or body.motion.moving


@lru_cache(maxsize=2)
def _nearest(
    bodies: tuple[Body, ...], places: tuple[Pose, ...], grid: Grid
) -> tuple[NDArray[np.int16], Array]:
    """The nearest body at every node, and its distance."""
    points = grid.points()
    distances = np.stack(
        [body.distance(points, place) for body, place in zip(bodies, places, strict=True)]
    )
    return np.argmin(distances, axis=0).astype(np.int16), distances.min(axis=0)


def at_rest(bodies: Sequence[Body], poses: Sequence[Pose]) -> tuple[Pose, ...]:
    """Where the surfaces are: the poses without velocities, and without time if it bends none."""
    return tuple(
        replace(
            pose,
            time=pose.time if body.deforming else 0.0,
            velocity=(0.0,) * len(pose.velocity),
            spin=(0.0,) * len(pose.spin),
        )
        for body, pose in zip(bodies, poses, strict=True)
    )


def _momentum(
    change: Array, points: Array, pose: Pose, weight: Array, loose: Sequence[bool]
) -> Array:
    """The rigid motion along the loose coordinates that has the momenta of a velocity there."""
    modes = rigid_modes(points, pose)[list(loose)]  # (m, ndim, ...)
    flat = modes.reshape(len(modes), change.size)
    weighted = (modes * weight).reshape(len(modes), change.size)
    return np.asarray(np.linalg.solve(weighted @ flat.T, weighted @ change.ravel()))


def _motion(drift: Array, points: Array, pose: Pose) -> Array:
    return np.tensordot(drift, rigid_modes(points, pose), axes=1)


def rigid_modes(points: Array, pose: Pose) -> Array:
    """Velocities (m, ndim, ...) of a unit motion along each axis and a unit spin about each."""
    count = len(points) + len(pose.spin)
    modes = np.zeros((count, *points.shape), points.dtype)
    for axis, mode in enumerate(modes):
        put_mode(mode, axis, points, pose)
    return modes


def put_mode(mode: Array, axis: int, points: Array, pose: Pose) -> None:
    """Fill zeros (ndim, ...) with the unit motion along one coordinate, m = ndim + spins of them.

    A unit spin about an axis: its cross product with the arm from the centre.
    """
    ndim = len(points)
    if axis < ndim:
        mode[axis] = 1.0
        return
    i, j = (0, 1) if ndim == 2 else ((axis - ndim + 1) % 3, (axis - ndim + 2) % 3)
    mode[i] = pose.center[j] - points[j]
    mode[j] = points[i] - pose.center[i]
