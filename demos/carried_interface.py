"""A drop of dye is wound up by a vortex that spreads; dashed where it goes exactly: 5 s.

The vortex of Lamb, Hydrodynamics, art. 334a; the dye is a level set on particles of its own.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from pmesh.vortex.exact import LambOseen

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/carried_interface"))
args = options.parse_args()

vortex = LambOseen(circulation=1.0, core=0.2, viscosity=1e-3)  # [L^2/T], [L], [L^2/T]
drop = levelset.shapes.Disk(radius=0.18, center=(0.3, 0.0))
CELLS = 40 if args.quick else 100  # of the dye, per unit length; the flow's mesh is twice as coarse
UNTIL = 0.75 if args.quick else 3.0  # [T]

half = round(1.5 * CELLS / 2)
grid = remesh.Grid((2 * half + 1,) * 2, 2 / CELLS, (-2 * half / CELLS,) * 2)
fine = remesh.Grid((round(1.4 * CELLS) + 1,) * 2, 1 / CELLS, (-0.7, -0.7))

flow = pmesh.VortexFlow(grid=grid, viscosity=vortex.viscosity)
dye = pmesh.Carrier(flow=flow, grid=fine, options={"remeshing": "distorted"})
states = [dye.start(drop, vorticity=vortex.vorticity)]
for time in np.linspace(0, UNTIL, 4)[1:]:
    states.append(pmesh.run(dye, states[-1], until=time, dt=0.05))


def exact(time, count=2000):
    """The drop's outline: each point turns about the vortex on its circle."""
    around = np.linspace(0, 2 * math.pi, count)
    x, y = 0.3 + 0.18 * np.cos(around), 0.18 * np.sin(around)
    square, turn = x * x + y * y, np.zeros(count)
    for t in (np.arange(200) + 0.5) / 200 * time:
        turn -= np.expm1(-square / vortex.radius(t) ** 2) / square * time / 200 / (2 * math.pi)
    return np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y])


area = dye.ledger(states[-1])["interface_volume"]
off = np.abs(dye.level_set.shape(states[-1].interface).distance(exact(UNTIL))).max() * CELLS
print(f"area: {100 * (area / drop.area - 1):+.3f} %; outline off the exact one by {off:.3f} cells")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (11.0, 3.2), sharey=True)
    for panel, state in zip(row, states, strict=True):
        fields = dye.fields(state)
        x, y = fine.axes()
        panel.contourf(x, y, fields["vorticity"].T, levels=24, cmap="Greys", vmax=12.0)
        panel.contourf(x, y, fields["level_set"].T, levels=[-1.0, 0.0], colors=[OURS], alpha=0.75)
        panel.plot(*exact(state.time), color=REFERENCE, lw=0.9, ls="--")
        panel.set(title=f"$t$ = {state.time:g}", aspect="equal", xlim=(-0.7, 0.7), ylim=(-0.7, 0.7))
        panel.grid(False)
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "dye.png", dpi=200)
