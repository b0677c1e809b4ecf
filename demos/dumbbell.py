"""A dumbbell shrinks by its mean curvature, parts in the middle, and two drops vanish: 20 s.

Lit pictures of four stages; volume beside that of the same surface followed as a curve.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from levelset.curvature_flow import CurvatureFlow
from levelset.shapes import Dumbbell
from pmesh.cases.dumbbell import DumbbellCase
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from pmesh.cases.surfaces import render, show_surface

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/dumbbell"))
args = options.parse_args()

CELLS = 24 if args.quick else 48  # per unit length; the bar's radius is a tenth of one
TIMES = (0.003, 0.0065) if args.quick else (0.003, 0.0056, 0.014)  # [L^2]
shape = Dumbbell(0.3, separation=1.0, bar=0.1, fillet=0.05)  # [L]

half = [CELLS, CELLS // 2, CELLS // 2]
grid = remesh.Grid([2 * n + 1 for n in half], 1 / CELLS, [-n / CELLS for n in half])
flow = CurvatureFlow(grid=grid)  # steps of ten times the explicit limit

states = [flow.start(shape)]
for time in TIMES:
    states.append(pmesh.run(flow, states[-1], until=time))

known = DumbbellCase(radius=0.3, separation=1.0, bar=0.1, fillet=0.05).reference()
for state in states:
    ours, law = flow.ledger(state)["volume"], np.interp(state.time, *known.volume)
    print(f"t = {state.time:g}: volume {ours:.5f}, followed as a curve {law:.5f}")
gone = "after" if states[-1].phi[tuple(half)] > 0 else "before"
print(f"at t = {states[-1].time:g} the middle is empty {gone} the pinch at {known.pinch:.5f}")


@styled
def draw():
    figure, (row,) = panels(1, len(states) + 1, (3.1 * len(states) + 3, 2.6))
    for panel, state in zip(row, states, strict=False):
        picture = render((state.phi, grid), bounds=shape.bounds(), view=(-68, 18), size=(800, 500))
        show_surface(panel, picture, title=f"$t$ = {state.time:g}")
    row[-1].plot(*known.volume, color=REFERENCE, label="followed as a curve")
    volumes = [flow.ledger(state)["volume"] for state in states]
    row[-1].plot([state.time for state in states], volumes, "o", color=OURS, label="level set")
    row[-1].set(title="volume", xlabel="$t$", ylim=(0, None))
    row[-1].legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "dumbbell.png", dpi=200)
