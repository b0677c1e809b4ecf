"""A vortex draws a disk out into a spiral, turns round, and brings it back: 15 s.

The test of Bell, Colella & Glaz (1989), reversed as by LeVeque (1996): the area must stay, and the
disk that is back must be the one that left.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from levelset.laws import SingleVortex
from pmesh.cases.deformation import interface_error, refined, traced
from pmesh.cases.style import OURS, REFERENCE, panels, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/single_vortex"))
args = options.parse_args()

CELLS = 48 if args.quick else 128  # per unit length
PERIOD = 2.0 if args.quick else 8.0  # [T]
disk = levelset.shapes.Disk(0.15, center=(0.5, 0.75))  # [L]
vortex = SingleVortex(period=PERIOD)

grid = remesh.Grid((CELLS + 1,) * 2, 1 / CELLS)
flow = levelset.ParticleLevelSet(grid=grid, velocity=vortex, kernel="L6,4", width=0.1875 * CELLS)

states = [flow.start(disk)]
for part in (0.125, 0.25, 0.5, 1.0):
    states.append(pmesh.run(flow, states[-1], until=part * PERIOD, dt=2.0 / CELLS))

for state in states:
    area = flow.ledger(state)["volume"] / disk.volume - 1.0
    print(f"t = {state.time:g}: {state.size} particles, area {100 * area:+.3f} %")
error = interface_error(flow.fields(states[-1])["level_set"], grid, disk)
print(f"interface back within {error * CELLS:.2f} cells on average")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (2.3 * len(states), 2.6))
    angle = np.linspace(0.0, 2.0 * math.pi, 8000)
    circle = disk.center + disk.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for panel, state in zip(row, states, strict=True):
        field, finer = refined(flow.fields(state)["level_set"], grid, 4)
        panel.contourf(*finer.axes(), field.T, levels=[-1e3, 0.0], colors=[OURS])
        panel.plot(*traced(circle, vortex, 0.0, state.time).T, color=REFERENCE, lw=0.6)
        panel.set(title=f"$t$ = {state.time:g}", xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[])
        panel.set_aspect("equal")
    figure.suptitle("A disk in a reversed vortex; line: exact")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "spiral.png", dpi=200)
