"""Zalesak's disk after one turn, by kernel and number of steps, and by a fifth-order WENO scheme.

    python benchmarks/zalesak.py [--nodes 100] [--kernels "M4'" "M6'" L4,4] [--steps 628 63]

Each line: change of the area and mean distance of the interface from the exact one. The WENO scheme
carries the same level set on all nodes of the mesh (tests/weno_level_set.py, no redistancing).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from levelset.quadrature import volume
from pmesh.cases.interface_error import mean_error
from pmesh.cases.zalesak import PERIOD
from pmesh.cases.zalesak_disk import ZalesakDisk
from pmesh.run.loop import run
from remesh.reconstruction import reconstruct


class Wide(ZalesakDisk):
    """The same, its error counted farther from the exact interface."""

    reach = 4.0


def carried(case: ZalesakDisk) -> tuple[float, float]:
    """Relative change of area and mean error in cells after the run."""
    flow, state = case.build()
    end = run(flow, state, until=case.until)
    return flow.ledger(end)["volume"] / case.shape.volume - 1, case.mean_error(end)


def by_weno(case: ZalesakDisk, courant: float) -> tuple[float, float]:
    """The same of the level set that the WENO scheme carries."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    from weno_level_set import carried as weno

    shape, grid = case.shape, case.recipe().grid
    end = weno(shape.distance(grid.points()), grid, case.law, PERIOD, courant=courant)
    near = np.abs(end) < 8 * grid.spacing
    places, values = grid.points()[:, near].T.copy(), end[near]

    def value_at(points: np.ndarray) -> np.ndarray:
        return reconstruct(places, values, points, grid.spacing, degree=2)

    error = mean_error(shape, value_at, grid.spacing, reach=Wide.reach)
    return volume(end, grid) / shape.volume - 1, error


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--nodes", type=int, default=100)
    options.add_argument("--kernels", nargs="+", default=["M4'", "M6'", "L4,4", "L6,4"])
    options.add_argument("--steps", nargs="+", type=int, default=[628, 63])
    options.add_argument("--width", type=float, default=6.0)
    options.add_argument("--courant", type=float, default=0.5, help="of the WENO scheme")
    args = options.parse_args()
    rows = [("no remeshing", 628, Wide(nodes=args.nodes))]
    for kernel in args.kernels:
        for steps in args.steps:
            case = Wide(
                nodes=args.nodes, kernel=kernel, steps=steps, remeshing="always", width=args.width
            )
            rows.append((f"remeshed by {kernel}", steps, case))
    print(f"{'':24} steps   area - exact   mean error [cells]   seconds")

    def show(name: str, steps: str, found: tuple[float, float], start: float) -> None:
        area, error = found
        taken = perf_counter() - start
        print(f"{name:24} {steps:>5}   {100 * area:+9.4f} %   {error:16.4f}   {taken:7.1f}")

    for name, steps, case in rows:
        start = perf_counter()
        show(name, str(steps), carried(case), start)
    start = perf_counter()
    show(f"WENO5, CFL {args.courant:g}", "", by_weno(rows[0][2], args.courant), start)


if __name__ == "__main__":
    main()
