"""The elliptical vortex on an adaptive mesh beside the same on the finest uniform one.

    python benchmarks/adaptive_flow.py [--nodes 1024] [--levels 5] [--tolerance 1e-4]
        [--until 1.0] [--repeats 7] [--blocks 16]

Runs the adaptive flow to ``--until`` and the uniform one through the same steps, and tells how far
the vorticity is apart, relative to its largest value; then times steps of both in turn, so that
both see the same machine: medians, their ratio, and the part of a step that adapting the mesh
takes. Then a vortex carried through its mesh by a stream, with steps of CFL 1 and 20.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from pmesh.vortex import adaptive
from pmesh.vortex.exact.patches import EllipticVortex
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.uniform import to_uniform

SIDE = 3.2  # of the box, in which the longer half axis of the vortex is 0.8
CORE = 0.1  # of the vortex that a stream carries
PATH = 1.0  # that it goes


@contextmanager
def clocked(names: tuple[str, ...]) -> Iterator[dict[str, float]]:
    """Seconds spent in some functions of the adaptive engine meanwhile."""
    spent = dict.fromkeys(names, 0.0)
    plain = {name: getattr(adaptive, name) for name in names}

    def timed(name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            start = time.perf_counter()
            result = plain[name](*arguments, **options)
            spent[name] += time.perf_counter() - start
            return result

        return call

    for name in names:
        setattr(adaptive, name, timed(name))
    try:
        yield spent
    finally:
        for name, law in plain.items():
            setattr(adaptive, name, law)


def beside_uniform(options: argparse.Namespace) -> None:
    """Accuracy, active nodes and time per step of both."""
    n = options.nodes
    grid = Grid((n, n), SIDE / n, (-0.5 * SIDE,) * 2)
    mesh = AdaptiveMesh(
        grid=grid, levels=options.levels, tolerance=options.tolerance, block=options.block,
        refinement=options.refinement,
    )  # fmt: skip
    law = EllipticVortex(kind="I").vorticity
    how = {"kernel": options.kernel, "deformation": options.deformation}
    flows = VortexFlow(grid=mesh, **how), VortexFlow(grid=grid, domain="fixed", **how)
    states: list[Any] = [flow.start(vorticity=law) for flow in flows]
    most, steps, until = 0, 0, options.until
    while states[0].time < until * (1 - 1e-12):
        dt = min(flows[0].limit(states[0]).dt, until - states[0].time)
        states[0] = flows[0].step(states[0], dt)
        if not options.skip_uniform:
            states[1] = flows[1].step(states[1], dt)
        most, steps = max(most, states[0].blocks.active), steps + 1
    one = to_uniform(states[0].vorticity, states[0].blocks)
    print(f"t = {until:g}, {steps} steps, tolerance {options.tolerance:g}, {n}^2 nodes at most")
    print(f"  active nodes {states[0].blocks.active}, at most {most}: 1/{n * n / most:.1f} of them")
    if not options.skip_uniform:
        apart = np.abs(one - states[1].vorticity).max() / np.abs(states[1].vorticity).max()
        print(f"  vorticity apart by {apart:.2e} of the largest")
    names = ("adapt", "landing", "carried", "sampled_at", "gradient_norm")
    times: list[list[float]] = [[], []]
    solves: list[float] = []
    shares: list[dict[str, float]] = []
    for _ in range(options.repeats):
        for k in (0,) if options.skip_uniform else (0, 1):
            dt = flows[k].limit(states[k]).dt
            with clocked(names) as spent:
                start = time.perf_counter()
                flows[k].step(states[k], dt)
                times[k].append(time.perf_counter() - start)
            if k == 0:
                shares.append({name: part / times[0][-1] for name, part in spent.items()})
        start = time.perf_counter()
        flows[0].velocity(states[0])
        solves.append(time.perf_counter() - start)
    step, solve = statistics.median(times[0]), statistics.median(solves)
    print(f"  step {1e3 * step:.1f} ms, of which a velocity solve {1e3 * solve:.1f}")
    for name in names:
        print(f"    {name}: {100 * statistics.median(s[name] for s in shares):.1f} % of the step")
    if times[1]:
        full = statistics.median(times[1])
        print(f"  uniform step {1e3 * full:.1f} ms: {full / step:.2f} times as long")


def carried_by_a_stream(options: argparse.Namespace) -> None:
    """A vortex goes through its mesh with steps of different length."""
    n = options.nodes
    grid = Grid((n, n // 2), 2.0 / n, (-0.5, -0.5))
    mesh = AdaptiveMesh(grid=grid, levels=options.levels, tolerance=options.tolerance)

    def law(points: Any) -> Any:
        return np.exp(-0.5 * (points[0] ** 2 + points[1] ** 2) / (0.4 * CORE) ** 2)

    for cfl in (1.0, 20.0):
        flow = VortexFlow(
            grid=mesh, freestream=(1.0, 0.0), largest_step=cfl * grid.spacing,
            kernel=options.kernel,
        )  # fmt: skip
        state: Any = flow.start(vorticity=law)
        steps = round(PATH / (cfl * grid.spacing))
        for _ in range(steps):
            state = flow.step(state, PATH / steps)
        x, y = grid.points()
        off = np.abs(to_uniform(state.vorticity, state.blocks) - law(np.stack([x - PATH, y]))).max()
        print(f"CFL {cfl:g}: {steps} steps, error {off:.2e}, active nodes {state.blocks.active}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=1024, help="of the finest mesh along an axis")
    parser.add_argument("--levels", type=int, default=5)
    parser.add_argument("--tolerance", type=float, default=1e-4)
    parser.add_argument("--refinement", type=float, default=16e-4)
    parser.add_argument("--block", type=int, default=16)
    parser.add_argument("--kernel", default="L6,4")
    parser.add_argument("--deformation", type=float, default=0.1)
    parser.add_argument("--until", type=float, default=1.0)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--skip-uniform", action="store_true", help="the adaptive flow alone")
    options = parser.parse_args()
    beside_uniform(options)
    carried_by_a_stream(options)


if __name__ == "__main__":
    main()
