"""Hill's spherical vortex travels without changing its shape; speed beside the exact one: 1 min.

M. J. M. Hill, Phil. Trans. R. Soc. A 185 (1894) 213: the only ring that is a sphere.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.hill import silhouette
from pmesh.cases.style import REFERENCE, panels, styled
from pmesh.vortex.exact import HillVortex

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/hill"))
args = options.parse_args()

CELLS = 8 if args.quick else 16  # per radius
UNTIL = 0.1 if args.quick else 1.0  # [a/U]

narrow, wide = HillVortex(width=1.5 / CELLS), HillVortex(width=1.5 * 2**0.5 / CELLS)
half = CELLS + 16
grid = remesh.Grid((2 * half,) * 3, 1 / CELLS, (-half / CELLS,) * 3)
flow = pmesh.VortexFlow(grid=grid, domain="follow", projection=1)


def vorticity(points):  # the jump at its edge is smoothed, so that second moments stay
    return 2.0 * narrow.vorticity(points) - wide.vorticity(points)


states = [flow.start(vorticity=vorticity)]
states.append(pmesh.run(flow, states[0], until=UNTIL))

first, last = (silhouette(state.vorticity, state.grid, level=3.75) for state in states)
print(f"speed {(last['place'] - first['place']) / UNTIL:.4f} (exact 1), "
      f"across/along {last['across'] / last['along']:.4f} (exact 1)")  # fmt: skip


@styled
def draw():
    figure, (row,) = panels(1, 2, (7.4, 3.6))
    turn = np.linspace(0, 2 * np.pi, 200)
    for panel, state in zip(row, states, strict=True):
        x, y, z = state.grid.axes()
        across = state.vorticity[1][:, abs(y).argmin()]
        panel.imshow(across.T, origin="lower", extent=(x[0], x[-1], z[0], z[-1]), cmap="RdBu_r",
                     vmin=-7.5, vmax=7.5)  # fmt: skip
        panel.plot(np.cos(turn), state.time + np.sin(turn), "--", color=REFERENCE, label="exact")
        panel.set(xlim=(-1.4, 1.4), ylim=(-1.4, UNTIL + 1.4), aspect="equal")
        panel.set(title=rf"$\omega_y$ at $y$ = 0, $t$ = {state.time:g}", xlabel="$x/a$")
        panel.grid(False)
    row[0].legend(loc="upper right")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "hill.png", dpi=200)
