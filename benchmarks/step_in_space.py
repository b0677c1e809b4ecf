"""Cost of a whole RK2 step in space, beside its two velocity solves, and its memory at the peak.

    python benchmarks/step_in_space.py [--nodes 128] [--threads 2] [--repeats 7] [--check]

Takes about two minutes. A viscous flow in free space on a fixed cube: a vortex ring, which leaves
much of it empty, and a field that fills it, so that no row of zeros is skipped. Columns: seconds of
a step (medians); million node-steps per second beside what is asked; the velocity solves in it,
products with their tables included; the step over them; "FFTs": the transforms in them alone, mesh
to mesh; the step over those; arrays of the mesh's size and of one component at the peak, beside
what the program takes without a flow. Steps, solves and transforms are timed in turn, so that all
see the same machine. ``--check`` exits with 1 where less than asked is reached.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from step import counted, seconds, transforms

from pmesh.vortex.exact import GaussianRing
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Precision = Literal["float64", "float32"]
ASKED: dict[Precision, float] = {"float64": 0.8, "float32": 1.5}  # million node-steps per second
RATIO, ARRAYS = 2.5, 25  # at most: a step over the transforms in it, arrays at the peak
REYNOLDS = 1000.0


def filling(points: Array) -> Array:
    """A field of waves without divergence, of the cube [-2, 2]^3, nowhere zero in whole rows."""
    x, y, z = 0.5 * np.pi * points
    waves = [np.sin(2 * y) * np.cos(3 * z), np.sin(z) * np.cos(2 * x), np.sin(3 * x) * np.cos(y)]
    return np.stack(waves) + 0.1


FIELDS: dict[str, Callable[[Array], Array]] = {
    "ring": GaussianRing(radius=1.0, core=0.2).vorticity,
    "filled": filling,
}


def begin(
    nodes: int, dtype: Precision, threads: int | None, field: str
) -> tuple[VortexFlow, State]:
    """A flow past the steps in which it makes its tables and buffers."""
    grid = Grid((nodes,) * 3, 4.0 / nodes, (-2.0,) * 3)
    flow = VortexFlow(
        grid=grid, viscosity=1 / REYNOLDS, freestream=(0.0,) * 3, domain="fixed", dtype=dtype,
        threads=threads,
    )  # fmt: skip
    state = flow.start(vorticity=FIELDS[field])
    for _ in range(2):
        state = flow.step(state, flow.limit(state).dt)
    return flow, state


class Cost(NamedTuple):
    """Median seconds of a step, of its velocity solves, and of the transforms in those."""

    step: float
    solves: float
    ffts: float


def measure(flow: VortexFlow, state: State, repeats: int) -> Cost:
    """What a step costs, in turn with what is in it; each time the same step."""
    dt = flow.limit(state).dt
    solver, speed = flow.engine.solver(state.grid), np.empty_like(state.vorticity)

    def solve() -> None:
        solver.velocity(state.vorticity, out=speed)

    with counted() as noted:
        flow.step(state, dt)
    works = [transforms(*one) for one in noted]
    taken: list[tuple[float, float, float]] = []
    for _ in range(repeats):
        start = time.perf_counter()
        flow.step(state, dt)
        taken.append((time.perf_counter() - start, seconds([solve] * len(noted)), seconds(works)))
    return Cost(*(statistics.median(column) for column in zip(*taken, strict=True)))


def kilobytes(name: str) -> int:
    """What the kernel counts for this process: "VmRSS" now, "VmHWM" at the peak (Linux)."""
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(name))


def most(nodes: int, dtype: Precision, threads: int | None, field: str) -> float:
    """Arrays at the peak of a step; in a process of its own (Linux)."""
    begin(32, dtype, threads, field)  # loads the program and its loops
    before = kilobytes("VmRSS")
    flow, state = begin(nodes, dtype, threads, field)
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the peak counts from here: not what the start took
    flow.step(state, flow.limit(state).dt)
    return 1024 * (kilobytes("VmHWM") - before) / (nodes**3 * np.dtype(dtype).itemsize)


def elsewhere(*words: Any) -> float:
    """`most`, asked of a new process."""
    command = [sys.executable, __file__, "--peak", *map(str, words)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description="time a whole step in space")
    parser.add_argument("--nodes", type=int, default=128, help="per axis")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--check", action="store_true", help="fail where less is reached")
    parser.add_argument("--peak", nargs=2, metavar=("DTYPE", "FIELD"), help="the memory alone")
    options = parser.parse_args()
    nodes, threads = options.nodes, options.threads
    if options.peak:
        dtype, field = options.peak
        print(most(nodes, dtype, threads, field))
        return
    short = []
    print(f"RK2, M6', free space, {nodes}^3 nodes, {threads} threads")
    print(
        f"{'field':8} {'dtype':8} {'step':>7} {'M/s':>6} {'asked':>6} {'solves':>7} {'ratio':>6} "
        f"{'FFTs':>7} {'ratio':>6} {'arrays':>7}"
    )
    for dtype, asked in ASKED.items():
        for field in FIELDS:
            arrays = elsewhere(dtype, field, "--nodes", nodes, "--threads", threads)
            cost = measure(*begin(nodes, dtype, threads, field), options.repeats)
            rate = nodes**3 / cost.step / 1e6
            print(
                f"{field:8} {dtype:8} {cost.step:7.3f} {rate:6.2f} {asked:6.1f} "
                f"{cost.solves:7.3f} {cost.step / cost.solves:6.2f} {cost.ffts:7.3f} "
                f"{cost.step / cost.ffts:6.2f} {arrays:7.1f}",
                flush=True,
            )
            if rate < asked or cost.step > RATIO * cost.ffts or arrays > ARRAYS:
                short.append(f"{field} {dtype}")
    if options.check and short:
        raise SystemExit(f"less than asked: {', '.join(short)}")


if __name__ == "__main__":
    main()
