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
AXES = "xyz"
PLACES = {  # columns of a body that moves
    2: ("x", "y", "angle", "u", "v", "spin"),
    3: (*(*"xyz", "turn_x", "turn_y", "turn_z"), *"uvw", "spin_x", "spin_y", "spin_z"),
}


def moments(impulse: Array, mask: Mask, poses: Sequence[Pose]) -> Values:
    """Sums (bodies, m) of an impulse density over each body: along the axes, about its centre."""
    ndim, axes = mask.grid.ndim, mask.grid.axes()
    sums = []
    for number, pose in enumerate(poses):
        own = impulse if len(poses) == 1 else np.where(mask.owner == number, impulse, 0.0)
        arms = [axis - middle for axis, middle in zip(axes, pose.center, strict=True)]
        total = _marginal(own, 0).sum(axis=1)
        along = [_marginal(own, axis) @ arm for axis, arm in enumerate(arms)]  # int r_i f
        turns = ((0, 1),) if ndim == 2 else ((1, 2), (2, 0), (0, 1))
        sums.append([*total, *(along[i][j] - along[j][i] for i, j in turns)])
    return np.array(sums) * mask.grid.cell_volume


def _marginal(field: Array, axis: int) -> Values:
    """Sums (ndim, n) of a vector field over all axes of the mesh but one."""
    others = tuple(a + 1 for a in range(field.ndim - 1) if a != axis)
    return np.asarray(field.sum(axis=others, dtype=np.float64))


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
    """Loads from the impulse on the fluid (bodies, m), its work, and the gain of kinetic energy.

    The fluid in the body's place moves with it, and its inertia is not the outer fluid's doing.
    """
    loads = []
    for number, body in enumerate(bodies):
        old, new, n = before[number], after[number], body.ndim
        gain = dt * inertia_force((body,), (old,), (new,), dt)
        turn = spin_gained(body, old, new)
        loads.append(
            Load(
                force=_plain((gain - sums[number, :n]) / dt),
                torque=_plain((turn - sums[number, n:]) / dt),
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
        energy = 0.5 * (volume * speed + float(np.dot(pose.spin, angular_momentum(body, pose))))
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
        columns |= {f"{name}_force_{a}": x for a, x in zip(AXES, load.force, strict=False)}
        ends = [""] if len(load.torque) == 1 else [f"_{a}" for a in AXES]
        columns |= {f"{name}_torque{a}": x for a, x in zip(ends, load.torque, strict=True)}
        columns[f"{name}_power"] = load.power
        if moves(body):
            values = (*pose.center, *pose.angle, *pose.velocity, *pose.spin)
            columns |= {f"{name}_{a}": x for a, x in zip(PLACES[body.ndim], values, strict=True)}
    return columns


def inertia_force(
    bodies: Sequence[Body], before: Sequence[Pose], after: Sequence[Pose], dt: float
) -> Values:
    """Rate of momentum [L^(ndim+1)/T^2] of the fluid that would move with all bodies."""
    total = np.zeros(len(before[0].center) if before else 0)
    for body, old, new in zip(bodies, before, after, strict=True):
        total += body.measure.volume * np.subtract(new.velocity, old.velocity) / dt
    return total


def inertia_torque(
    bodies: Sequence[Body], before: Sequence[Pose], after: Sequence[Pose], dt: float
) -> Values:
    """Rate of angular momentum [L^(ndim+2)/T^2] of that fluid about the origin: 1 or 3 numbers."""
    total = np.zeros(len(before[0].spin) if before else 0)
    for body, old, new in zip(bodies, before, after, strict=True):
        gain = spin_gained(body, old, new)
        for pose, sign in ((new, 1.0), (old, -1.0)):
            carried = np.cross(pose.center, pose.velocity) if body.ndim == 3 else _area_swept(pose)
            gain = gain + sign * body.measure.volume * carried
        total += gain / dt
    return total


def spin_gained(body: Body, old: Pose, new: Pose) -> Values:
    """Angular momentum [L^(ndim+2)/T] that fluid moving with a body gained about its centre.

    One number in the plane, three in space.
    """
    return angular_momentum(body, new) - angular_momentum(body, old)


def angular_momentum(body: Body, pose: Pose) -> Values:
    """That of fluid which turns with a body, about its centre [L^(ndim+2)/T]."""
    return np.asarray(np.atleast_2d(body.inertia(pose)) @ np.array(pose.spin))


def _area_swept(pose: Pose) -> float:
    """x v - y u of a plane body's centre."""
    (x, y), (u, v) = pose.center, pose.velocity
    return x * v - y * u


def _plain(values: Values) -> tuple[float, ...]:
    return tuple(float(x) for x in values)
