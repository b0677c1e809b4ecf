"""Motion by mean curvature on nodes of several spacings: fine where the surface needs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.curvature_flow import CurvatureFlow, CurvatureState, crossed
from levelset.floors import Floor
from levelset.given import (
    check_adaptive,
    check_ends,
    check_grid,
    check_state,
    level_set,
    precision_asked,
)
from levelset.interface import ByLevel
from levelset.lookup import places
from levelset.pyramid import Pyramid, at_nodes, levels_at, to_uniform
from levelset.pyramid_measures import pyramid_measures
from levelset.redistancing import redistance
from levelset.shape import Shape
from levelset.stack import Stack
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.limit import Limit, check_step
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.wavelets import get_wavelet

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class AdaptiveCurvatureState(ByLevel):
    """A level set on its way, on the nodes of all levels; all that a restart needs.

    Those of level 0 cover the box. Where a finer level has nodes the coarser one keeps its own.
    """

    time: float
    step: int
    grid: Grid  # the finest
    mesh: AdaptiveMesh
    nodes: Nodes  # of each level's own grid, ascending; the coarsest level first
    values: Array  # phi there, negative inside [L]; not a distance
    starts: tuple[int, ...]  # nodes starts[l] to starts[l + 1] - 1 are of level l

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of active nodes of each level."""
        own = np.diff(self.starts)
        above = np.append(own[1:], 0) // 2**self.mesh.ndim
        return tuple(int(n) for n in own - above)


@dataclass(frozen=True, kw_only=True)
class AdaptiveCurvatureFlow(CurvatureFlow):
    """A surface moves inward at its mean curvature: `CurvatureFlow` on `AdaptiveMesh`.

    The coarsest level covers the box. A level is refined where its own spacing does not resolve
    the surface: where without every second node it would shift by more than ``refinement``
    spacings there (4 times ``tolerance``), until that falls below ``tolerance``. All levels go
    on together, in explicit stages that reach ``stretch`` explicit steps of the finest level in
    use, their number grows with its root (`levelset.stages`): a mesh that has no need of its
    finest level takes longer steps. Of order 2 in dt, any is stable; order 4 in the spacing away
    from jumps. Cost: O(active nodes). Same bits for any number of threads. Edges of the coarsest
    level are mirrors: refuses a surface within two of its spacings of them, and a cap on blocks.
    """

    kind: ClassVar[type] = AdaptiveCurvatureState

    def _check_mesh(self) -> None:
        """Refuse what is no such mesh, a cap on blocks, and wavelets that lose the order."""
        check_adaptive(self.grid, "AdaptiveCurvatureFlow", "CurvatureFlow")
        check_grid(self.mesh.grid)
        if len(get_wavelet(self.mesh.wavelet).predict) != 4:
            raise InputError(
                f"motion by curvature needs a wavelet of order 4, got {self.mesh.wavelet!r}",
                hint="wavelet='4.4'",
            )

    @property
    def mesh(self) -> AdaptiveMesh:
        """The adaptive mesh."""
        return cast(AdaptiveMesh, self.grid)

    def start(self, surface: Shape | Array, *, dtype: str | None = None) -> CurvatureState:
        """The state at time 0, from a shape or from any phi on the nodes of the finest grid.

        A shape gives its distance where nodes are needed; an array is redistanced in the whole box.
        Refuses a surface that no line of the coarsest mesh crosses, or that is close to the end of
        an unbounded axis, and a phi that is not finite.
        """
        law, given = self._law(surface)
        mesh, ground = self.mesh, self.mesh.level_grid(0)
        nodes = np.arange(ground.size)
        values = law(places(ground, nodes))
        if not crossed(values):
            raise InputError(
                "the surface does not pass through the coarsest level: phi has one sign there",
                hint="a shape inside the grid, some coarse spacings thick, or fewer levels",
            )
        check_ends(np.abs(values).reshape(ground.shape), ground)
        floors = [Floor(ground, nodes, values)]
        floors += [Floor(mesh.level_grid(level)) for level in range(1, mesh.levels + 1)]
        stack = Stack(mesh, floors, law, self.threads)
        bands = stack.close(precision_asked(dtype, given))
        return cast(CurvatureState, _state(mesh, bands, 0.0, 0))

    def step(self, state: CurvatureState, dt: float) -> CurvatureState:
        """The state dt [T] later, on the nodes that the surface needed before it."""
        step = check_step(dt)
        own = self._own(state)
        floors = [Floor(*band) for band in self.pyramid(state).bands]
        stack = Stack(self.mesh, floors, threads=self.threads)
        stack.move(step)
        bands = stack.close(own.values.dtype)
        return cast(CurvatureState, _state(self.mesh, bands, own.time + step, own.step + 1))

    def limit(self, state: CurvatureState) -> Limit:
        """``stretch`` explicit steps of the finest level in use."""
        h = self.mesh.spacing(self._own(state).finest)
        return Limit(self.stretch * h**2 / (2 * self.mesh.ndim), "curvature")

    def pyramid(self, state: CurvatureState) -> Pyramid:
        """The level set in bands of all levels."""
        own = self._own(state)
        parts = [own.of(level) for level in range(self.mesh.levels + 1)]
        return Pyramid(self.mesh, tuple(
            Band(self.mesh.level_grid(level), own.nodes[part], own.values[part])
            for level, part in enumerate(parts)
        ))  # fmt: skip

    def to_uniform(self, state: CurvatureState, level: int | None = None) -> Array:
        """phi on all nodes of a level, the finest by default."""
        return to_uniform(self.pyramid(state), level, np.inf, threads=self.threads)

    def levels(self, state: CurvatureState, level: int | None = None) -> NDArray[np.uint8]:
        """The finest level that has nodes, on all nodes of a level; the finest by default."""
        return levels_at(self.pyramid(state), level).astype(np.uint8)

    def ledger(self, state: CurvatureState) -> dict[str, float]:
        """``volume``, ``area``, least phi; nodes, active ones, how few, and how fine they are."""
        own = self._own(state)
        found = pyramid_measures(self.pyramid(state), threads=self.threads)
        return {
            "volume": found.volume,
            "area": found.area,
            "lowest": float(own.values.min()),
            "stored": float(len(own.nodes)),
            "active": float(own.size),
            "compression": own.grid.size / own.size,
            "finest_level": float(own.finest),
        }

    def fields(self, state: CurvatureState) -> dict[str, Array]:
        """The level set and the levels in use, on all nodes of the finest grid."""
        levels: Array = np.asarray(self.levels(state), np.float32)
        return {"phi": self.to_uniform(state), "level": levels}

    def _own(self, state: CurvatureState) -> AdaptiveCurvatureState:
        """The state, checked: of this kind and mesh."""
        check_state(state, self.kind, self.mesh)
        return cast(AdaptiveCurvatureState, state)

    def _law(self, surface: Shape | Array) -> tuple[Callable[[Array], Array], Array]:
        """phi at places (n, ndim), and something of its precision."""
        if isinstance(surface, Shape):
            return lambda at: surface.distance(np.ascontiguousarray(at.T)), np.empty(0)
        grid = self.mesh.grid
        given = level_set(surface, grid)
        known = redistance(given, grid, threads=self.threads)
        return at_nodes(known, grid), given


def _state(
    mesh: AdaptiveMesh, bands: tuple[Band, ...], time: float, step: int
) -> AdaptiveCurvatureState:
    """The state with these bands."""
    starts = np.cumsum([0, *(len(band.nodes) for band in bands)])
    return AdaptiveCurvatureState(
        time=time, step=step, grid=mesh.grid, mesh=mesh,
        nodes=np.concatenate([band.nodes for band in bands]),
        values=np.concatenate([band.values for band in bands]),
        starts=tuple(int(s) for s in starts),
    )  # fmt: skip
