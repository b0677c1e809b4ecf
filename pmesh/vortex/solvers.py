"""The velocity solvers of a flow, kept between steps for their spectra and buffers."""

from __future__ import annotations

import threading
from collections import OrderedDict

from pmesh.spectral.velocity import VelocitySolver
from remesh.grid import Grid

KEPT = 12  # solvers at most
KEPT_NODES = 1_000_000  # of all but the largest: a mesh that grows lets go of what it was
_solvers: OrderedDict[tuple[object, ...], VelocitySolver] = OrderedDict()
_lock = threading.Lock()


def solver_for(
    grid: Grid, *, order: int, radius: float, dtype: str, threads: int | None
) -> VelocitySolver:
    """The solver of a mesh of this shape, wherever it lies; an earlier one if there is."""
    key = (grid.shape, grid.spacing, grid.boundary, order, radius, dtype, threads)
    with _lock:
        solver = _solvers.pop(key, None)
        if solver is None:
            mesh = Grid(grid.shape, grid.spacing, None, grid.boundary)
            solver = VelocitySolver(mesh, order=order, radius=radius, dtype=dtype, threads=threads)
        _solvers[key] = solver
        while len(_solvers) > KEPT or _spare_nodes() > KEPT_NODES:
            _solvers.popitem(last=False)
    return solver


def _spare_nodes() -> int:
    """Nodes of all solvers but the largest."""
    sizes = [solver.grid.size for solver in _solvers.values()]
    return sum(sizes) - max(sizes)
