"""Exact flows: vorticity, velocity and invariants in closed form, for tests, demos and docs."""

from pmesh.vortex.exact.flow import ExactFlow
from pmesh.vortex.exact.patches import EllipticVortex, KirchhoffEllipse, PerlmanPatch
from pmesh.vortex.exact.viscous import LambOseen, TaylorGreen

__all__ = [
    "EllipticVortex",
    "ExactFlow",
    "KirchhoffEllipse",
    "LambOseen",
    "PerlmanPatch",
    "TaylorGreen",
]
