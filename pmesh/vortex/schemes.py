"""The law that carries vorticity: particles moved, and stretched, by the velocity they induce."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.buffers import Buffers
from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.nodes import Advected, advect_nodes, sample_nodes
from remesh.paths import Scheme
from remesh.stencils import gradient
from remesh.stretching import Form, stretched

Array = NDArray[np.floating[Any]]


class Carried(NamedTuple):
    """Vorticity particles: strengths [1/T] by home node, and how far each has gone [L].

    Strengths are those that the particles have at home: in space, on the way, they are stretched
    with their lattice. ``displacement`` is None while the particles sit on their nodes.
    """

    strengths: Array
    displacement: Array | None


@dataclass(frozen=True, kw_only=True)
class Carriage:
    """How the particles of a mesh go, are stretched and are remeshed.

    In space strengths w become w + (w . grad) d with the displacement d of the lattice, Cauchy's
    formula, or its conservative form w + div(w d), which keeps their sum: of the order of the time
    scheme in dt, of order 6 in the spacing. The conservative form grows what divergence there is
    by d div w: its displacement counts from the ``drift``, which carries and does not stretch.
    In the plane strengths stay.
    """

    grid: Grid
    kernel: str | Kernel
    scheme: Scheme
    stretching: Form
    threads: int | None
    buffers: Buffers
    scratch: Callable[[tuple[int, ...]], AbstractContextManager[Array]]  # room for one field
    drift: tuple[float, ...] = ()  # a velocity that all have in common [L/T]

    def on_mesh(
        self, particles: Carried, out: Array | None = None, *, time: float = 0.0
    ) -> Advected:
        """The particles remeshed onto their grid, and the strength that left it.

        ``out``: where to; particles on their nodes are on the mesh as they are. ``time``: that they
        have gone for [T].
        """
        if particles.displacement is None:
            return Advected(particles.strengths, np.zeros(particles.strengths.shape[: -self._ndim]))
        if self._ndim == 2:
            return self._advected(particles.strengths, particles.displacement, out)
        displacement = particles.displacement
        drifted = self.stretching == "conservative" and any(self.drift) and time > 0
        shift = np.array(self.drift or (0.0,) * 3, displacement.dtype)[:, None, None, None]
        shift *= displacement.dtype.type(time)
        if drifted:
            displacement -= shift
        with self.scratch(particles.strengths.shape) as room:
            strengths = stretched(
                particles.strengths, displacement, self.grid, self.stretching, out=room,
                threads=self.threads,
            )  # fmt: skip
            if drifted:
                displacement += shift
            return self._advected(strengths, displacement, out)

    def carry(
        self,
        particles: Carried,
        velocity: Array,
        velocity_of: Callable[[Array, float], Array],
        dt: float,
    ) -> Array:
        """Displacement [L] of the particles after dt in the velocity that they induce.

        ``velocity``: on the nodes at the start [L/T], which may be overwritten;
        ``velocity_of(vorticity, part)``: on the nodes, asked once per further stage with the
        particles remeshed where they then are, a part of the step later; it may overwrite the
        vorticity. Order of the scheme in dt; order ``kernel.moments`` and better in the spacing
        when dt follows it.
        """
        base = particles.displacement
        slopes: list[Array | None] = [velocity]
        if base is not None:
            slopes = [self._sampled(velocity, base)]
        rows = self.scheme.rows
        for number, row in enumerate(rows):
            later = [*rows[number + 1 :], self.scheme.weights]
            place = self._combined(base, slopes, row, dt, later)
            stage = self.on_mesh(
                Carried(particles.strengths, place), self._like(particles.strengths),
                time=sum(row) * dt,
            )  # fmt: skip
            speed = velocity_of(stage.field, sum(row))
            slopes.append(self._sampled(speed, place))
            self.buffers.give(place)
        result = self._combined(base, slopes, self.scheme.weights, dt, [])
        for slope in slopes:
            self.buffers.give(slope)
        return result

    def told(self, particles: Carried, before: Array, after: Array) -> Carried:
        """The particles after the vorticity on the mesh changed, (*shape) or (3, *shape) [1/T]."""
        if particles.displacement is None or after is before:
            return particles
        change = sample_nodes(
            after - before, particles.displacement, self.grid, self.kernel, outside="zero",
            threads=self.threads,
        )  # fmt: skip
        if self._ndim == 3:
            change = brought_home(change, particles.displacement, self.grid)
        return Carried(particles.strengths + change, particles.displacement)

    @property
    def _ndim(self) -> int:
        return self.grid.ndim

    def _like(self, array: Array) -> Array:
        return self.buffers.take(array.shape, array.dtype)

    def _advected(self, strengths: Array, displacement: Array, out: Array | None) -> Advected:
        return advect_nodes(
            strengths, displacement, self.grid, self.kernel, out=out, threads=self.threads
        )

    def _sampled(self, velocity: Array, displacement: Array) -> Array:
        """The velocity at displaced nodes, in the place of that at the nodes."""
        with self.scratch(velocity.shape) as room:
            velocity[...] = sample_nodes(
                velocity, displacement, self.grid, self.kernel, out=room, threads=self.threads
            )
        return velocity

    def _combined(
        self,
        base: Array | None,
        slopes: list[Array | None],
        weights: Sequence[float],
        dt: float,
        later: Sequence[Sequence[float]],
    ) -> Array:
        """base + dt * sum of weighted slopes; takes the place of the first if it has no more use.

        ``later``: weights of the sums still to come.
        """
        used = [(number, weight) for number, weight in enumerate(weights) if weight]
        begin, weight = used[0]
        first = slopes[begin]
        assert first is not None  # what has weights is kept
        total = first
        if any(len(row) > begin and row[begin] for row in later):
            total = self._like(first)
        else:
            slopes[begin] = None
        np.multiply(first, first.dtype.type(dt * weight), out=total)
        for number, weight in used[1:]:
            slope = slopes[number]
            assert slope is not None
            for part, one in zip(total, slope, strict=True):
                part += one * one.dtype.type(dt * weight)
        if base is not None:
            total += base
        return total


def brought_home(change: Array, displacement: Array, grid: Grid) -> Array:
    """The strengths at home that a displaced lattice stretches to a given change (classical form).

    Solves (1 + grad d) s = change at every node.
    """
    turned = gradient(displacement, grid, order=6)  # [j, i] = d d_i / d x_j
    matrix = np.moveaxis(turned, (0, 1), (-1, -2)) + np.eye(3, dtype=turned.dtype)
    home = np.linalg.solve(matrix, np.moveaxis(change, 0, -1)[..., None])[..., 0]
    return np.ascontiguousarray(np.moveaxis(home, -1, 0))
