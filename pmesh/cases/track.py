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
    """Where one body was at the end of each step, and what it did during the step."""

    time: Values  # (n,) [T]
    dt: Values  # (n,) of the step that ended; 0 at the start
    place: Values  # (n, 2) of the centre of mass [L]
    angle: Values  # (n,) [rad]
    velocity: Values  # (n, 2) [L/T]
    spin: Values  # (n,) [rad/T]
    force: Values  # (n, 2) of the fluid on the body, mean over the step [L^3/T^2]
    torque: Values  # (n,) [L^4/T^2]
    power: Values  # (n,) that the body gives to the fluid [L^4/T^3]

    @classmethod
    def read(cls, series: Mapping[str, NDArray[Any]], body: int = 0, prefix: str = "") -> Self:
        """The track of a body in the columns of a run; refuses a run without it."""
        name = f"{prefix}body{body}"
        if f"{name}_x" not in series:
            raise InputError(
                f"the run has no columns of a moving {name}", hint="watch=[pmesh.Forces()]"
            )
        x, y, angle, u, v, spin = (np.asarray(series[f"{name}_{part}"]) for part in PLACES)
        loads = [series[f"{name}_{part}"] for part in ("force_x", "force_y", "torque", "power")]
        along, across, torque, power = (np.nan_to_num(np.asarray(load)) for load in loads)
        time = np.asarray(series["time"], np.float64)
        return cls(
            time,
            np.diff(time, prepend=time[0]),
            np.stack([x, y], axis=1),
            angle,
            np.stack([u, v], axis=1),
            spin,
            np.stack([along, across], axis=1),
            torque,
            power,
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
        distance = float(np.hypot(*moved))
        direction = moved / distance if distance > 0 else np.array([1.0, 0.0])
        return direction, distance / (last - first)

    def lateral(self, first: float, last: float, direction: Values) -> float:
        """Half of the range of the velocity across a direction [L/T]."""
        x, y = direction
        across = self.velocity[self.within(first, last)] @ np.array([-y, x])
        return 0.5 * float(np.ptp(across))

    def pose(self, row: int) -> Pose:
        """Place and velocities at the end of a step."""
        return Pose(
            time=float(self.time[row]),
            center=(float(self.place[row, 0]), float(self.place[row, 1])),
            angle=(float(self.angle[row]),),
            velocity=(float(self.velocity[row, 0]), float(self.velocity[row, 1])),
            spin=(float(self.spin[row]),),
        )

    def row(self, time: float) -> int:
        """The step that ends closest to a time."""
        return int(np.argmin(np.abs(self.time - time)))


def efficiency(mass: float, speed: float, work: float) -> float:
    """Kinetic energy of the mean motion over itself and the work of a period (Kern & Koumoutsakos).

    ``mass`` per unit fluid density [L^2], ``work`` that the body gave to the fluid [L^4/T^2].
    """
    energy = 0.5 * mass * speed**2
    return energy / (energy + work)


def imbalance(track: Track, impulse: Values, first: float, last: float) -> float:
    """Momentum that body and fluid gained together between two times, of what they exchanged.

    ``impulse`` (n, 2): of all vorticity [L^3/T], the body's place full of fluid; that of a
    neutrally buoyant body whose deformation has no momentum is in it. The exchange is the integral
    of the force's size.
    """
    change = track.at(impulse, last) - track.at(impulse, first)
    exchanged = float(track.integral(np.hypot(*track.force.T), first, last))
    return float(np.hypot(*change)) / exchanged


def disagreement(track: Track, force: Values, first: float, last: float) -> float | None:
    """How far the body's gain of momentum is from the integral of another force, of the exchange.

    Both over the steps between two times at which the other force (n, 2) is known; None if it
    never is. The force of a free body is its gain of momentum, by the law that moves it.
    """
    known = track.within(first, last) & np.isfinite(force).all(axis=1)
    if not known.any():
        return None
    steps, own = track.dt[known], track.force[known]
    apart = np.hypot(*(steps @ (force[known] - own)))
    return float(apart / (steps @ np.hypot(*own.T)))


def deformation_drift(flow: VortexFlow, grid: Grid, poses: Sequence[Pose]) -> tuple[Drift, ...]:
    """Momentum of each body's deformation as the flow imposes it, on the lattice of ``grid``.

    Sums of chi u and chi r x u over the nodes, over those of chi |u| and chi |r| |u|.
    """
    mask = flow.mask(grid, tuple(poses))
    points, drifts = mask.grid.points(), []
    for number, pose in enumerate(poses):
        weight = np.where(mask.owner == number, mask.chi, 0.0)
        modes = rigid_modes(points, pose)
        sums = np.sum(weight * np.sum(modes * mask.velocity, axis=1), axis=(1, 2))
        size = weight * np.hypot(*mask.velocity)
        arm = np.hypot(*modes[2])
        scales = float(size.sum()) or math.inf, float((size * arm).sum()) or math.inf
        linear = float(np.hypot(sums[0], sums[1])) / scales[0]
        drifts.append(Drift(linear, abs(float(sums[2])) / scales[1]))
    return tuple(drifts)
