"""An elliptical vortex throws off filaments and turns round, keeping its moments: 15 s.

Repeats the inviscid axisymmetrisation of Koumoutsakos (1997).
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import panels, show_field, styled
from pmesh.vortex.exact import EllipticVortex

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/elliptic_vortex"))
args = options.parse_args()

CELLS = 32 if args.quick else 80  # per unit length
TIMES = (0.5, 1.0) if args.quick else (1.0, 2.0, 4.0)  # [T]

exact = EllipticVortex(kind="I")  # half axes 0.4 and 0.8 [L], vorticity 20 [1/T] at the centre
half = round(1.4 * CELLS)
grid = remesh.Grid((2 * half + 1,) * 2, spacing=1 / CELLS, origin=(-half / CELLS,) * 2)
flow = pmesh.VortexFlow(grid=grid, viscosity=0.0)

states = [flow.start(vorticity=exact.vorticity)]
for time in TIMES:
    states.append(pmesh.run(flow, states[-1], until=time))

for name, law, known in (
    ("circulation", lambda points: 1.0, exact.circulation),
    ("angular moment", lambda points: np.sum(points**2, axis=0), exact.angular_moment),
):
    first, last = (
        np.sum(s.vorticity * law(s.grid.points())) * s.grid.cell_volume
        for s in (states[0], states[-1])
    )
    print(f"{name}: {last:.7f}, exact {known:.7f}, drift {last / first - 1:+.1e}")


@styled
def draw():
    figure, (row,) = panels(1, len(states), (2.7 * len(states), 3.0))
    for panel, state in zip(row, states, strict=True):
        show_field(panel, state.vorticity, state.grid, limit=20, colours="BuPu", power=0.6)
        panel.set(title=f"$t$ = {state.time:g}", xlim=(-1, 1), ylim=(-1, 1), xticks=[], yticks=[])
    figure.suptitle("Vorticity of an inviscid elliptical vortex")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "vorticity.png", dpi=200)
