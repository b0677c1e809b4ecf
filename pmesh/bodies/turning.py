"""Rotations: how turns follow each other, in the plane and in space.

A turn is one angle in the plane, a rotation vector in space: its direction is the axis, its length
the angle, at most pi. Turns in space do not commute; they are composed as unit quaternions
(w, x, y, z), all in world axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Turn = tuple[float, ...]
Given = Sequence[float] | Values


def quaternion(turn: Given) -> Values:
    """The unit quaternion of a rotation vector [rad]."""
    x, y, z = turn
    angle = math.hypot(x, y, z)
    share = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    return np.array([math.cos(0.5 * angle), share * x, share * y, share * z])


def rotation_vector(turned: Values) -> Turn:
    """The rotation vector [rad] of a quaternion of any length, |vector| <= pi."""
    w, x, y, z = (float(part) for part in (-turned if turned[0] < 0.0 else turned))
    sine = math.hypot(x, y, z)
    share = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 2.0 / w
    return share * x, share * y, share * z


def product(last: Values, first: Values) -> Values:
    """The quaternion of two turns, ``first`` first."""
    a, b = last[1:], first[1:]
    scalar = last[0] * first[0] - a @ b
    return np.array([scalar, *(last[0] * b + first[0] * a + np.cross(a, b))])


def inverse(turned: Values) -> Values:
    """The quaternion that turns back."""
    return np.asarray(turned * np.array([1.0, -1.0, -1.0, -1.0]))


def turned_on(angle: Given, by: Given) -> Turn:
    """Where a body stands at ``angle`` after a further turn ``by``, in world axes [rad].

    In the plane the sum; in space ``exp(by) exp(angle)``. With ``by = dt * spin``, the spin in mid
    step, it is of order two.
    """
    if len(angle) == 1:
        return (float(angle[0] + by[0]),)
    return rotation_vector(product(quaternion(by), quaternion(angle)))


def turn_between(before: Given, after: Given) -> Turn:
    """The turn in world axes that leads from one place to another: ``turned_on`` undone [rad]."""
    if len(before) == 1:
        return (float(after[0] - before[0]),)
    return rotation_vector(product(quaternion(after), inverse(quaternion(before))))
