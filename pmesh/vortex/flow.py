"""Incompressible flow carried by remeshed vortex particles, past penalised bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.contact import ContactLaw
from pmesh.bodies.forcing import DirectForcing
from pmesh.bodies.mask import Mask
from pmesh.bodies.penalise import Penalisation
from pmesh.bodies.pose import Pose
from pmesh.vortex.engine import Engine
from pmesh.vortex.limits import body_limits, ratio
from pmesh.vortex.loads import load_columns
from pmesh.vortex.recipe import validate
from pmesh.vortex.routes import check_routes, route_names, routes
from pmesh.vortex.state import FlowState, State
from pmesh.vortex.window import Window
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.limit import Limit, check_step, tightest
from remesh.multires.mesh import AdaptiveMesh
from remesh.stretching import Form

Array = NDArray[np.floating[Any]]

DEFAULT = Penalisation()
TOUCH = ContactLaw()


@dataclass(frozen=True, kw_only=True)
class VortexFlow:
    """Incompressible flow in a plane or in space, carried by remeshed vortex particles.

    Each step: half of the viscous spread and of the bodies' force, particles carried by the
    velocity they induce and remeshed, the other half (Strang). Second order in dt, third with
    "RK3" where nothing spreads; of the kernel's order in the spacing when dt follows it (in space
    measured 2.0, 4.0, 6.5 with M4', M6', L6,4). The spread is exact in time and never limits dt.
    Bodies are held implicitly, by penalisation or in the plane direct forcing, iterated on its slip
    residual; free ones move with what the fluid does to them in the same solve, and never overlap:
    first order in dt; in the spacing the plane's drag is of order 1.2, by direct forcing of order
    2. In the plane circulation and what was counted at unbounded edges stay one sum to round-off,
    as does the linear impulse without bodies; "distorted" particles that feel viscosity keep them
    to 1e-6, and to 0.4 % of what leaves.

    In space vorticity is a vector, (3, *shape), stretched with the particles' lattice
    (``stretching``). The conservative form keeps its total to round-off, the classical one to the
    divergence there is; the impulse drifts with the order in dt. Remeshing leaves divergence:
    ``cleaning`` takes part of it at each step, ``projection`` all that differences see at every
    n-th. ``diffusion`` is by a compact stencil in space, through FFTs in the plane.

    Refuses a negative viscosity, bodies that do not fit or overlap, and adaptive meshes in space; a
    body that leaves a fixed mesh is a BlowUpError.

    On a `remesh.AdaptiveMesh`, in the plane, each level is carried so, with its own spacing, and
    fields and velocities are on blocks. The velocity is right to the mesh's tolerance, the spread
    of order 8 and more in the spacing; adaptation keeps the moments, particles that pass from level
    to level lose some per cent of the tolerance in a step. The box does not grow; its coarse part
    is cheap.
    """

    grid: Grid | AdaptiveMesh  # the mesh at the start
    viscosity: float = 0.0  # nu [L^2/T]
    freestream: tuple[float, ...] = ()  # [L/T]; none is at rest far away
    bodies: tuple[Body, ...] = ()
    deformation: float = 0.25  # largest dt * max|grad u|
    kernel: str | Kernel = "M6'"  # of remeshing and interpolation
    time_scheme: Literal["RK2", "RK3", "RK4"] = "RK2"
    remeshing: Literal["always", "distorted"] = "always"
    distortion: float = 0.1  # largest strain of the particles' lattice, for "distorted"
    domain: Literal["grow", "follow", "fixed"] = "grow"  # of the unbounded axes
    negligible: float | None = None  # part of the largest vorticity that no room is made for; None:
    # 1e-6, and 1e-4 with projection
    order: int = 8  # of the Gaussian-regularised Poisson solve
    radius: float = 2.0  # of its regularisation, in spacings
    window: Window | None = None  # around the bodies, in body lengths, out of which wakes may leave
    penalisation: Penalisation | DirectForcing = DEFAULT
    stretching: Form = "conservative"  # of vorticity in space, see `Carriage`
    cleaning: bool = True  # divergence of vorticity in space, see `clean_divergence`
    projection: int = 0  # steps between projections onto solenoidal vorticity in space; 0: never
    diffusion: Literal["spectral", "compact"] | None = None  # None: compact in space
    contact: ContactLaw = TOUCH  # between bodies of which one at least is free
    largest_step: float = math.inf  # upper bound of dt [T]
    dtype: Literal["float64", "float32"] = "float64"
    threads: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot run."""
        validate(self)

    @property
    def lattice(self) -> Grid:
        """The mesh at the start, the finest one if it is adaptive."""
        return self.grid.grid if isinstance(self.grid, AdaptiveMesh) else self.grid

    @cached_property
    def engine(self) -> Engine[Any]:
        """What steps it on its kind of mesh."""
        if isinstance(self.grid, AdaptiveMesh):
            from pmesh.vortex.adaptive import AdaptiveEngine

            return AdaptiveEngine(self)
        from pmesh.vortex.uniform import UniformEngine

        return UniformEngine(self)

    def start(self, *, vorticity: Array | Callable[[Array], Array] | None = None) -> Any:
        """The state at time 0: ``vorticity`` on the nodes, or a law of points, or none.

        Points are (ndim, *shape); vorticity is a scalar in the plane, a vector (3, *shape) in
        space, where it must be the curl of a velocity.

        With bodies the start is impulsive: the slip of the given flow becomes a vortex sheet, and
        the impulse that this takes (the added mass) is not part of any later force. Refuses a
        uniform mesh for which the memory that is free does not suffice.
        """
        from pmesh.vortex.cost import refuse_without_room

        refuse_without_room(self)
        return self.engine.start(vorticity)

    def step(self, state: Any, dt: float) -> Any:
        """The state one step of dt [T] later; refuses a dt that is not positive and finite."""
        self.engine.check(state)
        return self.engine.step(state, check_step(dt))

    def limit(self, state: FlowState) -> Limit:
        """The largest step [T] that this state allows, and the rule that sets it.

        "deformation": dt * max|grad u| <= ``deformation``, from the last step's velocity; "body":
        no particle passes more than a tenth of the thinnest body; "diffusion": the viscous spread
        stays below a tenth of it; "motion": a law of motion or a body's period is resolved, a
        falling body drops less than a quarter of a spacing from rest, a spring swings less than
        half a radian; "largest_step": the user's own bound.
        """
        self.engine.check(state)
        limits = [Limit(ratio(self.deformation, state.gradient), "deformation")]
        limits += body_limits(self.bodies, state, self.viscosity)
        limits.append(Limit(self.largest_step, "largest_step"))
        return tightest(*limits)

    def velocity(self, state: Any) -> Array:
        """Velocity on the nodes or blocks, free stream included, [L/T]: (ndim, *shape)."""
        return self.engine.velocity(state)

    def ledger(self, state: Any) -> Mapping[str, float]:
        """Integrals of the vorticity, and what left the mesh."""
        return self.engine.ledger(state)

    def forces(self, state: FlowState) -> Mapping[str, float]:
        """Forces on the bodies per unit density [L^3/T^2], means over the last step, and the slip.

        ``bodyN_force``, ``_torque`` (about its centre), ``_power`` (that it gives to the fluid):
        from the momentum of the force that holds it; ``impulse_force``: on all bodies, from the
        rate of the vorticity's impulse, which the curl of the force changes by that momentum
        and everything else must leave alone. It is NaN across a periodic axis, and while vorticity
        leaves a fixed mesh; all are NaN at the start. ``slip``: velocity left in the bodies, root
        mean square; ``slip_residual``: how far it is from the law that holds them. What moves
        tells its place too: ``bodyN_x, _y, _angle`` and their rates ``_u, _v, _spin``.
        """
        if state.constraint is None:
            return {}
        columns = load_columns(self.bodies, state.loads, state.poses)
        names = [f"impulse_{what}_{axis}" for what in ("force", "torque") for axis in "xyz"]
        if self.lattice.ndim == 2:
            names = ["impulse_force_x", "impulse_force_y"]
        columns |= dict(zip(names, state.impulse_force, strict=True))
        held = state.constraint
        columns |= {"slip": held.slip, "slip_max": held.slip_max, "slip_residual": held.residual}
        return columns | {"slip_iterations": float(held.iterations)}

    def routes(self, before: State, after: State) -> Mapping[str, float]:
        """Forces and torques over the step between two states by two more routes: see `routes`.

        Refuses flows in space and adaptive meshes.
        """
        check_routes(self)
        return routes(self, before, after)

    @property
    def route_names(self) -> list[str]:
        """The columns of ``routes``, refused where those are."""
        check_routes(self)
        return route_names(len(self.bodies))

    def mask(self, grid: Grid, poses: tuple[Pose, ...]) -> Mask:
        """Where the bodies are imposed at these poses, on a box of the lattice of a mesh."""
        return self.engine.wall_on(grid, poses).mask()

    def fields(self, state: Any) -> Mapping[str, Array]:
        """Vorticity and velocity on the nodes; with bodies their indicator too."""
        return self.engine.fields(state)
