"""The force, torque and power on each body, from the momentum of the force that holds it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.mask import Mask, deformation_on, moves
from pmesh.bodies.pose import Pose
from pmesh.vortex.constraint import Wall
from pmesh.vortex.state import Load

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
PLACES = ("x", "y", "angle", "u", "v", "spin")  # columns of a body that moves


def moments(impulse: Array, mask: Mask, poses: Sequence[Pose]) -> Values:
    """Sums (bodies, 3) of an impulse density over each body: along x, y, and about its centre."""
    x, y = mask.grid.axes()
    sums = []
    for number, pose in enumerate(poses):
        own = impulse if len(poses) == 1 else np.where(mask.owner == number, impulse, 0.0)
        along = own.sum(axis=2, dtype=np.float64)  # of each row
        across = own[0].sum(axis=0, dtype=np.float64)
        total = along.sum(axis=1)
        torque = along[1] @ (x - pose.center[0]) - across @ (y - pose.center[1])
        sums.append([*total, torque])
    return np.array(sums) * mask.grid.cell_volume


def work(impulse: Array, mask: Mask, poses: Sequence[Pose], bodies: Sequence[Body]) -> Values:
    """Work (bodies,) of an impulse density on the bodies' own motion."""
    if not any(moves(body) for body in bodies):
        return np.zeros(len(poses))
    points, cell = mask.grid.points(), mask.grid.cell_volume
    done = []
    for number, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        matter = pose.rigid(points)
        change = deformation_on(body, pose, mask.grid)
        matter = matter if change is None else matter + change
        done.append(float(np.sum((impulse * matter)[:, mask.owner == number])) * cell)
    return np.array(done)


def loads_of(
    bodies: Sequence[Body],
    before: Sequence[Pose],
    after: Sequence[Pose],
    sums: Values,
    worked: Values,
    energies: Values,
    dt: float,
) -> tuple[Load, ...]:
    """Loads from the impulse on the fluid (bodies, 3), its work, and the gain of kinetic energy.

    The fluid in the body's place moves with it, and its inertia is not the outer fluid's doing.
    """
    loads = []
    for number, body in enumerate(bodies):
        old, new = before[number], after[number]
        gain = dt * inertia_force((body,), (old,), (new,), dt)
        turn = spin_gained(body, old, new)
        loads.append(
            Load(
                force=tuple(float(x) for x in (gain - sums[number, :2]) / dt),
                torque=float(turn - sums[number, 2]) / dt,
                power=float(worked[number] - energies[number]) / dt,
            )
        )
    return tuple(loads)


def kinetic_energy(wall: Wall, poses: Sequence[Pose]) -> Values:
    """Kinetic energy (bodies,) [L^(ndim+2)/T^2] of fluid that would move with each body."""
    if not any(moves(body) for body in wall.bodies):
        return np.zeros(len(poses))
    mask = wall.mask()
    energies = []
    for number, (body, pose) in enumerate(zip(wall.bodies, poses, strict=True)):
        volume, speed = body.measure.volume, float(np.dot(pose.velocity, pose.velocity))
        energy = 0.5 * (volume * speed + body.inertia(pose) * pose.spin[0] ** 2)
        change = deformation_on(body, pose, mask.grid)
        if change is not None:
            own = np.where(mask.owner == number, mask.chi, 0.0)
            square = float(np.sum(own * np.sum(change**2, axis=0)))
            energy += 0.5 * volume * square / float(own.sum())
        energies.append(energy)
    return np.array(energies)


def load_columns(
    bodies: Sequence[Body], loads: Sequence[Load], poses: Sequence[Pose]
) -> dict[str, float]:
    """Columns of a series: the load on each body and, if it moves, where and how."""
    columns: dict[str, float] = {}
    for number, (body, load, pose) in enumerate(zip(bodies, loads, poses, strict=True)):
        name = f"body{number}"
        columns |= {f"{name}_force_{a}": x for a, x in zip("xy", load.force, strict=True)}
        columns |= {f"{name}_torque": load.torque, f"{name}_power": load.power}
        if moves(body):
            values = (*pose.center, *pose.angle, *pose.velocity, *pose.spin)
            columns |= {f"{name}_{a}": x for a, x in zip(PLACES, values, strict=True)}
    return columns


def inertia_force(
    bodies: Sequence[Body], before: Sequence[Pose], after: Sequence[Pose], dt: float
) -> Values:
    """Rate of momentum [L^(ndim+1)/T^2] of the fluid that would move with all bodies."""
    total = np.zeros(2)
    for body, old, new in zip(bodies, before, after, strict=True):
        total += body.measure.volume * np.subtract(new.velocity, old.velocity) / dt
    return total


def spin_gained(body: Body, old: Pose, new: Pose) -> float:
    """Angular momentum [L^(ndim+2)/T] that fluid moving with a body gained about its centre."""
    return body.inertia(new) * new.spin[0] - body.inertia(old) * old.spin[0]
