"""The way of a swimmer through a run, and what it says: speed, lateral motion, work, balance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.mask import rigid_modes
from pmesh.bodies.pose import Pose
from pmesh.vortex.loads import PLACES
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Values = NDArray[np.float64]


class Drift(NamedTuple):
    """How much linear and angular momentum a deformation has on the mesh, of the sum of sizes."""

    linear: float
    angular: float


class Track(NamedTuple):
    """Where one body was at the end of each step, and what it did during the step.

    In the plane d = 2, and angles, spins and torques are numbers; in space d = 3, and they are
    vectors (n, 3): the angle a rotation vector.
    """

    time: Values  # (n,) [T]
    dt: Values  # (n,) of the step that ended; 0 at the start
    place: Values  # (n, d) of the centre of mass [L]
    angle: Values  # (n,) [rad]
    velocity: Values  # (n, d) [L/T]
    spin: Values  # (n,) [rad/T]
    force: Values  # (n, d) of the fluid on the body, mean over the step [L^(d+1)/T^2]
    torque: Values  # (n,) [L^(d+2)/T^2]
    power: Values  # (n,) that the body gives to the fluid [L^(d+2)/T^3]

    @classmethod
    def read(cls, series: Mapping[str, NDArray[Any]], body: int = 0, prefix: str = "") -> Self:
        """The track of a body in the columns of a run; refuses a run without it."""
        name = f"{prefix}body{body}"
        if f"{name}_x" not in series:
            raise InputError(
                f"the run has no columns of a moving {name}", hint="watch=[pmesh.Forces()]"
            )
        ndim = 3 if f"{name}_z" in series else 2
        axes, turns = "xyz"[:ndim], [""] if ndim == 2 else [f"_{axis}" for axis in "xyz"]
        moved = _columns(series, [f"{name}_{part}" for part in PLACES[ndim]])
        loads = [f"force_{axis}" for axis in axes] + [f"torque{axis}" for axis in turns]
        told = np.nan_to_num(_columns(series, [f"{name}_{part}" for part in [*loads, "power"]]))
        half, time = len(PLACES[ndim]) // 2, np.asarray(series["time"], np.float64)
        return cls(
            time,
            np.diff(time, prepend=time[0]),
            moved[:, :ndim],
            _alone(moved[:, ndim:half]),
            moved[:, half : half + ndim],
            _alone(moved[:, half + ndim :]),
            told[:, :ndim],
            _alone(told[:, ndim:-1]),
            told[:, -1],
        )

    def at(self, values: Values, time: float) -> Values:
        """Values, one row per step, at a time: straight between the steps."""
        columns = values.reshape(len(values), -1).T
        told = np.array([np.interp(time, self.time, column) for column in columns])
        return told.reshape(values.shape[1:])

    def integral(self, rate: Values, first: float, last: float) -> Values:
        """The integral of a mean over the steps, between two times."""
        steps = self.dt.reshape(-1, *(1,) * (rate.ndim - 1))
        total = np.cumsum(rate * steps, axis=0)
        return np.asarray(self.at(total, last) - self.at(total, first))

    def within(self, first: float, last: float) -> NDArray[np.bool_]:
        """The steps that end between two times."""
        slack = 1e-9 * max(1.0, abs(last))
        return (self.time > first - slack) & (self.time < last + slack)

    def way(self, first: float, last: float) -> tuple[Values, float]:
        """Direction and speed [L/T] of the mean motion between two times."""
        moved = self.at(self.place, last) - self.at(self.place, first)
        distance = float(np.linalg.norm(moved))
        direction = moved / distance if distance > 0 else np.eye(len(moved))[0]
        return direction, distance / (last - first)

    def lateral(self, first: float, last: float, direction: Values) -> float:
        """Half of the range of the velocity across a direction in the plane of x and y [L/T]."""
        x, y = direction[:2] / (np.hypot(*direction[:2]) or 1.0)
        across = self.velocity[self.within(first, last), :2] @ np.array([-y, x])
        return 0.5 * float(np.ptp(across))

    def pose(self, row: int) -> Pose:
        """Place and velocities at the end of a step."""
        center, angle, velocity, spin = (
            tuple(np.atleast_1d(values[row]).tolist())
            for values in (self.place, self.angle, self.velocity, self.spin)
        )
        return Pose(
            time=float(self.time[row]), center=center, angle=angle, velocity=velocity, spin=spin
        )

    def row(self, time: float) -> int:
        """The step that ends closest to a time."""
        return int(np.argmin(np.abs(self.time - time)))


def _columns(series: Mapping[str, NDArray[Any]], names: Sequence[str]) -> Values:
    return np.stack([np.asarray(series[name], np.float64) for name in names], axis=1)


def _alone(values: Values) -> Values:
    """A column (n,) if there is but one."""
    return values[:, 0] if values.shape[1] == 1 else values


def efficiency(mass: float, speed: float, work: float) -> float:
    """Kinetic energy of the mean motion over itself and the work of a period (Kern & Koumoutsakos).

    ``mass`` per unit fluid density [L^d], ``work`` that the body gave to the fluid [L^(d+2)/T^2].
    """
    energy = 0.5 * mass * speed**2
    return energy / (energy + work)


def imbalance(track: Track, impulse: Values, first: float, last: float) -> float:
    """Momentum that body and fluid gained together between two times, of what they exchanged.

    ``impulse`` (n, d): of all vorticity [L^(d+1)/T], the body's place full of fluid; that of a
    neutrally buoyant body whose deformation has no momentum is in it. The exchange is the integral
    of the force's size.
    """
    change = track.at(impulse, last) - track.at(impulse, first)
    exchanged = float(track.integral(np.linalg.norm(track.force, axis=1), first, last))
    return float(np.linalg.norm(change)) / exchanged


def disagreement(track: Track, force: Values, first: float, last: float) -> float | None:
    """How far the body's gain of momentum is from the integral of another force, of the exchange.

    Both over the steps between two times at which the other force (n, d) is known; None if it
    never is. The force of a free body is its gain of momentum, by the law that moves it.
    """
    known = track.within(first, last) & np.isfinite(force).all(axis=1)
    if not known.any():
        return None
    steps, own = track.dt[known], track.force[known]
    apart = np.linalg.norm(steps @ (force[known] - own))
    return float(apart / (steps @ np.linalg.norm(own, axis=1)))


def deformation_drift(flow: VortexFlow, grid: Grid, poses: Sequence[Pose]) -> tuple[Drift, ...]:
    """Momentum of each body's deformation as the flow imposes it, on the lattice of ``grid``.

    Sums of chi u and chi r x u over the nodes, over those of chi |u| and chi |r| |u|.
    """
    mask = flow.mask(grid, tuple(poses))
    points, drifts = mask.grid.points(), []
    for number, pose in enumerate(poses):
        weight = np.where(mask.owner == number, mask.chi, 0.0)
        modes = rigid_modes(points, pose)
        sums = np.einsum("ka,a->k", (modes * mask.velocity).sum(axis=1).reshape(len(modes), -1),
                         weight.ravel())  # fmt: skip
        size = weight * np.linalg.norm(mask.velocity, axis=0)
        arm = np.linalg.norm(points - _column(pose.center, grid.ndim), axis=0)
        scales = float(size.sum()) or math.inf, float((size * arm).sum()) or math.inf
        linear, angular = (np.linalg.norm(part) for part in np.split(sums, [grid.ndim]))
        drifts.append(Drift(float(linear) / scales[0], float(angular) / scales[1]))
    return tuple(drifts)


def _column(vector: Sequence[float], ndim: int) -> Values:
    return np.reshape(vector, (ndim, *(1,) * ndim))
