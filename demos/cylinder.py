"""A cylinder set in motion at once: its drag over the published curve, and its wake: 10 s.

Repeats Koumoutsakos & Leonard, J. Fluid Mech. 296 (1995) 1, at Re = 550.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.patches import Circle

import levelset
import pmesh
import remesh
from pmesh.cases.reference import cylinder_drag
from pmesh.cases.style import OURS, REFERENCE, panels, show_field, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/cylinder_demo"))
args = options.parse_args()

REYNOLDS = 550.0  # U D / nu; lengths in radii, velocities in the free stream's
CELLS = 24 if args.quick else 32  # per radius
UNTIL = 1.0 if args.quick else 5.0  # [R/U]

grid = remesh.Grid(shape=(4 * CELLS,) * 2, spacing=1 / CELLS, origin=(-2.0, -2.0))  # it grows
cylinder = pmesh.RigidBody(levelset.shapes.Disk(radius=1.0))
flow = pmesh.VortexFlow(
    grid=grid, viscosity=2 / REYNOLDS, freestream=(1.0, 0.0), bodies=[cylinder], domain="follow"
)
forces, ledger = pmesh.Forces(), pmesh.Ledger()
watch = [forces, ledger, pmesh.Snapshots(every=UNTIL / 5), pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

time = forces.series["time"] - 0.5 * forces.series["dt"]  # drag is the mean over a step
drag = forces.series["body0_force_x"]  # [rho U^2 R]: the drag coefficient
known = cylinder_drag(REYNOLDS)
late = (time > 0.3) & (time < known.span[1])
off = drag[late] / known.at(time[late]) - 1
print(f"drag off {known.source}: {100 * np.abs(off).max():.1f} % at most for 0.3 < T < {UNTIL:g}")
print(f"circulation that left the mesh: {ledger.series['lost_circulation'][-1]:.1e}")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.0, 3.4), width_ratios=(1.0, 1.2))
    shown = (known.time > 0.05) & (known.time < UNTIL)
    left.plot(time, drag, color=OURS, label=f"ours, {2 * CELLS} nodes per diameter")
    left.plot(known.time[shown], known.value[shown], "o", color=REFERENCE, mfc="white",
              label=known.source)  # fmt: skip
    left.set(title="Drag coefficient", xlabel="$T = U t / R$", xlim=(0, UNTIL), ylim=(0, 2))
    left.legend()
    show_field(right, end.vorticity, end.grid, limit=6)
    right.add_patch(Circle((0, 0), 1.0, fc="#d9d9d9", ec="#444444", lw=0.7))
    right.set(title=f"Vorticity at $T$ = {end.time:g}", xlim=(-1.5, 1.5 + UNTIL / 2), ylim=(-2, 2))
    return figure


draw().savefig(args.out / "drag.png", dpi=200)
