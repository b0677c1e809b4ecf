"""How the midline of a swimmer bends: its curvature as a law of place and time.

Places are in body lengths from the head, times in periods, curvatures in inverse body lengths.
A midline given by its curvature cannot stretch; the way from head to tail is +x when straight, so
that the swimmer goes towards -x, and positive curvature turns the tail to the left of that way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]
STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))  # of a derivative, order 4
NUDGE = 5e-4  # [periods], its step


class Bending(NamedTuple):
    """Curvature [1/L] and its rate [1/(L T)] along the midline, and the head's angle and rate."""

    curvature: Values
    rate: Values
    head: float = 0.0
    head_rate: float = 0.0


class Midline(Protocol):
    """What a swimmer asks of its midline. A value: it must be hashable (a frozen dataclass)."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Places [L] between which the curvature is smooth."""

    @property
    def times(self) -> tuple[float, ...]:
        """Times [T] between which it is smooth; after the last one it repeats every period."""

    def bending(self, s: Values, time: float) -> Bending:
        """Its curvature at places ``s`` [L] and a time >= 0 [T]."""

    def __hash__(self) -> int:
        """Of its values."""


def ramp(kind: str, time: float, over: float) -> tuple[float, float]:
    """How far a start has come, 0 to 1, and its rate, ``time`` after it and ``over`` a time.

    "sine": sin(pi t / (2 T)), which starts with a velocity (MRAG-I2D, Carling's swimmer);
    "smooth": (1 - cos(pi t / T)) / 2, which does not (SophT).
    """
    if time >= over:
        return 1.0, 0.0
    if kind == "sine":
        turn = 0.5 * math.pi / over
        return math.sin(turn * time), turn * math.cos(turn * time)
    turn = math.pi / over
    return 0.5 - 0.5 * math.cos(turn * time), 0.5 * turn * math.sin(turn * time)


@dataclass(frozen=True, kw_only=True)
class Wave:
    """A wave that runs to the tail: y = r(t) A(s) sin(2 pi (s / wavelength - t + phase)).

    ``amplitude``: A(s) [L] as a polynomial in s/L, low order first; s is the arc length, so x
    follows from dx^2 + dy^2 = ds^2. ``start``: how long the ramp r lasts [T]; 0 starts at once,
    bent. Refuses waves so high that a piece of the midline would be longer than itself.
    """

    amplitude: tuple[float, ...]
    wavelength: float = 1.0
    phase: float = 0.0
    start: float = 1.0
    ramp: Literal["smooth", "sine"] = "smooth"

    def __post_init__(self) -> None:
        """Refuse values that make no wave, and a wave that is too steep."""
        object.__setattr__(self, "amplitude", tuple(float(a) for a in self.amplitude))
        numbers = (*self.amplitude, self.wavelength, self.phase, self.start)
        if not self.amplitude or not all(map(math.isfinite, numbers)):
            raise InputError(f"a Wave needs finite numbers, got {self}", hint="amplitude=(0, 0.1)")
        if self.wavelength == 0 or self.start < 0:
            raise InputError(
                f"a Wave needs a wavelength and a start of at least 0, got {self.wavelength:g} "
                f"and {self.start:g}",
                hint="wavelength=1.0, start=1.0",
            )
        if self.ramp not in ("smooth", "sine"):
            raise InputError(f"unknown ramp {self.ramp!r}", hint='ramp="smooth"')
        steepest = self._steepest()
        if steepest >= 1.0:
            raise InputError(
                f"the wave is too high: |dy/ds| reaches {steepest:.3g}, of at most 1",
                hint="a smaller amplitude or a longer wave",
            )

    @property
    def breaks(self) -> tuple[float, ...]:
        """None: it is smooth along the midline."""
        return ()

    @property
    def times(self) -> tuple[float, ...]:
        """The end of the ramp."""
        return (self.start,)

    def bending(self, s: Values, time: float) -> Bending:
        """Curvature y'' / sqrt(1 - y'^2) and its rate."""
        one, two, one_t, two_t = self._slopes(s, time)
        cos = np.sqrt(1.0 - one**2)
        first, _, first_t, _ = self._slopes(np.zeros(1), time)
        return Bending(
            two / cos,
            two_t / cos + two * one * one_t / cos**3,
            math.asin(first[0]),
            float(first_t[0]) / math.sqrt(1.0 - float(first[0]) ** 2),
        )

    def lateral(self, s: Values, time: float) -> Values:
        """The law's y [L]."""
        come, _ = ramp(self.ramp, time, self.start)
        arg = 2 * math.pi * (s / self.wavelength - time + self.phase)
        return np.asarray(come * np.polynomial.polynomial.polyval(s, self.amplitude) * np.sin(arg))

    def _slopes(self, s: Values, time: float) -> tuple[Values, Values, Values, Values]:
        """y', y'' and their rates."""
        come, rate = ramp(self.ramp, time, self.start)
        poly = np.polynomial.polynomial
        a0, a1, a2 = (poly.polyval(s, poly.polyder(self.amplitude, n)) for n in range(3))
        k, w = 2 * math.pi / self.wavelength, 2 * math.pi
        arg = 2 * math.pi * (s / self.wavelength - time + self.phase)
        sin, cos = np.sin(arg), np.cos(arg)
        one = a1 * sin + a0 * k * cos
        two = (a2 - a0 * k**2) * sin + 2 * a1 * k * cos
        one_t = -w * (a1 * cos - a0 * k * sin)
        two_t = -w * ((a2 - a0 * k**2) * cos - 2 * a1 * k * sin)
        return come * one, come * two, come * one_t + rate * one, come * two_t + rate * two

    def _steepest(self) -> float:
        """The largest |y'| of the full wave."""
        s = np.linspace(0.0, 1.0, 201)
        poly = np.polynomial.polynomial
        k = 2 * math.pi / self.wavelength
        a0, a1 = poly.polyval(s, self.amplitude), poly.polyval(s, poly.polyder(self.amplitude))
        return float(np.hypot(a1, a0 * k).max())


class Stage(NamedTuple):
    """Where a start by bends goes: how long it takes [T], and the bends at its end [1/L]."""

    duration: float
    baseline: tuple[float, ...]
    undulation: tuple[float, ...]
    tail: float  # phase lag of the tail [periods]


@dataclass(frozen=True, kw_only=True)
class Bends:
    """Curvature splines: B(s, t) + K(s, t) sin(2 pi (t - tail(t) s + phase)).

    B and K are natural cubic splines through their values at ``points`` [L]; from straight, they
    and the tail's lag go from stage to stage by cubics of time that start and end at rest; after
    the last stage they stay, and the motion is periodic.
    """

    points: tuple[float, ...]
    stages: tuple[Stage, ...]
    phase: float = 0.0  # [periods]

    def __post_init__(self) -> None:
        """Refuse points that are not in order and stages that do not fit them."""
        object.__setattr__(self, "points", tuple(map(float, self.points)))
        object.__setattr__(self, "stages", tuple(Stage(*stage) for stage in self.stages))
        if len(self.points) < 3 or not all(np.diff(self.points) > 0):
            raise InputError(
                f"the points of Bends must rise, at least 3, got {self.points}",
                hint="points=(0, 0.5, 1)",
            )
        count = len(self.points)
        for stage in self.stages:
            if not (len(stage.baseline) == len(stage.undulation) == count and stage.duration > 0):
                raise InputError(
                    f"a Stage needs a positive duration and {count} values each, got {stage}",
                    hint="Stage(0.7, baseline, undulation, tail)",
                )
        if not self.stages:
            raise InputError("Bends need at least one Stage", hint="stages=(Stage(...),)")

    @property
    def breaks(self) -> tuple[float, ...]:
        """The points."""
        return self.points

    @property
    def times(self) -> tuple[float, ...]:
        """The ends of the stages."""
        return tuple(float(t) for t in np.cumsum([stage.duration for stage in self.stages]))

    def bending(self, s: Values, time: float) -> Bending:
        """Curvature and its rate."""
        spline = _spline(self.points)
        (base, bend, tail), rates = self._held(time)
        B, K, B_t, K_t = (spline(s) @ v for v in (base, bend, rates[0], rates[1]))
        arg = 2 * math.pi * (time - tail * s + self.phase)
        arg_t = 2 * math.pi * (1.0 - rates[2] * s)
        sin = np.sin(arg)
        return Bending(B + K * sin, B_t + K_t * sin + K * arg_t * np.cos(arg))

    def _held(self, time: float) -> tuple[tuple[Any, Any, float], tuple[Any, Any, float]]:
        """Baseline, undulation and tail at a time, and their rates."""
        zero = (0.0,) * len(self.points)
        before, begin = Stage(0.0, zero, zero, 0.0), 0.0
        for stage in self.stages:
            if time < begin + stage.duration:
                u = (time - begin) / stage.duration
                share, rate = u * u * (3 - 2 * u), 6 * u * (1 - u) / stage.duration
                start = [np.asarray(values) for values in before[1:]]
                change = [np.asarray(b) - a for a, b in zip(start, stage[1:], strict=True)]
                held = [a + share * d for a, d in zip(start, change, strict=True)]
                rates = [rate * d for d in change]
                return (held[0], held[1], float(held[2])), (rates[0], rates[1], float(rates[2]))
            before, begin = stage, begin + stage.duration
        still = np.asarray(zero)
        return (np.asarray(before[1]), np.asarray(before[2]), before[3]), (still, still, 0.0)


@dataclass(frozen=True, kw_only=True)
class Curved:
    """A curvature of one's own: ``law(s, t)`` [1/L] for an array of places and a time.

    Periodic in t with period 1 after ``settled``; smooth between ``breaks`` [L]. Its rate is a
    difference of order four over 5e-4 periods: the law is asked for times a little below 0 too.
    A lateral displacement has the curvature y'' / sqrt(1 - y'^2), s being the arc length.
    """

    law: Callable[[Values, float], Values]
    settled: float = 0.0
    breaks: tuple[float, ...] = ()

    @property
    def times(self) -> tuple[float, ...]:
        """When it becomes periodic."""
        return (self.settled,)

    def bending(self, s: Values, time: float) -> Bending:
        """What the law says, and its rate."""
        told = [self._told(s, time + n * NUDGE) for n, _ in STENCIL]
        rate = sum(w * v for (_, w), v in zip(STENCIL, told, strict=True)) / NUDGE
        return Bending(self._told(s, time), np.asarray(rate))

    def _told(self, s: Values, time: float) -> Values:
        values = np.asarray(self.law(s, time), np.float64)
        if values.shape != s.shape or not np.isfinite(values).all():
            raise InputError(
                f"the law of a Curved midline must give {s.shape} finite numbers at t = {time:g}",
                hint="law=lambda s, t: 2.0 * np.sin(2 * np.pi * (s - t))",
            )
        return values


CARLING = Wave(amplitude=(0.125 * 0.03125 / 1.03125, 0.125 / 1.03125))
"""Carling's anguilliform wave: 0.125 (s + 0.03125) / 1.03125, as MRAG-I2D and SophT have it
(J. Carling, T. L. Williams, G. Bowtell, J. Exp. Biol. 201, 3143, 1998)."""

ANGUILLIFORM = Wave(amplitude=(0.025, 0.1))
"""A backbone with the same tail and a wider head: 0.1 (s + 0.25), as P. Koumoutsakos prints it in
the lecture "Key aspects of particle methods"."""

CARANGIFORM = Wave(amplitude=(0.02, -0.0825, 0.1625))
"""Carangiform: 0.1 (1 - 0.825 (s - 1) + 1.625 (s^2 - 1)), of A. P. Maertens, A. Gao,
M. S. Triantafyllou, J. Fluid Mech. 813, 301 (2017), as CubismUP_3D has it."""

_UNDULATION = (0.0, 0.0, -5.73, -2.73, -1.09, 0.0)
CSTART = Bends(
    points=(0.0, 0.2, 0.5, 0.75, 0.95, 1.0),
    stages=(
        Stage(0.7, (0.0, 0.0, -3.19, -0.74, -0.44, 0.0), _UNDULATION, 0.74),
        Stage(1.0, (0.0,) * 6, _UNDULATION, 0.74),
    ),
    phase=0.176,
)
"""The best 2-D C-start of a larval fish within the curvatures seen in life: bend for 0.7 periods,
then swim (M. Gazzola, W. M. van Rees, P. Koumoutsakos, J. Fluid Mech. 698, 5, 2012; numbers as
CubismUP_2D has them, not checked against the paper)."""


@lru_cache(maxsize=16)
def _spline(points: tuple[float, ...]) -> Callable[[Values], Values]:
    """The natural cubic splines that are one at one point and zero at the others, (n, points)."""
    from scipy.interpolate import CubicSpline

    spline: Callable[[Values], Values] = CubicSpline(points, np.eye(len(points)), bc_type="natural")
    return spline
