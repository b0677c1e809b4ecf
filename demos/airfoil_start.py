"""An aerofoil set in motion at once leaves a starting vortex; its lift grows by Wagner's law: 30 s.

Repeats the law of H. Wagner, Z. angew. Math. Mech. 5 (1925) 17: half of the lift is there at once.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.wagner import wagner
from pmesh.cases.wake import draw_vorticity

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/airfoil_start_demo"))
args = options.parse_args()

REYNOLDS = 1000.0  # U c / nu; lengths in chords, velocities in the free stream's
ANGLE = math.radians(8.0)  # of attack
CELLS = 80 if args.quick else 128  # per chord
UNTIL = 0.3 if args.quick else 1.5  # [c/U]

airfoil = levelset.shapes.Naca("0012").moved(angle=-ANGLE)
half = round(0.7 * CELLS)
grid = remesh.Grid((2 * half,) * 2, spacing=1 / CELLS, origin=(-half / CELLS,) * 2)  # it grows
flow = pmesh.VortexFlow(
    grid=grid, viscosity=1 / REYNOLDS, freestream=(1.0, 0.0), bodies=[pmesh.RigidBody(airfoil)],
    domain="follow", deformation=0.5,
)  # fmt: skip
forces, ledger = pmesh.Forces(), pmesh.Ledger()
watch = [forces, ledger, pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

time = forces.series["time"] - 0.5 * forces.series["dt"]  # the lift is the mean over a step
lift, drag = 2 * forces.series["body0_force_y"], 2 * forces.series["body0_force_x"]
known = 2 * math.pi * math.sin(ANGLE) * wagner(2 * np.maximum(time, 0))
late = time > 0.25
print(f"lift over Wagner's, t > 0.25: {np.min(lift[late] / known[late]):.3f} at least, "
      f"{np.max(lift[late] / known[late]):.3f} at most")  # fmt: skip
behind = end.grid.axes()[0] > 0.5 * math.cos(ANGLE) + 2 * end.grid.spacing
shed = float(end.vorticity[behind].sum()) * end.grid.cell_volume
total = ledger.series["circulation"][-1]
print(f"circulation behind the trailing edge {shed:.3f} U c, in all {total:.0e}")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.6, 3.2), width_ratios=(1.0, 1.4))
    left.plot(2 * time, lift, color=OURS, label="$C_L$, ours")
    left.plot(2 * time, known, color=REFERENCE, ls="--", label="$C_L$, Wagner, inviscid")
    left.plot(2 * time, drag, color=OTHERS[0], lw=1, label="$C_D$")
    left.set(title="Lift and drag", xlabel="travel $2 U t / c$", xlim=(0, 2 * UNTIL), ylim=(0, 1.2))
    left.legend(loc="upper right")
    draw_vorticity(right, end.vorticity, end.grid, 20.0, chi=flow.fields(end)["chi"])
    right.set(title=f"Vorticity at $t$ = {end.time:g}", xlim=(-0.7, 0.9 + UNTIL), ylim=(-0.6, 0.6))
    return figure


draw().savefig(args.out / "lift.png", dpi=200)
