"""One step past bodies: where they go, the force that holds them there, and what it did."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.contact import ContactLaw, resolve
from pmesh.bodies.freedom import arrived, freedom_of, outer_impulses, predicted
from pmesh.bodies.pose import Pose
from pmesh.vortex.constraint import Wall
from pmesh.vortex.loads import kinetic_energy, loads_of, moments, work
from pmesh.vortex.state import Constraint, FlowState, Load

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


class Held(NamedTuple):
    """What a step left behind."""

    created: Array  # vorticity on the mesh by the second part of the force [1/T]
    constraint: Constraint
    loads: tuple[Load, ...]
    poses: tuple[Pose, ...]
    earlier: tuple[Pose, ...]  # to foresee the next from; a body that was hit has no acceleration


class Ahead(NamedTuple):
    """Where the bodies will be at the end of a step, and what pushes them apart on the way."""

    poses: tuple[Pose, ...]
    hits: Values  # impulse of contacts on each body, (bodies, m)


def foresee(bodies: tuple[Body, ...], state: FlowState, contact: ContactLaw, dt: float) -> Ahead:
    """The poses dt [T] later, kept apart."""
    poses = predicted(bodies, state.earlier, state.poses, dt)
    return Ahead(*resolve(bodies, state.poses, poses, contact, state.grid.spacing))


@dataclass(frozen=True, kw_only=True)
class Passage:
    """The bodies over one step: half of the last known force first, the rest when they arrive."""

    before: Wall
    after: Wall  # at the predicted poses
    dt: float
    last: Constraint
    given: Array | None  # impulse density of the first half, on the near box of ``before`` [L/T]
    push: Values  # outer impulse on each body, (bodies, m)
    hit: tuple[bool, ...]  # which bodies another one pushed

    @classmethod
    def planned(cls, state: FlowState, wall: Wall, ahead: Ahead, dt: float) -> Passage:
        """The step that a state begins; on the first one no force is known."""
        assert state.constraint is not None  # there are bodies
        return cls(
            before=wall,
            after=wall.at(ahead.poses),
            dt=dt,
            last=state.constraint,
            given=0.5 * dt * state.constraint.force if state.step > 0 else None,
            push=outer_impulses(wall.bodies, state.poses, dt) + ahead.hits,
            hit=tuple(bool(row.any()) for row in ahead.hits),
        )

    @property
    def tau(self) -> float:
        """Time over which the second part of the force acts [T]."""
        return self.dt if self.given is None else 0.5 * self.dt

    def arrive(self, velocity: Array, speed: float) -> Held:
        """Hold the bodies at the end of the step, given the velocity there without the force."""
        before, after = self.before, self.after
        bodies = after.bodies
        sums, worked = np.zeros_like(self.push), np.zeros(len(bodies))
        guess = carried = None
        if self.given is not None:
            mask = before.mask()
            sums = moments(self.given, mask, before.poses)
            worked = work(self.given, mask, before.poses, bodies)
            carried = after.carried(before, self.given)
            guess = after.guess(carried + after.carried(before, self.dt * self.last.change))
        freedom = freedom_of(
            bodies, before.poses, after.poses, after.mask(), self.push - sums, self.dt
        )
        speed = max(speed, after.fastest())
        imposed = after.impose(velocity, self.tau, speed, guess, freedom)
        poses = arrived(bodies, after.poses, after.mask(), imposed.values)
        sums = sums + moments(imposed.impulse, after.mask(), poses)
        worked = worked + work(imposed.impulse, after.mask(), poses, bodies)
        gained = kinetic_energy(after, poses) - kinetic_energy(before, before.poses)
        force, change = self._means(imposed.impulse, carried)
        return Held(
            created=after.created(imposed.impulse, after.viscosity * self.tau),
            constraint=after.held(imposed, force, change),
            loads=loads_of(bodies, before.poses, poses, sums, worked, gained, self.dt),
            poses=poses,
            earlier=tuple(
                replace(old, velocity=new.velocity, spin=new.spin) if hit else old
                for old, new, hit in zip(before.poses, poses, self.hit, strict=True)
            ),
        )

    def _means(self, impulse: Array, carried: Array | None) -> tuple[Array, Array]:
        """The mean force density over the step, and its change since the last step."""
        if carried is None:
            return impulse / self.dt, np.zeros_like(impulse)
        force = (impulse + carried) / self.dt
        return force, force - carried / (0.5 * self.dt)
