"""What keeps bodies apart: unilateral contact without friction, with Newton's restitution.

The law is Moreau's: where two bodies touch, the impulse only pushes, and the normal velocity
after it is no less than ``-restitution`` times the one before; one of the two holds with equality.
It is imposed on velocities at the end of a step, with all contacts together; places are projected
beside it, so that a step of any length ends with the gaps kept (Jean's time stepping with the
projection of Acary). Source: J. J. Moreau, in *Nonsmooth Mechanics and Applications* (1988) 1;
M. Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235; V. Acary, ibid. 256 (2013) 224.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body, matter_velocity
from pmesh.bodies.gaps import Contact, contacts
from pmesh.bodies.motion import Free, coordinates
from pmesh.bodies.pose import Pose
from pmesh.bodies.spring import own_inertia
from pmesh.bodies.turning import turn_between, turned_on
from remesh.errors import InputError, as_number

__all__ = ["Contact", "ContactLaw", "contacts", "resolve"]

Values = NDArray[np.float64]
CLOSE = 1e-3  # gaps are kept to this, in spacings
ACTIVE = 0.02  # beyond the gap kept: what still touches, in spacings
OPENING = 0.05  # a step, in spacings: how fast bodies that were too near part
PART = 0.5  # of the law's gap: how far bodies go in a part of a step
PARTS = 64  # of a step, at most
ROUNDS = 40  # of projecting the places in one part


@dataclass(frozen=True, kw_only=True)
class ContactLaw:
    """How bodies touch: at a gap of some spacings, and how they bounce.

    ``restitution``: normal velocity after over before, 0 to 1; ``added``: of the fluid that a body
    carries with it, over the fluid it displaces, in the masses that meet (0 in vacuum).
    """

    gap: float = 1.0  # that bodies keep, in spacings
    reach: float = 2.0  # within which they are looked at, in spacings
    restitution: float = 0.0
    added: float = 1.0

    def __post_init__(self) -> None:
        """Refuse a gap that is not positive or not within reach, and a restitution beyond 1."""
        for name, hint in (("gap", 1.0), ("reach", 2.0), ("restitution", 0.0), ("added", 1.0)):
            value = as_number(f"ContactLaw {name}", getattr(self, name), hint=f"{name}={hint}")
            object.__setattr__(self, name, value)
        if not 0.0 < self.gap < self.reach < math.inf:
            raise InputError(
                f"ContactLaw: 0 < gap < reach asked, got gap {self.gap:g}, reach {self.reach:g}",
                hint="ContactLaw(gap=1.0, reach=2.0)",
            )
        if not 0.0 <= self.restitution <= 1.0:
            raise InputError(
                f"ContactLaw restitution must be 0 to 1, got {self.restitution:g}",
                hint="restitution=0.0",
            )
        if not 0.0 <= self.added < math.inf:
            raise InputError(
                f"ContactLaw added must not be negative, got {self.added:g}", hint="added=1.0"
            )


def resolve(
    bodies: Sequence[Body],
    before: Sequence[Pose],
    after: Sequence[Pose],
    law: ContactLaw,
    spacing: float,
) -> tuple[tuple[Pose, ...], Values]:
    """The poses at the end of a step such that free bodies keep their gaps, and the impulses.

    ``before``, ``after``: poses at the start, and foreseen at the end of the step. Returns the
    poses, places, velocities and spins changed where bodies touch, and impulses (n, m) along the
    axes and about each centre, per unit density of the fluid [L^(ndim+1)/T, L^(ndim+2)/T]; poses
    of bodies that touch nothing are the very ones given. Bodies that are not free, and what
    ``locked`` holds, have infinite mass: walls. Impulses on a pair are equal, opposite and on one
    line. Bodies land on the law's gap, whatever their speed (a long step is cut into parts of half
    that way); two that begin nearer part by 0.05 spacings a step. What rests keeps the speed that
    forces not yet in ``after`` give it in a step: the next impulse takes it away. A free body that
    walls crush cannot be helped.
    """
    untouched = np.zeros((len(bodies), len(coordinates(bodies[0].ndim)) if bodies else 0))
    if not any(isinstance(body.motion, Free) for body in bodies):
        return tuple(after), untouched
    parts = _parts(bodies, before, after, law, spacing)
    if parts == 0:
        return tuple(after), untouched
    inverse = np.array(
        [_inverse_mass(body, pose, law.added) for body, pose in zip(bodies, before, strict=True)]
    )
    kept = _gaps_kept(bodies, before, law, spacing)
    offset, moved = np.zeros_like(untouched), list(after)
    for part in range(1, parts + 1):
        way = [_between(a, b, part / parts) for a, b in zip(before, after, strict=True)]
        moved, touched = _apart(bodies, way, offset, inverse, kept, law, spacing)
    limits = _limits(touched, kept, law, spacing) + ACTIVE * spacing
    touching = [c for c, limit in zip(touched, limits, strict=True) if c.gap < limit]
    if not touching:
        return tuple(moved), untouched
    rows = _rows(touching, moved)
    approach = np.array([-_parting(c, bodies, before) for c in touching])
    parting = np.array([_parting(c, bodies, moved) for c in touching])
    wanted = law.restitution * np.maximum(approach, 0.0) - parting
    impulses = _along(rows, _pressed(rows, inverse, wanted))
    return tuple(map(_pushed, moved, _answers(inverse, impulses))), impulses


def _parts(
    bodies: Sequence[Body],
    before: Sequence[Pose],
    after: Sequence[Pose],
    law: ContactLaw,
    spacing: float,
) -> int:
    """How many parts a step needs, none where nothing comes near."""
    reach = law.reach * spacing
    lows, highs, ways = [], [], []
    for body, one, two in zip(bodies, before, after, strict=True):
        here, there = np.array(body.bounds(one)), np.array(body.bounds(two))
        radius = float(np.abs(here - np.array(one.center)).max()) * math.sqrt(body.ndim)
        turn = math.hypot(*turn_between(one.angle, two.angle)) * radius
        lows.append(np.minimum(here[0], there[0]) - 0.5 * turn)
        highs.append(np.maximum(here[1], there[1]) + 0.5 * turn)
        ways.append(math.dist(one.center, two.center) + turn)
    longest = -1.0
    for i, body in enumerate(bodies):
        if isinstance(body.motion, Free):
            for j in range(len(bodies)):
                meet = np.all(lows[i] <= highs[j] + reach) and np.all(lows[j] <= highs[i] + reach)
                if i != j and meet:
                    longest = max(longest, ways[i], ways[j])
    return 0 if longest < 0 else min(max(math.ceil(longest / (PART * law.gap * spacing)), 1), PARTS)


def _inverse_mass(body: Body, pose: Pose, added: float) -> Values:
    """Inverse (m, m) of the masses and moments of inertia, per unit density of the fluid."""
    motion, names = body.motion, coordinates(body.ndim)
    result = np.zeros((len(names), len(names)))
    if not isinstance(motion, Free):
        return result
    loose = np.flatnonzero([name not in motion.locked for name in names])
    heavy = (motion.density + added) * own_inertia(body, pose)
    result[np.ix_(loose, loose)] = np.linalg.inv(heavy[np.ix_(loose, loose)])
    return result


def _answers(inverse: Values, impulses: Values) -> Values:
    """What impulses (n, m) do to the velocities of the bodies."""
    return np.asarray(np.einsum("akl,al->ak", inverse, impulses))


def _gaps_kept(
    bodies: Sequence[Body], before: Sequence[Pose], law: ContactLaw, spacing: float
) -> dict[tuple[int, int], float]:
    """The gap [L] that each pair keeps which begins the step nearer than the law's."""
    kept: dict[tuple[int, int], float] = {}
    for one in contacts(bodies, before, law.reach * spacing):
        own = min(law.gap, one.gap / spacing + OPENING) * spacing
        kept[one.first, one.second] = min(own, kept.get((one.first, one.second), own))
    return kept


def _between(before: Pose, after: Pose, share: float) -> Pose:
    """The pose at a share of the way; its velocities are those at the end."""
    if share >= 1.0:
        return after
    center = tuple(
        (1 - share) * a + share * b for a, b in zip(before.center, after.center, strict=True)
    )
    turn = np.multiply(share, turn_between(before.angle, after.angle))
    time = (1 - share) * before.time + share * after.time
    return replace(after, time=time, center=center, angle=turned_on(before.angle, turn))


def _apart(
    bodies: Sequence[Body],
    poses: Sequence[Pose],
    offset: Values,
    inverse: Values,
    kept: dict[tuple[int, int], float],
    law: ContactLaw,
    spacing: float,
) -> tuple[list[Pose], tuple[Contact, ...]]:
    """The poses, moved the least (in the metric of mass) that keeps the gaps; fills ``offset``."""
    reach = law.reach * spacing
    for _ in range(ROUNDS):
        moved = [_shifted(pose, move) for pose, move in zip(poses, offset, strict=True)]
        found = contacts(bodies, moved, reach)
        lack = _limits(found, kept, law, spacing) - np.array([c.gap for c in found])
        if not np.any(lack > CLOSE * spacing):
            break
        rows = _rows(found, moved)
        offset += _answers(inverse, _along(rows, _pressed(rows, inverse, lack)))
    return moved, found


def _limits(
    found: Sequence[Contact], kept: dict[tuple[int, int], float], law: ContactLaw, spacing: float
) -> Values:
    """The gap [L] that each contact keeps."""
    return np.array([kept.get((c.first, c.second), law.gap * spacing) for c in found])


def _rows(found: Sequence[Contact], poses: Sequence[Pose]) -> Values:
    """How fast each contact opens (contacts, n, m) with the motion of each body."""
    size = len(poses[0].center) + len(poses[0].spin)
    rows = np.zeros((len(found), len(poses), size))
    for row, one in zip(rows, found, strict=True):
        for body, sign in ((one.first, 1.0), (one.second, -1.0)):
            arm, normal = np.subtract(one.point, poses[body].center), np.array(one.normal)
            if len(normal) == 2:
                turn = [arm[0] * normal[1] - arm[1] * normal[0]]
            else:
                turn = np.cross(arm, normal).tolist()
            row[body] = sign * np.array([*normal, *turn])
    return rows


def _along(rows: Values, pushes: Values) -> Values:
    """What pushes (contacts) are to each body (n, m)."""
    return np.asarray(np.tensordot(pushes, rows, axes=1))


def _parting(one: Contact, bodies: Sequence[Body], poses: Sequence[Pose]) -> float:
    """How fast a contact opens [L/T]."""
    point = np.array(one.point)[:, None]
    first, second = (matter_velocity(bodies[k], point, poses[k]) for k in (one.first, one.second))
    return float(np.dot(one.normal, (first - second)[:, 0]))


def _pressed(rows: Values, inverse: Values, lack: Values) -> Values:
    """The pushes p >= 0 with ``w p >= lack``, one of the two an equality for each contact.

    The least-squares problem with p >= 0, by active sets (Lawson and Hanson, *Solving Least
    Squares Problems* (1974), ch. 23): exact, however unlike the masses.
    """
    w = np.einsum("iak,akl,jal->ij", rows, inverse, rows)
    scale = np.sqrt(np.diag(w))
    able = scale > 0
    scale = np.where(able, scale, 1.0)
    w = w / np.outer(scale, scale) + 1e-10 * np.eye(len(w))
    aim = np.where(able, lack / scale, -1.0)
    push, chosen = np.zeros(len(w)), np.zeros(len(w), bool)
    for _ in range(10 * len(w) + 10):
        short = np.where(chosen, -np.inf, aim - w @ push)
        if not short.max() > 1e-12 * np.abs(aim).max():
            break
        chosen[short.argmax()] = True
        while True:
            trial = np.zeros(len(w))
            trial[chosen] = np.linalg.solve(w[np.ix_(chosen, chosen)], aim[chosen])
            wrong = chosen & (trial <= 0)
            if not wrong.any():
                break
            share = float(np.min(push[wrong] / (push[wrong] - trial[wrong] + 1e-300)))
            push = push + share * (trial - push)
            chosen &= ~(wrong & (push <= 1e-14 * push.max(initial=0.0)))
            push = np.where(chosen, push, 0.0)
        push = trial
    return push / scale


def _shifted(pose: Pose, move: Values) -> Pose:
    """A pose moved along its coordinates."""
    if not move.any():
        return pose
    n = len(pose.center)
    center = tuple(float(x) for x in pose.center + move[:n])
    return replace(pose, center=center, angle=turned_on(pose.angle, move[n:]))


def _pushed(pose: Pose, change: Values) -> Pose:
    """A pose whose velocity and spin changed."""
    if not change.any():
        return pose
    n = len(pose.center)
    velocity = tuple(float(x) for x in pose.velocity + change[:n])
    return replace(pose, velocity=velocity, spin=tuple(float(x) for x in pose.spin + change[n:]))
