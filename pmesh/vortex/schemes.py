"""The law that carries vorticity: particles moved in the velocity that they induce."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid
from remesh.kernels import Kernel
from remesh.nodes import Advected, advect_nodes, sample_nodes
from remesh.paths import Scheme, moved

Array = NDArray[np.floating[Any]]


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
        place = moved(base, slopes, row, dt)
        stage = on_mesh(Carried(particles.strengths, place), grid, kernel, threads)
        slopes.append(
            sample_nodes(velocity_of(stage.field, sum(row)), place, grid, kernel, threads=threads)
        )
    return moved(base, slopes, scheme.weights, dt)
