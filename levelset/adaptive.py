"""Interfaces on particles of several spacings: fine where the interface needs it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.given import check_adaptive, check_state
from levelset.interface import AdaptiveInterface, Interface
from levelset.lookup import Lattice, places
from levelset.profile import LEVEL, profile
from levelset.pyramid import Pyramid, at_nodes, levels_at, remeshed, started, to_uniform
from levelset.pyramid_measures import pyramid_measures
from levelset.redistancing import redistance
from levelset.seams import image_distance
from levelset.shape import Shape
from levelset.transport import ParticleLevelSet, start_time
from remesh.errors import InputError
from remesh.kernels import get_kernel
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
DRAWN = 1.0  # largest dt * max|grad u| from one remeshing to the next


@dataclass(frozen=True, kw_only=True)
class AdaptiveLevelSet(ParticleLevelSet):
    """Interfaces carried by particles of several spacings: `ParticleLevelSet` on `AdaptiveMesh`.

    Level l has a band on its own grid, ``mesh.level_grid(l)``, that of level 0 around all of the
    interface, finer ones only around the parts that need them; where a finer band has a node,
    coarser ones take its value. ``width`` is the half width of the profile in spacings of level 0,
    one profile for all levels; finer bands are as wide as the kernel asks. Particles of all levels
    go with the flow and are remeshed on the nodes of their level, so that fine parts travel with
    it, whatever the Courant number; fine bands bear to be drawn together by dt * max|grad u| = 1
    from one remeshing to the next, which `limit` keeps to.

    The tolerance is a displacement: a place is refined where the interface would be off by more
    than ``mesh.refinement`` of ``reach`` if it were interpolated from every second node, and
    refined no more where that falls below ``mesh.tolerance`` of it. The error of an interface that
    is carried falls in proportion to the tolerance, until the finest level ends it.
    Blocks and their size do not matter to bands. Cost: O(particles); scratch of the finest grid's
    size is set aside, of which the pages near the interface are used: 1.1 GB for 10^6 particles
    at 256^3. Refuses redistancing, to be carried without remeshing, and a cap on blocks.
    Source: Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5 (2006) 980.
    """

    kind: ClassVar[type[Interface]] = AdaptiveInterface

    def __post_init__(self) -> None:
        """Refuse settings that cannot be computed with."""
        check_adaptive(self.grid, "AdaptiveLevelSet", "ParticleLevelSet")
        super().__post_init__()
        if self.remeshing == "never":
            raise InputError(
                "an adaptive mesh follows the interface by remeshing, got remeshing='never'",
                hint="remeshing='always', or a uniform grid",
            )
        if self.redistancing is not None:
            raise InputError(
                f"an adaptive mesh is not redistanced, got redistancing={self.redistancing}",
                hint="redistancing=None; a larger width, or more levels, where the flow is long",
            )

    @property
    def mesh(self) -> AdaptiveMesh:
        """The adaptive mesh."""
        return cast(AdaptiveMesh, self.grid)

    def start(self, shape: Shape | Array, *, time: float = 0.0) -> AdaptiveInterface:
        """Particles near the surface of a shape, or of a level set on the finest grid."""
        start, law = start_time(time), self._law(shape)
        corners = places(self.box, np.arange(self.box.size))
        self._check_ends(law(corners).reshape(self.box.shape))
        pyramid = started(
            self.mesh, lambda at: profile(law(at), self.reach), self.reach, self._more
        )
        self._check_seen(np.concatenate([band.values for band in pyramid.bands]))
        state = self._on_bands(pyramid, AdaptiveInterface(
            time=start, step=0, grid=self.finest, nodes=np.empty(0, np.int64),
            positions=np.empty((0, self.finest.ndim)), values=np.empty(0), gradient=0.0,
            mesh=self.mesh, starts=(0,),
        ))  # fmt: skip
        return replace(state, gradient=self._gradient(state))

    def remesh(self, state: Interface) -> AdaptiveInterface:
        """The same interface on nodes again, finer and coarser where it must be."""
        own = cast(AdaptiveInterface, state)
        return self._on_bands(self.pyramid(own), replace(own, remeshings=own.remeshings + 1, age=0))

    def pyramid(self, state: Interface) -> Pyramid:
        """The level set on the bands of all levels: profile values [L], zero on the interface."""
        check_state(state, self.kind, self.mesh)
        own = cast(AdaptiveInterface, state)
        parts = [own.of(level) for level in range(self.mesh.levels + 1)]
        if own.age == 0:
            grids = [self.mesh.level_grid(level) for level in range(len(parts))]
            return Pyramid(self.mesh, tuple(
                Band(grid, own.nodes[part], own.values[part])
                for grid, part in zip(grids, parts, strict=True)
            ))  # fmt: skip
        return remeshed(
            self.mesh,
            [(own.nodes[part], own.positions[part], own.values[part]) for part in parts],
            self.kernel, self.reach, threads=self.threads,
        )  # fmt: skip

    def band(self, state: Interface) -> Band:
        """The level set on nodes of the finest grid near the interface."""
        field = self.to_uniform(state)
        nodes = np.flatnonzero(np.abs(field) < LEVEL * self.reach)
        return Band(self.finest, nodes, field.reshape(-1)[nodes])

    def rebuild(
        self, state: Interface, points: Array, *, radius: float = 0.8, degree: int = 2
    ) -> Array:
        """Refused: particles of several spacings have no one radius."""
        raise InputError(
            "an interface on an adaptive mesh is not rebuilt from its particles",
            hint="flow.to_uniform(state), or a uniform grid",
        )

    def to_uniform(self, state: Interface, level: int | None = None) -> Array:
        """The level set on all nodes of a level, the finest by default: level beyond the band."""
        return to_uniform(self.pyramid(state), level, LEVEL * self.reach, threads=self.threads)

    def fields(self, state: Interface) -> Mapping[str, Array]:
        """The level set on all nodes of the finest grid, and the level of the particles there.

        Level l holds for 2^(levels - l) nodes along each axis from a particle on; -1 where there
        is none.
        """
        levels: Array = levels_at(self.pyramid(state)).astype(np.float32)
        return {"level_set": self.to_uniform(state), "level": levels}

    def ledger(self, state: Interface) -> Mapping[str, float]:
        """Volume inside, area of the surface; particles, active ones, and how fine they are."""
        pyramid = self.pyramid(state)
        found = pyramid_measures(pyramid, threads=self.threads)
        return {
            "volume": found.volume,
            "surface": found.area,
            "particles": float(pyramid.stored),
            "active": float(pyramid.active),
            "compression": self.finest.size / max(1, pyramid.active),
            "finest_level": float(pyramid.finest),
            "remeshings": float(state.remeshings),
        }

    @property
    def _allowed(self) -> float:
        """Largest dt * max|grad u| of a step: what fine bands are drawn together by, at most."""
        steps = self.remeshing if isinstance(self.remeshing, int) else 1
        return min(super()._allowed, DRAWN / steps)

    @property
    def _more(self) -> int:
        """Nodes that the kernel reads to each side."""
        return get_kernel(self.kernel).half_width

    def _on_bands(self, pyramid: Pyramid, state: AdaptiveInterface) -> AdaptiveInterface:
        """Particles on the nodes of all bands."""
        bands = pyramid.bands
        nodes = np.concatenate([band.nodes for band in bands])
        values = np.concatenate([band.values for band in bands])
        positions = np.concatenate([places(band.grid, band.nodes) for band in bands])
        starts = np.cumsum([0, *(len(band.nodes) for band in bands)])
        self._check_inside(positions, values)
        return replace(
            state, nodes=nodes, values=values, positions=positions,
            starts=tuple(int(s) for s in starts),
        )  # fmt: skip

    def _lattices(self, state: Interface) -> Iterator[tuple[Lattice, slice]]:
        own = cast(AdaptiveInterface, state)
        for level in range(self.mesh.levels + 1):
            part = own.of(level)
            grid = self.mesh.level_grid(level)
            lattice = Lattice(
                grid, own.nodes[part], own.positions[part], own.values[part], self.threads
            )
            yield lattice, part
            lattice.close()

    def _law(self, shape: Shape | Array) -> Callable[[Array], Array]:
        """The signed distance at places (n, ndim)."""
        if isinstance(shape, Shape):
            return lambda at: image_distance(shape, self.finest, np.ascontiguousarray(at.T))
        known = redistance(shape, self.finest, width=self.reach, threads=self.threads)
        return at_nodes(known, self.finest)
