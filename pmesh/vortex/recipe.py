"""What a vortex flow refuses, before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.penalise import Penalisation
from pmesh.spectral.symbols import Greens
from pmesh.vortex.schemes import SCHEMES
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import get_kernel

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]


def validate(flow: VortexFlow) -> None:
    """Refuse parameters of a flow that cannot run; lists become tuples."""
    if not isinstance(flow.grid, Grid) or flow.grid.ndim != 2:
        raise InputError(
            f"VortexFlow needs a 2-D grid, got {flow.grid!r}", hint="Grid((256, 128), 1/64)"
        )
    object.__setattr__(flow, "freestream", _vector(flow.freestream, flow.grid.ndim))
    if not isinstance(flow.bodies, Iterable):
        raise InputError(
            f"bodies must be a list of bodies, got {flow.bodies!r}", hint="bodies=[body]"
        )
    object.__setattr__(flow, "bodies", tuple(flow.bodies))
    if not (math.isfinite(flow.viscosity) and flow.viscosity >= 0):
        raise InputError(
            f"viscosity must be zero or positive, got {flow.viscosity}", hint="viscosity=1/550"
        )
    for name in ("deformation", "distortion", "largest_step"):
        value = getattr(flow, name)
        if math.isnan(value) or value <= 0:
            raise InputError(f"{name} must be positive, got {value}", hint=f"{name}=0.25")
    get_kernel(flow.kernel)
    Greens(order=flow.order, radius=flow.radius)
    _one_of("time_scheme", flow.time_scheme, SCHEMES)
    _one_of("remeshing", flow.remeshing, ("always", "distorted"))
    _one_of("domain", flow.domain, ("grow", "follow", "fixed"))
    _one_of("dtype", flow.dtype, ("float64", "float32"))
    if not isinstance(flow.penalisation, Penalisation):
        raise InputError(
            f"penalisation must be a Penalisation, got {flow.penalisation!r}",
            hint="penalisation=Penalisation(strength=1000)",
        )
    _check_bodies(flow)


def checked_vorticity(
    vorticity: Array | Callable[[Array], Array] | None, grid: Grid, dtype: np.dtype[Any]
) -> Array:
    """Start values on the nodes, from an array, a law of points or nothing."""
    if vorticity is None:
        return np.zeros(grid.shape, dtype)
    values = np.asarray(vorticity(grid.points()) if callable(vorticity) else vorticity)
    if values.shape != grid.shape:
        raise InputError(
            f"vorticity must have the grid's shape {grid.shape}, got {values.shape}",
            hint="values on grid.points(), or a function of points (2, *shape)",
        )
    if not np.isfinite(values).all():
        raise InputError(
            f"vorticity must be finite, {np.count_nonzero(~np.isfinite(values))} values are not",
            hint="check the initial condition",
        )
    return np.array(values, dtype, order="C")


def _vector(value: object, ndim: int) -> tuple[float, ...]:
    given = np.asarray(value, dtype=object).ravel()
    try:
        numbers = tuple(float(x) for x in given)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != ndim or not all(math.isfinite(x) for x in numbers):
        raise InputError(
            f"freestream must hold {ndim} finite velocities, got {value!r}",
            hint="freestream=(1.0, 0.0)",
        )
    return numbers


def _one_of(name: str, value: str, known: Iterable[str]) -> None:
    if value not in known:
        words = ", ".join(repr(word) for word in known)
        raise InputError(f"{name} must be one of {words}, got {value!r}", hint=f"one of {words}")


def _check_bodies(flow: VortexFlow) -> None:
    if not flow.bodies:
        return
    if flow.viscosity == 0:
        raise InputError(
            "a body holds the fluid by viscosity, which is 0 here", hint="viscosity=1/550"
        )
    low = flow.grid.origin
    high = tuple(start + span for start, span in zip(low, flow.grid.length, strict=True))
    for number, body in enumerate(flow.bodies):
        if not all(hasattr(body, name) for name in ("distance", "bounds", "velocity")):
            raise InputError(
                f"bodies[{number}] is a {type(body).__name__}, not a body",
                hint="pmesh.RigidBody(levelset.shapes.Disk(radius=0.5))",
            )
        if body.ndim != flow.grid.ndim:
            raise InputError(
                f"bodies[{number}] has {body.ndim} dimensions, the grid {flow.grid.ndim}",
                hint="a plane shape, such as levelset.shapes.Disk",
            )
        first, last = body.bounds(0.0)
        if any(a < b for a, b in zip(first, low, strict=True)) or any(
            a > b for a, b in zip(last, high, strict=True)
        ):
            raise InputError(
                f"bodies[{number}] reaches from {first} to {last}, "
                f"outside the domain {low} to {high}",
                hint="a larger grid, or another place for the body",
            )
        if min(b - a for a, b in zip(first, last, strict=True)) < 8 * flow.grid.spacing:
            raise InputError(
                f"bodies[{number}] is thinner than 8 spacings of {flow.grid.spacing:g}",
                hint="a finer spacing",
            )
