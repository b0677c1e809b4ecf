"""Interfaces on particles: each keeps its value of the level set and goes with the flow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.given import check_ends, check_grid, check_state
from levelset.interface import Interface
from levelset.lookup import Lattice, around, places, remeshed
from levelset.profile import LEVEL, distance_of, profile
from levelset.quadrature import measures
from levelset.redistancing import redistance, redistance_band
from levelset.sampled import Sampled
from levelset.seams import across_seams, image_distance
from levelset.shape import Shape
from levelset.specks import specks
from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.limit import Limit, check_step, tightest
from remesh.multires.mesh import AdaptiveMesh
from remesh.paths import Velocity, get_scheme, travel
from remesh.reconstruction import CUTOFF, reconstruct

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
SHARES = np.linspace(0.0, 1.0, 9)  # of a step, at which its velocity gradient is asked for


@dataclass(frozen=True, kw_only=True)
class ParticleLevelSet:
    """Interfaces carried by particles in a narrow band, in any velocity.

    On a `Grid`; on an `AdaptiveMesh` with bands of several spacings, fine where the interface needs
    it: see `levelset.adaptive.AdaptiveLevelSet`.

    ``start(shape)`` puts particles on the nodes near the interface; ``step`` moves them, and
    remeshes when asked: at every step, every k steps, when their lattice is distorted, or never.
    Rigid motion is exact to the error of the time integration without remeshing, and never
    distorts. Splitting and merging need no care. Of the scheme's order in dt; of order
    ``kernel.moments`` and better in the spacing with dt in proportion to it, where the mesh
    resolves the interface. float64. Cost: O(particles), which follow the interface.
    Source: Hieber & Koumoutsakos, J. Comput. Phys. 210 (2005) 342.
    """

    grid: Grid | AdaptiveMesh
    velocity: Velocity  # u(time, positions (n, ndim)), (n, ndim) [L/T]
    kernel: str | Kernel = "M6'"  # of remeshing
    time_scheme: Literal["RK2", "RK3", "RK4"] = "RK4"
    substeps: int = 1  # of the time scheme in a step
    width: float = 6.0  # half width of the band, in spacings; of the coarsest level
    remeshing: Literal["always", "distorted", "never"] | int = "always"  # or every so many steps
    distortion: float = 0.5  # largest |ln stretch| of the particles' lattice, for "distorted"
    deformation: float = 0.25  # largest dt * max|grad u| of a substep
    largest_step: float = math.inf  # upper bound of dt [T]
    redistancing: int | None = None  # remeshings from one redistancing to the next
    threads: int | None = field(default=None, compare=False)
    kind: ClassVar[type[Interface]] = Interface  # of its states

    def __new__(cls, **settings: Any) -> Self:
        """On an adaptive mesh the one that keeps particles of several spacings."""
        if cls is ParticleLevelSet and isinstance(settings.get("grid"), AdaptiveMesh):
            from levelset.adaptive import AdaptiveLevelSet  # which builds on this class

            return cast(Self, object.__new__(AdaptiveLevelSet))
        return object.__new__(cls)

    def __post_init__(self) -> None:
        """Refuse settings that cannot be computed with."""
        get_kernel(self.kernel)
        get_scheme(self.time_scheme)
        check_grid(self.finest)
        axes = getattr(self.velocity, "ndim", self.finest.ndim)
        if not callable(self.velocity) or axes != self.finest.ndim:
            raise InputError(
                f"velocity must be a law u(time, positions) of {self.finest.ndim} dimensions, got "
                f"{self.velocity!r:.60}",
                hint="levelset.laws.SingleVortex(period=8.0)",
            )
        for name in ("width", "distortion", "deformation"):
            value = as_number(name, getattr(self, name), hint=f"{name}=0.5")
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value}", hint=f"{name}=0.5")
        if not as_number("largest_step", self.largest_step) > 0:
            raise InputError(
                f"largest_step must be positive, got {self.largest_step}", hint="largest_step=0.1"
            )
        words = ("always", "distorted", "never")
        if self.remeshing not in words and not _counts(self.remeshing):
            raise InputError(
                f"remeshing must be one of {words} or a number of steps, got {self.remeshing!r}",
                hint="remeshing='always'",
            )
        least = 2 if self.remeshing == "never" else get_kernel(self.kernel).half_width
        if self.width < least:
            raise InputError(
                f"width must be at least {least} spacings, what the kernel reads, got {self.width}",
                hint="width=6.0",
            )
        for name in ("substeps", "redistancing"):
            value = getattr(self, name)
            if not (_counts(value) or (name == "redistancing" and value is None)):
                raise InputError(f"{name} must be a whole number >= 1, got {value!r}",
                                 hint=f"{name}=2")  # fmt: skip

    @property
    def finest(self) -> Grid:
        """The grid; of an adaptive mesh the finest."""
        return self.grid.grid if isinstance(self.grid, AdaptiveMesh) else self.grid

    @property
    def box(self) -> Grid:
        """The grid that the interface must stay within; of an adaptive mesh the coarsest."""
        return self.grid.level_grid(0) if isinstance(self.grid, AdaptiveMesh) else self.grid

    @property
    def reach(self) -> float:
        """Half width of the band, on an adaptive mesh that of the coarsest level [L]."""
        return self.width * self.box.spacing

    def start(self, shape: Shape | Array, *, time: float = 0.0) -> Interface:
        """Particles on the nodes near the surface of a shape, or of a level set on the grid.

        A shape gives its distance, on a periodic axis that of its nearest image; an array of
        ``grid.shape`` is redistanced. Looks at every node of the grid. Refuses an interface that is
        empty, or not inside the box, and values that are not finite.
        """
        start = start_time(time)
        if isinstance(shape, Shape):
            distance = image_distance(shape, self.finest)
        else:
            distance = redistance(shape, self.finest, width=self.reach, threads=self.threads)
        self._check_ends(distance)
        self._check_seen(distance)
        values = profile(distance, self.reach).ravel()
        nodes = np.flatnonzero(np.abs(distance.ravel()) < self.reach)
        band = Band(self.finest, nodes, values[nodes])
        if self.remeshing != "never":
            known = np.ones(values.size, np.uint8)
            more = get_kernel(self.kernel).half_width
            band = around(nodes, values, known, self.finest, self.reach, more)
        state = self._on_nodes(band, Interface(
            time=start, step=0, grid=self.finest, nodes=band.nodes,
            positions=np.empty((0, self.finest.ndim)), values=band.values, gradient=0.0,
        ))  # fmt: skip
        return replace(state, gradient=self._gradient(state))

    def step(self, state: Interface, dt: float) -> Interface:
        """The interface one step of dt [T] later."""
        check_state(state, self.kind, self.grid)
        step, scheme, positions = check_step(dt), get_scheme(self.time_scheme), state.positions
        part = step / self.substeps
        for k in range(self.substeps):
            positions = travel(positions, self.velocities, state.time + k * part, part, scheme)
        self._check_inside(positions, state.values)
        moved = replace(
            state, time=state.time + step, step=state.step + 1, age=state.age + 1,
            positions=positions,
        )  # fmt: skip
        if self.due(moved):
            moved = self.remesh(moved)
        return replace(moved, gradient=self._gradient(moved))

    def due(self, state: Interface) -> bool:
        """Whether the particles are to be remeshed."""
        if self.remeshing == "distorted":
            return max(one.distortion() for one, _ in self._lattices(state)) > self.distortion
        if isinstance(self.remeshing, int):
            return state.age >= self.remeshing
        return self.remeshing == "always"

    def remesh(self, state: Interface) -> Interface:
        """The same interface, its particles on nodes again; those far from it are dropped."""
        count = state.remeshings + 1
        band = self.band(state)
        if self.redistancing is not None and count % self.redistancing == 0:
            band = self._redistanced(band)
        return self._on_nodes(band, replace(state, remeshings=count, age=0))

    def band(self, state: Interface) -> Band:
        """The level set on the nodes near the interface: profile values [L], zero on it."""
        check_state(state, self.kind, self.grid)
        if state.age == 0:
            return Band(self.finest, state.nodes, state.values.copy())
        return remeshed(
            self.finest, state.nodes, state.positions, state.values, self.kernel, self.reach,
            threads=self.threads,
        )  # fmt: skip

    def distance(self, state: Interface) -> Band:
        """The signed distance [L] on the nodes near the interface."""
        return redistance_band(self.band(state), width=self.reach, threads=self.threads)

    def rebuild(
        self, state: Interface, points: Array, *, radius: float = 0.8, degree: int = 2
    ) -> Array:
        """The signed distance [L] at ``points`` (m, ndim) [L], from the particles where they are.

        The mollified sum, corrected to keep polynomials of ``degree`` (`remesh.reconstruct`), of
        ``radius`` spacings; no mesh is involved, so a rigid motion changes nothing in it. NaN away
        from particles. Of order ``degree + 1`` while they overlap.
        """
        distances = distance_of(state.values, self.reach)
        width = radius * self.finest.spacing
        positions, distances, places = across_seams(
            state.positions, distances, points, self.finest, CUTOFF * width
        )
        return reconstruct(positions, distances, places, width, degree=degree, threads=self.threads)

    def shape(self, state: Interface) -> Sampled:
        """The interface as a shape: a body for a flow, a tool to cut with, something to measure.

        Its distance is known on the whole mesh. Refuses one that lies across a periodic seam.
        """
        field = self.band(state).filled(LEVEL * self.reach)
        return Sampled(redistance(field, self.finest, threads=self.threads), self.finest)

    def limit(self, state: Interface) -> Limit:
        """The step in which the velocity gradient deforms the particles' lattice as allowed.

        A law that knows its ``max_gradient`` is asked for the whole step, others are measured at
        its start.
        """
        check_state(state, self.kind, self.grid)
        known = getattr(self.velocity, "max_gradient", None)
        rate, allowed = state.gradient, self._allowed
        dt = allowed / rate if rate > 0 else math.inf
        while known is not None and math.isfinite(dt):
            rate = max(known(state.time + share * dt) for share in SHARES)
            if rate * dt <= allowed * (1 + 1e-9):
                break
            dt = min(allowed / rate, 0.9 * dt)
        return tightest(Limit(dt, "deformation"), Limit(self.largest_step, "largest_step"))

    def ledger(self, state: Interface) -> Mapping[str, float]:
        """Volume inside, area of the surface, and how many particles and remeshings it took.

        Volume and area are NaN where particles not remeshed have left holes between them.
        """
        check_state(state, self.kind, self.grid)
        try:
            inside, surface, _ = measures(self.band(state), threads=self.threads)
        except InputError:
            inside = surface = math.nan
        return {
            "volume": inside,
            "surface": surface,
            "particles": float(state.size),
            "remeshings": float(state.remeshings),
        }

    def forces(self, state: Interface) -> Mapping[str, float]:
        """None: an interface that is carried exerts none."""
        return {}

    def fields(self, state: Interface) -> Mapping[str, Array]:
        """The level set on all nodes: its profile, level beyond the band."""
        return {"level_set": self.band(state).filled(LEVEL * self.reach)}

    def velocities(self, time: float, positions: Array) -> Array:
        """The velocity at positions (n, ndim) [L/T], checked: of their shape, and finite."""
        found = np.asarray(self.velocity(time, positions))
        if found.shape != positions.shape or found.dtype.kind not in "fiu":
            raise InputError(
                f"velocity must return real numbers of shape {positions.shape}, got {found.dtype} "
                f"of shape {found.shape}",
                hint="u(time, positions): one row of components per particle",
            )
        found = found.astype(np.float64, copy=False)
        if not np.isfinite(found).all():
            raise InputError(
                f"velocity is not finite at t = {time:g} for {(~np.isfinite(found)).any(1).sum()} "
                "particles", hint="check the velocity law where the interface goes",
            )  # fmt: skip
        return found

    @property
    def _allowed(self) -> float:
        """Largest dt * max|grad u| of a step."""
        return self.substeps * self.deformation

    def _on_nodes(self, band: Band, state: Interface) -> Interface:
        """Particles on the nodes of a band; refuses one that reaches the end of an axis."""
        positions = places(self.finest, band.nodes)
        self._check_inside(positions, band.values)
        return replace(state, nodes=band.nodes, values=band.values, positions=positions)

    def _check_inside(self, positions: Array, values: Array) -> None:
        """Refuse an inside that reaches the end of an unbounded axis."""
        half = 0.5 * self.box.spacing
        for axis, (low, length) in enumerate(zip(self.box.origin, self.box.length, strict=True)):
            along = positions[:, axis]
            if self.box.periodic[axis] or not along.size:
                continue
            first, last = low + half, low + length - half
            if along.min() >= first and along.max() <= last:
                continue
            if (values[(along < first) | (along > last)] < 0).any():
                raise InputError(
                    f"the interface has reached the end of the box along axis {axis}",
                    hint="a larger box, or a periodic axis",
                )

    def _redistanced(self, band: Band) -> Band:
        """Profiles of distances; a drop of one node, which no redistancing would end, is let go."""
        if not (band.values < 0).any():
            return band
        near = redistance_band(band, width=self.reach, threads=self.threads)
        values = near.values.copy()
        values[np.searchsorted(near.nodes, specks(near))] *= -1.0
        return Band(self.finest, near.nodes, profile(values, self.reach))

    def _gradient(self, state: Interface) -> float:
        """Largest row sum of |du_i/dx_j| where the particles are, by differences of neighbours."""
        known = getattr(self.velocity, "max_gradient", None)
        if known is not None:
            return float(known(state.time))
        velocities = self.velocities(state.time, state.positions)
        return max(one.gradient(velocities[part]) for one, part in self._lattices(state))

    def _lattices(self, state: Interface) -> Iterator[tuple[Lattice, slice]]:
        """Lattices of particles, and which of the particles are theirs."""
        whole = slice(None)
        yield Lattice(self.finest, state.nodes, state.positions, state.values, self.threads), whole

    def _check_seen(self, distance: Array) -> None:
        """Refuse what has no interface that the mesh sees."""
        h = self.finest.spacing
        if not (distance < 0).any():
            raise InputError(
                "no node lies inside the shape: the interface is empty",
                hint=f"a shape inside the box from {self.box.origin}, {self.box.length} "
                "long, larger than a spacing, negative inside",
            )
        if distance.min() > -0.5 * h:
            raise InputError(
                f"the shape is {-2 * distance.min() / h:.2g} spacings thick: the mesh does not "
                "see it", hint="a finer mesh",
            )  # fmt: skip

    def _check_ends(self, distance: Array) -> None:
        """Refuse distances on the box that are not finite, or an inside that touches its edge."""
        if not np.isfinite(distance).all():
            raise InputError("the distance is not finite everywhere", hint="check the shape")
        check_ends(distance, self.box)


def start_time(time: float) -> float:
    """The time [T] as a plain float; refuses what is not finite."""
    start = as_number("time", time)
    if not math.isfinite(start):
        raise InputError(f"time must be finite, got {time}", hint="time=0.0")
    return start


def _counts(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1
