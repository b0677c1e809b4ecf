"""Exact flows: vorticity, velocity and invariants in closed form, for tests, demos and docs."""

from pmesh.vortex.exact.flow import ExactFlow
from pmesh.vortex.exact.hill import HillVortex
from pmesh.vortex.exact.knots import TorusKnot
from pmesh.vortex.exact.patches import EllipticVortex, KirchhoffEllipse, PerlmanPatch
from pmesh.vortex.exact.periodic import BeltramiFlow, TaylorGreenCube
from pmesh.vortex.exact.rings import GaussianRing, VortexRing, head_on, leapfrogging, oblique
from pmesh.vortex.exact.strained import StrainedRing
from pmesh.vortex.exact.superposition import Superposition
from pmesh.vortex.exact.thin_rings import CoaxialRings, thin_ring_speed
from pmesh.vortex.exact.tubes import VortexTubes
from pmesh.vortex.exact.viscous import LambOseen, TaylorGreen

__all__ = [
    "BeltramiFlow",
    "CoaxialRings",
    "EllipticVortex",
    "ExactFlow",
    "GaussianRing",
    "HillVortex",
    "KirchhoffEllipse",
    "LambOseen",
    "PerlmanPatch",
    "StrainedRing",
    "Superposition",
    "TaylorGreen",
    "TaylorGreenCube",
    "TorusKnot",
    "VortexRing",
    "VortexTubes",
    "head_on",
    "leapfrogging",
    "oblique",
    "thin_ring_speed",
]
