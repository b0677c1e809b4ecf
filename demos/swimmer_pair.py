"""Two eels, one behind the other: what the wake of the first does to the second, 4 min.

The second meets vortices that the first shed; when it comes half a period later, it meets others.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, panels, styled
from pmesh.cases.wake import colour_limit, draw_vorticity, window
from pmesh.run.snapshots import read_snapshots

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/swimmer_pair_demo"))
args = options.parse_args()

VISCOSITY = 1.4e-4  # [L^2/T]; lengths in body lengths, times in periods of the wave
DISTANCE, PHASE = 0.25, 0.5  # from tail to nose [L]; of the second eel's wave [T]
NODES = 104 if args.quick else 128  # per length
UNTIL = 0.25 if args.quick else 5.0  # [T]

grid = remesh.Grid(shape=(352, 64), spacing=1 / NODES, origin=(-0.5, -0.25))
leader = pmesh.Swimmer.carling()
follower = pmesh.Swimmer.carling(position=(1.0 + DISTANCE, 0.0), phase=PHASE)
flow = pmesh.VortexFlow(grid=grid, viscosity=VISCOSITY, bodies=[leader, follower], domain="follow")
forces = pmesh.Forces()
watch = [forces, pmesh.Snapshots(every=UNTIL, dtype="float32"), pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

time, series = forces.series["time"], forces.series
last = time > UNTIL - 1.0
for k, name in enumerate(("first", "second")):
    work = np.average(series[f"body{k}_power"][last][1:], weights=series["dt"][last][1:])
    speed = -np.average(series[f"body{k}_u"][last][1:], weights=series["dt"][last][1:])
    print(f"the {name} one swims {speed:.3f} L/T with a power of {work:.4f} L^4/T^3")
gap = np.hypot(*(series[f"body1_{a}"] - series[f"body0_{a}"] for a in "xy")) - 1.0
print(f"distance from {gap[0]:.3f} to {gap[-1]:.3f} L")


@styled
def draw():
    figure, ((speeds,), (wake,)) = panels(2, 1, (7.2, 5.2))
    for k, (name, colour) in enumerate((("first", OURS), ("second", OTHERS[0]))):
        speeds.plot(time, -series[f"body{k}_u"], color=colour, label=f"the {name} one")
    speeds.set(title="Velocity towards $-x$", xlabel="$t / T$", ylabel="$[L/T]$", xlim=(0, UNTIL))
    speeds.legend(loc="best")
    shot = read_snapshots(args.out)[-1]
    part = window([shot])
    draw_vorticity(wake, shot["vorticity"], shot.grid, colour_limit([shot]), chi=shot["chi"])
    wake.set(title=f"Vorticity at $t$ = {shot.time:g}", xlim=part[:2], ylim=part[2:])
    return figure


draw().savefig(args.out / "pair.png", dpi=200)
