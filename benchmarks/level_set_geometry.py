"""What geometry of a level set costs in a narrow band, and how the cost grows with the mesh.

Prints, for a disk and a ball and a band of eight nodes across the contour, the time per node of the
band and the exponent between two meshes: the interface's is ndim - 1. About ten seconds.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from levelset.curvatures import curvature, normal
from levelset.extension import extend
from levelset.quadrature import measures
from levelset.shapes import Disk, Sphere
from remesh.grid import Grid

MESHES = {2: (512, 1024, 2048), 3: (32, 64, 128)}
REPEATS = 5


def best(law: Callable[[], object]) -> float:
    """Least processor time of some runs, after one that compiles [s]."""
    law()
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        law()
        times.append(time.process_time() - start)
    return min(times)


for ndim, counts in MESHES.items():
    before: dict[str, float] = {}
    for n in counts:
        grid = Grid((n,) * ndim, 3.1 / n, origin=(-1.55 + 1.55 / n,) * ndim)
        phi = (Disk(1.0) if ndim == 2 else Sphere(1.0)).distance(grid.points())
        nodes = np.flatnonzero(np.abs(phi) < 4 * grid.spacing)
        known = phi.reshape(-1)[nodes].copy()
        laws: dict[str, Callable[[], object]] = {
            "measures": lambda v=known, g=grid, m=nodes: measures(v, g, nodes=m, threads=1),
            "normal": lambda v=known, g=grid, m=nodes: normal(v, g, nodes=m, threads=1),
            "curvature": lambda v=known, g=grid, m=nodes: curvature(v, g, nodes=m, threads=1),
            "extend": lambda v=known, g=grid, m=nodes: extend(v, v, g, nodes=m, threads=1),
        }
        for name, law in laws.items():
            took = best(law)
            grown = f"  exponent {np.log2(took / before[name]):.2f}" if name in before else ""
            print(f"{ndim}-D {n:5d}  {name:9s} {1e9 * took / len(nodes):6.0f} ns/node{grown}")
            before[name] = took
