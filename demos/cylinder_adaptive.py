"""A cylinder set in motion at once in a large box that is fine at its wall only: 20 s.

Repeats Koumoutsakos & Leonard, J. Fluid Mech. 296 (1995) 1, at Re = 550.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.patches import Circle

import levelset
import pmesh
import remesh
from pmesh.cases.mesh_picture import show_mesh, show_values
from pmesh.cases.reference import cylinder_drag
from pmesh.cases.style import OURS, REFERENCE, panels, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/cylinder_adaptive_demo"))
args = options.parse_args()

REYNOLDS = 550.0  # U D / nu; lengths in radii, velocities in the free stream's
CELLS = 24 if args.quick else 32  # per radius on the finest level
TOLERANCE = 2e-3  # relative to the largest vorticity
UNTIL = 0.6 if args.quick else 3.0  # [R/U]

h = 1 / CELLS
nodes = (512, 256)  # of the finest mesh: a box of 16 by 8 radii
origin = (-5.0 + h / 2, -128 * h + h / 2)
mesh = remesh.AdaptiveMesh(grid=remesh.Grid(nodes, h, origin), levels=3, tolerance=TOLERANCE)
cylinder = pmesh.RigidBody(levelset.shapes.Disk(radius=1.0))
flow = pmesh.VortexFlow(
    grid=mesh, viscosity=2 / REYNOLDS, freestream=(1.0, 0.0), bodies=[cylinder], kernel="L6,4"
)
forces, ledger = pmesh.Forces(), pmesh.Ledger()
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=[forces, ledger])

time = forces.series["time"] - 0.5 * forces.series["dt"]  # drag is the mean over a step
drag = forces.series["body0_force_x"]  # [rho U^2 R]: the drag coefficient
known = cylinder_drag(REYNOLDS)
late = (time > 0.3) & (time < known.span[1])
off = drag[late] / known.at(time[late]) - 1
print(f"drag off {known.source}: {100 * np.abs(off).max():.1f} % at most for 0.3 < T < {UNTIL:g}")
most = ledger.series["active"].max()
print(f"at most {most:.0f} active nodes, 1/{mesh.grid.size / most:.0f} of the finest mesh")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.0, 3.4), width_ratios=(1.0, 1.2))
    shown = (known.time > 0.05) & (known.time < UNTIL)
    left.plot(time, drag, color=OURS, label=f"ours, {2 * CELLS} nodes per diameter at the wall")
    left.plot(known.time[shown], known.value[shown], "o", color=REFERENCE, mfc="white",
              label=known.source)  # fmt: skip
    left.set(title="Drag coefficient", xlabel="$T = U t / R$", xlim=(0, UNTIL), ylim=(0, 2))
    left.legend()
    show_values(right, end.vorticity, end.blocks, limit=6)
    show_mesh(right, end.blocks, legend=False, width=0.4)
    right.add_patch(Circle((0, 0), 1.0, fc="#d9d9d9", ec="#444444", lw=0.7))
    right.set(title=f"Vorticity at $T$ = {end.time:g}", xlim=(-2.5, 4.5), ylim=(-2.4, 2.4))
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "drag.png", dpi=200)
