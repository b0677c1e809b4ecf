"""Cutting: moving tools remove what they touch from a body that particles carry."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.interface import Interface
from levelset.laws import Uniform
from levelset.lookup import places
from levelset.pieces import pieces
from levelset.profile import LEVEL, profile
from levelset.quadrature import volume
from levelset.rows import runs
from levelset.shape import Bounds, Shape
from levelset.thickness import thickness
from levelset.tool import Path, Sweep, Tool
from levelset.transport import ParticleLevelSet
from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.limit import Limit, check_step, tightest
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
THINNEST = 2.0  # spacings: what a tool cuts must be seen by the mesh
PACE = 0.5  # spacings that a tool moves from pose to pose
GAINED = 1e-3  # of the whole: volume that a cut may add to a body by the mesh's errors
STRAYED = 0.01  # of the whole: change of volume that is believed in steps beyond the limit


@dataclass(frozen=True, kw_only=True)
class Cut:
    """A body under the knife at one instant. A value: a step makes a new one."""

    time: float  # [T]
    step: int  # steps taken since the start
    grid: Grid
    body: Interface  # what is left
    volume: float  # of it [L^ndim]
    removed: float = 0.0  # volume that the tools took since the start [L^ndim]

    @property
    def size(self) -> int:
        """Number of particles."""
        return self.body.size


@dataclass(frozen=True, kw_only=True)
class Cutting:
    """Tools that move through a body: what they touch is taken away, and counted.

    In each step the ``carrier`` moves the body's particles; each then keeps the larger of its
    value and of minus its least distance from the tools on their way, seen from the particle on
    its own way: no ridges between steps, for steps of any length. Particles are made where a tool
    enters the body and dropped deep inside the cut; a body that moves carries particles all through
    its inside, one at rest (`Uniform` with no velocity) near its surface only. What is
    cut off goes on as a piece of its own. Removed is what the volume of the level set loses by the
    cuts alone: of order 2 in the spacing, for its sharp edges. On periodic axes tools meet the body
    in the box, not its images. Tools' ways are seen at 32 uneven times of a step and more (see
    `Tool.sweep`): what comes and goes faster wants a smaller ``largest_step``. Refuses tools whose
    thickest part is below two spacings, and steps so large that particles do not follow: a cut that
    adds to the body, or beyond the carrier's limit a volume that is not kept. Cost of a step: that
    of the carrier, of the particles near the tools, and of the volume, which a body that moves is
    remeshed for once, and once more where it was cut.
    """

    carrier: ParticleLevelSet
    tools: Tool | Sequence[Tool]
    largest_step: float = math.inf  # upper bound of dt [T]

    def __post_init__(self) -> None:
        """Refuse tools that do not fit, or that the mesh does not see."""
        if not isinstance(self.carrier, ParticleLevelSet):
            raise InputError(
                f"Cutting: carrier must be a ParticleLevelSet, got {self.carrier!r}",
                hint="carrier=ParticleLevelSet(grid=grid, velocity=law)",
            )
        if isinstance(self.carrier.grid, AdaptiveMesh):
            raise InputError(
                "Cutting: tools cut on a uniform grid, the carrier's is adaptive",
                hint="carrier=ParticleLevelSet(grid=mesh.grid, velocity=law)",
            )
        several = isinstance(self.tools, Sequence)
        tools = tuple(cast(Sequence[Tool], self.tools)) if several else (cast(Tool, self.tools),)
        object.__setattr__(self, "tools", tools)
        if not tools or not all(isinstance(tool, Tool) for tool in tools):
            raise InputError(
                f"Cutting: tools must be a Tool or several, got {self.tools!r}",
                hint="Tool(shape=Sphere(0.1), shift=lambda t: (t, 0.0, 0.0))",
            )
        largest = as_number("largest_step", self.largest_step, hint="largest_step=0.01")
        if not largest > 0:
            raise InputError(
                f"largest_step must be positive, got {largest}", hint="largest_step=0.01"
            )
        object.__setattr__(self, "largest_step", largest)
        grid = self.carrier.finest
        for tool in tools:
            if tool.shape.ndim != grid.ndim:
                raise InputError(
                    f"a tool has {tool.shape.ndim} dimensions, the grid {grid.ndim}",
                    hint="tools and a grid of one dimension",
                )
            thin = thickness(tool.shape) / grid.spacing
            if thin < 0.999 * THINNEST:
                raise InputError(
                    f"a tool is {thin:.2g} spacings thick: the mesh does not see its cut",
                    hint=f"at least {THINNEST:g} spacings, or a finer mesh",
                )

    @property
    def resting(self) -> bool:
        """Whether the body stays where it is."""
        law = self.carrier.velocity
        return isinstance(law, Uniform) and not any(law.velocity)

    def start(self, shape: Shape | Array, *, time: float = 0.0) -> Cut:
        """The whole body, as `ParticleLevelSet.start` takes it; nothing is cut yet."""
        body = self.carrier.start(shape, time=time)
        return Cut(time=body.time, step=0, grid=body.grid, body=body, volume=self._volume(body))

    def step(self, state: Cut, dt: float) -> Cut:
        """The body one step of dt [T] later, less what the tools touched on their way."""
        dt = check_step(dt)
        sweeps = self._sweeps(state.time, dt)
        before = self._ready(replace(state.body, time=state.time), sweeps)
        moved = self._moved(before, dt)
        depth = self._depth(before, moved, sweeps, dt)
        cut = replace(moved, values=np.maximum(moved.values, profile(-depth, self.carrier.reach)))
        body = self._tidied(cut, depth)
        touched = bool((cut.values > moved.values).any())
        left = self._volume(body) if touched or not self.resting else state.volume
        now = spared = left
        if touched:
            now = state.volume if self.resting else self._volume(moved)
            spared = left if self.carrier.redistancing is None else self._volume(cut)
        self._check(state, dt, now, spared)
        return Cut(
            time=state.time + dt, step=state.step + 1, grid=state.grid, body=body, volume=left,
            removed=state.removed + now - spared,
        )  # fmt: skip

    def limit(self, state: Cut) -> Limit:
        """The carrier's limit, and the user's own bound; the tools set none."""
        return tightest(self.carrier.limit(state.body), Limit(self.largest_step, "largest_step"))

    def band(self, state: Cut) -> Band:
        """The level set of what is left, on the nodes near its surface: see `ParticleLevelSet`."""
        return self.carrier.band(state.body)

    def ledger(self, state: Cut) -> Mapping[str, float]:
        """Volume left and removed, pieces, and particles."""
        homes = Band(state.grid, state.body.nodes, state.body.values)  # as many, and at no cost
        return {
            "volume": state.volume,
            "removed": state.removed,
            "pieces": float(len(pieces(homes))),
            "particles": float(state.size),
            "remeshings": float(state.body.remeshings),
        }

    def forces(self, state: Cut) -> Mapping[str, float]:
        """None: tools cut without effort."""
        return {}

    def fields(self, state: Cut) -> Mapping[str, Array]:
        """The level set of what is left on all nodes: its profile, level beyond the band."""
        return self.carrier.fields(state.body)

    def _check(self, state: Cut, dt: float, moved: float, cut: float) -> None:
        """Refuse a cut that adds to the body, and volume lost in steps beyond the limit."""
        whole = state.volume + state.removed
        strayed = abs(moved - state.volume) > STRAYED * whole
        if cut - moved > GAINED * whole or (strayed and dt > self.carrier.limit(state.body).dt):
            raise InputError(
                f"the particles do not follow the velocity in a step of {dt:g}: the body's volume "
                f"goes from {state.volume:.3g} to {moved:.3g}, and by the cut to {cut:.3g}",
                hint=f"dt={self.carrier.limit(state.body).dt:.3g} at most, or more `substeps`",
            )

    def _sweeps(self, time: float, dt: float) -> list[Sweep]:
        """The tools' ways in a step."""
        pace = PACE * self.carrier.finest.spacing
        return [tool.sweep(time, time + dt, pace) for tool in cast(Sequence[Tool], self.tools)]

    def _ready(self, body: Interface, sweeps: Sequence[Sweep]) -> Interface:
        """The body with particles inside, wherever a tool may enter it."""
        if self.resting:
            for sweep in sweeps:
                body = _filled(body, self._level, sweep.bounds(self.carrier.reach))
            return body
        if body.age and len(_inside(body)):
            body = self.carrier.remesh(body)
        return body if body.age else _filled(body, self._level)

    def _moved(self, body: Interface, dt: float) -> Interface:
        """The body where the carrier takes it, not remeshed."""
        if self.resting:
            return replace(body, time=body.time + dt, step=body.step + 1)
        return replace(self.carrier, remeshing="never").step(body, dt)

    def _depth(
        self, before: Interface, after: Interface, sweeps: Sequence[Sweep], dt: float
    ) -> NDArray[np.float64]:
        """Least distance of each particle from the tools while both moved [L]; inf far away."""
        depth = np.full(after.size, np.inf)
        low = np.minimum(before.positions, after.positions)
        high = np.maximum(before.positions, after.positions)
        for sweep in sweeps:
            box = sweep.bounds(self._margin)
            near = np.flatnonzero(((low <= box[1]) & (high >= box[0])).all(axis=1))
            if near.size:
                found = sweep.distance(
                    self._path(before, after, near, dt), near.size, within=self.carrier.reach
                )
                depth[near] = np.minimum(depth[near], found)
        return depth

    def _path(self, before: Interface, after: Interface, near: Nodes, dt: float) -> Path:
        """Ways of some particles: cubics through both ends with the velocities there."""
        start: NDArray[np.float64] = before.positions[near].astype(np.float64)
        end = after.positions[near]
        if self.resting:
            return lambda _, which: start[which].T
        first = dt * self.carrier.velocities(before.time, start)
        last = dt * self.carrier.velocities(after.time, end)

        def path(part: NDArray[np.float64], which: Nodes) -> NDArray[np.float64]:
            s = part[:, None]
            way = (3.0 - 2.0 * s) * s * s
            bend = s * (1.0 - s) * ((1.0 - s) * first[which] - s * last[which])
            found = start[which] + way * (end[which] - start[which]) + bend
            return np.asarray(found.T, np.float64)

        return path

    def _tidied(self, body: Interface, depth: NDArray[np.float64]) -> Interface:
        """The body without particles that it needs no more; remeshed if its carrier wants that."""
        if self.resting:
            return _kept(body, np.abs(body.values) < self._level)
        body = _kept(body, depth > -self._margin)
        return self.carrier.remesh(body) if self.carrier.due(body) else body

    @property
    def _level(self) -> float:
        """The size of the values far from the surface [L]."""
        return LEVEL * self.carrier.reach

    @property
    def _margin(self) -> float:
        """How far from a cut particles still serve its kernel [L]."""
        wide = get_kernel(self.carrier.kernel).half_width + 1
        return self.carrier.reach + wide * self.carrier.finest.spacing

    def _volume(self, body: Interface) -> float:
        band = self.carrier.band(body)
        return volume(band.values, band.grid, nodes=band.nodes, threads=self.carrier.threads)


def _inside(body: Interface, box: Bounds | None = None) -> Nodes:
    """Home nodes inside the body that have no particle; with a box those in it."""
    grid = body.grid
    beyond = runs(body.nodes, body.values, grid)
    first, stop = beyond.first, beyond.stop
    kept = beyond.inside & (stop > first)
    if box is not None:
        low, high = (
            np.floor(np.subtract(box[0], grid.origin) / grid.spacing).astype(np.int64),
            np.ceil(np.subtract(box[1], grid.origin) / grid.spacing).astype(np.int64) + 1,
        )
        rows = np.unravel_index(beyond.row, grid.shape[:-1])
        for index, a, b in zip(rows, low, high, strict=False):
            kept &= (index >= a) & (index < b)
        first, stop = np.maximum(first, low[-1]), np.minimum(stop, high[-1])
        kept &= stop > first
    begin = beyond.row[kept] * grid.shape[-1] + first[kept]
    counts = (stop - first)[kept]
    every: Nodes = np.arange(counts.sum()) + np.repeat(begin - np.cumsum(counts) + counts, counts)
    return every


def _filled(body: Interface, level: float, box: Bounds | None = None) -> Interface:
    """A body whose particles are on nodes, with more of them inside it: all, or those in a box."""
    new = _inside(body, box)
    if not len(new):
        return body
    nodes = np.concatenate([body.nodes, new])
    order = np.argsort(nodes)
    values = np.concatenate([body.values, np.full(len(new), -level)])[order]
    return replace(
        body, nodes=nodes[order], values=values, positions=places(body.grid, nodes[order])
    )


def _kept(body: Interface, kept: NDArray[np.bool_]) -> Interface:
    """The body with some of its particles."""
    return replace(
        body, nodes=body.nodes[kept], values=body.values[kept], positions=body.positions[kept]
    )
