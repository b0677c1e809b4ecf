"""A coil shortens at its curvature, turns convex, round, and vanishes, on an adaptive mesh: 20 s.

Grayson, J. Differential Geom. 26 (1987) 285: every simple closed curve does. All lose the area 2 pi
per unit time; the particles are fine where the coil is thin and bent.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import levelset
import pmesh
import remesh
from levelset.polygon import Polygon
from pmesh.cases.adaptive_interface import COLOURS
from pmesh.cases.style import OURS, REFERENCE, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/curve_shortening"))
args = options.parse_args()

CELLS, LEVELS = (128, 2) if args.quick else (256, 3)  # per unit length on the finest level
THICK = 0.045  # of the coil [L]
TIMES = (0.001, 0.002) if args.quick else (0.004, 0.01, 0.018)  # [L^2]

turn = np.linspace(0.0, 5.0 * np.pi, 400)
radius = 0.08 + 0.3 * turn / turn[-1]
rims = [(radius + side * THICK / 2) * np.exp(1j * turn) for side in (1, -1)]
outline = np.concatenate([rims[0], rims[1][::-1]])
coil = Polygon(tuple(zip(outline.real.tolist(), outline.imag.tolist(), strict=True)))

grid = remesh.Grid((CELLS,) * 2, 1 / CELLS, (-0.5, -0.5))
mesh = remesh.AdaptiveMesh(grid=grid, levels=LEVELS, tolerance=5e-3, block=8)
flow = levelset.CurvatureFlow(grid=mesh)

states, ledger = [flow.start(coil)], pmesh.Ledger()
for time in TIMES:
    states.append(pmesh.run(flow, states[-1], until=time, watch=[ledger]))

for state in states:
    area = flow.ledger(state)["volume"] + 2.0 * np.pi * state.time
    print(f"t = {state.time:g}: {state.size} active particles, ", end="")
    print(f"area and what it must have lost {area:.5f} of {coil.volume:.5f}")


@styled
def draw():
    figure = Figure(figsize=(9.4, 6.0), layout="constrained")
    axes = figure.subplot_mosaic("abe;cde", width_ratios=(1.0, 1.0, 0.85))
    for panel in axes.values():
        panel.set_axis_off()
    for name, state in zip("abcd", states, strict=False):
        panel = axes[name]
        for level, band in enumerate(flow.pyramid(state).bands):
            x, y = grid.origin[0] + band.grid.spacing * np.array(
                np.unravel_index(band.nodes, band.grid.shape)
            )
            panel.scatter(x, y, s=16 / 4**level, color=COLOURS[level], marker="s", lw=0)
        field = flow.fields(state)["phi"]
        panel.contour(*grid.axes(), field.T, levels=[0.0], colors=["black"], linewidths=0.9)
        panel.set(title=f"$t$ = {state.time:g}: {state.size} active", aspect="equal")
    time, area = ledger.series["time"], ledger.series["volume"]
    last = axes["e"]
    last.set_axis_on()
    last.plot(time, coil.volume - 2.0 * np.pi * time, color=REFERENCE, label=r"$A_0 - 2 \pi t$")
    last.plot(time[::12], area[::12], "o", color=OURS, label="level set")
    last.set(title="area", xlabel="$t$", ylim=(0, None))
    last.legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "curve_shortening.png", dpi=200)
