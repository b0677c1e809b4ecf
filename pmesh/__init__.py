"""Flows, interfaces and bodies computed with particles that are remeshed onto a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

from remesh.lazy import lazy_names

if TYPE_CHECKING:
    from pmesh.bodies.body import RigidBody as RigidBody
    from pmesh.bodies.contact import ContactLaw as ContactLaw
    from pmesh.bodies.forcing import DirectForcing as DirectForcing
    from pmesh.bodies.motion import Fixed as Fixed
    from pmesh.bodies.motion import Free as Free
    from pmesh.bodies.motion import Prescribed as Prescribed
    from pmesh.bodies.motion import Spring as Spring
    from pmesh.bodies.penalise import Penalisation as Penalisation
    from pmesh.bodies.swimmer import Swimmer as Swimmer
    from pmesh.run.forecast import Estimate as Estimate
    from pmesh.run.forecast import estimate as estimate
    from pmesh.run.loop import run as run
    from pmesh.run.progress import Progress as Progress
    from pmesh.run.snapshots import Snapshots as Snapshots
    from pmesh.run.watchers import Forces as Forces
    from pmesh.run.watchers import Ledger as Ledger
    from pmesh.spectral.corrections import AdaptiveSolver as AdaptiveSolver
    from pmesh.spectral.poisson import poisson as poisson
    from pmesh.spectral.poisson import velocity as velocity
    from pmesh.vortex.carrier import Carrier as Carrier
    from pmesh.vortex.criteria import lambda2 as lambda2
    from pmesh.vortex.criteria import q_criterion as q_criterion
    from pmesh.vortex.flow import VortexFlow as VortexFlow
    from pmesh.vortex.flowmap import VelocityHistory as VelocityHistory
    from pmesh.vortex.flowmap import ftle as ftle
    from pmesh.vortex.state import State as State
    from pmesh.vortex.window import Window as Window
    from remesh.errors import BlowUpError as BlowUpError
    from remesh.errors import InputError as InputError
    from remesh.errors import PmeshError as PmeshError
    from remesh.errors import StorageError as StorageError
    from remesh.limit import Limit as Limit
else:
    from pmesh import run  # a package that can be called

__all__ = [
    "AdaptiveSolver",
    "BlowUpError",
    "Carrier",
    "ContactLaw",
    "DirectForcing",
    "Estimate",
    "Fixed",
    "Forces",
    "Free",
    "InputError",
    "Ledger",
    "Limit",
    "Penalisation",
    "PmeshError",
    "Prescribed",
    "Progress",
    "RigidBody",
    "Snapshots",
    "Spring",
    "State",
    "StorageError",
    "Swimmer",
    "VelocityHistory",
    "VortexFlow",
    "Window",
    "estimate",
    "ftle",
    "lambda2",
    "poisson",
    "q_criterion",
    "run",
    "velocity",
]

_HOME = {
    "Carrier": "pmesh.vortex.carrier",
    "Fixed": "pmesh.bodies.motion",
    "Free": "pmesh.bodies.motion",
    "Prescribed": "pmesh.bodies.motion",
    "Spring": "pmesh.bodies.motion",
    "Window": "pmesh.vortex.window",
    "RigidBody": "pmesh.bodies.body",
    "ContactLaw": "pmesh.bodies.contact",
    "DirectForcing": "pmesh.bodies.forcing",
    "Swimmer": "pmesh.bodies.swimmer",
    "Penalisation": "pmesh.bodies.penalise",
    "Estimate": "pmesh.run.forecast",
    "estimate": "pmesh.run.forecast",
    "Progress": "pmesh.run.progress",
    "Snapshots": "pmesh.run.snapshots",
    "Forces": "pmesh.run.watchers",
    "Ledger": "pmesh.run.watchers",
    "poisson": "pmesh.spectral.poisson",
    "velocity": "pmesh.spectral.poisson",
    "VelocityHistory": "pmesh.vortex.flowmap",
    "AdaptiveSolver": "pmesh.spectral.corrections",
    "VortexFlow": "pmesh.vortex.flow",
    "ftle": "pmesh.vortex.flowmap",
    "lambda2": "pmesh.vortex.criteria",
    "q_criterion": "pmesh.vortex.criteria",
    "Limit": "remesh.limit",
    "State": "pmesh.vortex.state",
    "BlowUpError": "remesh.errors",
    "InputError": "remesh.errors",
    "PmeshError": "remesh.errors",
    "StorageError": "remesh.errors",
}

__getattr__, __dir__ = lazy_names(globals(), _HOME)
