"""What the reversed-flow cases share: exact surfaces, errors, pieces and holes."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from levelset.interface import Interface
from levelset.laws import Deformation, SingleVortex
from levelset.shapes import Disk, Sphere
from levelset.transport import ParticleLevelSet
from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.paths import get_scheme, travel

if TYPE_CHECKING:
    from pmesh.run.protocols import Watcher
    from pmesh.run.snapshots import Snapshot

Values = NDArray[np.float64]
KEPT = "the flow keeps volumes"
BACK = "the flow turns back: the start"
TRACED = "the surface traced by RK4, converged"
DEFORMED = 0.5  # largest dt * max|grad u| of one RK4 step
PATHS = 60  # steps per unit of time of exact paths: RK4, to 1e-6 of the box
PARTS = {2: 8, 3: 4}  # samples along a cell's side that an interface error is measured with


@dataclass(frozen=True, kw_only=True)
class Reversed(Case):
    """Base: a round body drawn out by a vortex of the unit box that turns back at half the period.

    A case adds ``nodes``, ``period`` and the options whose defaults differ.
    """

    nodes: int = option(64, "mesh cells per unit length")
    period: float = option(2.0, "of the flow; all is back after it", unit="T")
    radius: float = option(0.15, "of the body", unit="L")
    kernel: str = option("L6,4", "remeshing kernel")
    band: float = option(0.15, "half width of the band of particles", unit="L")
    courant: float = option(1.0, "time step times largest speed over the cell size")
    remeshing: int = option(1, "steps from one remeshing to the next")
    substeps: int = option(0, "RK4 steps in a step; 0: as many as the deformation asks for")
    every: float = option(0.5, "time between snapshots", unit="T")

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("period", "radius", "courant", "band", "every")
        self.require(self.nodes >= 16, "nodes", "at least 16")
        self.require(self.radius * self.nodes >= 2, "radius", "at least two cells")
        self.require(self.radius <= self.most, "radius", f"at most {self.most:g} to fit the box")
        self.check_band()
        self.require(self.remeshing >= 1, "remeshing", "at least 1")
        self.require(self.substeps >= 0, "substeps", "at least 0")

    def check_band(self) -> None:
        """Refuse a band that the mesh does not resolve."""
        suffices = f"--band {2.0 / self.nodes:.4g}"
        self.require(self.width >= 2, "band", "at least 2 cells to each side", suffices)

    @property
    def most(self) -> float:
        """The largest radius that fits the box [L]."""
        return 0.2

    @property
    @abstractmethod
    def law(self) -> SingleVortex | Deformation:
        """The velocity."""

    @property
    @abstractmethod
    def shape(self) -> Disk | Sphere:
        """The body at the start and, exactly, after the period."""

    @property
    def spacing(self) -> float:
        """Side of a cell [L]."""
        return 1.0 / self.nodes

    @property
    def width(self) -> float:
        """Half width of the band in cells."""
        return self.band * self.nodes

    def build(self) -> tuple[Any, Any]:
        """Particles around the body's surface, in the unit box."""
        step = self.courant * self.spacing / self.law.max_speed(0.0)
        asked = math.ceil(step * self.law.max_gradient(0.0) / DEFORMED)
        flow = ParticleLevelSet(
            grid=Grid((self.nodes + 1,) * self.law.ndim, self.spacing),
            velocity=self.law,
            kernel=self.kernel,
            width=self.width,
            remeshing=self.remeshing,
            substeps=self.substeps or asked,
            deformation=DEFORMED,
            largest_step=step,
        )
        return flow, flow.start(self.shape)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, in it the area of the surface, and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [*super().watchers(), Snapshots(self.every, dtype="float32")]

    def at(self, outcome: Outcome, name: str, time: float) -> float | None:
        """A column of the series at a time; None if the run did not reach it."""
        series = outcome.series
        if series["time"][-1] < time * (1 - 1e-9):
            return None
        return float(np.interp(time, series["time"], series[name]))

    def back(self, outcome: Outcome) -> bool:
        """Whether the run ended just when all should be back."""
        return math.isclose(outcome.state.time, self.period, rel_tol=1e-9)

    def error(self, flow: ParticleLevelSet, state: Interface) -> float:
        """L1 error of the interface after the period [L]."""
        return interface_error(flow.fields(state)["level_set"], state.grid, self.shape)

    def half(self, outcome: Outcome) -> Snapshot | None:
        """The snapshot at half the period, where the body is drawn out most."""
        for shot in outcome.snapshots():
            if math.isclose(shot.time, 0.5 * self.period, rel_tol=1e-9):
                return shot
        return None


@dataclass(frozen=True, kw_only=True)
class ReversedCase(Reversed):
    """Base: that on a uniform mesh, and on others to compare with."""

    coarse: bool = option(True, "whether to run with half the cells as well, for the order")

    def errors(self, outcome: Outcome) -> dict[int, float]:
        """L1 errors after the period by mesh cells per unit length, the coarsest first."""
        found = {self.nodes: self.error(outcome.flow, outcome.state)}
        for nodes in self.others():
            found[nodes] = _solved(replace(self, nodes=nodes, until=self.period, coarse=False))
        return dict(sorted(found.items()))

    def others(self) -> Sequence[int]:
        """Meshes to compare with."""
        return [self.nodes // 2] if self.coarse and self.nodes >= 32 else []

    def of_errors(self, outcome: Outcome) -> list[Metric]:
        """The interface error in cells and as a length, on other meshes, and the orders between."""
        if not self.back(outcome):
            return []
        errors = self.errors(outcome)
        own = errors[self.nodes]
        found = [
            Metric("L1 interface error in cells", own * self.nodes, 0.0, 1.0, "A", BACK,
                   "absolute"),
            Metric("L1 interface error over the radius", own / self.radius, kind="report"),
        ]  # fmt: skip
        for first, second in zip(list(errors)[:-1], list(errors)[1:], strict=True):
            order = math.log2(errors[first] / errors[second]) / math.log2(second / first)
            name = f"order of the interface error, {first} to {second} cells"
            found.append(Metric(name, order, kind="report"))
        return found


@lru_cache(maxsize=8)
def _solved(case: ReversedCase) -> float:
    """The error of the case on another mesh, run to its end."""
    from pmesh.run.loop import run

    flow, start = case.build()
    return case.error(flow, run(flow, start, until=case.until))


def interface_error(phi: NDArray[Any], grid: Grid, shape: Disk | Sphere) -> float:
    """Volume of what is on the wrong side of a surface, over the area of the exact one [L].

    Counted with samples, 8 along a cell's side in the plane and 4 in space, of the interpolated
    level set in the cells around nodes where a sign is near a change; nodes stand for the others.
    """
    from scipy.ndimage import maximum_filter, minimum_filter

    from remesh.transfer import m2p

    exact = shape.distance(grid.points())
    inside = (phi < 0).astype(np.uint8)
    cut = maximum_filter(inside, 3) != minimum_filter(inside, 3)
    cut |= np.abs(exact) < 2.0 * grid.spacing
    wrong = float(np.count_nonzero((inside == 1)[~cut] != (exact < 0)[~cut]))
    parts = PARTS[grid.ndim]
    side = ((np.arange(parts) + 0.5) / parts - 0.5) * grid.spacing
    offsets = np.stack(np.meshgrid(*[side] * grid.ndim, indexing="ij"), axis=-1)
    places = np.moveaxis(grid.points(), 0, -1)[cut]
    field = np.ascontiguousarray(phi, np.float64)
    for offset in offsets.reshape(-1, grid.ndim):
        points = np.ascontiguousarray(places + offset)
        ours = m2p(field, points, grid, kernel="M6'") < 0
        wrong += np.count_nonzero(ours != (shape.distance(points.T) < 0)) / len(side) ** grid.ndim
    return wrong * grid.cell_volume / shape.surface


def refined(phi: NDArray[Any], grid: Grid, parts: int) -> tuple[Values, Grid]:
    """A level set, level away from its interface, between the nodes as well; and that mesh."""
    from remesh.transfer import m2p

    field = np.ascontiguousarray(phi, np.float64)
    finer = Grid(
        [parts * (n - 1) + 1 for n in grid.shape], grid.spacing / parts, origin=grid.origin
    )
    nearest = [(np.arange(n) + parts // 2) // parts for n in finer.shape]
    found: Values = np.array(field[np.ix_(*nearest)])
    near = np.flatnonzero(np.abs(found) < 0.99 * np.abs(field).max())
    indices = np.stack(np.unravel_index(near, finer.shape), axis=1)
    points: Values = np.array(grid.origin) + finer.spacing * indices
    found.reshape(-1)[near] = m2p(field, points, grid, kernel="M6'")
    return found, finer


class Topology(NamedTuple):
    """Of the surface of a body in space."""

    pieces: int
    holes: int  # handles of all pieces together: a ball has none, a ring one


def topology(phi: NDArray[Any], grid: Grid) -> Topology:
    """Pieces of the surface of a level set in space, and holes through them.

    Counted on the triangles between the nodes of a mesh twice as fine: V - E + F = 2 (pieces -
    holes), whatever the shape.
    """
    import pyvista
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    field, finer = refined(phi, grid, 2)
    image = pyvista.ImageData(dimensions=finer.shape)
    image.point_data["phi"] = field.ravel(order="F")
    surface: Any = image.contour([0.0], scalars="phi", method="contour", compute_normals=False)
    faces = np.asarray(surface.regular_faces, np.int64)
    if not len(faces):
        return Topology(0, 0)
    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    ends = np.sort(np.concatenate([faces[:, :2], faces[:, 1:], faces[:, ::2]]), axis=1)
    edges = np.unique(ends, axis=0)
    links = coo_array((np.ones(len(edges)), tuple(edges.T)), shape=(len(used),) * 2)
    pieces = int(connected_components(links, directed=False)[0])
    euler = len(used) - len(edges) + len(faces)
    return Topology(pieces, pieces - euler // 2)


def traced(points: Values, law: Any, start: float, end: float) -> Values:
    """Where points (n, ndim) at one time are at another."""
    count = max(1, math.ceil(abs(end - start) * PATHS))
    dt = (end - start) / count
    for k in range(count):
        points = np.asarray(travel(points, law, start + k * dt, dt, get_scheme("RK4")), np.float64)
    return points


def exact_level_set(points: Values, law: Any, shape: Disk | Sphere, time: float) -> Values:
    """The level set that the flow brings to points (n, ndim): the start's, where they came from."""
    return np.asarray(shape.distance(traced(points, law, time, 0.0).T), np.float64)


@lru_cache(maxsize=8)
def exact_surface(law: Any, shape: Disk | Sphere, time: float) -> float:
    """Exact length or area of the body's surface: how much each of its points is stretched."""
    step = 1e-6 * shape.radius
    if law.ndim == 2:
        angle = 2 * np.pi * np.arange(20_000) / 20_000
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tangents = [np.stack([-np.sin(angle), np.cos(angle)], axis=1)]
    else:
        k = np.arange(40_000) + 0.5
        height, turn = 1.0 - 2.0 * k / len(k), k * math.pi * (3.0 - math.sqrt(5.0))
        ring = np.sqrt(1.0 - height**2)
        normal = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
        first = np.cross(normal, (0.3, 0.5, 0.8))
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        tangents = [first, np.cross(normal, first)]
    points = np.array(shape.center) + shape.radius * normal
    ends = [points + sign * step * t for t in tangents for sign in (1, -1)]
    moved = traced(np.concatenate(ends), law, 0.0, time).reshape(len(ends), *points.shape)
    sides = [(moved[2 * i] - moved[2 * i + 1]) / (2 * step) for i in range(len(tangents))]
    grown = sides[0] if law.ndim == 2 else np.cross(*sides)
    return float(np.linalg.norm(grown, axis=1).mean()) * shape.surface
