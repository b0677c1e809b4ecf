"""A ball is drawn out into a sheet on particles of three spacings, and comes back: 40 s.

The deformation test of Enright et al., J. Comput. Phys. 183 (2002) 83, with the particles of
Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5 (2006) 980: the volume must stay.
"""

import argparse
from pathlib import Path

import levelset
import pmesh
import remesh
from levelset.laws import Deformation
from pmesh.cases.enright import BOX, VIEW
from pmesh.cases.style import panels, styled
from pmesh.cases.surfaces import COPPER, Layer, render, show_surface

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/enright_adaptive"))
args = options.parse_args()

CELLS = 64 if args.quick else 128  # per unit length on the finest level
PERIOD = 1.0 if args.quick else 3.0  # [T]
ball = levelset.shapes.Sphere(0.15, center=(0.35, 0.35, 0.35))  # [L]

grid = remesh.Grid((CELLS,) * 3, 1 / CELLS, boundary="periodic")
mesh = remesh.AdaptiveMesh(grid=grid, levels=2, tolerance=5e-3, block=8)
flow = levelset.ParticleLevelSet(
    grid=mesh, velocity=Deformation(period=PERIOD), kernel="L6,4", width=5.0, substeps=2
)

states = [flow.start(ball)]
for part in (0.25, 0.5, 1.0):
    states.append(pmesh.run(flow, states[-1], until=part * PERIOD, dt=1 / 16))

for state in states:
    told = flow.ledger(state)
    volume = told["volume"] / ball.volume - 1.0
    print(f"t = {state.time:g}: {state.size} active, volume {100 * volume:+.2f} %, ", end="")
    print(f"1/{told['compression']:.0f} of the finest mesh")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (3.2 * len(states), 3.3))
    for panel, state in zip(row, states, strict=True):
        layer = Layer(surface=(flow.to_uniform(state), grid), colour=COPPER)
        picture = render(layer, bounds=BOX, view=VIEW, size=(900, 800))
        title = f"$t$ = {state.time:g}: {state.size} active"
        show_surface(panel, picture, title=title)
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "sheet.png", dpi=200)
