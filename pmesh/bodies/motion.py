"""How a body moves: held, led by a law of time, or free in the fluid."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from pmesh.bodies.pose import Pose
from pmesh.bodies.turning import turn_between, turned_on
from remesh.errors import InputError, as_number

Law = Callable[[float], Sequence[float] | float]
PLANE = ("x", "y", "angle")  # coordinates of a body
SPACE = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))  # of a derivative, order 4
Name = Literal["x", "y", "z", "angle", "turn_x", "turn_y", "turn_z"]
NUDGE = 1e-3  # of its steps, in units of the law's own scale of time


def coordinates(ndim: int) -> tuple[str, ...]:
    """The coordinates of a body; turns in space are about the axes of the world."""
    return PLANE if ndim == 2 else SPACE


@dataclass(frozen=True)
class Fixed:
    """No motion."""

    moving: ClassVar[bool] = False

    def pose(self, start: Pose, time: float) -> Pose:
        """The place at a time: always the start."""
        return replace(start, time=time)


@dataclass(frozen=True, kw_only=True)
class Prescribed:
    """A motion given as laws of time.

    ``shift(t)``: of the centre from where the body was placed [L]; ``angle(t)``: turned by [rad],
    in space a rotation vector in world axes. ``velocity`` and ``spin`` are their derivatives, in
    space the angular velocity in world axes; if not given they are differences of order four over
    steps of 1e-3 ``scale`` [T], the time over which the laws change. Before t = 0 the body rests:
    a velocity at t = 0 is an impulsive start.
    """

    shift: Law | None = None
    angle: Law | None = None
    velocity: Law | None = None
    spin: Law | None = None
    scale: float = 1.0

    moving: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Refuse laws that cannot be called."""
        for name in ("shift", "angle", "velocity", "spin"):
            law = getattr(self, name)
            if law is not None and not callable(law):
                raise InputError(
                    f"Prescribed {name} must be a function of time, got {law!r}",
                    hint=f"{name}=lambda t: ...",
                )
        _positive("Prescribed scale", self.scale)

    def pose(self, start: Pose, time: float) -> Pose:
        """The place and velocity at a time; refuses laws of the wrong length or not finite."""
        n, turns = len(start.center), len(start.angle)
        shift = _told("shift", self.shift, time, n)
        angle = _told("angle", self.angle, time, turns)
        return Pose(
            time=time,
            center=tuple(a + b for a, b in zip(start.center, shift, strict=True)),
            angle=turned_on(start.angle, angle),
            velocity=self._rate("velocity", self.velocity, self.shift, time, n),
            spin=self._rate("spin", self.spin, self.angle, time, turns),
        )

    def _rate(
        self, name: str, rate: Law | None, law: Law | None, time: float, count: int
    ) -> tuple[float, ...]:
        """A given rate, or the differences of its law: of turns from now, as turns add up so."""
        if rate is not None or law is None:
            return _told(name, rate, time, count)
        step = NUDGE * self.scale
        told = [_told(name, law, time + k * step, count) for k, _ in STENCIL]
        if name == "spin" and count == 3:
            now = _told(name, law, time, count)
            told = [turn_between(now, turn) for turn in told]
        parts = [np.multiply(w, value) for (_, w), value in zip(STENCIL, told, strict=True)]
        return tuple(float(x) for x in np.sum(parts, axis=0) / step)


@dataclass(frozen=True, kw_only=True)
class Spring:
    """Springs and dampers that hold a free body to where it was placed, per unit fluid density.

    Force ``-stiffness * shift - damping * velocity`` along each axis [L^ndim/T^2 and L^ndim/T],
    torque ``-torsion * angle - twist_damping * spin``, in space with the rotation vector: that has
    the energy ``torsion |angle|^2 / 2``. Refuses numbers that are negative or not finite: they
    would feed the motion.
    """

    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()
    torsion: float = 0.0
    twist_damping: float = 0.0

    def __post_init__(self) -> None:
        """Refuse negative numbers, and what are none."""
        for name in ("stiffness", "damping"):
            given = tuple(_numbers(f"Spring {name}", getattr(self, name), "(1.0, 1.0)"))
            object.__setattr__(self, name, given)
        for name in ("torsion", "twist_damping"):
            (value,) = _numbers(f"Spring {name}", (getattr(self, name),), "1.0")
            object.__setattr__(self, name, value)
        lowest = min((*self.stiffness, *self.damping, self.torsion, self.twist_damping))
        if lowest < 0:
            raise InputError(
                f"Spring constants must not be negative, got {lowest:g}",
                hint="stiffness=(1.0, 1.0)",
            )


@dataclass(frozen=True, kw_only=True)
class Free:
    """Motion that follows from the forces of the fluid, gravity and springs.

    ``density``: of the body over the fluid's, 1 is neutrally buoyant, less is a light body;
    ``gravity`` [L/T^2] acts on the difference; ``velocity`` and ``spin``: at the start, the spin a
    number in the plane, three in space; ``locked``: what cannot move, of "x", "y", "angle" (a
    tethered swimmer: ``("x",)``), in space of "x", "y", "z", "turn_x", "turn_y", "turn_z".
    """

    density: float = 1.0
    gravity: tuple[float, ...] = ()
    spring: Spring | None = None
    velocity: tuple[float, ...] = ()
    spin: float | tuple[float, ...] = 0.0
    locked: tuple[Name, ...] = ()

    moving: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Refuse a density that is not positive, and numbers that are none."""
        _positive("Free density", self.density)
        for name in ("gravity", "velocity"):
            given = tuple(_numbers(f"Free {name}", getattr(self, name), "(0.0, -1.0)"))
            object.__setattr__(self, name, given)
        alone = not isinstance(self.spin, Sequence | np.ndarray)
        spin = _numbers("Free spin", (self.spin,) if alone else self.spin, "0.0")  # type: ignore[arg-type]
        object.__setattr__(self, "spin", spin[0] if alone else tuple(spin))
        if self.spring is not None and not isinstance(self.spring, Spring):
            raise InputError(
                f"Free spring must be a Spring, got {self.spring!r}",
                hint="spring=Spring(stiffness=(1.0, 1.0))",
            )
        self._check_locked()

    def _check_locked(self) -> None:
        """Refuse locks that are no names of coordinates, or on what is given a velocity."""
        locked = self.locked
        if not isinstance(locked, tuple | list) or not any(
            all(name in names for name in locked) for names in (PLANE, SPACE)
        ):
            raise InputError(
                'Free locked must hold names among "x", "y", "angle", in space "x", "y", "z", '
                f'"turn_x", "turn_y", "turn_z", got {locked!r}',
                hint='locked=("x", "y")',
            )
        object.__setattr__(self, "locked", tuple(locked))
        speeds = dict(zip(("x", "y", "z"), self.velocity, strict=False))
        if isinstance(self.spin, tuple):
            speeds |= dict(zip(SPACE[3:], self.spin, strict=False))
        else:
            speeds["angle"] = self.spin
        for name in locked:
            if speeds.get(name, 0.0) != 0.0:
                raise InputError(
                    f'Free locks "{name}" and gives it the velocity {speeds[name]:g}',
                    hint="a velocity of zero there, or no lock",
                )


Motion = Fixed | Prescribed | Free


def _told(name: str, law: Law | None, time: float, count: int) -> tuple[float, ...]:
    """What a law says at a time, as plain floats; zeros for no law."""
    if law is None:
        return (0.0,) * count
    values = tuple(float(x) for x in np.ravel(np.asarray(law(time), np.float64)))
    if len(values) != count or not all(map(math.isfinite, values)):
        raise InputError(
            f"Prescribed {name} must give {count} finite numbers, gave {values} at t = {time:g}",
            hint=f"{name}=lambda t: {(0.0,) * count if count > 1 else 0.0}",
        )
    return values


def _numbers(name: str, given: Sequence[float], hint: str) -> list[float]:
    """The given numbers as plain floats; refuses what is no sequence of finite ones."""
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str):
        raise InputError(f"{name} must be numbers, one along each axis, got {given!r}", hint=hint)
    values = [as_number(name, x, hint=hint) for x in given]
    if not all(map(math.isfinite, values)):
        raise InputError(f"{name} must be finite, got {tuple(values)}", hint=hint)
    return values


def _positive(name: str, given: object) -> None:
    value = as_number(name, given, hint="1.0")
    if not (math.isfinite(value) and value > 0):
        raise InputError(f"{name} must be positive, got {value:g}", hint="1.0")
