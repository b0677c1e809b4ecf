"""Cost and accuracy of the velocity solve on adaptive meshes, beside the uniform solve.

    python benchmarks/adaptive_velocity.py [--threads 2] [--space]

Takes about a minute, with ``--space`` (3-D) three more. One row per field and tolerance: active
nodes, their share of the finest grid, blocks, processor milliseconds (of all threads, best of
several) of one velocity, nanoseconds per active node, the largest error over the largest velocity,
the same in tolerances, and how many times less the solve costs than the uniform one on the finest
grid. Fields are vortices of widths from 4 to 40 spacings (3-D: 4 to 12), scattered at random, the
same seeds for all. At the end the exponent of time against active nodes for each tolerance.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.spectral.corrections import AdaptiveSolver
from pmesh.spectral.velocity import VelocitySolver
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled
from remesh.threads import thread_count

Array = NDArray[Any]
Flow = Callable[[Array], tuple[Array, Array]]


def vortices(count: int, spacing: float, generator: np.random.Generator) -> Flow:
    """Gaussian vortices in the plane: vorticity and velocity."""
    width = spacing * np.exp(generator.uniform(np.log(4), np.log(40), count))
    center = generator.uniform(0.25, 0.75, (count, 2))
    peak = generator.choice((-1, 1), count) * 4 * spacing / width

    def flow(points: Array) -> tuple[Array, Array]:
        vorticity, velocity = np.zeros(points.shape[1:]), np.zeros(points.shape)
        for w, c, a in zip(width, center, peak, strict=True):
            x, y = points[0] - c[0], points[1] - c[1]
            r2 = np.maximum(x**2 + y**2, 1e-300)
            bell = np.exp(-r2 / (2 * w**2))
            turn = a * w**2 * (1 - bell) / r2
            vorticity += a * bell
            velocity += np.stack([-turn * y, turn * x])
        return vorticity, velocity

    return flow


def blobs(count: int, spacing: float, generator: np.random.Generator) -> Flow:
    """Curls of the curl of Gaussian vectors in space: vorticity and velocity."""
    width = spacing * np.exp(generator.uniform(np.log(4), np.log(12), count))
    center = generator.uniform(0.38, 0.62, (count, 3))
    axes = generator.normal(size=(count, 3))

    def flow(points: Array) -> tuple[Array, Array]:
        vorticity, velocity = np.zeros(points.shape), np.zeros(points.shape)
        for w, c, axis in zip(width, center, axes, strict=True):
            x = np.stack([p - o for p, o in zip(points, c, strict=True)]) / w
            a = axis.reshape(3, *(1,) * (points.ndim - 1))
            r2 = (x**2).sum(axis=0)
            bell = np.exp(-r2 / 2)
            vorticity += np.cross(np.broadcast_to(a, x.shape), x, axis=0) * (5 - r2) * bell / w
            velocity += (2 * a + (a * x).sum(axis=0) * x - a * r2) * bell
        return vorticity, velocity

    return flow


def best(work: Callable[[], object], least: float = 0.3) -> float:
    """Processor milliseconds of the fastest of several calls."""
    work()
    times: list[float] = []
    while sum(times) < least or len(times) < 3:
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def row(mesh: AdaptiveMesh, flow: Flow, dtype: str, threads: int) -> tuple[int, int, float, float]:
    """Active nodes, blocks, milliseconds and relative error of one solve."""
    blocks, vorticity = sampled(lambda points: flow(points)[0], mesh, threads=threads)
    solver, vorticity = AdaptiveSolver(mesh, threads=threads), vorticity.astype(dtype)
    found = solver.velocity(vorticity, blocks)
    exact, leaves = flow(blocks.points())[1], blocks.leaves()
    error = np.abs(found - exact)[:, leaves].max() / np.abs(exact[:, leaves]).max()
    took = best(lambda: solver.velocity(vorticity, blocks))
    return blocks.active, blocks.size, took, float(error)


def study(ndim: int, nodes: int, levels: int, counts: list[int], threads: int) -> None:
    """The table of one number of dimensions."""
    grid = Grid((nodes,) * ndim, 1 / nodes)
    uniform = VelocitySolver(grid, threads=threads)
    source = np.zeros(grid.shape if ndim == 2 else (3, *grid.shape))
    whole = best(lambda: uniform.velocity(source))
    print(f"{nodes}^{ndim}, {levels} halvings, {threads} threads: uniform {whole:.1f} ms")
    print("vortices  type  tolerance    active  share   blocks      ms  ns/active    error  tol  x")
    rows = []
    for count in counts:
        flow = (vortices if ndim == 2 else blobs)(count, 1 / nodes, np.random.default_rng(count))
        for dtype, tolerance in [("f8", 1e-2), ("f8", 1e-3), ("f8", 1e-4), ("f4", 1e-3)]:
            mesh = AdaptiveMesh(grid=grid, levels=levels, tolerance=tolerance)
            active, size, took, error = row(mesh, flow, dtype, threads)
            if dtype == "f8":
                rows.append((active, size, took, tolerance))
            print(
                f"{count:8d}  {dtype:>4}  {tolerance:9.0e}  {active:8d}  {active / grid.size:5.1%}"
                f"  {size:7d}  {took:6.1f}  {1e6 * took / active:9.0f}  {error:7.1e}"
                f"  {error / tolerance:3.1f}  {whole / took:.0f}"
            )
    for tolerance in (1e-2, 1e-3, 1e-4):
        some = [(a, t) for a, size, t, own in rows if own == tolerance and size > 10]
        power = np.polyfit(*np.log(np.array(some)).T, 1)[0]
        print(f"tolerance {tolerance:.0e}: time ~ active^{power:.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--space", action="store_true", help="3-D too")
    arguments = parser.parse_args()
    threads = thread_count(arguments.threads)
    study(2, 2048, 6, [8, 32, 128], threads)
    if arguments.space:
        study(3, 256, 3, [1, 4, 12], threads)


if __name__ == "__main__":
    main()
