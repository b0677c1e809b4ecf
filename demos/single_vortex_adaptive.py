"""A disk is drawn out into a spiral on particles of several spacings, and comes back: 10 s.

The wavelet particle level sets of Bergdorf & Koumoutsakos, Multiscale Model. Simul. 5 (2006) 980:
state a tolerance, and the particles are fine where the interface needs them, at a CFL of 40.
"""

import argparse
from pathlib import Path

import levelset
import pmesh
import remesh
from levelset.laws import SingleVortex
from pmesh.cases.adaptive_interface import COLOURS
from pmesh.cases.single_vortex import frame
from pmesh.cases.style import panels, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/single_vortex_adaptive"))
args = options.parse_args()

CELLS, LEVELS = (128, 2) if args.quick else (512, 4)  # per unit length on the finest level
PERIOD = 2.0 if args.quick else 8.0  # [T]
disk = levelset.shapes.Disk(0.15, center=(0.5, 0.75))  # [L]

grid = remesh.Grid((CELLS,) * 2, 1 / CELLS, boundary="periodic")
mesh = remesh.AdaptiveMesh(grid=grid, levels=LEVELS, tolerance=0.01, refinement=0.02)
flow = levelset.ParticleLevelSet(
    grid=mesh, velocity=SingleVortex(period=PERIOD), kernel="L6,4", width=5.0, substeps=4
)

states = [flow.start(disk)]
for part in (0.25, 0.5, 1.0):
    states.append(pmesh.run(flow, states[-1], until=part * PERIOD, dt=40 / 512))

for state in states:
    told = flow.ledger(state)
    area = told["volume"] / disk.volume - 1.0
    print(f"t = {state.time:g}: {state.size} active particles, area {100 * area:+.3f} %, ", end="")
    print(f"1/{told['compression']:.0f} of the finest mesh")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (3.0 * len(states), 3.2))
    for panel, state in zip(row, states, strict=True):
        for level in range(LEVELS + 1):
            x, y = state.positions[state.of(level)].T
            panel.scatter(x, y, s=9 / 4**level, color=COLOURS[level], marker="s", lw=0)
        field = flow.fields(state)["level_set"]
        panel.contour(*grid.axes(), field.T, levels=[0.0], colors=["black"], linewidths=0.6)
        frame(panel, f"$t$ = {state.time:g}: {state.size} active")
    figure.suptitle("Particles of several spacings follow a disk in a reversed vortex")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "levels.png", dpi=200)
