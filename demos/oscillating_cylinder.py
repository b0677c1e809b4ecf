"""A cylinder that oscillates in fluid at rest: its force beside Morison's formula: 60 s.

Repeats Dütsch, Durst, Becker & Lienhart, J. Fluid Mech. 360 (1998) 249, at Re = 100, KC = 5.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from pmesh.cases.wake import draw_vorticity

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and one period")
options.add_argument("--out", type=Path, default=Path("out/oscillating_cylinder_demo"))
args = options.parse_args()

REYNOLDS, KC = 100.0, 5.0  # U D / nu and U T / D; lengths in diameters, U is the largest speed
CELLS = 16 if args.quick else 24  # per diameter
PERIODS = 1 if args.quick else 3
RATE = 2 * math.pi / KC

grid = remesh.Grid((2 * CELLS,) * 2, 1 / CELLS, (-1.0, -1.0))  # it follows the vorticity
law = pmesh.Prescribed(
    shift=lambda t: (-math.sin(RATE * t) / RATE, 0.0),
    velocity=lambda t: (-math.cos(RATE * t), 0.0),
    scale=1 / RATE,
)
body = pmesh.RigidBody(levelset.shapes.Disk(radius=0.5), motion=law)
flow = pmesh.VortexFlow(
    grid=grid, viscosity=1 / REYNOLDS, bodies=[body], domain="follow", deformation=0.5
)
forces = pmesh.Forces()
end = pmesh.run(
    flow, flow.start(), until=PERIODS * KC, watch=[forces, pmesh.Progress()],
    out=args.out, overwrite=True,
)  # fmt: skip

series = {name: column[1:] for name, column in forces.series.items()}
dt, force = series["dt"], series["body0_force_x"]  # forces are means over a step
phase = RATE * (series["time"] - 0.5 * dt)
speed, gain = -np.cos(phase), RATE * np.sin(phase)
parts = np.stack([-0.5 * np.abs(speed) * speed, -0.25 * math.pi * gain])  # of Morison's formula
last = series["time"] > (PERIODS - 1) * KC + 1e-9
weighed = parts[:, last] * dt[last]
drag, added = np.linalg.solve(weighed @ parts[:, last].T, weighed @ force[last])
print(f"Cd = {drag:.2f}, Cm = {added:.2f}; published 2.09 and 1.45")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.0, 3.4), width_ratios=(1.2, 1.0))
    time = phase / (2 * math.pi)
    left.plot(time, 2 * force, color=OURS, label=f"ours, {CELLS} nodes per diameter")
    left.plot(time, 2 * np.array([2.09, 1.45]) @ parts, "--", color=REFERENCE,
              label="Morison's, published coefficients")  # fmt: skip
    left.set(title="Force coefficient", xlabel="$t / T$", ylim=(-5, 6), xlim=(0, PERIODS))
    left.legend()
    around = np.linspace(0, 2 * math.pi, 97)
    circle = 0.5 * np.stack([np.cos(around), np.sin(around)], axis=1) + end.poses[0].center
    draw_vorticity(right, end.vorticity, end.grid, 5, outlines=[circle])
    right.set(title=f"Vorticity after {PERIODS} periods", xlim=(-2.5, 2.5), ylim=(-1.8, 1.8))
    return figure


draw().savefig(args.out / "force.png", dpi=200)
