"""Order of the drag in the spacing: a started cylinder, each way of holding it, three spacings.

    python benchmarks/drag_order.py [--reynolds 40] [--until 2] [--nodes 24 48 96] [--dt 0.005]
        [--hold NAME ...]

Prints the mean drag coefficient over the last tenth of the run with the cylinder's centre in a
cell's middle and on a node, the order that three spacings tell, the slip and the iterations. The
time step is the same for all: the order is that in space.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

import pmesh
from levelset.shapes import Disk
from pmesh.bodies.forcing import DirectForcing
from pmesh.bodies.penalise import Penalisation
from remesh.grid import Grid

WAYS = {
    "penalisation": Penalisation(),
    "sharp": Penalisation(sharp=True, width=2.5, strength=1e4),
    "forcing": DirectForcing(),
}


def drag(
    way: str, reynolds: float, nodes: int, until: float, dt: float, place: float
) -> dict[str, float]:
    """Mean drag coefficient, slip and iterations; lengths in radii; ``place`` of the centre [h]."""
    h = 2 / nodes
    cells = 8 * math.ceil(1.4 / h / 8)
    grid = Grid((2 * cells,) * 2, h, ((0.5 - cells) * h,) * 2)
    body = pmesh.RigidBody(Disk(radius=1.0, center=(place * h, place * h)))
    flow = pmesh.VortexFlow(
        grid=grid, viscosity=2 / reynolds, freestream=(1.0, 0.0), bodies=(body,),
        domain="follow", penalisation=WAYS[way],
    )  # fmt: skip
    forces, began = pmesh.Forces(), time.process_time()
    pmesh.run(flow, flow.start(), until=until, dt=dt, watch=[forces])
    series = forces.series
    late = np.flatnonzero(series["time"] > 0.9 * until)
    weights = series["dt"][late]
    return {
        "drag": float(np.average(series["body0_force_x"][late], weights=weights)),
        "slip": float(series["slip"][late].max()),
        "iterations": float(np.mean(series["slip_iterations"][late])),
        "seconds": time.process_time() - began,
    }


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description="order of the drag in the spacing")
    parser.add_argument("--reynolds", type=float, default=40.0)
    parser.add_argument("--until", type=float, default=2.0, help="T = U t / R")
    parser.add_argument("--dt", type=float, default=0.005, help="R / U")
    parser.add_argument("--nodes", type=int, nargs="+", default=[24, 48, 96])
    parser.add_argument("--hold", nargs="+", choices=list(WAYS), default=list(WAYS))
    options = parser.parse_args()
    for way in options.hold:
        values = []
        for nodes in options.nodes:
            cell = drag(way, options.reynolds, nodes, options.until, options.dt, 0.0)
            node = drag(way, options.reynolds, nodes, options.until, options.dt, 0.5)
            values.append(0.5 * (cell["drag"] + node["drag"]))
            print(
                f"{way:13} {nodes:4} nodes  drag {cell['drag']:.5f} {node['drag']:.5f}  "
                f"slip {cell['slip']:.1e}  {cell['iterations']:.1f} iterations  "
                f"{cell['seconds']:.0f} s",
                flush=True,
            )
        if len(values) >= 3:
            a, b, c = values[-3:]
            first, last = options.nodes[-3], options.nodes[-1]
            order = math.log(abs((a - b) / (b - c))) / math.log(math.sqrt(last / first))
            print(f"{way:13} order {order:.2f}, from the means over both places", flush=True)


if __name__ == "__main__":
    main()
