"""A swimmer in the plane: a body that bends by a law of time and moves as the fluid makes it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.measure import Measure
from levelset.shape import rotation
from pmesh.bodies import midline as midlines
from pmesh.bodies.body import Bounds, check_motion, launched
from pmesh.bodies.gait import Gait, Section, Shape, check, shape, straight
from pmesh.bodies.midline import Midline
from pmesh.bodies.motion import Free, Motion
from pmesh.bodies.outline import Eel, Foil, Larva, Outline
from pmesh.bodies.pose import Pose, still
from remesh.errors import InputError, as_number

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
MARGIN = 0.05  # [L] beyond the outline up to which the velocity follows its law, then stays
FREE = Free(density=1.0)


class _Placed(NamedTuple):
    """The body at a pose, in world axes and the user's units."""

    shape: Shape
    line: Values  # (m, 2) midline
    angle: Values  # (m,)
    velocity: Values  # (m, 2)
    ring: Values  # (n, 2)


@dataclass(frozen=True, kw_only=True)
class Swimmer:
    """A body with a midline that bends and a half-width: ``Swimmer.carling(length=1.0)``.

    ``position``: of its centre of mass at time 0 [L]; ``heading``: turned by [rad], at 0 the head
    points to -x and it swims that way; ``samples``: of the midline, the outline has twice as many;
    ``section``: see ``Gait``. Its deformation has no momentum and no angular momentum, to 1e-12.
    Refuses bends so sharp that a section across the body would fold over.
    """

    midline: Midline
    outline: Outline
    length: float = 1.0
    period: float = 1.0
    position: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    motion: Motion = field(default=FREE)
    samples: int = 400
    section: Section = "incompressible"

    def __post_init__(self) -> None:
        """Refuse values that make no swimmer."""
        for name, law, example in (
            ("midline", "bending", "CARLING"),
            ("outline", "half_width", "Eel()"),
        ):
            if not hasattr(getattr(self, name), law):
                raise InputError(
                    f"a Swimmer needs a {name}, got {getattr(self, name)!r}",
                    hint=f"pmesh.bodies.{name}.{example}",
                )
        for name in ("length", "period"):
            value = as_number(f"Swimmer {name}", getattr(self, name), hint="1.0")
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"Swimmer {name} must be positive, got {value:g}", hint="1.0")
            object.__setattr__(self, name, value)
        given = self.position if isinstance(self.position, Iterable) else (self.position,)
        place = tuple(as_number("Swimmer position", x, hint="0.0") for x in given)
        heading = as_number("Swimmer heading", self.heading, hint="0.0")
        if len(place) != 2 or not all(map(math.isfinite, (*place, heading))):
            raise InputError(
                f"a Swimmer needs a finite position (x, y) and heading, got {place}, {heading:g}",
                hint="position=(0.0, 0.0), heading=0.0",
            )
        object.__setattr__(self, "position", place)
        object.__setattr__(self, "heading", heading)
        samples = as_number("Swimmer samples", self.samples, hint="samples=400")
        if not 50 <= samples <= 20_000 or samples % 1:
            raise InputError(
                f"Swimmer samples must be a whole number from 50 to 20000, got {samples:g}",
                hint="samples=400",
            )
        if self.section not in ("incompressible", "rigid"):
            raise InputError(
                f"unknown section {self.section!r}", hint='section="incompressible" or "rigid"'
            )
        check_motion(self.motion)
        check(self.gait)

    @classmethod
    def carling(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """The anguilliform swimmer: Carling's wave, the outline of Kern and Koumoutsakos.

        ``more``: ``position``, ``heading``, ``motion``, ``samples``, ``section``, and ``start``,
        ``ramp``, ``phase`` of the wave. At nu = 1.4e-4 L^2/T its published speed is about
        0.54 L/T (Kern and Koumoutsakos 2006, not read again).
        """
        return _wave(cls, midlines.CARLING, Eel(), length, period, more)

    @classmethod
    def anguilliform(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """The same with the backbone 0.1 (s + 0.25) of Koumoutsakos' lecture on particle methods.

        The tail's amplitude is that of Carling's, the head's seven times as large.
        """
        return _wave(cls, midlines.ANGUILLIFORM, Eel(), length, period, more)

    @classmethod
    def carangiform(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """A swimmer that moves its tail most: the wave of Maertens et al., a NACA 0012 outline."""
        return _wave(cls, midlines.CARANGIFORM, Foil(), length, period, more)

    @classmethod
    def cstart(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """A larva that escapes: bends into a C for 0.7 periods, then swims (Gazzola 2012)."""
        more.setdefault("outline", Larva())
        return cls(midline=midlines.CSTART, length=length, period=period, **more)

    @property
    def gait(self) -> Gait:
        """Its shape as a law of time, in body lengths and periods; swimmers alike share it."""
        return Gait(
            midline=self.midline, outline=self.outline, samples=self.samples, section=self.section
        )

    @property
    def ndim(self) -> int:
        """Two."""
        return 2

    @property
    def deforming(self) -> bool:
        """True: its shape is a law of the time."""
        return True

    @property
    def solenoidal(self) -> bool:
        """Whether its deformation has no divergence: with incompressible sections."""
        return self.section == "incompressible"

    @property
    def measure(self) -> Measure:
        """Area, centre (the origin of its own axes) and the straight body's polar moment."""
        area, _, inertia = straight(self.gait)
        L = self.length
        return Measure(volume=area * L**2, center=(0.0, 0.0), inertia=inertia * L**4)

    def inertia_at(self, time: float) -> float:
        """Polar moment [L^4] about the centre of mass at a time."""
        return self._shape(time).inertia * self.length**4

    def placed(self) -> Pose:
        """Where it was put, at rest."""
        return replace(still(self.position), angle=(self.heading,))

    def inertia(self, pose: Pose) -> float:
        """Polar moment [L^4] about the centre of mass: it is less when bent."""
        return self.inertia_at(pose.time)

    def start(self) -> Pose:
        """There too, but for its motion at time 0: a law's own place, a free body's velocity."""
        return launched(self.placed(), self.motion)

    def bounds(self, pose: Pose) -> Bounds:
        """Lower and upper corner of a box that holds the body [L]."""
        ring = self.outline_points(pose)
        low, high = ring.min(axis=0), ring.max(axis=0)
        return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))

    def outline_points(self, pose: Pose) -> Values:
        """The contour (n, 2) [L], closed, anticlockwise from the nose; not to be written to."""
        return _placed(self, pose).ring

    def outlines(self, pose: Pose, step: float) -> list[Array]:
        """The outline as the one closed line; its points are those of ``samples``."""
        return [self.outline_points(pose)]

    def midline_points(self, pose: Pose) -> Values:
        """The midline (m, 2) [L] from head to tail; not to be written to."""
        return _placed(self, pose).line

    def distance(self, points: Array, pose: Pose) -> Array:
        """Signed distance [L], negative inside, at ``points`` (2, ...): exact for the contour,
        which is within 2e-5 L of the smooth one at 400 samples.
        """
        from pmesh.bodies._swimmer import ring_distance

        flat, result = _flat(points), np.empty(points[0].size, points.dtype)
        ring = self.outline_points(pose)
        ring = np.concatenate((ring, ring[:1]))
        ring_distance(flat, ring, result)
        return result.reshape(points.shape[1:])

    def deformation(self, points: Array, pose: Pose) -> Array | None:
        """Velocity [L/T] of its matter beyond the rigid motion at ``points`` (2, ...), world axes.

        With s and rho the place and the offset of the nearest point of the midline m(s),
        ``m_t - rho theta_t t + g n``, where an incompressible section moves its pieces by
        g = kappa_t rho^2 / (2 (1 - kappa rho)) and a rigid one by none. Goes on outside by the same
        law for 0.05 L, then stays.
        """
        return np.asarray(self._matter(points, pose)[:2], points.dtype)

    def divergence(self, points: Array, pose: Pose) -> Array | None:
        """Divergence [1/T] of that velocity; None for incompressible sections: it is zero.

        A rigid section has -kappa_t rho / (1 - kappa rho), of which the integral over the body
        is zero. Goes on outside: meant to be multiplied with the body's indicator.
        """
        if self.solenoidal:
            return None
        return np.asarray(self._matter(points, pose)[2], points.dtype)

    def _matter(self, points: Array, pose: Pose) -> Values:
        from pmesh.bodies._swimmer import matter

        now, L, T = _placed(self, pose), self.length, self.period
        result = np.empty((3, points[0].size))
        body = now.shape
        matter(
            _flat(points),
            body.stations * L,
            now.line,
            now.angle,
            now.velocity,
            body.spin / T,
            body.curvature / L,
            body.rate / (L * T),
            body.below * L,
            body.above * L,
            MARGIN * L,
            self.solenoidal,
            result,
        )
        return result.reshape(3, *points.shape[1:])

    def _shape(self, time: float) -> Shape:
        return shape(self.gait, time / self.period)


def _wave(
    cls: type[Swimmer],
    wave: midlines.Wave,
    outline: Outline,
    length: float,
    period: float,
    more: dict[str, Any],
) -> Swimmer:
    """A swimmer with a wave of which the start, ramp and phase may be given."""
    own = {name: more.pop(name) for name in ("start", "ramp", "phase") if name in more}
    more.setdefault("outline", outline)
    return cls(midline=replace(wave, **own), length=length, period=period, **more)


@lru_cache(maxsize=256)
def _placed(swimmer: Swimmer, pose: Pose) -> _Placed:
    """The body at a pose, in world axes."""
    body, L = swimmer._shape(pose.time), swimmer.length
    turn = rotation(pose.angle).T
    center = np.asarray(pose.center)
    return _Placed(
        shape=body,
        line=body.place @ turn * L + center,
        angle=body.angle + pose.angle[0],
        velocity=body.velocity @ turn * (L / swimmer.period),
        ring=body.ring @ turn * L + center,
    )


def _flat(points: Array) -> Array:
    """Points as (2, n)."""
    if points.shape[0] != 2:
        raise InputError(
            f"a swimmer is seen at points (2, ...), got {points.shape}", hint="grid.points()"
        )
    return np.ascontiguousarray(points.reshape(2, -1))
