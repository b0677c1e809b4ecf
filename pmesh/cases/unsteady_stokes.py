"""A cylinder that sets off slowly in viscous fluid: exact laws of unsteady Stokes flow.

The force per length on a cylinder with the velocity U is, in Laplace's variable s,
``F = -pi a^2 rho [1 + 4 K1(z) / (z K0(z))] s U``, ``z = a sqrt(s / nu)``: the first term is the
added mass, the second friction and its history. Source: G. G. Stokes, Trans. Camb. Phil. Soc. 9
(1851) 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
NODES = 24  # of Talbot's contour: about 10 digits, before round-off eats more


class Release(NamedTuple):
    """A cylinder let go in fluid at rest, at some times; what falls has positive speed."""

    speed: Values  # [L/T]
    acceleration: Values  # [L/T^2]
    friction: Values  # force of viscosity over the mass of the fluid displaced [L/T^2]


def released(
    time: float | Values, *, density: float, pull: float, viscosity: float, radius: float
) -> Release:
    """Motion at times > 0 [T] of a cylinder of a density (over the fluid's) that is let go.

    ``pull``: its weight less its buoyancy, over the mass of the fluid displaced [L/T^2]. Inertia of
    the flow around it is left out: right until it has moved by a tenth of its diameter.
    """

    def gain(s: Complex) -> Complex:
        weighed = s * (density + 1.0 + history(s, viscosity, radius))
        return np.asarray(pull / weighed, np.complex128)

    when = np.asarray(time, np.float64)
    return Release(
        speed=inverse_laplace(lambda s: gain(s) / s, when),
        acceleration=inverse_laplace(gain, when),
        friction=inverse_laplace(lambda s: gain(s) * history(s, viscosity, radius), when),
    )


def friction_of_acceleration(
    time: float | Values, *, viscosity: float, radius: float
) -> NDArray[np.float64]:
    """Force of viscosity at times > 0 [T] at constant acceleration 1 from rest.

    Over the mass of the fluid displaced; the added mass gives 1 more.
    """
    return inverse_laplace(lambda s: history(s, viscosity, radius) / s, time)


def history(s: Complex, viscosity: float, radius: float) -> Complex:
    """``4 K1(z) / (z K0(z))``: the viscous part of the force, over ``pi a^2 rho s U``."""
    from scipy.special import kve  # imported late: scipy is slow to load

    z = radius * np.sqrt(s / viscosity)
    return np.asarray(4.0 * kve(1, z) / (z * kve(0, z)), np.complex128)


def inverse_laplace(
    transform: Callable[[Complex], Complex], time: float | NDArray[np.floating[Any]]
) -> Values:
    """The function of time > 0 whose Laplace transform this is, by Talbot's contour.

    Relative error about 1e-9 for what is smooth and has its singularities at s <= 0. Source:
    J. Abate, P. P. Valko, Int. J. Numer. Meth. Engng 60 (2004) 979. Refuses times not above zero.
    """
    when = np.asarray(time, np.float64)
    if not np.all(when > 0):
        raise InputError("the inverse is known after t = 0 only", hint="times above zero")
    angle = np.arange(1, NODES) * math.pi / NODES
    cot = 1.0 / np.tan(angle)
    rate = 2.0 * NODES / (5.0 * when[..., None])
    s = rate * angle * (cot + 1j)
    slope = 1.0 + 1j * (angle + (angle * cot - 1.0) * cot)
    parts = np.real(np.exp(s * when[..., None]) * transform(s) * slope)
    first = 0.5 * np.exp(rate * when[..., None]) * np.real(transform(rate + 0j))
    return np.asarray((rate / NODES * (first + parts.sum(-1, keepdims=True)))[..., 0], np.float64)
