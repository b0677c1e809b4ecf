"""The same drag from two frames: a cylinder towed in still fluid, and one held in a stream: 30 s.

What Galileo asks of Koumoutsakos & Leonard, J. Fluid Mech. 296 (1995) 1, at Re = 550.
"""

import argparse
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.reference import cylinder_drag
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.wake import draw_vorticity

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/moving_cylinder_demo"))
args = options.parse_args()

REYNOLDS = 550.0  # U D / nu; lengths in radii, velocities in the cylinder's
CELLS = 24 if args.quick else 32  # per radius
UNTIL = 0.6 if args.quick else 4.0  # [R/U]
STEP = 0.01  # the same for both [R/U]

grid = remesh.Grid((4 * CELLS,) * 2, 1 / CELLS, (-2.0, -2.0))  # it follows the vorticity
disk = levelset.shapes.Disk(radius=1.0)
towing = pmesh.Prescribed(shift=lambda t: (-t, 0.0), velocity=lambda t: (-1.0, 0.0))
runs = {
    "held": {"freestream": (1.0, 0.0), "bodies": [pmesh.RigidBody(disk)]},
    "towed": {"bodies": [pmesh.RigidBody(disk, motion=towing)]},
}
drag, end = {}, {}
for name, what in runs.items():
    flow = pmesh.VortexFlow(grid=grid, viscosity=2 / REYNOLDS, domain="follow", **what)
    forces = pmesh.Forces()
    end[name] = pmesh.run(
        flow, flow.start(), until=UNTIL, dt=STEP, watch=[forces, pmesh.Progress()],
        out=args.out / name, overwrite=True,
    )  # fmt: skip
    time = forces.series["time"] - 0.5 * forces.series["dt"]
    drag[name] = np.interp(np.linspace(0.3, UNTIL, 200), time, forces.series["body0_force_x"])
off = np.abs(drag["towed"] / drag["held"] - 1)
print(f"towed off held, 0.3 < T < {UNTIL:g}: {100 * off.max():.2f} % at most")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.0, 3.4), width_ratios=(1.0, 1.2))
    time, known = np.linspace(0.3, UNTIL, 200), cylinder_drag(REYNOLDS)
    shown = (known.time > 0.3) & (known.time < UNTIL)
    left.plot(time, drag["held"], color=OTHERS[2], lw=3.5, label="held in a stream")
    left.plot(time, drag["towed"], color=OURS, lw=1.2, label="towed in still fluid")
    left.plot(known.time[shown], known.value[shown], "o", color=REFERENCE, mfc="white",
              label=known.source)  # fmt: skip
    left.set(title="Drag coefficient", xlabel="$T = U t / R$", xlim=(0, UNTIL), ylim=(0, 2))
    left.legend()
    around = np.linspace(0, 2 * np.pi, 97)
    circle = np.stack([np.cos(around) - UNTIL, np.sin(around)], axis=1)
    draw_vorticity(right, end["towed"].vorticity, end["towed"].grid, 6, outlines=[circle])
    right.set(title=f"Vorticity behind the towed cylinder, $T$ = {UNTIL:g}", ylim=(-2, 2))
    right.set(xlim=(-UNTIL - 1.5, 3.0 - UNTIL / 2))
    return figure


draw().savefig(args.out / "drag.png", dpi=200)
