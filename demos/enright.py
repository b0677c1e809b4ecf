"""A ball is drawn out into a sheet two cells thin, and back, without tearing: 60 s.

The deformation test of Enright et al., J. Comput. Phys. 183 (2002) 83: the volume must stay, and
the sheet must stay whole.
"""

import argparse
from pathlib import Path

import levelset
import pmesh
import remesh
from levelset.laws import Deformation
from pmesh.cases.deformation import refined, topology
from pmesh.cases.enright import BOX, VIEW
from pmesh.cases.style import panels, styled
from pmesh.cases.surfaces import COPPER, Layer, render, show_surface

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/enright"))
args = options.parse_args()

CELLS = 32 if args.quick else 100  # per unit length
PERIOD = 1.0 if args.quick else 3.0  # [T]
ball = levelset.shapes.Sphere(0.15, center=(0.35, 0.35, 0.35))  # [L]

grid = remesh.Grid((CELLS + 1,) * 3, 1 / CELLS)
flow = levelset.ParticleLevelSet(
    grid=grid, velocity=Deformation(period=PERIOD), kernel="L6,4", width=8.0
)

states = [flow.start(ball)]
for part in (0.25, 0.5, 1.0):
    states.append(pmesh.run(flow, states[-1], until=part * PERIOD, dt=2.0 / CELLS))

for state in states:
    volume = flow.ledger(state)["volume"] / ball.volume - 1.0
    pieces, holes = topology(flow.fields(state)["level_set"], grid)
    print(f"t = {state.time:g}: {state.size} particles, volume {100 * volume:+.2f} %, ", end="")
    print(f"pieces {pieces} of 1, holes {holes} of 0")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (3.2 * len(states), 3.3))
    for panel, state in zip(row, states, strict=True):
        surface = refined(flow.fields(state)["level_set"], grid, 2)
        layer = Layer(surface=surface, colour=COPPER)
        picture = render(layer, bounds=BOX, view=VIEW, size=(900, 800))
        show_surface(panel, picture, title=f"$t$ = {state.time:g}")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "sheet.png", dpi=200)
