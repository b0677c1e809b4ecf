"""Orders of accuracy of unsteady flows in space, in the spacing and in the time step.

    python benchmarks/order_in_space.py [space] [time] [free] [--threads 1]

``space``: a Beltrami flow in a stream, exact for all time, dt following the spacing, for kernels
and both forms of stretching; ``time``: the same on one mesh, RK2 and RK3, without viscosity and
with it; ``free``: an elliptic ring in free space beside itself on a finer mesh. Prints
relative L2 errors of the vorticity (and velocity), and the order that two neighbours tell.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import replace

import numpy as np

import pmesh
from pmesh.vortex.exact import BeltramiFlow
from remesh.grid import Grid

STRENGTHS, DRIFT = (1.0, 0.7, 0.43), (0.5, -0.3, 0.2)  # of the Beltrami flow [L/T]
END = 0.5  # [T]
KERNELS = ("M4'", "M6'", "L4,4", "L6,4", "L6,6")
FORMS = ("conservative", "classical")


def apart(ours: np.ndarray, exact: np.ndarray) -> float:
    """Relative L2 distance."""
    return float(np.linalg.norm(ours - exact) / np.linalg.norm(exact))


def orders(errors: list[float], sizes: list[float]) -> list[float]:
    """Between neighbours."""
    pairs = zip(errors, errors[1:], sizes, sizes[1:], strict=False)
    return [math.log(a / b) / math.log(h / k) for a, b, h, k in pairs]


def told(name: str, errors: list[float], sizes: list[float]) -> None:
    """Print a row."""
    found = "  ".join(f"{order:5.2f}" for order in orders(errors, sizes))
    print(f"{name:34s}", "  ".join(f"{error:.3e}" for error in errors), " order", found, flush=True)


def beltrami(nodes: int, viscosity: float, threads: int, **options: object):
    """The flow on one period, and the exact one."""
    exact = BeltramiFlow(strengths=STRENGTHS, viscosity=viscosity, drift=DRIFT)
    grid = Grid((nodes,) * 3, exact.length / nodes, boundary="periodic")
    flow = pmesh.VortexFlow(
        grid=grid, viscosity=viscosity, freestream=DRIFT, threads=threads, **options
    )  # type: ignore[arg-type]
    return flow, exact


def advanced(flow: pmesh.VortexFlow, vorticity: object, steps: int, end: float = END):
    """The state at the end after equal steps."""
    state = flow.start(vorticity=vorticity)
    for _ in range(steps):
        state = flow.step(state, end / steps)
    return state


def in_spacing(threads: int) -> None:
    """Orders in the spacing, dt following it: no particle passes half a cell in a step."""
    sizes = [16, 32, 48]
    for viscosity in (0.0, 0.02):
        for form in FORMS:
            for kernel in KERNELS:
                errors, speeds = [], []
                for nodes in sizes:
                    flow, exact = beltrami(
                        nodes, viscosity, threads, kernel=kernel, stretching=form,
                        time_scheme="RK4",
                    )  # fmt: skip
                    end = advanced(flow, exact.vorticity, 5 * nodes // 16, 0.25)
                    points = end.grid.points()
                    errors.append(apart(end.vorticity, exact.vorticity(points, 0.25)))
                    speeds.append(apart(flow.velocity(end), exact.velocity(points, 0.25)))
                steps = [1 / n for n in sizes]
                name = f"{kernel} {form} nu {viscosity:g}"
                told(name + ", vorticity", errors, steps)
                told(name + ", velocity", speeds, steps)


def in_time(threads: int) -> None:
    """Orders in dt on one mesh, whose own error cancels."""
    counts = [4, 8, 16]
    for viscosity in (0.0, 0.05):
        for form in FORMS:
            for scheme in ("RK2", "RK3"):
                flow, exact = beltrami(
                    32, viscosity, threads, kernel="L8,4", stretching=form, time_scheme="RK4"
                )  # fmt: skip
                fine = advanced(flow, exact.vorticity, 128).vorticity
                flow = replace(flow, time_scheme=scheme)
                errors = [apart(advanced(flow, exact.vorticity, n).vorticity, fine) for n in counts]
                told(f"{scheme} {form} nu {viscosity:g}", errors, [1 / n for n in counts])


def elliptic_ring(points: np.ndarray) -> np.ndarray:
    """The curl of a Gaussian along z, hence without divergence: a ring that is not round."""
    x, y, z = points
    bell = np.exp(-((x / 0.66) ** 2) - (y / 0.5) ** 2 - (z / 0.42) ** 2)
    return np.stack([-2.0 * y / 0.25 * bell, 2.0 * x / 0.4356 * bell, np.zeros_like(x)])


def in_free_space(threads: int) -> None:
    """Order in the spacing by self-convergence."""

    def run(cells: int, kernel: str, form: str) -> np.ndarray:
        h = 1.0 / cells
        shape = tuple(2 * round(side * cells) for side in (2.5, 2.0, 2.0))
        grid = Grid(shape, h, tuple(-0.5 * n * h for n in shape))
        flow = pmesh.VortexFlow(
            grid=grid,
            kernel=kernel,
            stretching=form,
            time_scheme="RK4",
            domain="fixed",
            threads=threads,
        )  # type: ignore[arg-type]
        return advanced(flow, elliptic_ring, cells, 0.5).vorticity

    fine, sizes = run(24, "L8,4", "conservative"), (6, 8, 12)
    for form in FORMS:
        for kernel in ("M4'", "M6'", "L6,4"):
            errors = []
            for n in sizes:
                there = (slice(None), *(slice(None, None, 24 // n),) * 3)
                errors.append(apart(run(n, kernel, form), fine[there]))
            told(f"{kernel} {form}, elliptic ring", errors, [1 / n for n in sizes])


def main() -> None:
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description="orders of accuracy of flows in space")
    parser.add_argument("tables", nargs="*", metavar="space|time|free")
    parser.add_argument("--threads", type=int, default=1)
    given = parser.parse_args()
    tables = {"space": in_spacing, "time": in_time, "free": in_free_space}
    for name in given.tables or tables:
        began = time.perf_counter()
        tables[name](given.threads)
        print(f"{name}: {time.perf_counter() - began:.0f} s\n")


if __name__ == "__main__":
    main()
