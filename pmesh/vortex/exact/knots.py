"""Vortex knots: torus knots with Gaussian cores, the trefoil first of all."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pmesh.vortex.exact.flow import Triple, check, check_triple, frame
from pmesh.vortex.exact.tubes import Filament, Tubes, closed_filament, node_count
from remesh.errors import InputError, as_whole


@dataclass(frozen=True, kw_only=True)
class TorusKnot(Tubes):
    """Knot that winds ``turns[0]`` times about the axis and ``turns[1]`` times about a torus.

    ``r = R + b cos(q s), angle = p s, z = b sin(q s)``, 0 < s < 2 pi; (2, 3) is the trefoil. Where
    Gamma is positive it moves along ``axis``. The centre line is right-handed, its writhe and its
    helicity positive, or left-handed: its mirror image. In the limit of thin cores the helicity is
    ``Gamma^2 writhe``: the lines of the tube have no twist of their own against the centre
    line. Fields and invariants: see Tubes.
    Source of the curve: D. Kleckner, W. T. M. Irvine, Nature Phys. 9 (2013) 253.
    """

    turns: tuple[int, int] = (2, 3)  # (p, q), without common divisor
    radius: float = 1.0  # R of the torus [L]
    tube: float = 0.4  # b of the torus [L]
    core: float = 0.1  # a [L]
    circulation: float = 1.0  # Gamma [L^2/T]
    center: Triple = (0.0, 0.0, 0.0)  # [L]
    axis: Triple = (0.0, 0.0, 1.0)  # any length
    right_handed: bool = True

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive, a torus through its axis, turns that make no knot."""
        check(self, positive=("radius", "tube", "core"), not_negative=())
        check_triple(self, "center", "axis")
        frame(self.axis)
        for count in self.turns:
            as_whole("TorusKnot: turns", count, least=1, hint="turns=(2, 3)")
        if len(self.turns) != 2 or math.gcd(*self.turns) != 1:
            raise InputError(
                f"TorusKnot: turns must be two whole numbers without common divisor, "
                f"got {self.turns}",
                hint="turns=(2, 3)",
            )
        if self.tube >= self.radius:
            raise InputError(
                f"TorusKnot: tube = {self.tube} must be below radius = {self.radius}",
                hint=f"tube={0.4 * self.radius:.3g}",
            )

    def filaments(self) -> tuple[Filament, ...]:
        """The knot's centre line."""
        about, round_tube = self.turns
        longest = math.hypot(about * (self.radius + self.tube), round_tube * self.tube)
        count = node_count(self, longest, self.core, about + round_tube)
        s = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
        reach = self.radius + self.tube * np.cos(round_tube * s)
        height = self.tube * np.sin(round_tube * s) * (-1.0 if self.right_handed else 1.0)
        local = np.stack([reach * np.cos(about * s), reach * np.sin(about * s), height])
        curve = frame(self.axis).T @ local + np.asarray(self.center, float)[:, None]
        return (closed_filament(curve, self.circulation, self.core),)
