"""An elliptical vortex throws off filaments on a mesh that is fine where they are: 15 s.

The inviscid axisymmetrisation of Koumoutsakos (1997): state a tolerance, pay for the active nodes.
"""

import argparse
from pathlib import Path

import pmesh
import remesh
from pmesh.cases.mesh_picture import show_mesh, show_values
from pmesh.cases.style import panels, styled
from pmesh.vortex.exact import EllipticVortex

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/elliptic_vortex_adaptive"))
args = options.parse_args()

NODES, LEVELS = (256, 3) if args.quick else (512, 4)  # along an axis of the finest mesh, halvings
SIDE = 3.2  # of the box [L], in which the vortex has half axes of 0.4 and 0.8
TOLERANCE = 1e-3  # relative to the largest vorticity, 20 [1/T]
TIMES = (0.25, 0.5) if args.quick else (0.75, 1.5, 3.0)  # [T]

grid = remesh.Grid((NODES,) * 2, SIDE / NODES, origin=(-SIDE / 2,) * 2)
mesh = remesh.AdaptiveMesh(grid=grid, levels=LEVELS, tolerance=TOLERANCE)
flow = pmesh.VortexFlow(grid=mesh, kernel="L6,4")

exact = EllipticVortex(kind="I")
states = [flow.start(vorticity=exact.vorticity)]
for time in TIMES:
    states.append(pmesh.run(flow, states[-1], until=time))

for state in states:
    told = flow.ledger(state)
    print(
        f"t = {state.time:g}: {state.size} active nodes, 1/{told['compression']:.0f} of all", end=""
    )
    for name in ("circulation", "angular_moment"):
        print(f", {name} off by {told[name] / getattr(exact, name) - 1:+.0e}", end="")
    print()


@styled
def draw():
    figure, (row,) = panels(1, len(states), (2.9 * len(states), 3.2))
    for panel, state in zip(row, states, strict=True):
        show_values(panel, state.vorticity, state.blocks, limit=20, colours="BuPu", power=0.6)
        show_mesh(panel, state.blocks, legend=False, width=0.4)
        panel.set(xlim=(-1, 1), ylim=(-1, 1), xticks=[], yticks=[],
                  title=f"$t$ = {state.time:g}: {state.size} active nodes")  # fmt: skip
    figure.suptitle("Vorticity of an elliptical vortex, and the blocks that hold it")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "vorticity.png", dpi=200)
