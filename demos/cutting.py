"""A lathe turns a baluster out of a bar of particles that spins under the tool: 1 min.

The bar is never remeshed. Virtual cutting as Hieber & Koumoutsakos showed it on a liver (the case
`cutting`); what is removed is beside Pappus' rule for bodies of revolution.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.style import panels, styled
from pmesh.cases.surfaces import COPPER, Layer, render, show_surface

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and half of the cut")
options.add_argument("--out", type=Path, default=Path("out/cutting"))
args = options.parse_args()

CELLS = 24 if args.quick else 56  # per unit length
STEPS = 8 if args.quick else 24  # per turn; any number gives the same cut
DEPTH = 0.42  # from the axis to the middle of the tool in the end [L]
UNTIL = 1.0 if args.quick else 2.1  # turns: one to plunge, one to go round

bar = levelset.shapes.Capsule((0.0, 0.0, -0.5), (0.0, 0.0, 0.5), 0.3)
balls = ((0.24, -0.30), (0.17, 0.11), (0.17, 0.45), (0.22, 0.78))  # radius and height [L]
form = levelset.shapes.Sphere(balls[0][0], center=(0.0, 0.0, balls[0][1]))
for radius, height in balls[1:]:
    form = form | levelset.shapes.Sphere(radius, center=(0.0, 0.0, height))
tool = levelset.Tool(shape=form, shift=lambda t: (DEPTH + 0.25 * max(1 - t, 0) ** 2, 0.0, 0.0))

grid = remesh.Grid((CELLS, CELLS, 2 * CELLS), 1 / CELLS, (-0.5 + 0.5 / CELLS,) * 2 + (-1.0,))
spin = levelset.laws.Rotation(center=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 2 * math.pi))
lathe = levelset.ParticleLevelSet(grid=grid, velocity=spin, remeshing="never")
turning = levelset.Cutting(carrier=lathe, tools=tool, largest_step=1 / STEPS)

states = [turning.start(bar)]
for time in (0.5, 0.8, UNTIL):
    states.append(pmesh.run(turning, states[-1], until=time, watch=[pmesh.Progress()]))
removed = states[-1].removed
around, up = np.meshgrid(
    (np.arange(800) + 0.5) / 2000, np.arange(-2000, 2000) / 2000, indexing="ij"
)
plane = np.stack([around, 0 * around, up])  # one half plane through the axis
deep = bar.distance(plane) < 0
deep &= form.distance(plane - np.reshape((tool.pose(UNTIL)[0]), (3, 1, 1))) < 0
exact = 2 * math.pi * np.sum(around[deep]) / 2000**2
print(f"removed: {removed:.5f}, a whole turn of the tool: {exact:.5f}, "
      f"{100 * (removed / exact - 1):+.2f} % (the turn is whole from t = 2 on)")  # fmt: skip


@styled
def draw():
    figure, (row,) = panels(1, len(states), (9.0, 4.2))
    bounds = ((-0.3, -0.3, -0.8), (0.92, 0.3, 0.95))
    for panel, state in zip(row, states, strict=True):
        layers = [Layer(surface=(turning.fields(state)["level_set"], grid), colour=COPPER)]
        room = remesh.Grid((90, 90, 150), 0.012, (tool.pose(state.time)[0][0] - 0.5, -0.5, -0.7))
        ball = tool.at(state.time).distance(room.points())
        layers.append(Layer(surface=(ball, room), colour="#9aa4ae"))
        picture = render(*layers, bounds=bounds, view=(-75.0, 16.0), size=(560, 900))
        show_surface(panel, picture, title=f"{state.time:g} turns")
    figure.suptitle(f"A bar of {states[1].size / 1000:.0f} thousand particles on the lathe")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "lathe.png", dpi=200)
