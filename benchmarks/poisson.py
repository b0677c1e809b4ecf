"""Cost of the velocity solve, beside the bare FFTs in it and a plain padded solve.

    python benchmarks/poisson.py [--threads 2] [--big]

Takes about half a minute. Columns: milliseconds (median) of one velocity solve; of its transforms
alone (same plans and blocks, no copies, no products); their ratio; of a plain solve that pads
with zeros and transforms everything with scipy.fft; the gain over it; of one diffuse-and-velocity;
and the seconds of the first call.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from collections.abc import Callable

import numpy as np
import scipy.fft

from pmesh.spectral.convolve import Convolver, _Worker
from pmesh.spectral.velocity import VelocitySolver
from remesh.grid import Grid
from remesh.threads import thread_count

SIZES = [
    ((200, 200), "f8"),
    ((1024, 512), "f8"),
    ((1024, 512), "f4"),
    ((1024, 1024), "f8"),
    ((64, 64, 64), "f8"),
]
BIG = [((2048, 2048), "f8"), ((128, 128, 128), "f8")]


def milliseconds(work: Callable[[], object], least: float = 0.6) -> float:
    work()
    times: list[float] = []
    while sum(times) < least or len(times) < 3:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def bare_transforms(convolver: Convolver, sources: int, outputs: int) -> Callable[[], None]:
    """The transforms of one solve and nothing else; the convolver must have run before."""
    rows, modes = (
        math.prod(convolver._row_blocks()),
        math.ceil(convolver.modes / convolver.mode_block),
    )

    def rows_in(own: _Worker, block: int) -> None:
        own.to_hat()

    def rows_out(own: _Worker, block: int) -> None:
        own.from_hat()

    def columns(own: _Worker, block: int) -> None:
        for s in range(sources):
            if convolver.padded_middle > 1:
                own.plane_forward()
            own.forward[s]()
        for _ in range(outputs):
            own.backward()
            if convolver.padded_middle > 1:
                own.plane_backward()

    def work() -> None:
        for _ in range(sources):
            convolver._each(rows_in, rows)
        convolver._each(columns, modes)
        for _ in range(outputs):
            convolver._each(rows_out, rows)

    return work


def plain_solve(grid: Grid, dtype: str, threads: int) -> Callable[[], object]:
    """Pad, transform everything, multiply by complex spectra, transform back, cut: no pruning."""
    padded = tuple(2 * n for n in grid.shape)
    fields = 1 if grid.ndim == 2 else 3
    half = (*padded[:-1], padded[-1] // 2 + 1)
    spectra = [np.ones(half, np.result_type(dtype, "c8")) for _ in range(grid.ndim)]
    vorticity = np.ones((fields, *grid.shape), dtype)
    axes = tuple(range(grid.ndim))
    inner = tuple(slice(0, n) for n in grid.shape)

    def work() -> object:
        hats = [scipy.fft.rfftn(w, padded, axes=axes, workers=threads) for w in vorticity]
        if grid.ndim == 2:
            products = [hats[0] * spectra[1], hats[0] * spectra[0]]
        else:
            cycles = ((1, 2), (2, 0), (0, 1))
            products = [hats[k] * spectra[j] - hats[j] * spectra[k] for j, k in cycles]
        return [scipy.fft.irfftn(p, padded, axes=axes, workers=threads)[inner] for p in products]

    return work


def row(shape: tuple[int, ...], dtype: str, kernel: str, order: int, threads: int) -> str:
    """One line of the table; the FFTs and the plain solve do not depend on the kernel."""
    grid = Grid(shape, 1 / 64)
    fields = 1 if len(shape) == 2 else 3
    lead = () if len(shape) == 2 else (3,)
    vorticity = np.random.default_rng(0).standard_normal((*lead, *shape)).astype(dtype)
    start = time.perf_counter()
    solver = VelocitySolver(grid, kernel=kernel, order=order, dtype=dtype, threads=threads)
    out = solver.velocity(vorticity)
    first = time.perf_counter() - start
    solve = milliseconds(lambda: solver.velocity(vorticity, out=out))
    size = "x".join(map(str, shape))
    text = f"{size:>16} {dtype:>5} {kernel + str(order):>7} {solve:9.1f}"
    if (kernel, order) == ("HEJ", 8):
        bare = milliseconds(bare_transforms(solver._convolver, fields, len(shape)))
        plain = milliseconds(plain_solve(grid, dtype, threads))
        pair = (np.empty_like(vorticity), out)
        both = milliseconds(lambda: solver.diffuse_and_velocity(vorticity, 1e-4, out=pair))
        text += f" {bare:7.1f} {solve / bare:6.2f} {plain:8.1f} {plain / solve:5.1f} {both:9.1f}"
    else:
        text += " " * 40
    return f"{text} {first:9.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description="time the velocity solve")
    parser.add_argument("--threads", type=int, default=thread_count(None))
    parser.add_argument("--big", action="store_true", help="also 2048^2 and 128^3")
    options = parser.parse_args()
    print(f"free space, {options.threads} threads, milliseconds")
    print(
        f"{'size':>16} {'dtype':>5} {'kernel':>7} {'velocity':>9} {'FFTs':>7} {'ratio':>6} "
        f"{'plain':>8} {'gain':>5} {'+diffuse':>9} {'first [s]':>9}"
    )
    for shape, dtype in SIZES + (BIG if options.big else []):
        for kernel, order in (("HEJ", 8), ("HEJ", 2), ("LGF", 2), ("HE", 2)):
            print(row(shape, dtype, kernel, order, options.threads), flush=True)


if __name__ == "__main__":
    main()
