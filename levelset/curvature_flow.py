"""Motion by mean curvature: a surface shrinks at the speed kappa, pinches off and vanishes.

The normal speed is -kappa, kappa = div n = (ndim - 1)/R on a sphere, so phi_t = kappa |grad phi|:

    phi_t = lap phi - n . Hess(phi) . n,    n = grad phi/|grad phi|.

The first term stiffens as h falls, is linear and is taken implicitly, by cosine and Fourier
transforms; the second, zero for a distance, explicitly (Smereka, J. Sci. Comput. 19 (2003) 439):

    E(dt) phi = (1 - dt lap)^-1 (phi - dt n . Hess(phi) . n)

and a step is ``2 E(dt/2) E(dt/2) - E(dt)``, of order 2 in dt. A wave of which a share r in [0, 1]
of k^2 lies along n is amplified by (1 + r z)/(1 + z), z = dt k^2: at most 1 for every dt, and the
extrapolated step keeps that (with q = 1 - r, w = z/2 its 1 - gain is
``2 q w (1 + (4-q) w + (3-2q) w^2)/((1+w)^2 (1+2w)) >= 0``).

phi starts as a distance and is never made one again: the motion is that of every level surface by
itself, and what was a kink at a centre becomes smooth, phi = sqrt(r^2 + 2 (ndim-1) t) - R for a
sphere. Where the slope is below what the mesh resolves, |grad phi| < h |Hess phi|/4, it tells no
direction, and n . Hess . n is its mean over the slopes Hess x of the points x close by, each
weighted with its square: tr Hess^3/tr Hess^2, right where a ball, a neck or a sheet vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, ClassVar, Self, cast

import numpy as np
from numpy.typing import NDArray

from levelset.given import check_grid, check_state, level_set, precision_asked
from levelset.quadrature import measures
from levelset.redistancing import redistance
from levelset.shape import Shape
from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.layout import split
from remesh.limit import Limit, check_step
from remesh.multires.mesh import AdaptiveMesh
from remesh.threads import share, thread_count

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True, kw_only=True)
class CurvatureState:
    """A level set on its way; all that a restart needs."""

    time: float
    step: int
    grid: Grid
    phi: Array  # negative inside [L]; not a distance

    @property
    def size(self) -> int:
        """Nodes that a step moves."""
        return self.grid.size


@dataclass(frozen=True, kw_only=True)
class CurvatureFlow:
    """A surface moves inward at its mean curvature; dt is not bound by h^2 but by accuracy.

    An unbounded edge of the mesh is a mirror: a surface that reaches it meets it at a right angle.
    One that does not should stay some eight spacings off: phi has a kink there.
    """

    grid: Grid | AdaptiveMesh
    stretch: float = 10.0  # largest dt over the explicit limit h^2/(2 ndim)
    threads: int | None = field(default=None, compare=False)
    kind: ClassVar[type] = CurvatureState  # of its states

    def __new__(cls, **settings: Any) -> Self:
        """On an adaptive mesh the one whose nodes have several spacings."""
        if cls is CurvatureFlow and isinstance(settings.get("grid"), AdaptiveMesh):
            from levelset.adaptive_flow import AdaptiveCurvatureFlow  # which builds on this class

            return cast(Self, object.__new__(AdaptiveCurvatureFlow))
        return object.__new__(cls)

    def __post_init__(self) -> None:
        """Refuse what is no grid, and a stretch that is not positive."""
        self._check_mesh()
        stretch = as_number("stretch", self.stretch, hint="stretch=10.0")
        if not (math.isfinite(stretch) and stretch > 0):
            raise InputError(f"stretch must be positive, got {stretch}", hint="stretch=10.0")

    def _check_mesh(self) -> None:
        """Refuse what is no grid."""
        check_grid(cast(Grid, self.grid))

    def start(self, surface: Shape | Array, *, dtype: str | None = None) -> CurvatureState:
        """The state at time 0, from a shape or from any phi on the nodes.

        A shape gives its distance; an array is redistanced in the whole box, for where its slope
        dies off the surface it would move at another speed. Looks at every node. Refuses a surface
        that no mesh line crosses, and a phi that is not finite.
        """
        grid = cast(Grid, self.grid)
        given = level_set(surface, grid)
        if not crossed(given):
            raise InputError(
                "the surface does not pass through the grid: phi has one sign on all nodes",
                hint="a shape inside the grid, a few spacings thick",
            )
        if not isinstance(surface, Shape):
            given = redistance(given, grid, threads=self.threads)
        phi = np.array(given, precision_asked(dtype, given), order="C")
        return CurvatureState(time=0.0, step=0, grid=grid, phi=phi)

    def step(self, state: CurvatureState, dt: float) -> CurvatureState:
        """The state dt [T] later."""
        check_state(state, self.kind, self.grid)
        dt = check_step(dt)
        phi = curvature_step(state.phi, state.grid, dt, threads=self.threads)
        return replace(state, time=state.time + dt, step=state.step + 1, phi=phi)

    def limit(self, state: CurvatureState) -> Limit:
        """``stretch`` explicit steps."""
        check_state(state, self.kind, self.grid)
        grid = state.grid
        return Limit(self.stretch * grid.spacing**2 / (2 * grid.ndim), "curvature")

    def ledger(self, state: CurvatureState) -> dict[str, float]:
        """``volume`` and ``area`` (2-D: area and length), zero once it vanished; least phi."""
        check_state(state, self.kind, self.grid)
        found = measures(state.phi, state.grid, threads=self.threads)
        return {
            "volume": found.volume,
            "area": found.area,
            "lowest": float(state.phi.min()),
        }

    def forces(self, state: CurvatureState) -> dict[str, float]:
        """None."""
        return {}

    def fields(self, state: CurvatureState) -> dict[str, Array]:
        """The level set."""
        return {"phi": state.phi}


def crossed(phi: Array) -> bool:
    """Whether phi has both signs."""
    return bool(phi.min() < 0 < phi.max())


def curvature_step(phi: Array, grid: Grid, dt: float, *, threads: int | None = None) -> Array:
    """phi after the time dt [L^2] of motion by mean curvature, of order 2 in dt and 4 in h.

    Any dt is stable. An unbounded edge is a mirror. Symmetric to round-off where phi is. Costs six
    transforms of the mesh. Source: see the module.
    """
    normal = normal_bend(phi, grid, threads=threads)
    whole = _semi_implicit(phi, normal, grid, dt, threads)
    half = _semi_implicit(phi, normal, grid, 0.5 * dt, threads)
    normal = normal_bend(half, grid, threads=threads)
    half = _semi_implicit(half, normal, grid, 0.5 * dt, threads)
    return np.asarray(2.0 * half - whole, phi.dtype)


def normal_bend(phi: Array, grid: Grid, *, threads: int | None = None) -> Array:
    """n . Hess(phi) . n [1/L] on all nodes, of order 4; zero for a distance. Edges are mirrors."""
    from levelset import _curvature_flow

    ghosts = [(2, 2) if wraps else (0, 0) for wraps in grid.periodic]
    mirrors = [(0, 0) if wraps else (2, 2) for wraps in grid.periodic]
    padded = np.pad(np.pad(phi, ghosts, mode="wrap"), mirrors, mode="reflect")
    out = np.empty(grid.shape, phi.dtype)
    rows, pieces = split(math.prod(grid.shape[:-1]))
    loop = _curvature_flow.normal_bend2 if grid.ndim == 2 else _curvature_flow.normal_bend3
    share(loop, pieces, thread_count(threads), rows, padded, out)
    out /= phi.dtype.type(grid.spacing**2)
    return out


def _semi_implicit(phi: Array, normal: Array, grid: Grid, dt: float, threads: int | None) -> Array:
    """(1 - dt lap)^-1 (phi - dt normal): cosines along mirrored axes, waves along periodic ones."""
    from scipy import fft

    workers = thread_count(threads)
    waves = [axis for axis in range(grid.ndim) if grid.periodic[axis]]
    cosines = [axis for axis in range(grid.ndim) if not grid.periodic[axis]]
    found = phi - phi.dtype.type(dt) * normal
    symbol = _symbol(grid).astype(phi.dtype, copy=False)
    damping = 1 + phi.dtype.type(dt / grid.spacing**2) * symbol
    if cosines:
        found = fft.dctn(found, type=1, axes=cosines, workers=workers)
    if waves:
        shape = [grid.shape[axis] for axis in waves]
        found = fft.rfftn(found, axes=waves, workers=workers) / damping
        found = fft.irfftn(found, s=shape, axes=waves, workers=workers)
    else:
        found /= damping
    if cosines:
        found = fft.idctn(found, type=1, axes=cosines, workers=workers)
    return np.asarray(found)


@lru_cache(maxsize=4)
def _symbol(grid: Grid) -> Array:
    """-h^2 lap of the fourth-order difference, for every cosine or wave of the mesh."""
    total = np.zeros((1,) * grid.ndim)
    last = max((axis for axis in range(grid.ndim) if grid.periodic[axis]), default=-1)
    for axis, (count, wraps) in enumerate(zip(grid.shape, grid.periodic, strict=True)):
        kept = count // 2 + 1 if axis == last else count
        angle = np.arange(kept) * (2 * np.pi / count if wraps else np.pi / (count - 1))
        line = (15.0 - 16.0 * np.cos(angle) + np.cos(2.0 * angle)) / 6.0
        total = total + line.reshape([-1 if k == axis else 1 for k in range(grid.ndim)])
    total.flags.writeable = False
    return np.asarray(total)


def extinction(time: Sequence[float] | Array, volume: Sequence[float] | Array, ndim: int) -> float:
    """When a shrinking ball vanishes [T], from its volume at two times or more.

    volume^(2/ndim) falls linearly, by 2 (ndim - 1) per unit time for the squared radius: the line
    through the last two volumes given, followed to zero. Leave out balls that the mesh does not
    resolve. Refuses volumes that do not fall.
    """
    size = np.asarray(volume, np.float64)[-2:] ** (2 / ndim)
    times = np.asarray(time, np.float64)[-2:]
    if len(size) != 2 or len(times) != 2 or not size[0] > size[1] >= 0 or not times[1] > times[0]:
        raise InputError(
            "extinction follows two volumes that fall, none negative",
            hint="the last two before the radius falls below four spacings",
        )
    return float(times[1] + size[1] * (times[1] - times[0]) / (size[0] - size[1]))
