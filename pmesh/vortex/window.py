"""The part of space that a long run keeps, and what stands for the wake that has left it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.pose import Pose
from pmesh.vortex.domain import Shift
from remesh.errors import InputError, as_number
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
FADING = 60.0  # decay over a fading zone that is passed at the wind's speed: exp(-FADING / 3)
CORE = 0.75  # body lengths, of the Gaussian source and vortex beyond: bodies feel potential flow
MEMORY = 4.0  # crossings of the fading zone over which the deficit is averaged


@dataclass(frozen=True, kw_only=True)
class Window:
    """A domain in body lengths around the bodies' centre, which it travels with.

    ``lower`` and ``upper``: how far it reaches along each axis, in lengths of the largest body;
    in the last ``fade`` lengths vorticity fades away. With ``wake`` the momentum deficit that has
    faded, its flux q, and the circulation that has, G, go on to act: what lies beyond is, for the
    flow inside, a source q and a vortex G at the end of the window. Without them the drag in a
    window of L lengths behind the body is too large by about Cd/(2 pi L) of itself, and each eddy
    of a vortex street that leaves is felt at the body as a gust of about G/(4 pi L).
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    fade: float = 1.0
    wake: bool = True

    def __post_init__(self) -> None:
        """Refuse what leaves no room for bodies."""
        for name in ("lower", "upper"):
            reach = tuple(as_number(f"Window {name}", x, hint="3.0") for x in getattr(self, name))
            if not all(math.isfinite(x) and x > self.fade + 0.5 for x in reach):
                raise InputError(
                    f"Window {name} must reach beyond half a body and the fading zone, "
                    f"{0.5 + self.fade:g} lengths, got {reach}",
                    hint="lower=(3, 3), upper=(12, 3), in body lengths",
                )
            object.__setattr__(self, name, reach)
        if not (math.isfinite(self.fade) and self.fade > 0):
            raise InputError(f"Window fade must be positive, got {self.fade}", hint="fade=1.0")

    def corners(self, bodies: Sequence[Body], poses: Sequence[Pose]) -> tuple[Array, Array]:
        """Lower and upper corner [L]."""
        center = np.mean([pose.center for pose in poses], axis=0)
        length = _length(bodies)
        return center - length * np.array(self.lower), center + length * np.array(self.upper)

    def clipped(
        self, shift: Shift, grid: Grid, bodies: Sequence[Body], poses: Sequence[Pose]
    ) -> Shift:
        """The change of a mesh that does not reach out of the window, nor trim what is in it."""
        low, high = self.corners(bodies, poses)
        before, after = list(shift.before), list(shift.after)
        for axis in range(grid.ndim):
            if grid.periodic[axis]:
                continue
            end = grid.origin[axis] + (grid.shape[axis] - 1) * grid.spacing
            before[axis] = min(before[axis], _whole((grid.origin[axis] - low[axis]) / grid.spacing))
            after[axis] = min(after[axis], _whole((high[axis] - end) / grid.spacing))
        return Shift(tuple(before), tuple(after))

    def faded(
        self, grid: Grid, bodies: Sequence[Body], poses: Sequence[Pose], reach: float
    ) -> Array | None:
        """Factor (shape of the mesh) for ``reach`` [L] of travel; None if nothing lies there."""
        low, high = self.corners(bodies, poses)
        zone = self.fade * _length(bodies)
        factors, busy = [], False
        for axis, x in enumerate(grid.axes()):
            depth = np.maximum(low[axis] + zone - x, x - high[axis] + zone) / zone
            if grid.periodic[axis]:
                depth = np.zeros_like(x)
            depth = np.clip(depth, 0.0, 1.0)
            busy = busy or bool(depth.any())
            factors.append(np.exp(-FADING * reach / zone * depth**2))
        return np.multiply.outer(*factors) if busy else None

    def remembered(
        self, deficit: float, gone: Array, bodies: Sequence[Body], wind: Array, dt: float
    ) -> float:
        """The deficit's flux [L^2/T] after impulse ``gone`` [L^3/T] faded away in dt."""
        speed = float(np.hypot(*wind))
        if not (self.wake and speed > 0):
            return 0.0
        flux = -float(np.dot(gone, wind)) / (dt * speed**2)
        share = -math.expm1(-dt * speed / (MEMORY * self.fade * _length(bodies)))
        return deficit + share * (flux - deficit)

    def departed(
        self, circulation: float, gone: float, bodies: Sequence[Body], wind: Array, dt: float
    ) -> float:
        """The circulation [L^2/T] that acts from the end after ``gone`` more faded away in dt.

        What left goes on with the wind W, and at the body a distance L ahead of the end its
        velocity falls like 1/(L + W t); as a vortex that stays at the end it fades like
        exp(-W t/L), which begins alike.
        """
        speed = float(np.hypot(*wind))
        if not (self.wake and speed > 0):
            return 0.0
        far = self._reach(_length(bodies), wind / speed)
        return circulation * math.exp(-dt * speed / far) + gone

    def beyond(
        self,
        grid: Grid,
        bodies: Sequence[Body],
        poses: Sequence[Pose],
        deficit: float,
        wind: Array,
        circulation: float = 0.0,
    ) -> Array:
        """Velocity [L/T] of a source of flux ``deficit`` and a vortex at the downwind end."""
        length, unit = _length(bodies), wind / np.hypot(*wind)
        center = np.mean([pose.center for pose in poses], axis=0)
        place = center + unit * self._reach(length, unit)
        x, y = grid.axes()
        arm_x, arm_y = (x - place[0])[:, None], (y - place[1])[None, :]
        square = np.maximum(arm_x**2 + arm_y**2, 1e-6 * length**2)
        scale = -np.expm1(-0.5 * square / (CORE * length) ** 2) / (2 * math.pi * square)
        source, vortex = deficit * scale, circulation * scale
        return np.stack([source * arm_x - vortex * arm_y, source * arm_y + vortex * arm_x])

    def _reach(self, length: float, unit: Array) -> float:
        """Distance [L] from the centre to the middle of the fading zone along a direction."""
        ends = length * np.where(unit > 0, self.upper, self.lower)
        along = min(
            end / abs(part) for end, part in zip(ends, unit, strict=True) if abs(part) > 1e-9
        )
        return float(along - 0.5 * self.fade * length)


def _length(bodies: Sequence[Body]) -> float:
    return max(body.length for body in bodies)


def _whole(nodes: float) -> int:
    return math.floor(nodes + 1e-6)
