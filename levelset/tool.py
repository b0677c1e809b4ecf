"""A tool: a shape that moves by laws of time, and the region that it sweeps."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Array, Bounds, Shape, around, grown, vector
from levelset.thickness import thickness
from remesh.errors import InputError, as_number

Values = NDArray[np.float64]
Law = Callable[[float], Sequence[float] | float]
Path = Callable[[Values, NDArray[np.int64]], Values]  # see `Sweep.distance`
ROOM = 4_000_000  # distances of places from poses in memory
MOST = 100_000  # poses of one sweep
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
PROBES = 32  # uneven times at which a path is seen before its poses are chosen
CUTS = 10  # golden sections of the time around the closest pose


@dataclass(frozen=True, kw_only=True)
class Tool:
    """A shape that moves: turned about the origin by ``angle(t)``, then shifted by ``shift(t)``.

    Laws of time as `Shape.moved` takes them: ``ndim`` lengths [L]; an angle [rad], in 3-D a
    rotation vector. Without a law the tool stays. Refuses what is not a shape or not a law.
    """

    shape: Shape
    shift: Law | None = None
    angle: Law | None = None

    def __post_init__(self) -> None:
        """Refuse what is not a shape, and laws that cannot be called."""
        if not isinstance(self.shape, Shape):
            raise InputError(
                f"a tool needs a shape, got {type(self.shape).__name__}",
                hint="Tool(shape=Sphere(0.1), shift=lambda t: (t, 0.0, 0.0))",
            )
        for name in ("shift", "angle"):
            law = getattr(self, name)
            if law is not None and not callable(law):
                raise InputError(
                    f"Tool: {name} must be a law of time, got {law!r}", hint=f"{name}=lambda t: ..."
                )

    def at(self, time: float) -> Shape:
        """The shape where it is at a time."""
        shift, angle = self.pose(time)
        return self.shape.moved(shift, angle)

    def pose(self, time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Shift [L] and angle [rad] at a time; refuses laws of the wrong length or not finite."""
        time = as_number("time", time, hint="tool.at(0.0)")
        turns = 1 if self.shape.ndim == 2 else 3
        parts = []
        for name, law, count in (
            ("shift", self.shift, self.shape.ndim),
            ("angle", self.angle, turns),
        ):
            given: Any = (0.0,) * count if law is None else law(time)
            single = isinstance(given, str) or not np.iterable(given)
            parts.append(vector(f"Tool: {name}({time:g})", (given,) if single else given, count))
        return parts[0], parts[1]

    def sweep(self, start: float, stop: float, pace: float) -> Sweep:
        """The tool's poses from one time to another, its box moving at most ``pace`` [L] each.

        The path is seen at 32 uneven times first; then poses grow more until, at an uneven time
        between any two, the tool is within half a pace of where their parabola has it. Moves that
        are over within 1/32 of the time may be missed. Refuses paths of too many poses.
        """
        if not (start <= stop and pace > 0):
            raise InputError(
                f"a sweep goes on in time at a positive pace, got {start} to {stop} at {pace}",
                hint="tool.sweep(0.0, 1.0, 0.01)",
            )
        corners = _corners(self.shape.bounds())
        span = stop - start
        seen = np.sort((GOLDEN * np.arange(1, PROBES + 1)) % 1.0)
        shifts, angles = self._poses(start + span * np.concatenate([[0.0], seen, [1.0]]))
        moves = _moves(_placed(corners, shifts, angles))
        fastest = float((moves / np.diff(seen, prepend=0.0, append=1.0)).max())
        count = max(2, math.ceil(min(fastest / pace, 2.0 * MOST)))
        while count <= MOST:
            shifts, angles = self._poses(np.linspace(start, stop, count + 1))
            move = float(_moves(_placed(corners, shifts, angles)).max())
            if move <= pace:
                found = Sweep(self.shape, shifts, angles, pace)
                part = np.arange(count) + 0.2 + 0.6 * ((GOLDEN * np.arange(count)) % 1.0)
                there = _placed(corners, *self._poses(start + span / count * part))
                off = there - _placed(corners, *found.pose(np.clip(np.rint(part), 1, count - 1)
                                                           .astype(np.int64), part))  # fmt: skip
                if np.sqrt((off**2).sum(axis=1)).max() <= 0.5 * pace:
                    return found
            count = max(2 * count, math.ceil(min(count * move / pace, 2.0 * MOST)))
        raise InputError(
            f"the tool's path from t = {start:g} to {stop:g} takes more than {MOST} poses",
            hint="a law of time without jumps, a shorter time, or a coarser grid",
        )

    def _poses(self, times: Values) -> tuple[Values, Values]:
        """Shifts (count, ndim) and angles (count, 1 or 3) at some times, without jumps by turns."""
        told = [self.pose(float(time)) for time in times]
        shifts, angles = (np.array(part) for part in zip(*told, strict=True))
        return shifts, _continued(angles)


class Sweep(NamedTuple):
    """A tool at a row of times, evenly apart."""

    shape: Shape
    shifts: Values  # (count, ndim) [L]
    angles: Values  # (count, 1 or 3) [rad]
    pace: float  # that no corner of its box exceeds from one to the next [L]

    def bounds(self, distance: float) -> Bounds:
        """A box that holds all that comes within ``distance`` [L] of the tool on its way."""
        box = None
        for shift, angle in zip(self.shifts, self.angles, strict=True):
            here = self.shape.moved(shift.tolist(), angle.tolist()).reach(distance)
            box = here if box is None else around(box, here)
        assert box is not None
        return grown(box, self.pace)

    def distance(self, path: Path, count: int, within: float = math.inf) -> Values:
        """Least signed distance (count,) [L] of places from the tool on its way.

        ``path(parts, which)`` tells where the places ``which`` are at these parts of the way
        (ndim, len(which)), so that they may move too.
        Poses are parabolas through three neighbours; around each that is closer than its own,
        golden sections find the moment. Distances that are not below ``within`` are those of the
        closest pose.
        """
        room = max(1, ROOM // len(self.shifts))
        parts = [np.arange(k, min(k + room, count)) for k in range(0, count, room)]
        found = [self._distance(path, which, within) for which in parts]
        return np.concatenate([np.empty(0), *found])

    def _distance(self, path: Path, which: NDArray[np.int64], within: float) -> Values:
        """The same for some of the places."""
        last = len(self.shifts) - 1
        poses = np.empty((last + 3, len(which)))
        poses[[0, -1]] = np.inf
        for k in range(last + 1):
            middle, moment = np.array([min(max(k, 1), last - 1)]), np.array([float(k)])
            poses[k + 1] = self._seen(path(np.full(len(which), k / last), which), middle, moment)
        best: Values = poses.min(axis=0)
        lowest = (poses[1:-1] <= poses[:-2]) & (poses[1:-1] <= poses[2:])
        lowest &= poses[1:-1] <= np.minimum(best, within) + self.pace
        when, near = np.nonzero(lowest)
        if near.size:
            np.minimum.at(best, near, self._closest(path, which[near], when))
        return best

    def _closest(self, path: Path, near: NDArray[np.int64], when: NDArray[np.int64]) -> Values:
        """Golden sections of the time around a pose, one time per place."""
        last = len(self.shifts) - 1
        middle = np.clip(when, 1, last - 1)
        low = np.maximum(when - 1.0, 0.0)
        high = np.minimum(when + 1.0, float(last))

        def away(moment: Values) -> Values:
            return self._seen(path(moment / last, near), middle, moment)

        first, second = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        one, two = away(first), away(second)
        for _ in range(CUTS):
            left = one < two
            high, low = np.where(left, second, high), np.where(left, low, first)
            first, second = (
                np.where(left, high - GOLDEN * (high - low), second),
                np.where(left, first, low + GOLDEN * (high - low)),
            )
            fresh = away(np.where(left, first, second))
            one, two = np.where(left, fresh, two), np.where(left, one, fresh)
        return np.minimum(one, two)

    def pose(self, middle: Any, moment: Values) -> tuple[Values, Values]:
        """Shifts (n, ndim) [L] and angles (n, 1 or 3) [rad] at moments, in poses from the first.

        By the parabola through the pose ``middle`` and its neighbours, one per moment.
        """
        u = moment - middle
        weights = (0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0))
        shift, angle = (
            sum(w[:, None] * rows[middle + k] for k, w in zip((-1, 0, 1), weights, strict=True))
            for rows in (self.shifts, self.angles)
        )
        return shift, angle

    def _seen(self, places: Values, middle: Any, moment: Values) -> Values:
        """Signed distance of places, each at its own moment, in poses from the first."""
        shift, angle = self.pose(middle, moment)
        local = places - shift.T
        if self.angles.any():
            local = _turned(local, -angle.T)
        return np.asarray(self.shape.distance(local), np.float64)


@dataclass(frozen=True)
class Swept(Shape):
    """All that a tool touches from one time to another.

    Outside, the distance is the tool's least one on its way; inside, its size is a lower bound, as
    in a union. The tool's path is followed at a ``pace`` [L] per pose, a twentieth of the tool's
    thickness if none is given, and each place then finds its own closest moment: no ridges between
    poses. As exact as the tool's distance, where it has one least value in two poses. Never too
    large. Moves that are over within 1/32 of the time may be missed.
    """

    tool: Tool
    start: float  # [T]
    stop: float  # [T]
    pace: float | None = field(default=None, kw_only=True)  # [L]

    def __post_init__(self) -> None:
        """Refuse what is not a tool, times not in order, and a pace that is not positive."""
        if not isinstance(self.tool, Tool):
            raise InputError(
                f"Swept: tool must be a Tool, got {self.tool!r}",
                hint="Swept(Tool(shape=Disk(0.1), shift=lambda t: (t, 0.0)), 0.0, 1.0)",
            )
        for name in ("start", "stop"):
            object.__setattr__(self, name, as_number(f"Swept: {name}", getattr(self, name),
                                                     hint=f"{name}=0.0"))  # fmt: skip
        if not (math.isfinite(self.start) and self.start < self.stop < math.inf):
            raise InputError(
                f"Swept: start must come before stop, got {self.start} and {self.stop}",
                hint="Swept(tool, 0.0, 1.0)",
            )
        if self.pace is not None:
            pace = as_number("Swept: pace", self.pace, hint="pace=0.01")
            if not (math.isfinite(pace) and pace > 0):
                raise InputError(f"Swept: pace must be a positive length, got {pace}",
                                 hint="pace=0.01")  # fmt: skip
            object.__setattr__(self, "pace", pace)

    @cached_property
    def _sweep(self) -> Sweep:
        pace = 0.05 * thickness(self.tool.shape) if self.pace is None else self.pace
        return self.tool.sweep(self.start, self.stop, pace)

    @property
    def ndim(self) -> int:
        """Number of dimensions of the tool."""
        return self.tool.shape.ndim

    @property
    def volume(self) -> float | None:
        """None: no closed form is known."""
        return None

    def bounds(self) -> Bounds:
        """The box around the boxes of all poses."""
        return self._sweep.bounds(0.0)

    def reach(self, distance: float) -> Bounds:
        """The box around what comes within a distance."""
        return self._sweep.bounds(distance)

    def _distance(self, points: Array) -> Array:
        places = np.asarray(points, np.float64).reshape(self.ndim, -1)
        found = self._sweep.distance(lambda _, which: places[:, which], places.shape[1])
        return np.asarray(found.reshape(points.shape[1:]))


def _corners(bounds: Bounds) -> Values:
    """Corners of a box, (ndim, 2^ndim)."""
    grids = np.meshgrid(*zip(*bounds, strict=True), indexing="ij")
    return np.stack([part.ravel() for part in grids]).astype(np.float64)


def _placed(corners: Values, shifts: Values, angles: Values) -> Values:
    """Corners (count, ndim, corners) in some poses."""
    count, across = len(shifts), corners.shape[1]
    turned = _turned(np.tile(corners, count), np.repeat(angles.T, across, axis=1))
    return turned.reshape(-1, count, across).swapaxes(0, 1) + shifts[:, :, None]


def _moves(placed: Values) -> Values:
    """The largest move of a corner from each pose to the next [L]."""
    return np.asarray(np.sqrt(((placed[1:] - placed[:-1]) ** 2).sum(axis=1)).max(axis=1))


def _continued(angles: Values) -> Values:
    """Angles (count, 1 or 3) of the same poses, each with the whole turns nearest to the last's."""
    if angles.shape[1] == 1:
        return np.unwrap(angles, axis=0)
    found = angles.copy()
    for last, here in itertools.pairwise(found):
        turn = math.sqrt(float(here @ here))
        if turn > 0.0:
            whole = round(float(here @ last / turn - turn) / (2.0 * math.pi))
            here *= 1.0 + 2.0 * math.pi * whole / turn
    return found


def _turned(places: Values, angle: Values) -> Values:
    """Places (ndim, n) turned about the origin, each by its own angle (1 or 3, n)."""
    if len(places) == 2:
        cos, sin = np.cos(angle[0]), np.sin(angle[0])
        return np.stack([cos * places[0] - sin * places[1], sin * places[0] + cos * places[1]])
    turn = np.sqrt((angle**2).sum(axis=0))
    across = np.cross(angle, places, axis=0)
    once = np.sinc(turn / np.pi)  # sin(t)/t
    twice = 0.5 * np.sinc(turn / (2.0 * np.pi)) ** 2  # (1 - cos t)/t^2
    return np.asarray(places + once * across + twice * np.cross(angle, across, axis=0))
