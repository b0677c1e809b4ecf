"""What a vortex flow refuses, before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.contact import ContactLaw
from pmesh.bodies.forcing import DirectForcing
from pmesh.bodies.mask import MARGIN, box_around
from pmesh.bodies.penalise import Penalisation
from pmesh.bodies.pose import Pose
from pmesh.spectral.corrections import AdaptiveSolver
from pmesh.spectral.symbols import Greens
from pmesh.vortex.window import Window
from remesh.errors import InputError, as_number, as_whole
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.multires.mesh import AdaptiveMesh
from remesh.paths import SCHEMES
from remesh.stencils import divergence_ratio
from remesh.threads import thread_count

if TYPE_CHECKING:
    from pmesh.vortex.flow import VortexFlow

Array = NDArray[np.floating[Any]]

BALLS = {2: "Disk", 3: "Sphere"}  # shapes to begin with
OVERLAP = 0.5  # spacings by which two bodies may each lie inside the other at the start
DIVERGENT = 0.4  # divergence over gradients of a start, at most; of noise it is 0.58
THICK = 8.0  # spacings between the walls of a body, at least


def validate(flow: VortexFlow) -> None:
    """Refuse parameters of a flow that cannot run; lists become tuples."""
    if not isinstance(flow.grid, Grid | AdaptiveMesh) or flow.grid.ndim not in (2, 3):
        raise InputError(
            f"VortexFlow needs a grid in 2 or 3 dimensions, uniform or adaptive, got {flow.grid!r}",
            hint="Grid((256, 128), 1/64)",
        )
    stream = flow.freestream if np.size(flow.freestream) else (0.0,) * flow.grid.ndim
    object.__setattr__(flow, "freestream", _vector(stream, flow.grid.ndim))
    if not isinstance(flow.bodies, Iterable):
        raise InputError(
            f"bodies must be a list of bodies, got {flow.bodies!r}", hint="bodies=[body]"
        )
    object.__setattr__(flow, "bodies", tuple(flow.bodies))
    viscosity = as_number("viscosity", flow.viscosity, hint="viscosity=1/550")
    if not (math.isfinite(viscosity) and viscosity >= 0):
        raise InputError(
            f"viscosity must be zero or positive, got {flow.viscosity}", hint="viscosity=1/550"
        )
    for name in ("deformation", "distortion", "largest_step"):
        value = as_number(name, getattr(flow, name), hint=f"{name}=0.25")
        if math.isnan(value) or value <= 0:
            raise InputError(f"{name} must be positive, got {value}", hint=f"{name}=0.25")
    if flow.negligible is not None:
        part = as_number("negligible", flow.negligible, hint="negligible=1e-6")
        if not 0 < part < 1:
            raise InputError(
                f"negligible must be between 0 and 1, got {part}", hint="negligible=1e-6"
            )
    get_kernel(flow.kernel)
    Greens(order=flow.order, radius=as_number("radius", flow.radius, hint="radius=2.0"))
    thread_count(flow.threads)
    _one_of("time_scheme", flow.time_scheme, SCHEMES)
    _one_of("remeshing", flow.remeshing, ("always", "distorted"))
    _one_of("domain", flow.domain, ("grow", "follow", "fixed"))
    object.__setattr__(flow, "dtype", _precision(flow.dtype))
    _one_of("stretching", flow.stretching, ("conservative", "classical"))
    if flow.diffusion is not None:
        _one_of("diffusion", flow.diffusion, ("spectral", "compact"))
    if not isinstance(flow.cleaning, bool):
        raise InputError(
            f"cleaning must be True or False, got {flow.cleaning!r}", hint="cleaning=True"
        )
    if flow.grid.ndim == 2 and flow.stretching != "conservative":
        raise InputError(
            "vorticity in the plane does not stretch, got stretching="
            f"{flow.stretching!r}", hint="no stretching, or a grid with three axes",
        )  # fmt: skip
    projection = as_whole("projection", flow.projection, least=0, hint="projection=10")
    if flow.grid.ndim == 3:
        _check_space(flow)
    elif projection:
        raise InputError("vorticity in the plane has no divergence to project", hint="projection=0")
    if not isinstance(flow.penalisation, Penalisation | DirectForcing):
        raise InputError(
            f"penalisation must be a Penalisation or a DirectForcing, got {flow.penalisation!r}",
            hint="penalisation=Penalisation(strength=1000)",
        )
    if not isinstance(flow.contact, ContactLaw):
        raise InputError(
            f"contact must be a ContactLaw, got {flow.contact!r}", hint="contact=ContactLaw()"
        )
    _check_bodies(flow)
    _check_window(flow)
    if isinstance(flow.grid, AdaptiveMesh):
        _check_adaptive(flow)


def _check_space(flow: VortexFlow) -> None:
    """Refuse what is not there in three dimensions."""
    if isinstance(flow.grid, AdaptiveMesh):
        raise InputError(
            "flows on adaptive meshes are plane, the mesh has 3 dimensions",
            hint="a uniform Grid, or two dimensions",
        )
    if flow.remeshing == "distorted" and flow.stretching != "classical":
        raise InputError(
            "particles in space that are not remeshed at each step are stretched in the classical "
            f"form, got stretching={flow.stretching!r}", hint='stretching="classical"',
        )  # fmt: skip
    if flow.remeshing == "distorted" and flow.projection:
        raise InputError(
            f"projection acts on remeshed vorticity, got remeshing={flow.remeshing!r}",
            hint='remeshing="always", or projection=0',
        )


def _check_adaptive(flow: VortexFlow) -> None:
    """Refuse what an adaptive mesh cannot do."""
    assert isinstance(flow.grid, AdaptiveMesh)
    AdaptiveSolver(flow.grid, order=flow.order, radius=flow.radius)
    if flow.remeshing != "always":
        raise InputError(
            f"on an adaptive mesh particles are remeshed at every step, got remeshing="
            f"{flow.remeshing!r}", hint='remeshing="always"',
        )  # fmt: skip
    if flow.diffusion is not None:
        raise InputError(
            f"an adaptive mesh spreads level by level, got diffusion={flow.diffusion!r}",
            hint="diffusion=None",
        )
    if flow.domain == "follow":
        raise InputError(
            'an adaptive mesh does not follow the vorticity, got domain="follow"',
            hint="a large grid: where nothing happens it is coarse",
        )
    if flow.window is not None:
        raise InputError(
            "a window is for uniform grids, the mesh is adaptive",
            hint="a large grid: where nothing happens it is coarse",
        )
    if not all(body.solenoidal for body in flow.bodies):
        raise InputError(
            "on an adaptive mesh bodies must deform without changing their volume",
            hint="a swimmer whose sections keep their area, or a uniform grid",
        )


def _check_window(flow: VortexFlow) -> None:
    sides = (3,) * flow.grid.ndim
    window, hint = flow.window, f"window=Window(lower={sides}, upper={(12, *sides[1:])})"
    if window is None:
        return
    if not isinstance(window, Window):
        raise InputError(f"window must be a Window, got {window!r}", hint=hint)
    if len(window.lower) != flow.grid.ndim or len(window.upper) != flow.grid.ndim:
        raise InputError(
            f"a window has {flow.grid.ndim} reaches on each side here, "
            f"got {window.lower} and {window.upper}",
            hint=hint,
        )
    if not flow.bodies:
        raise InputError("a window lies around bodies, there are none", hint="bodies=[body]")
    if flow.domain == "fixed":
        raise InputError(
            "a window travels with the bodies, the domain is fixed", hint='domain="follow"'
        )
    if window.wake and any(flow.lattice.periodic):
        raise InputError(
            "the wake that leaves a window goes on to act in free space, an axis is periodic",
            hint="Window(..., wake=False)",
        )


def checked_vorticity(
    vorticity: Array | Callable[[Array], Array] | None, grid: Grid, dtype: np.dtype[Any]
) -> Array:
    """Start values on the nodes, from an array, a law of points or nothing."""
    shape = grid.shape if grid.ndim == 2 else (3, *grid.shape)
    if vorticity is None:
        return np.zeros(shape, dtype)
    values = _values(vorticity, grid)
    if values.dtype.kind not in "fiub":
        hint = "flow.start(vorticity=ring.vorticity)" if hasattr(vorticity, "vorticity") else None
        raise InputError(
            f"vorticity must hold real numbers, got {values.dtype}",
            hint=hint or "an array of floats",
        )
    if values.shape != shape:
        raise InputError(
            f"vorticity must have the shape {shape} on this grid, got {values.shape}",
            hint=f"values on grid.points(), or a function of points ({grid.ndim}, *shape)",
        )
    if not np.isfinite(values).all():
        bad = np.argwhere(~np.isfinite(values))
        place = grid.points()[:, *bad[0, -grid.ndim :]]
        raise InputError(
            f"vorticity must be finite, {len(bad)} values are not, the first at "
            f"{tuple(round(float(x), 6) for x in place)}",
            hint="check the initial condition",
        )
    return np.array(values, dtype, order="C")


def _values(vorticity: Array | Callable[[Array], Array], grid: Grid) -> NDArray[Any]:
    """Values of an array or a law; components of a law that are plain numbers fill the mesh."""
    found: Any = vorticity(grid.points()) if callable(vorticity) else vorticity
    if grid.ndim == 3 and isinstance(found, tuple | list) and len(found) == 3:
        found = np.stack([np.broadcast_to(np.asarray(part), grid.shape) for part in found])
    return np.asarray(found)


def check_solenoidal(vorticity: Array, grid: Grid, threads: int | None) -> None:
    """Refuse a start in space that is far from solenoidal."""
    if min(n for n, wraps in zip(grid.shape, grid.periodic, strict=True)) < 7:
        return
    ratio = divergence_ratio(vorticity, grid, threads=threads)
    if ratio > DIVERGENT:
        raise InputError(
            f"vorticity must have no divergence: it is {ratio:.2g} of the gradients, root mean "
            "square", hint="the curl of a velocity (remesh.stencils.curl), or projection=1",
        )  # fmt: skip


def _vector(value: object, ndim: int) -> tuple[float, ...]:
    given = np.asarray(value, dtype=object).ravel()
    try:
        numbers = tuple(float(x) for x in given)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != ndim or not all(math.isfinite(x) for x in numbers):
        raise InputError(
            f"freestream must hold {ndim} finite velocities, got {value!r}",
            hint=f"freestream={(1.0, 0.0, 0.0)[:ndim]}",
        )
    return numbers


def _precision(value: object) -> str:
    """The name of a precision given as a name or a NumPy type."""
    try:
        name = np.dtype(value).name  # type: ignore[call-overload]
    except TypeError:
        name = str(value)
    _one_of("dtype", name, ("float64", "float32"))
    return str(name)


def _one_of(name: str, value: str, known: Iterable[str]) -> None:
    if value not in known:
        words = ", ".join(repr(word) for word in known)
        raise InputError(f"{name} must be one of {words}, got {value!r}", hint=f"one of {words}")


def _check_bodies(flow: VortexFlow) -> None:
    grid = flow.lattice
    if not flow.bodies:
        return
    if flow.viscosity == 0:
        raise InputError(
            "a body holds the fluid by viscosity, which is 0 here", hint="viscosity=1/550"
        )
    low = grid.origin
    high = tuple(start + span for start, span in zip(low, grid.length, strict=True))
    for number, body in enumerate(flow.bodies):
        if not all(
            hasattr(body, name)
            for name in ("distance", "bounds", "motion", "measure", "placed", "inertia")
        ):
            raise InputError(
                f"bodies[{number}] is a {type(body).__name__}, not a body",
                hint=f"pmesh.RigidBody(levelset.shapes.{BALLS[grid.ndim]}(radius=0.5))",
            )
        if body.ndim != grid.ndim:
            raise InputError(
                f"bodies[{number}] has {body.ndim} dimensions, the grid {grid.ndim}",
                hint=f"a shape such as levelset.shapes.{BALLS[grid.ndim]}, or a swimmer with "
                f"ndim={grid.ndim}",
            )
        first, last = body.bounds(body.start())
        if any(a < b for a, b in zip(first, low, strict=True)) or any(
            a > b for a, b in zip(last, high, strict=True)
        ):
            raise InputError(
                f"bodies[{number}] reaches from {first} to {last}, "
                f"outside the domain {low} to {high}",
                hint="a larger grid, or another place for the body",
            )
        try:
            hash(body)
        except TypeError as error:
            raise InputError(
                f"bodies[{number}] cannot be hashed", hint="a frozen dataclass that holds tuples"
            ) from error
    _check_room(flow, grid)


def _check_room(flow: VortexFlow, grid: Grid) -> None:
    """Refuse bodies that the mesh cannot see, and boxes that the Poisson solve cannot serve."""
    if all(grid.periodic):
        raise InputError(
            "bodies need an unbounded axis, all axes of the grid are periodic",
            hint=f"boundary={('unbounded', *('periodic',) * (grid.ndim - 1))}",
        )
    reach = flow.penalisation.width * grid.spacing
    poses = tuple(body.start() for body in flow.bodies)
    box = box_around(flow.bodies, poses, grid, reach)
    points, distances = box.points(), []
    thinnest = getattr(flow.penalisation, "thinnest", THICK)
    for number, (body, pose) in enumerate(zip(flow.bodies, poses, strict=True)):
        distances.append(body.distance(points, pose))
        thick = 2 * _depth(body, pose, box, distances[-1]) / grid.spacing
        if thick < thinnest:
            raise InputError(
                f"bodies[{number}] is {max(thick, 0):.2f} spacings thick, needs {thinnest:g}",
                hint=f"a spacing below {grid.spacing * max(thick, 1.0) / thinnest:.3g}, or for a "
                "body that is thin by nature Penalisation(thinnest=...)",
            )
    _check_apart(distances, grid.spacing)
    if flow.domain != "fixed":
        return
    for axis, wraps in enumerate(grid.periodic):
        low = (box.origin[axis] - grid.origin[axis]) / grid.spacing
        if not wraps and not -0.5 < low < grid.shape[axis] - box.shape[axis] + 0.5:
            raise InputError(
                f"bodies need {reach / grid.spacing + MARGIN:.3g} nodes to the edges of a fixed "
                f"domain, they have fewer along axis {axis}",
                hint='a larger grid, or domain="grow"',
            )


def _depth(body: Body, pose: Pose, box: Grid, distance: Array) -> float:
    """How deep the middle of a body lies below its surface [L], to a sixteenth of a spacing."""
    deep = box.points()[:, distance <= 0.5 * min(float(distance.min()), 0.0)]
    if not deep.size:
        return -float(distance.min())
    parts = box.spacing * np.arange(-4, 5) / 8
    around = np.stack(np.meshgrid(*[parts] * box.ndim, indexing="ij")).reshape(box.ndim, 1, -1)
    return -float(body.distance(deep[:, :, None] + around, pose).min())


def _check_apart(distances: Sequence[Array], spacing: float) -> None:
    """Refuse bodies that begin inside each other, by their distances on one box."""
    for number, one in enumerate(distances):
        for before, other in enumerate(distances[:number]):
            overlap = -float(np.maximum(one, other).min()) / spacing
            if overlap > OVERLAP:
                raise InputError(
                    f"bodies[{before}] and bodies[{number}] overlap by {2 * overlap:.1f} spacings",
                    hint="one body of the union of their shapes, one | other",
                )
