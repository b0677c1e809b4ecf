"""A vortex core spreads as a^2 = a0^2 + 4 nu t while it turns; dots ours, lines exact: 10 s.

Repeats the vortex of Lamb, Hydrodynamics, art. 334a.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from pmesh.vortex.exact import LambOseen

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/lamb_oseen"))
args = options.parse_args()

exact = LambOseen(circulation=1.0, core=0.2, viscosity=1e-3)  # [L^2/T], [L], [L^2/T]
CELLS = 6 if args.quick else 12  # per core
UNTIL = 2.0 if args.quick else 10.0  # [T]; by t = 10 the core's area has doubled

h = exact.core / CELLS
half = round(6 * exact.radius(UNTIL) / h)  # six cores either way: vorticity 1e-16 at the edge
grid = remesh.Grid(shape=(2 * half + 1,) * 2, spacing=h, origin=(-half * h,) * 2)
flow = pmesh.VortexFlow(grid=grid, viscosity=exact.viscosity)

states = [flow.start(vorticity=exact.vorticity)]
for time in np.linspace(0, UNTIL, 5)[1:]:  # a state is a value: keep as many as you like
    states.append(pmesh.run(flow, states[-1], until=time))


def core(state):
    square = np.sum(state.grid.points() ** 2, axis=0)
    return np.sqrt(np.sum(state.vorticity * square) / np.sum(state.vorticity))


ours, law = core(states[-1]), exact.radius(UNTIL)
print(f"core at t = {UNTIL:g}: ours {ours:.6f}, exact {law:.6f}, {100 * (ours / law - 1):+.4f} %")


@styled
def draw():
    figure, ((panel,),) = panels(1, 1, (5.0, 3.6))
    radius = np.linspace(0, 3 * law, 300)
    for i, state in enumerate(states):
        x, y = state.grid.axes()
        middle = np.abs(y).argmin()
        seen = (x > -1e-9) & (x < radius[-1])
        line = exact.vorticity(np.stack([radius, 0 * radius]), state.time)
        panel.plot(radius, line, color=REFERENCE, lw=1, label=None if i else "exact")
        panel.plot(x[seen], state.vorticity[seen, middle], "o", color=OURS, ms=3, mew=0,
                   alpha=0.3 + 0.7 * i / len(states), label=f"$t$ = {state.time:g}")  # fmt: skip
    panel.set(title="Lamb-Oseen vortex: vorticity", xlabel="$r$", xlim=(0, radius[-1]))
    panel.legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "profiles.png", dpi=200)
