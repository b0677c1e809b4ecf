"""Cost of a whole RK2 step in free space, beside the FFTs in it, with and without the cylinder.

    python benchmarks/step.py [--shape 1024 512] [--threads 2] [--repeats 9] [--check]

Takes about a minute. Every convolution that a step asks for is noted as it happens, those on the
penalisation's small boxes too; then its transforms are timed in turn with steps, so that both see
the same machine. Columns: milliseconds of a step (medians); million node-steps per second beside
what is asked; the FFTs, mesh to mesh: the same convolutions without their products; the step over
them; "bare": the lines' transforms alone, in the cache; forward and inverse transforms on the whole
mesh; those on small boxes; iterations of the penalisation. ``--check`` exits with 1 where less
than asked is reached.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from poisson import bare_transforms

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.spectral.convolve import Convolver, Term
from pmesh.vortex.exact import LambOseen
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.grid import Grid

Solve = tuple[Convolver, int, int]  # and its numbers of sources and outputs
CASES = {  # name: viscosity, with the cylinder, million node-steps per second asked in float64
    "inviscid vortex": (0.0, False, 3.0),
    "viscous vortex": (1 / 550, False, 3.0),
    "cylinder, Re = 550": (1 / 550, True, 2.0),
}
RATIO = 2.5  # a step takes at most this many times its FFTs


def begin(
    shape: tuple[int, int], viscosity: float, body: bool, dtype: Any, threads: int | None
) -> tuple[VortexFlow, State]:
    """A flow that fills its mesh, past the steps in which it finds its pace."""
    spacing = 8.0 / shape[0]
    grid = Grid(shape, spacing, (-1.5, -0.5 * shape[1] * spacing))
    flow = VortexFlow(
        grid=grid, viscosity=viscosity, freestream=(1.0, 0.0), domain="fixed", dtype=dtype,
        bodies=(RigidBody(Disk(radius=0.5)),) if body else (), threads=threads,
    )  # fmt: skip
    vortex = LambOseen(circulation=1.0, core=0.3, viscosity=1e-3, center=(1.0, 0.0))
    state = flow.start(vorticity=None if body else vortex.vorticity)
    for _ in range(12 if body else 3):
        state = flow.step(state, flow.limit(state).dt)
    return flow, state


@contextmanager
def counted() -> Iterator[list[Solve]]:
    """The solves that are asked for meanwhile."""
    solves: list[Solve] = []
    run = Convolver.run

    def count(self: Convolver, sources: Any, outputs: Any, *rest: Any, **options: Any) -> None:
        solves.append((self, len(sources), len(outputs)))
        run(self, sources, outputs, *rest, **options)

    Convolver.run = count  # type: ignore[method-assign]
    try:
        yield solves
    finally:
        Convolver.run = run  # type: ignore[method-assign]


def seconds(works: list[Callable[[], None]]) -> float:
    start = time.perf_counter()
    for work in works:
        work()
    return time.perf_counter() - start


def transforms(convolver: Convolver, sources: int, outputs: int) -> Callable[[], None]:
    """The transforms of one convolution from fields to fields, without its products."""
    fields = [np.ones(convolver.box.shape, convolver.dtype) for _ in range(max(sources, outputs))]
    terms = [[Term(min(number, sources - 1))] for number in range(outputs)]
    return lambda: convolver.run(fields[:sources], terms, fields[:outputs])


class Cost(NamedTuple):
    """Median seconds of a step and of what is in it."""

    step: float
    ffts: float
    bare: float
    solves: list[Solve]
    iterations: float


def measure(flow: VortexFlow, state: State, repeats: int) -> Cost:
    """What a step costs, in turn with the transforms in it."""
    times: dict[str, list[float]] = {"step": [], "ffts": [], "bare": []}
    iterations = []
    for _ in range(repeats):
        dt = flow.limit(state).dt
        with counted() as noted:
            start = time.perf_counter()
            state = flow.step(state, dt)
            times["step"].append(time.perf_counter() - start)
        for name, law in (("ffts", transforms), ("bare", bare_transforms)):
            works = [law(*solve) for solve in noted]
            times[name].append(seconds(works))
        iterations.append(state.constraint.iterations if state.constraint else 0)
    middle = {name: statistics.median(found) for name, found in times.items()}
    return Cost(**middle, solves=noted, iterations=statistics.mean(iterations))


def count(solves: list[Solve]) -> str:
    """Transforms of some solves, forward + inverse."""
    return f"{sum(n for _, n, _ in solves)} + {sum(n for _, _, n in solves)}"


def main() -> None:
    parser = argparse.ArgumentParser(description="time a whole step")
    parser.add_argument("--shape", type=int, nargs=2, default=(1024, 512))
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--check", action="store_true", help="fail where less is reached")
    options = parser.parse_args()
    shape = (options.shape[0], options.shape[1])
    nodes, short = math.prod(shape), []
    print(f"RK2, M6', free space, {shape[0]} x {shape[1]} nodes")
    print(
        f"{'flow':20} {'dtype':8} {'step':>7} {'M/s':>6} {'asked':>6} {'FFTs':>7} {'ratio':>6} "
        f"{'bare':>7} {'mesh':>7} {'boxes':>8} {'its':>5}"
    )
    for dtype in ("float64", "float32"):
        for name, (viscosity, body, asked) in CASES.items():
            cost = measure(*begin(shape, viscosity, body, dtype, options.threads), options.repeats)
            rate, ratio = nodes / cost.step / 1e6, cost.step / cost.ffts
            whole = [solve for solve in cost.solves if solve[0].box.shape == shape]
            boxes = [solve for solve in cost.solves if solve[0].box.shape != shape]
            print(
                f"{name:20} {dtype:8} {1e3 * cost.step:7.1f} {rate:6.2f} {asked:6.1f} "
                f"{1e3 * cost.ffts:7.1f} {ratio:6.2f} {1e3 * cost.bare:7.1f} {count(whole):>7} "
                f"{count(boxes):>8} {cost.iterations:5.1f}",
                flush=True,
            )
            if dtype == "float64" and (rate < asked or ratio > RATIO):
                short.append(name)
    if options.check and short:
        raise SystemExit(f"less than asked: {', '.join(short)}")


if __name__ == "__main__":
    main()
