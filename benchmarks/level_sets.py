"""What level sets on particles cost: particle-steps per second, its parts, its growth, its gain.

Steps of a disk in the single vortex and of a ball in the deformation field, remeshed at each one:
rates with M4' and L6,4, RK2 and RK4; nanoseconds per particle of the parts of a step; the exponent
of the time per step over the number of nodes along a side (the interface's is ndim - 1); the same
step with particles on all nodes of the mesh. Medians. Half a minute; ``--quick`` ten seconds.
``--courant`` instead tells the error of the single vortex at grid CFL 1, 5, 20 and 40 (minutes).
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import numpy as np

from levelset.interface import Interface
from levelset.laws import Deformation, SingleVortex
from levelset.lookup import Lattice, around, places
from levelset.profile import LEVEL
from levelset.shapes import Disk, Sphere
from levelset.transport import ParticleLevelSet
from pmesh.cases.deformation import interface_error
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.paths import get_scheme, travel

LAWS = {2: SingleVortex(), 3: Deformation()}
SHAPES = {2: Disk(0.15, center=(0.5, 0.75)), 3: Sphere(0.15, center=(0.35, 0.35, 0.35))}
COURANT = 2.0  # of the steps that are timed


def seconds(law: Callable[[], object], repeats: int) -> float:
    law()
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        law()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


def flow_on(ndim: int, nodes: int, threads: int, **options: object) -> ParticleLevelSet:
    grid = Grid((nodes + 1,) * ndim, 1.0 / nodes)
    return ParticleLevelSet(grid=grid, velocity=LAWS[ndim], threads=threads, **options)


def pace(flow: ParticleLevelSet) -> float:
    return COURANT * flow.grid.spacing / LAWS[flow.grid.ndim].max_speed(0.0)


def drawn_out(flow: ParticleLevelSet, steps: int) -> Interface:
    """The interface a few steps after the start."""
    state = flow.start(SHAPES[flow.grid.ndim])
    for _ in range(steps):
        state = flow.step(state, pace(flow))
    return state


def rates(sizes: dict[int, int], threads: int, repeats: int) -> None:
    print(f"rates with {threads} threads, remeshing at each step")
    for ndim, nodes in sizes.items():
        for kernel in ("M4'", "L6,4"):
            for scheme in ("RK2", "RK4"):
                flow = flow_on(ndim, nodes, threads, kernel=kernel, time_scheme=scheme)
                state, dt = drawn_out(flow, 5), pace(flow)
                taken = seconds(lambda f=flow, s=state, dt=dt: f.step(s, dt), repeats)
                print(
                    f"  {ndim}-D {nodes:4d} {kernel:>5} {scheme}: {state.size:7d} particles, "
                    f"{1e3 * taken:7.2f} ms, {state.size / taken / 1e6:5.2f} million per second"
                )


def parts(sizes: dict[int, int], threads: int, repeats: int) -> None:
    print("parts of a step [ns per particle]")
    for ndim, nodes in sizes.items():
        for kernel in ("M4'", "L6,4"):
            flow = flow_on(ndim, nodes, threads, kernel=kernel, time_scheme="RK2")
            state, dt = drawn_out(flow, 5), pace(flow)
            scheme, half = get_scheme("RK2"), get_kernel(kernel).half_width
            at = travel(state.positions, flow.velocity, state.time, dt, scheme)
            grid, level = flow.grid, LEVEL * flow.reach
            lattice = Lattice(grid, state.nodes, at, state.values, threads)
            found = lattice.look_up(kernel, level)
            laws: dict[str, Callable[[], object]] = {
                "move": lambda s=state, dt=dt, f=flow, c=scheme: travel(
                    s.positions, f.velocity, s.time, dt, c
                ),
                "lay out": lambda s=state, g=grid, x=at: Lattice(g, s.nodes, x, s.values, threads),
                "look up": lambda la=lattice, k=kernel, v=level: la.look_up(k, v),
                "band": lambda f=found, g=grid, r=flow.reach, h=half: around(
                    f.nodes, f.field.copy(), f.marks.copy(), g, r, h
                ),
                "places": lambda g=grid, s=state: places(g, s.nodes),
            }
            told = ", ".join(
                f"{name} {1e9 * seconds(law, repeats) / state.size:.0f}"
                for name, law in laws.items()
            )
            print(f"  {ndim}-D {nodes:4d} {kernel:>5}: {told}")


def growth(sizes: dict[int, tuple[int, ...]], threads: int, repeats: int) -> None:
    print("growth with the nodes along a side")
    for ndim, counts in sizes.items():
        taken, particles = [], []
        for nodes in counts:
            flow = flow_on(ndim, nodes, threads, kernel="M4'", time_scheme="RK2")
            state, dt = drawn_out(flow, 2), pace(flow)
            taken.append(seconds(lambda f=flow, s=state, dt=dt: f.step(s, dt), repeats))
            particles.append(state.size)
        slope = np.polyfit(np.log(counts), np.log(taken), 1)[0]
        number = np.polyfit(np.log(counts), np.log(particles), 1)[0]
        times = ", ".join(f"{n}: {1e3 * t:.2f} ms" for n, t in zip(counts, taken, strict=True))
        print(f"  {ndim}-D {times}: exponent {slope:.2f}, of the particles {number:.2f}")


def against_all_nodes(sizes: dict[int, int], threads: int, repeats: int) -> None:
    print("the same step with particles on all nodes")
    for ndim, nodes in sizes.items():
        flow = flow_on(ndim, nodes, threads, kernel="M4'", time_scheme="RK2")
        state, dt = drawn_out(flow, 1), pace(flow)
        full = Grid((nodes,) * ndim, 1.0 / nodes, boundary="periodic")
        every = np.arange(full.size)
        at = places(full, every)
        values = np.sin(2 * np.pi * at).prod(axis=1)

        def step(g=full, n=every, x=at, v=values, f=flow, dt=dt) -> object:
            moved = travel(x, f.velocity, 0.0, dt, get_scheme("RK2"))
            return Lattice(g, n, moved, v, threads).look_up("M4'", 10.0)

        band = seconds(lambda f=flow, s=state, dt=dt: f.step(s, dt), repeats)
        whole = seconds(step, max(repeats // 3, 1))
        print(
            f"  {ndim}-D {nodes:4d}: band {1e3 * band:.2f} ms ({state.size} particles), all nodes "
            f"{1e3 * whole:.1f} ms ({full.size}): {whole / band:.0f} times as long"
        )


def courant(nodes: int, band: float, threads: int) -> None:
    """Error of the single vortex after its period of 8, from small to large steps."""
    print(f"single vortex, {nodes} cells, band {band:g}, L6,4, T = 8")
    for number in (1.0, 5.0, 20.0, 40.0):
        for substeps in (1, 2, 4):
            dt = number / nodes
            if dt * 2 * math.pi / substeps > 1.0 or (number <= 5.0 and substeps > 1):
                continue
            flow = flow_on(
                2, nodes, threads, kernel="L6,4", width=band * nodes, substeps=substeps
            )  # fmt: skip
            state = flow.start(SHAPES[2])
            count = round(8.0 / dt)
            start = time.perf_counter()
            for k in range(count):
                state = flow.step(state, 8.0 * (k + 1) / count - state.time)
            area = flow.ledger(state)["volume"] / SHAPES[2].volume - 1.0
            error = interface_error(flow.fields(state)["level_set"], flow.grid, SHAPES[2])
            print(
                f"  CFL {number:4g}, dt max|grad u| = {dt * 2 * math.pi:.2f}, {substeps} RK4: area "
                f"{100 * area:+.3f} %, L1 error {error:.2e} = {error * nodes:.3f} h, "
                f"{time.perf_counter() - start:.0f} s",
                flush=True,
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="small meshes")
    parser.add_argument("--courant", type=int, metavar="CELLS", help="errors over the step instead")
    parser.add_argument("--band", type=float, default=0.1875, help="its half width for --courant")
    options = parser.parse_args()
    if options.courant:
        courant(options.courant, options.band, options.threads)
        return
    repeats = 5 if options.quick else 15
    sizes = {2: 512, 3: 64} if options.quick else {2: 1024, 3: 128}
    rates(sizes, options.threads, repeats)
    parts(sizes, options.threads, repeats)
    small = {2: (128, 256, 512), 3: (48, 64, 96)}
    large = {2: (128, 256, 512, 1024), 3: (48, 64, 96, 128, 192)}
    growth(small if options.quick else large, options.threads, repeats)
    against_all_nodes({2: 256, 3: 64}, options.threads, repeats)


if __name__ == "__main__":
    main()
