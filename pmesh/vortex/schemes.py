"""Moving particles: Runge-Kutta schemes as tables, and the law that carries vorticity."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.nodes import Advected, advect_nodes, sample_nodes

Array = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Scheme:
    """An explicit Runge-Kutta scheme: ``rows[k]`` weighs the slopes before stage k + 1."""

    name: str
    order: int
    rows: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    source: str


SCHEMES: dict[str, Scheme] = {
    scheme.name: scheme
    for scheme in (
        Scheme("RK2", 2, ((1 / 2,),), (0.0, 1.0), "midpoint rule"),
        Scheme("RK3", 3, ((1 / 2,), (0.0, 3 / 4)), (2 / 9, 1 / 3, 4 / 9), "Ralston 1962"),
    )
}


class Carried(NamedTuple):
    """Vorticity particles: strengths [1/T] by home node, and how far each has gone [L].

    ``displacement`` is None while the particles sit on their nodes.
    """

    strengths: Array
    displacement: Array | None


def on_mesh(
    particles: Carried, grid: Grid, kernel: str | Kernel, threads: int | None = None
) -> Advected:
    """The particles remeshed onto their grid, and the strength that left it."""
    if particles.displacement is None:
        return Advected(particles.strengths, np.zeros(()))
    return advect_nodes(particles.strengths, particles.displacement, grid, kernel, threads=threads)


def carry(
    particles: Carried,
    velocity: Array,
    velocity_of: Callable[[Array, float], Array],
    grid: Grid,
    dt: float,
    scheme: Scheme,
    kernel: str | Kernel,
    threads: int | None = None,
) -> Array:
    """Displacement [L] of the particles after dt in the velocity that they induce.

    ``velocity``: on the nodes at the start [L/T]; ``velocity_of(vorticity, part)``: on the
    nodes, asked once per further stage with the particles remeshed where they then are, a part of
    the step later. Order of the scheme
    in dt; order ``kernel.moments`` and better in the spacing when dt follows it.
    """
    base = particles.displacement
    slopes = [velocity]
    if base is not None:
        slopes = [sample_nodes(velocity, base, grid, kernel, threads=threads)]
    for row in scheme.rows:
        moved = _moved(base, slopes, row, dt)
        stage = on_mesh(Carried(particles.strengths, moved), grid, kernel, threads)
        slopes.append(
            sample_nodes(velocity_of(stage.field, sum(row)), moved, grid, kernel, threads=threads)
        )
    return _moved(base, slopes, scheme.weights, dt)


def _moved(base: Array | None, slopes: list[Array], weights: Sequence[float], dt: float) -> Array:
    """base + dt * sum of weighted slopes."""
    used = [(weight, slope) for weight, slope in zip(weights, slopes, strict=True) if weight]
    (weight, slope), *others = used
    total = slope * slope.dtype.type(dt * weight)
    for weight, slope in others:
        total += slope * slope.dtype.type(dt * weight)
    if base is not None:
        total += base
    return total
