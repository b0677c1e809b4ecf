"""Bodies in a flow: where they are, how they move, what they weigh."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from levelset.contour import contour, even
from levelset.measure import Measure, measure
from levelset.second import second_moments
from levelset.shape import Shape, rotation, seen_from
from levelset.support import turned_box
from pmesh.bodies.motion import Fixed, Free, Motion, Prescribed, coordinates
from pmesh.bodies.pose import Pose, still
from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
CELLS = 256  # of the mesh from which an outline is drawn, at least
Bounds = tuple[tuple[float, ...], tuple[float, ...]]
Inertia = float | NDArray[np.float64]


class Body(Protocol):
    """What a flow asks of a body: its distance, its velocity, its motion and its mass.

    A value: equal bodies are the same body, so it must be hashable (a frozen dataclass).
    """

    def __hash__(self) -> int:
        """Equal bodies have equal hashes."""

    @property
    def ndim(self) -> int:
        """Number of dimensions."""

    @property
    def motion(self) -> Motion:
        """Fixed, Prescribed or Free."""

    @property
    def deforming(self) -> bool:
        """Whether its shape is a law of the time."""

    @property
    def solenoidal(self) -> bool:
        """Whether its deformation has no divergence."""

    @property
    def period(self) -> float:
        """Time over which its deformation changes [T]; infinite for a rigid body."""

    @property
    def length(self) -> float:
        """Its size [L], in which domains are given."""

    @property
    def measure(self) -> Measure:
        """Volume, centre and second moments, in its own axes."""

    def placed(self) -> Pose:
        """Where it was put at time 0, at rest: what laws of motion count from."""

    def start(self) -> Pose:
        """Where it is at time 0, as its motion has it there."""

    def inertia(self, pose: Pose) -> Inertia:
        """Polar second moment about its centre, now [L^(ndim+2)]; in space the inertia tensor.

        The tensor ``int (|r|^2 I - r r^T) dV``, (3, 3), in world axes.
        """

    def bounds(self, pose: Pose) -> Bounds:
        """Lower and upper corner of a box that holds the body [L]."""

    def distance(self, points: Array, pose: Pose) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...)."""

    def deformation(self, points: Array, pose: Pose) -> Array | None:
        """Velocity [L/T] of its matter beyond the rigid motion, (ndim, ...); None if rigid."""

    def divergence(self, points: Array, pose: Pose) -> Array | None:
        """Divergence [1/T] of that velocity inside the body; None if it is solenoidal."""

    def outlines(self, pose: Pose, step: float) -> list[Array]:
        """Closed lines (n, 2) around a plane body, anticlockwise, points about ``step`` [L] apart.

        The same points of matter at every pose.
        """


@dataclass(frozen=True)
class RigidBody:
    """A solid of a given shape: ``RigidBody(levelset.shapes.Disk(radius=0.5), motion=Fixed())``.

    ``motion``: ``Fixed()``, ``Prescribed(...)`` or ``Free(density=...)``. A solid from a file:
    ``RigidBody(levelset.shapes.TriangleMesh.from_file("body.stl").moved((x, y, z)))``, whose closed
    surface tells distance, volume and inertia exactly. Refuses what is no shape or no motion, and
    free motions with vectors or locks of another dimension.
    """

    shape: Shape
    motion: Motion = field(default=Fixed(), kw_only=True)

    def __post_init__(self) -> None:
        """Refuse what is not a shape or not a motion."""
        if not isinstance(self.shape, Shape):
            raise InputError(
                f"a RigidBody needs a shape, got {type(self.shape).__name__}",
                hint="levelset.shapes.Disk(radius=0.5)",
            )
        check_motion(self.motion)
        if isinstance(self.motion, Free):
            check_free(self.motion, self.shape.ndim)

    @property
    def ndim(self) -> int:
        """Number of dimensions of the shape."""
        return self.shape.ndim

    @property
    def deforming(self) -> bool:
        """False: it is rigid."""
        return False

    @property
    def solenoidal(self) -> bool:
        """True: it is rigid."""
        return True

    @property
    def period(self) -> float:
        """Infinite: it is rigid."""
        return math.inf

    @property
    def length(self) -> float:
        """Its longest extent along an axis [L]."""
        return max(b - a for a, b in zip(*self.shape.bounds(), strict=True))

    @property
    def measure(self) -> Measure:
        """Volume, centre and second moments of the shape."""
        return measure(self.shape)

    def placed(self) -> Pose:
        """Where the shape was put, at rest."""
        return still(self.measure.center)

    def start(self) -> Pose:
        """There too, but for its motion at time 0: a law's own place, a free body's velocity."""
        return launched(self.placed(), self.motion)

    def inertia(self, pose: Pose) -> Inertia:
        """That of the measure: it is rigid; in space the tensor, turned with it."""
        if self.ndim == 2:
            return self.measure.inertia
        second, turn = second_moments(self.shape), rotation(pose.angle)
        return np.asarray(np.trace(second) * np.eye(3) - turn @ second @ turn.T)

    def bounds(self, pose: Pose) -> Bounds:
        """Lower and upper corner of a box that holds the body [L], tight in space."""
        placed = self._placed(pose)
        return placed.bounds() if self.ndim == 2 or placed is self.shape else turned_box(placed)

    def distance(self, points: Array, pose: Pose) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...)."""
        center = self.measure.center
        if pose.center == center and not any(pose.angle):
            return self.shape.distance(points)
        return self.shape.distance(seen_from(pose.seen(points), tuple(-x for x in center)))

    def deformation(self, points: Array, pose: Pose) -> Array | None:
        """None: it is rigid."""
        return None

    def divergence(self, points: Array, pose: Pose) -> Array | None:
        """None: it is rigid."""
        return None

    def outlines(self, pose: Pose, step: float) -> list[Array]:
        """Closed lines (n, 2) around a plane shape, anticlockwise, points ``step`` [L] apart."""
        return [pose.placed(line.T).T for line in _rings(self.shape, step)]

    def _placed(self, pose: Pose) -> Shape:
        center = self.measure.center
        if pose.center == center and not any(pose.angle):
            return self.shape
        if not any(pose.angle):
            return self.shape.moved([a - b for a, b in zip(pose.center, center, strict=True)])
        return self.shape.moved([-c for c in center]).moved(pose.center, pose.angle)


@lru_cache(maxsize=64)
def _rings(shape: Shape, step: float) -> tuple[Array, ...]:
    """Outlines of a shape seen from its centre."""
    low, high = shape.bounds()
    cells = max(CELLS, math.ceil(max(np.subtract(high, low)) / step))
    return tuple(even(line - measure(shape).center, step) for line in contour(shape, cells=cells))


def matter_velocity(body: Body, points: Array, pose: Pose) -> Array:
    """Velocity [L/T] of a body's matter at ``points`` (ndim, ...): rigid motion and deformation."""
    rigid, change = pose.rigid(points), body.deformation(points, pose)
    return rigid if change is None else rigid + change


def check_motion(motion: object) -> None:
    """Refuse what is not a motion."""
    if not isinstance(motion, Fixed | Prescribed | Free):
        raise InputError(
            f"motion must be Fixed(), Prescribed(...) or Free(...), got {motion!r}",
            hint="motion=pmesh.Fixed()",
        )


def check_free(motion: Free, ndim: int) -> None:
    """Refuse vectors of another dimension than the body, and locks on what it has not."""
    spring, turns = motion.spring, len(coordinates(ndim)) - ndim
    vectors = {"velocity": motion.velocity, "gravity": motion.gravity}
    if spring is not None:
        vectors |= {"spring stiffness": spring.stiffness, "spring damping": spring.damping}
    for name, vector in vectors.items():
        if len(vector) not in (0, ndim):
            raise InputError(
                f"Free {name} must have {ndim} components, got {vector}", hint=f"{(0.0,) * ndim}"
            )
    if motion.spin != 0.0 and len(_spin(motion)) != turns:
        raise InputError(
            f"Free spin must be {'a number' if turns == 1 else '3 numbers'} in {ndim} dimensions, "
            f"got {motion.spin}",
            hint="spin=0.0" if turns == 1 else "spin=(0.0, 0.0, 1.0)",
        )
    for name in motion.locked:
        if name not in coordinates(ndim):
            raise InputError(
                f'Free locks "{name}" of a body in {ndim} dimensions',
                hint=f"names among {', '.join(coordinates(ndim))}",
            )


def _spin(motion: Free) -> tuple[float, ...]:
    return motion.spin if isinstance(motion.spin, tuple) else (motion.spin,)


def launched(pose: Pose, motion: Motion) -> Pose:
    """A pose at its motion's first instant; refuses vectors of another dimension."""
    if isinstance(motion, Free):
        check_free(motion, len(pose.center))
        return Pose(
            time=pose.time,
            center=pose.center,
            angle=pose.angle,
            velocity=motion.velocity or pose.velocity,
            spin=_spin(motion) if motion.spin != 0.0 else pose.spin,
        )
    return motion.pose(pose, pose.time)
