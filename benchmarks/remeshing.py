"""What remeshing costs: nanoseconds per node or particle, and in units of a memory triad.

Every figure is a median of repeated calls in one run, with warm buffers. The triad a = b + s c
streams three arrays of the mesh's size; a law that costs 5 triads moves as much as 15 such arrays.
Takes about a minute; ``--quick`` about ten seconds.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from remesh.grid import Grid
from remesh.nodes import advect_nodes, sample_nodes
from remesh.stencils import max_gradient_norm
from remesh.transfer import m2p, p2m

DEFORMATION = 0.25  # dt * max|grad u| of the displacement: a usual Lagrangian CFL number
WAVES = 9.0  # radians of the displacement's waves along the longest axis


def seconds(law: Callable[[], object], repeats: int) -> float:
    law()
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        law()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


def laws(grid: Grid, dtype: type, kernel: str, threads: int) -> dict[str, Callable[[], object]]:
    """The laws that a step calls, on a smooth displacement of several to many cells."""
    number = WAVES / max(grid.length)
    waves = number * grid.points()
    turned = np.roll(waves, 1, axis=0)
    move = (DEFORMATION / number * np.sin(waves) * np.cos(turned)).astype(dtype)
    field = np.random.default_rng(0).normal(size=grid.shape).astype(dtype)
    velocity = move / grid.spacing
    out, out_vector = np.empty_like(field), np.empty_like(velocity)
    low = np.array(grid.origin)
    places = np.mod((grid.points() + move).reshape(grid.ndim, -1).T - low, grid.length) + low
    places = np.ascontiguousarray(places, dtype)
    strengths = field.ravel()
    vectors = f"sample_nodes, {grid.ndim} components"
    return {
        "advect_nodes": lambda: advect_nodes(field, move, grid, kernel, out=out, threads=threads),
        vectors: lambda: sample_nodes(
            velocity, move, grid, kernel, out=out_vector, threads=threads
        ),
        "p2m": lambda: p2m(places, strengths, grid, kernel, threads=threads),
        "m2p": lambda: m2p(field, places, grid, kernel, threads=threads),
        "max_gradient_norm": lambda: max_gradient_norm(velocity, grid, threads=threads),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="small meshes, one kernel")
    options = parser.parse_args()
    shapes = ((256, 128), (32, 32, 32)) if options.quick else ((1024, 512), (96, 96, 96))
    kernels = ("M4'",) if options.quick else ("M4'", "M6'")
    repeats = 3 if options.quick else 9
    print(f"{'mesh':>14} {'dtype':>8} {'kernel':>6} {'law':<28} {'ns':>7} {'triads':>7}")
    for shape in shapes:
        for dtype in (np.float64, np.float32):
            a, b, c = (np.ones(shape, dtype) for _ in range(3))
            triad = seconds(lambda a=a, b=b, c=c: np.add(b, np.multiply(c, 3, out=a), out=a), 15)
            for kernel in kernels:
                grid = Grid(shape, 1 / shape[-1], boundary="periodic")
                for name, law in laws(grid, dtype, kernel, options.threads).items():
                    taken = seconds(law, repeats)
                    mesh = "x".join(map(str, shape))
                    print(
                        f"{mesh:>14} {np.dtype(dtype).name:>8} {kernel:>6} {name:<28} "
                        f"{taken / grid.size * 1e9:7.1f} {taken / triad:7.1f}"
                    )


if __name__ == "__main__":
    main()
