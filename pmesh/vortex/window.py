"""The part of space that a long run keeps, and what stands for the wake that has left it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from pmesh.bodies.body import Body
from pmesh.bodies.pose import Pose
from pmesh.vortex import ledger
from pmesh.vortex.budget import Moments
from pmesh.vortex.domain import Shift, strides
from pmesh.vortex.state import State, Wake
from remesh.errors import InputError, as_number
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
FADING = 60.0  # decay over a fading zone that is passed at the wind's speed: exp(-FADING / 3)
CORE = 0.75  # body lengths, of the Gaussian source and vortex beyond: bodies feel potential flow
MEMORY = 4.0  # crossings of the fading zone over which the deficit is averaged


class Gone(NamedTuple):
    """What faded away in a step."""

    impulse: Array  # about the bodies' centre [L^(ndim+1)/T]
    circulation: Any  # in the plane [L^2/T]; in space the vector int w dV [L^3/T]


@dataclass(frozen=True, kw_only=True)
class Window:
    """A domain in body lengths around the bodies' centre, which it travels with.

    ``lower`` and ``upper``: how far it reaches along each axis, in lengths of the largest body;
    in the last ``fade`` lengths vorticity fades away. With ``wake`` the momentum deficit that has
    faded, its flux q, and the circulation that has, G, go on to act: what lies beyond is, for the
    flow inside, a source q and a vortex G at the end of the window. Without them the drag in a
    window of L lengths behind the body is too large by about Cd/(2 pi L) of itself, and each eddy
    of a vortex street that leaves is felt at the body as a gust of about G/(4 pi L). In space the
    source alone acts: of the drag Cd/(16 L^2), and vortex lines have no circulation to carry off.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    fade: float = 1.0
    wake: bool = True

    def __post_init__(self) -> None:
        """Refuse what leaves no room for bodies."""
        fade = as_number("Window fade", self.fade, hint="fade=1.0")
        if not (math.isfinite(fade) and fade > 0):
            raise InputError(f"Window fade must be positive, got {fade}", hint="fade=1.0")
        for name in ("lower", "upper"):
            given = getattr(self, name)
            if not isinstance(given, Iterable):
                raise InputError(
                    f"Window {name} must hold one reach per axis, got {given!r}",
                    hint="lower=(3, 3), upper=(12, 3), in body lengths",
                )
            reach = tuple(as_number(f"Window {name}", x, hint="3.0") for x in given)
            if not all(math.isfinite(x) and x > self.fade + 0.5 for x in reach):
                raise InputError(
                    f"Window {name} must reach beyond half a body and the fading zone, "
                    f"{0.5 + self.fade:g} lengths, got {reach}",
                    hint="lower=(3, 3), upper=(12, 3), in body lengths",
                )
            object.__setattr__(self, name, reach)

    def corners(self, bodies: Sequence[Body], poses: Sequence[Pose]) -> tuple[Array, Array]:
        """Lower and upper corner [L]."""
        center = np.mean([pose.center for pose in poses], axis=0)
        length = _length(bodies)
        return center - length * np.array(self.lower), center + length * np.array(self.upper)

    def clipped(
        self, shift: Shift, grid: Grid, bodies: Sequence[Body], poses: Sequence[Pose]
    ) -> Shift:
        """The change of a mesh that does not reach out of the window, nor trim what is in it.

        In whole strides, so that meshes have few shapes: one stride may stick out.
        """
        low, high = self.corners(bodies, poses)
        before, after = list(shift.before), list(shift.after)
        for axis in range(grid.ndim):
            if grid.periodic[axis]:
                continue
            end = grid.origin[axis] + (grid.shape[axis] - 1) * grid.spacing
            before[axis] = min(before[axis], _missing(grid.origin[axis] - low[axis], grid))
            after[axis] = min(after[axis], _missing(high[axis] - end, grid))
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
        return reduce(np.multiply.outer, factors) if busy else None

    def remembered(
        self, wake: Wake, gone: Gone, bodies: Sequence[Body], wind: Array, dt: float
    ) -> Wake:
        """What the wake beyond does after more of it faded away in dt.

        Its circulation goes on with the wind W, and at the body a distance L ahead of the end its
        velocity falls like 1/(L + W t); as a vortex that stays at the end it fades like
        exp(-W t/L), which begins alike. Where the wind stops the wake stays; where it turns the
        end turns with it.
        """
        speed = float(np.linalg.norm(wind))
        if not (self.wake and speed > 0):
            return wake
        length, unit = _length(bodies), wind / speed
        old = np.asarray(wake.way or (0.0,) * len(wind))
        flux = -float(np.dot(gone.impulse, unit)) / (dt * speed)
        share = -math.expm1(-dt * speed / (MEMORY * self.fade * length))
        way = old + (share if old.any() else 1.0) * (unit - old)
        kept = math.exp(-dt * speed / self._reach(length, unit))
        return Wake(
            flux=wake.flux + share * (flux - wake.flux),
            circulation=kept * wake.circulation + gone.circulation if len(wind) == 2 else 0.0,
            way=tuple(float(x) for x in way),
        )

    def beyond(
        self, grid: Grid, bodies: Sequence[Body], poses: Sequence[Pose], wake: Wake
    ) -> Array | None:
        """Velocity [L/T] of a source and a vortex at the downwind end; None if there is nothing."""
        size = math.hypot(*wake.way)
        if not (size > 1e-9 and (wake.flux or wake.circulation)):
            return None
        length, unit = _length(bodies), np.asarray(wake.way) / size
        center = np.mean([pose.center for pose in poses], axis=0)
        place = center + unit * self._reach(length, unit)
        arms = np.meshgrid(
            *(x - at for x, at in zip(grid.axes(), place, strict=True)), indexing="ij", sparse=True
        )
        square = np.maximum(sum(arm**2 for arm in arms), 1e-6 * length**2)
        if grid.ndim == 3:
            ratio = np.sqrt(0.5 * square) / (CORE * length)
            inside = erf(ratio) - 2.0 / math.sqrt(math.pi) * ratio * np.exp(-(ratio**2))
            source = wake.flux * inside / (4 * math.pi * square * np.sqrt(square))
            return np.stack([source * arm for arm in arms])
        cut = -np.expm1(-0.5 * square / (CORE * length) ** 2)
        scale = cut / (2 * math.pi * square)
        source, vortex = wake.flux * scale, wake.circulation * scale
        x, y = arms
        return np.stack([source * x - vortex * y, source * y + vortex * x])

    def _reach(self, length: float, unit: Array) -> float:
        """Distance [L] from the centre to the middle of the fading zone along a direction."""
        ends = length * np.where(unit > 0, self.upper, self.lower)
        along = min(
            end / abs(part) for end, part in zip(ends, unit, strict=True) if abs(part) > 1e-9
        )
        return float(along - 0.5 * self.fade * length)


def _missing(gap: float, grid: Grid) -> int:
    """Nodes in whole strides that reach over a gap [L]; less than a spacing counts as none."""
    return strides(math.trunc(gap / grid.spacing + 1e-9))


def _length(bodies: Sequence[Body]) -> float:
    return max(body.length for body in bodies)


def let_go(window: Window, state: State, bodies: Sequence[Body], wind: Array, dt: float) -> State:
    """The state without what has reached the end of its window, and with what that goes on to do.

    ``wind``: the stream that the bodies feel on the whole [L/T].
    """
    grid = state.grid
    reach = dt * (float(np.linalg.norm(wind)) or state.speed)
    factor = window.faded(grid, bodies, state.poses, reach)
    gone, kept = Gone(np.zeros(grid.ndim), 0.0), state.vorticity
    if factor is not None:
        kept = (kept * factor).astype(kept.dtype, copy=False)
        center = np.mean([pose.center for pose in state.poses], axis=0)
        before, after = (_moments(field, grid, center) for field in (state.vorticity, kept))
        gone = Gone(before.impulse - after.impulse, before.circulation - after.circulation)
    return replace(
        state,
        vorticity=kept,
        lost_circulation=state.lost_circulation + gone.circulation,
        wake=window.remembered(state.wake, gone, bodies, wind, dt),
    )


def _moments(vorticity: Array, grid: Grid, center: Array) -> Gone:
    """Impulse about a centre, and circulation."""
    if grid.ndim == 3:
        moments = Moments(vorticity, grid)
        return Gone(moments.impulse - 0.5 * np.cross(center, moments.total), moments.total)
    total = ledger.circulation(vorticity, grid)
    about = np.array(ledger.impulse(vorticity, grid)) - total * np.array([center[1], -center[0]])
    return Gone(about, total)
