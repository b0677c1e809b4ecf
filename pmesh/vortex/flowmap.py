"""Where the flow carries points: tracers, streaklines, the flow map and its FTLE, from snapshots.

A velocity here is any law ``velocity(time, positions)`` with positions and result of shape
``(n, ndim)``; :class:`VelocityHistory` makes one from velocity fields at several times.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import Kernel, get_kernel
from remesh.paths import SCHEMES, Velocity, travel
from remesh.stencils import gradient
from remesh.transfer import m2p

Array = NDArray[np.floating[Any]]
KEPT = 6  # fields in memory


class Frame(Protocol):
    """Fields by name on a grid at a time: a snapshot."""

    @property
    def time(self) -> float:
        """Time [T]."""

    @property
    def grid(self) -> Grid:
        """The mesh at that time."""

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A field."""


class VelocityHistory:
    """Velocity between snapshots: in space by a remeshing kernel, in time by a cubic through four.

    Third order in the mesh with "M4'", fourth in the time between snapshots (second through two,
    third through three). The meshes may differ. Beyond an unbounded edge the velocity is that of
    the nearest point of the mesh. Keeps six fields in memory. Refuses fewer than two snapshots and
    times outside theirs.
    """

    def __init__(
        self,
        frames: Sequence[Frame],
        *,
        field: str = "velocity",
        kernel: str | Kernel = "M4'",
        threads: int | None = None,
    ) -> None:
        self.frames = sorted(frames, key=lambda frame: frame.time)
        self.times = np.array([frame.time for frame in self.frames], np.float64)
        if self.times.size < 2 or (np.diff(self.times) <= 0).any():
            raise InputError(
                f"a history needs two snapshots or more at different times, got {self.times.size}",
                hint="snapshots closer together: a smaller `every`",
            )
        self.field, self.kernel, self.threads = field, kernel, threads
        self._padding = get_kernel(kernel).half_width + 1
        self._fields: dict[int, tuple[Array, Grid]] = {}

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [T]."""
        return float(self.times[0]), float(self.times[-1])

    def __call__(self, time: float, positions: Array) -> Array:
        """Velocity at the positions, shape (n, ndim) [L/T]."""
        slack = 1e-9 * (self.times[-1] - self.times[0])
        if not self.times[0] - slack <= time <= self.times[-1] + slack:
            raise InputError(
                f"the snapshots span t = {self.times[0]:g} to {self.times[-1]:g}, asked for "
                f"{time:g}",
                hint="a time between, a shorter span, or snapshots of more times",
            )
        place = int(np.searchsorted(self.times, time, side="right")) - 1
        first = min(max(place - 1, 0), max(self.times.size - 4, 0))
        near = range(first, min(first + 4, self.times.size))
        share = _lagrange(self.times[near.start : near.stop], time)
        parts = [(*self._load(k), w) for k, w in zip(near, share, strict=True) if w != 0]
        if all(grid == parts[0][1] for _, grid, _ in parts):  # one mesh: blend, then sample once
            blend = sum(w * field for field, _, w in parts[1:]) + parts[0][2] * parts[0][0]
            return self._at(blend, parts[0][1], positions)
        found = np.zeros(positions.shape, np.float64)
        for field, grid, weight in parts:
            found += weight * self._at(field, grid, positions)
        return found

    def steps(self, start: float, end: float) -> int:
        """Steps in which no point passes more than a node, and at least four per snapshot."""
        low, high = min(start, end), max(start, end)
        inside = [
            k
            for k in range(self.times.size)
            if self.times[min(k + 1, self.times.size - 1)] >= low
            and self.times[max(k - 1, 0)] <= high
        ]
        rates = []
        for number in inside:
            field, grid = self._load(number)
            rates.append(math.sqrt(float((field**2).sum(axis=0).max())) / grid.spacing)
        return max(4 * len(inside), math.ceil((high - low) * max(rates)), 1)

    def _at(self, field: Array, grid: Grid, positions: Array) -> Array:
        inside = np.array(positions, np.float64)
        for axis, wraps in enumerate(grid.periodic):
            low = grid.origin[axis]
            if wraps:
                inside[:, axis] = low + np.mod(inside[:, axis] - low, grid.length[axis])
            else:
                pad = self._padding * grid.spacing
                high = low + grid.length[axis] - pad
                np.clip(inside[:, axis], low + pad, high, out=inside[:, axis])
        return m2p(field, inside, grid, self.kernel, outside="drop", threads=self.threads)

    def _load(self, number: int) -> tuple[Array, Grid]:
        """A field, unbounded axes continued straight on by the kernel's width."""
        if number not in self._fields:
            while len(self._fields) >= KEPT:
                del self._fields[min(self._fields, key=lambda k: -abs(k - number))]
            frame = self.frames[number]
            grid, n = frame.grid, self._padding
            field = np.asarray(frame[self.field], np.float64)
            wide = [(0, 0)] + [(0, 0) if wraps else (n, n) for wraps in grid.periodic]
            field = np.pad(field, wide, mode="reflect", reflect_type="odd")
            low = [x - pad[0] * grid.spacing for x, pad in zip(grid.origin, wide[1:], strict=True)]
            self._fields[number] = field, Grid(field.shape[1:], grid.spacing, low, grid.boundary)
        return self._fields[number]


class Streaks(NamedTuple):
    """Dye: where the points are that left the sources at the times ``released``."""

    released: Array  # (m,) [T]
    positions: Array  # (m, sources, ndim) [L]


def tracers(
    velocity: Velocity, positions: ArrayLike, times: ArrayLike, *, steps: int | None = None
) -> Array:
    """Paths of points: positions at the times, shape (len(times), n, ndim) [L].

    The points are where ``positions`` (n, ndim) says at the first time; times may increase or
    decrease. Classical Runge-Kutta, fourth order, ``steps`` of them between two times; a
    VelocityHistory tells how many it takes. Refuses points that are not finite.
    """
    place: Array = np.array(positions, np.float64)
    if place.ndim != 2 or place.shape[1] not in (2, 3) or not np.isfinite(place).all():
        raise InputError(
            f"positions must be finite and have shape (n, 2) or (n, 3), got {place.shape}",
            hint="one row per point",
        )
    moments = np.atleast_1d(np.asarray(times, np.float64))
    path = [place]
    for start, end in pairwise(moments):
        place = _carried(velocity, place, float(start), float(end), steps)
        path.append(place)
    return np.stack(path)


def streaklines(
    velocity: Velocity,
    sources: ArrayLike,
    start: float,
    end: float,
    *,
    releases: int = 50,
    steps: int | None = None,
) -> Streaks:
    """Dye that leaves the sources (n, ndim) at ``releases`` even times from start to end, at end.

    Oldest first. ``steps`` between two releases, see :func:`tracers`.
    """
    points: Array = np.array(sources, np.float64)
    if not (end > start and releases >= 2):
        raise InputError(
            f"dye needs end > start and two releases or more, got {start:g} to {end:g} and "
            f"{releases}",
            hint="start=0.0, end=1.0, releases=50",
        )
    released = np.linspace(start, end, releases)
    places = points
    for a, b in pairwise(released):
        carried = tracers(velocity, places, [a, b], steps=steps)[-1]
        places = np.concatenate([carried, points])
    return Streaks(released, places.reshape(releases, *points.shape))


def flow_map(
    velocity: Velocity, grid: Grid, start: float, end: float, *, steps: int | None = None
) -> Array:
    """Where points that are on the nodes at ``start`` are at ``end``, (ndim, *grid.shape) [L].

    ``end`` may be earlier. Positions on periodic axes are not wrapped. As :func:`tracers`.
    """
    nodes = grid.points().reshape(grid.ndim, -1).T
    ends = tracers(velocity, nodes, [start, end], steps=steps)[-1]
    return np.ascontiguousarray(ends.T).reshape(grid.ndim, *grid.shape)


def ftle(
    velocity: Velocity, grid: Grid, start: float, span: float, *, steps: int | None = None
) -> Array:
    """Finite-time Lyapunov exponent on the nodes, shape ``grid.shape`` [1/T].

    ln(sigma) / |span|, sigma the largest stretching of the flow map from ``start`` to ``start +
    span``, by fourth-order differences of it on the grid. Ridges of a negative span (backward)
    attract, as dye does; those of a positive one repel. Exact for linear flows. Source: Shadden,
    Lekien & Marsden, Physica D 212 (2005) 271, eqs. 7-9.
    """
    if not (math.isfinite(span) and span != 0):
        raise InputError(f"span must be a time other than 0, got {span}", hint="span=-1.0")
    moved = flow_map(velocity, grid, start, start + span, steps=steps) - grid.points()
    stretched = np.moveaxis(gradient(moved, grid), (0, 1), (-2, -1)) + np.eye(grid.ndim)
    strain = stretched @ np.swapaxes(stretched, -1, -2)  # Cauchy-Green: the rows are d/dx_i
    largest = np.linalg.eigvalsh(strain)[..., -1]
    return np.asarray(0.5 * np.log(np.maximum(largest, np.finfo(float).tiny)) / abs(span))


def _carried(
    velocity: Velocity, place: Array, start: float, end: float, steps: int | None
) -> Array:
    """Points at ``end`` that are at ``place`` at ``start``."""
    if steps is None:
        if not isinstance(velocity, VelocityHistory):
            raise InputError("a law of velocity needs a number of steps", hint="steps=100")
        steps = velocity.steps(start, end)
    if steps < 1:
        raise InputError(f"steps must be at least 1, got {steps}", hint="steps=100")
    dt = (end - start) / steps
    for k in range(steps):
        place = travel(place, velocity, start + k * dt, dt, SCHEMES["RK4"])
    return place


def _lagrange(times: NDArray[np.float64], time: float) -> list[float]:
    """Weights of the polynomial through values at the times."""
    return [
        math.prod((time - b) / (a - b) for j, b in enumerate(times) if j != i)
        for i, a in enumerate(times)
    ]
