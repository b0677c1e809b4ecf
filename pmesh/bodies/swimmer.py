"""A swimmer: a body that bends by a law of time and moves as the fluid makes it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from levelset.measure import Measure
from pmesh.bodies import bent as shapes
from pmesh.bodies import midline as midlines
from pmesh.bodies.bent import Scaled
from pmesh.bodies.body import Bounds, Inertia, check_free, check_motion, launched
from pmesh.bodies.gait import Gait, Section, Shape, check, shape, straight
from pmesh.bodies.hull import AROUND, hull
from pmesh.bodies.midline import Midline
from pmesh.bodies.motion import Free, Motion
from pmesh.bodies.outline import Eel, Foil, Larva, Outline
from pmesh.bodies.pose import Pose, still
from pmesh.bodies.profile import Arch, Profile
from pmesh.bodies.turning import quaternion, rotation_vector
from remesh.errors import InputError, as_number

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
FREE = Free(density=1.0)


@dataclass(frozen=True, kw_only=True)
class Swimmer:
    """A body with a midline that bends and a half-width: ``Swimmer.carling(length=1.0)``.

    ``profile``: its half-height, for a swimmer in space with elliptic sections, which bends in the
    plane z = 0 of its own axes. ``position``: of its centre of mass at time 0 [L]; ``heading``:
    turned by [rad], at 0 the head points to -x and it swims that way; in space about z, or else
    ``orientation``, a rotation vector [rad]. ``samples``: of the midline, the outline has twice as
    many; ``section``: see ``Gait``. Its deformation has no momentum and no angular momentum, to
    1e-12. Refuses bends so sharp that a section across the body would fold over.
    """

    midline: Midline
    outline: Outline
    length: float = 1.0
    period: float = 1.0
    position: tuple[float, ...] = ()
    heading: float = 0.0
    orientation: tuple[float, ...] = ()
    motion: Motion = field(default=FREE)
    samples: int = 400
    section: Section = "incompressible"
    profile: Profile | None = None

    def __post_init__(self) -> None:
        """Refuse values that make no swimmer."""
        parts = [("midline", "bending", "CARLING"), ("outline", "half_width", "Eel()")]
        if self.profile is not None:
            parts.append(("profile", "half_height", "Arch()"))
        for name, law, example in parts:
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
        self._check_place()
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
        if isinstance(self.motion, Free):
            check_free(self.motion, self.ndim)
        check(self.gait)

    def _check_place(self) -> None:
        """Refuse places and turns that are none, or of another dimension."""
        place = _numbers("position", self.position) or (0.0,) * self.ndim
        (heading,), turn = (
            _numbers("heading", (self.heading,)),
            _numbers("orientation", self.orientation),
        )
        if len(place) != self.ndim or not all(map(math.isfinite, (*place, heading))):
            axes = ", ".join(("x", "y", "z")[: self.ndim])
            raise InputError(
                f"this Swimmer needs a finite position ({axes}) and heading, got {place}, "
                f"{heading:g}",
                hint=f"position={(0.0,) * self.ndim}, heading=0.0",
            )
        allowed = self.ndim == 3 and len(turn) == 3 and heading == 0.0
        if turn and not (allowed and all(map(math.isfinite, turn))):
            raise InputError(
                f"the orientation of a Swimmer is a rotation vector in space, instead of a "
                f"heading, got {turn} and the heading {heading:g}",
                hint="profile=Arch(), orientation=(0.0, 0.0, 1.0)",
            )
        for name, value in (("position", place), ("heading", heading), ("orientation", turn)):
            object.__setattr__(self, name, value)

    @classmethod
    def carling(
        cls, *, length: float = 1.0, period: float = 1.0, ndim: int = 2, **more: Any
    ) -> Swimmer:
        """The anguilliform swimmer: Carling's wave, the outline of Kern and Koumoutsakos.

        ``more``: ``position``, ``heading``, ``motion``, ``samples``, ``section``, and ``start``,
        ``ramp``, ``phase`` of the wave. At nu = 1.4e-4 L^2/T its published speed is about
        0.54 L/T in the plane, 0.40 L/T in space (Kern and Koumoutsakos 2006, not read again).
        """
        return _wave(cls, midlines.CARLING, length, period, _eel(ndim) | more)

    @classmethod
    def anguilliform(
        cls, *, length: float = 1.0, period: float = 1.0, ndim: int = 2, **more: Any
    ) -> Swimmer:
        """The same with the backbone 0.1 (s + 0.25) of Koumoutsakos' lecture on particle methods.

        The tail's amplitude is that of Carling's, the head's seven times as large.
        """
        return _wave(cls, midlines.ANGUILLIFORM, length, period, _eel(ndim) | more)

    @classmethod
    def carangiform(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """A swimmer that moves its tail most: the wave of Maertens et al., a NACA 0012 outline."""
        return _wave(cls, midlines.CARANGIFORM, length, period, {"outline": Foil()} | more)

    @classmethod
    def cstart(cls, *, length: float = 1.0, period: float = 1.0, **more: Any) -> Swimmer:
        """A larva that escapes: bends into a C for 0.7 periods, then swims (Gazzola 2012)."""
        more.setdefault("outline", Larva())
        return cls(midline=midlines.CSTART, length=length, period=period, **more)

    @property
    def gait(self) -> Gait:
        """Its shape as a law of time, in body lengths and periods; swimmers alike share it."""
        return Gait(
            midline=self.midline,
            outline=self.outline,
            samples=self.samples,
            section=self.section,
            profile=self.profile,
        )

    @property
    def ndim(self) -> int:
        """Three with a profile, else two."""
        return 2 if self.profile is None else 3

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
        """Volume, centre (the origin of its own axes) and the straight body's polar moment."""
        volume, _, inertia = straight(self.gait)
        L, n = self.length, self.ndim
        return Measure(volume=volume * L**n, center=(0.0,) * n, inertia=inertia * L ** (n + 2))

    def inertia_at(self, time: float) -> float:
        """Second moment [L^(ndim+2)] about the axis z through the centre of mass, at a time."""
        return self._shape(time).inertia * self.length ** (self.ndim + 2)

    def inertia(self, pose: Pose) -> Inertia:
        """Polar moment [L^4] about the centre of mass, in space the tensor: less when bent."""
        return shapes.inertia(self._scaled, pose)

    def placed(self) -> Pose:
        """Where it was put, at rest."""
        turn = self.orientation or (0.0,) * (2 * self.ndim - 4) + (self.heading,)
        if math.hypot(*turn) > math.pi and self.ndim == 3:
            turn = rotation_vector(quaternion(turn))
        return replace(still(self.position), angle=turn)

    def start(self) -> Pose:
        """There too, but for its motion at time 0: a law's own place, a free body's velocity."""
        return launched(self.placed(), self.motion)

    def bounds(self, pose: Pose) -> Bounds:
        """Lower and upper corner of a box that holds the body [L]."""
        return shapes.box(self._scaled, pose)

    def outline_points(self, pose: Pose) -> Values:
        """The contour (n, ndim) [L], closed, anticlockwise from the nose; not to be written to.

        In space that of its section along the plane in which it bends.
        """
        return shapes.seen(shapes.bent(self._scaled, pose).ring, self._scaled, pose)

    def outlines(self, pose: Pose, step: float) -> list[Array]:
        """The outline as the one closed line; its points are those of ``samples``."""
        if self.ndim != 2:
            raise InputError(
                "outlines are of plane bodies, this swimmer is one in space",
                hint="surface(pose)",
            )
        return [self.outline_points(pose)]

    def surface(self, pose: Pose, around: int = AROUND) -> tuple[Values, NDArray[np.int64]]:
        """Vertices (n, 3) [L] and triangles (m, 3) of a body in space: see ``hull``."""
        if self.ndim != 3:
            raise InputError("surfaces are of bodies in space", hint="outline_points(pose)")
        vertices, faces = hull(self.gait, self._shape(pose.time), around)
        return np.asarray(pose.placed(vertices.T * self.length).T, np.float64), faces

    def midline_points(self, pose: Pose) -> Values:
        """The midline (m, ndim) [L] from head to tail; not to be written to."""
        return shapes.seen(shapes.bent(self._scaled, pose).line, self._scaled, pose)

    def distance(self, points: Array, pose: Pose) -> Array:
        """Signed distance [L], negative inside, at ``points`` (ndim, ...).

        In the plane exact for the contour, which is within 2e-5 L of the smooth one at 400
        samples. In space, for Carling's bends, within 5e-4 L up to 0.05 L outside, 7e-4 L on the
        surface and 2e-3 L to 0.02 L inside, 3e-5 L in the mean; within a tenth farther out.
        """
        return shapes.distance(self._scaled, points, pose)

    def deformation(self, points: Array, pose: Pose) -> Array | None:
        """Velocity [L/T] of its matter beyond the rigid motion at ``points``, in world axes.

        With s and rho the place and the offset of the nearest point of the midline m(s),
        ``m_t - rho theta_t t + g n``, where an incompressible section moves its pieces by
        g = kappa_t rho^2 / (2 (1 - kappa rho)) and a rigid one by none: in space the same at all
        heights, and nothing along the height. Goes on outside by the same law for 0.05 L, then
        stays.
        """
        velocity, _ = shapes.matter(self._scaled, points, pose, self.solenoidal)
        return np.asarray(velocity, points.dtype)

    def divergence(self, points: Array, pose: Pose) -> Array | None:
        """Divergence [1/T] of that velocity; None for incompressible sections: it is zero.

        A rigid section has -kappa_t rho / (1 - kappa rho), of which the integral over the body
        is zero. Goes on outside: meant to be multiplied with the body's indicator.
        """
        if self.solenoidal:
            return None
        _, source = shapes.matter(self._scaled, points, pose, self.solenoidal)
        return np.asarray(source, points.dtype)

    @property
    def _scaled(self) -> Scaled:
        return Scaled(self.gait, self.length, self.period)

    def _shape(self, time: float) -> Shape:
        return shape(self.gait, time / self.period)


def _wave(
    cls: type[Swimmer], wave: midlines.Wave, length: float, period: float, more: dict[str, Any]
) -> Swimmer:
    """A swimmer with a wave of which the start, ramp and phase may be given."""
    own = {name: more.pop(name) for name in ("start", "ramp", "phase") if name in more}
    return cls(midline=replace(wave, **own), length=length, period=period, **more)


def _eel(ndim: int) -> dict[str, Any]:
    """Outline and profile of the anguilliform swimmer."""
    if ndim not in (2, 3):
        raise InputError(f"a swimmer has 2 or 3 dimensions, got {ndim!r}", hint="ndim=3")
    return {"outline": Eel()} if ndim == 2 else {"outline": Eel(exponent=2.0), "profile": Arch()}


def _numbers(name: str, given: object) -> tuple[float, ...]:
    """One number or several."""
    values = given if isinstance(given, Iterable) else (given,)
    return tuple(as_number(f"Swimmer {name}", x, hint="0.0") for x in values)
