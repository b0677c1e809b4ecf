"""One interface carried three ways: by particles with and without remeshing, and by markers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.limit import Limit

if TYPE_CHECKING:
    from levelset.interface import Interface
    from levelset.transport import ParticleLevelSet

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Both:
    """One interface on particles that are never remeshed and on some that are, and as markers."""

    time: float  # [T]
    step: int
    without: Interface
    remeshed: Interface
    markers: Values  # (n, 2), a closed line of points that the flow carries [L]

    @property
    def grid(self) -> Grid:
        """The mesh of both."""
        return self.remeshed.grid

    @property
    def size(self) -> int:
        """Particles of both."""
        return self.without.size + self.remeshed.size


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two particle level sets that take the same steps, and markers beside them."""

    without: ParticleLevelSet
    remeshed: ParticleLevelSet
    dt: float  # [T]

    def step(self, state: Both, dt: float) -> Both:
        """All three one step of dt [T] later."""
        from remesh.paths import get_scheme, travel

        law = self.without.velocity
        return Both(
            time=state.time + dt,
            step=state.step + 1,
            without=self.without.step(state.without, dt),
            remeshed=self.remeshed.step(state.remeshed, dt),
            markers=np.asarray(travel(state.markers, law, state.time, dt, get_scheme("RK4"))),
        )

    def limit(self, state: Both) -> Limit:
        """The step that was asked for."""
        return Limit(self.dt, "courant")

    def ledger(self, state: Both) -> Mapping[str, float]:
        """The area inside the markers, particles, remeshings."""
        return {
            "marker_area": polygon_area(state.markers),
            "particles_without": float(state.without.size),
            "particles_with": float(state.remeshed.size),
            "remeshings": float(state.remeshed.remeshings),
        }

    def forces(self, state: Both) -> Mapping[str, float]:
        """None."""
        return {}

    def fields(self, state: Both) -> Mapping[str, Array]:
        """The level set of the remeshed particles."""
        return self.remeshed.fields(state.remeshed)


def polygon_area(line: Values) -> float:
    """Area inside a closed line (n, 2), positive if it runs anticlockwise."""
    x, y = (line - line.mean(axis=0)).T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def polygon_length(line: Values) -> float:
    """Length of a closed line (n, 2)."""
    return float(np.hypot(*(np.roll(line, -1, axis=0) - line).T).sum())


def inside(line: Values, grid: Grid) -> NDArray[np.bool_]:
    """Which nodes of a plane mesh lie inside a closed line (n, 2): odd crossings below them."""
    (x, y), (u, v) = line.T, np.roll(line, -1, axis=0).T
    rows, columns = grid.axes()
    found = np.zeros(grid.shape, bool)
    first = np.searchsorted(rows, np.minimum(x, u), side="right")
    stop = np.searchsorted(rows, np.maximum(x, u), side="right")
    for back in range(int((stop - first).max(initial=0))):
        row = first + back
        edge = np.flatnonzero(row < stop)
        row = row[edge]
        share = (rows[row] - x[edge]) / (u[edge] - x[edge])
        above = np.searchsorted(columns, y[edge] + share * (v[edge] - y[edge]))
        seen = above < len(columns)
        np.logical_xor.at(found, (row[seen], above[seen]), True)
    return np.asarray(np.logical_xor.accumulate(found, axis=1))


def largest_gap(state: Interface) -> float:
    """Largest distance of two particles that began as neighbours along an axis, in spacings."""
    found = 1.0
    for stride in (1, state.grid.shape[1]):
        place = np.searchsorted(state.nodes, state.nodes + stride)
        place[place == len(state.nodes)] = 0
        here = np.flatnonzero(state.nodes[place] == state.nodes + stride)
        apart = state.positions[place[here]] - state.positions[here]
        found = max(found, float(np.hypot(*apart.T).max(initial=0.0)) / state.grid.spacing)
    return found
