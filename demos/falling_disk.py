"""Two heavy disks fall, one behind the other: it drafts, they kiss, they tumble: 60 s.

The scene of Fortes, Joseph & Lundgren, J. Fluid Mech. 177 (1987) 467, in a plane. Gravity's impulse
must be found again in the disks and in the vorticity, whatever happens between them.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.wake import draw_vorticity

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/falling_disk_demo"))
args = options.parse_args()

DENSITY, PULL = 1.5, 1.0  # over the fluid's; weight less buoyancy over that of the fluid displaced
VISCOSITY = 1 / 60  # lengths in diameters, times such that PULL is 1
CELLS = 16  # per diameter
UNTIL = 1.0 if args.quick else 14.0
SHOTS = 1.0 if args.quick else 3.5

gravity = (0.0, -PULL / (DENSITY - 1))
grid = remesh.Grid((4 * CELLS, 6 * CELLS), 1 / CELLS, (-2.0, -3.0))  # it follows the vorticity
bodies = [
    pmesh.RigidBody(
        levelset.shapes.Disk(radius=0.5).moved(place),
        motion=pmesh.Free(density=DENSITY, gravity=gravity),
    )
    for place in ((0.02, 1.0), (0.0, -1.0))  # the upper one stands a little aside
]
flow = pmesh.VortexFlow(
    grid=grid, viscosity=VISCOSITY, bodies=bodies, domain="follow", deformation=0.5
)
forces, ledger = pmesh.Forces(), pmesh.Ledger()
watch = [forces, ledger, pmesh.Snapshots(every=SHOTS, dtype="float32"), pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

time, series = forces.series["time"], forces.series
place = np.array([[series[f"body{k}_{axis}"] for axis in "xy"] for k in (0, 1)])
gap = np.hypot(*(place[0] - place[1])) - 1.0
print(f"smallest gap: {gap.min() * CELLS:.2f} spacings at t = {time[gap.argmin()]:.1f}")
upper = bodies[0]  # as the lower one
excess = (upper.motion.density - 1) * upper.measure.volume  # mass beyond the fluid's
held = ledger.series["impulse_y"] + excess * (series["body0_v"] + series["body1_v"])
given = 2 * excess * gravity[1] * time
print(f"momentum off gravity's impulse: {np.abs(held - given).max() / abs(given[-1]):.1e} of it")


@styled
def draw():
    from pmesh.run.snapshots import read_snapshots

    shots = read_snapshots(args.out)[1:]
    figure, (row,) = panels(1, len(shots) + 1, (9.6, 4.2), width_ratios=[1.6] + [1.0] * len(shots))
    for k, (name, colour) in enumerate((("upper", OURS), ("lower", REFERENCE))):
        row[0].plot(time, -series[f"body{k}_v"], color=colour, label=f"the {name} one falls")
    row[0].plot(time, gap, color=OTHERS[2], ls="--", label="gap between them")
    row[0].set(title="Speeds, and the gap", xlabel="$t$", xlim=(0, UNTIL), ylim=(0, 2.1))
    row[0].legend(loc="upper left")
    around = np.linspace(0, 2 * math.pi, 97)
    circle = 0.5 * np.stack([np.cos(around), np.sin(around)], axis=1)
    for panel, shot in zip(row[1:], shots, strict=True):
        now = [[np.interp(shot.time, time, x) for x in one] for one in place]
        outlines = [circle + center for center in now]
        draw_vorticity(panel, shot["vorticity"], shot.grid, 4.0, outlines=outlines)
        x, y = np.mean(now, axis=0)
        panel.set(title=f"$t$ = {shot.time:g}", xlim=(x - 2, x + 2), ylim=(y - 2.5, y + 5.5))
    return figure


draw().savefig(args.out / "fall.png", dpi=200)
