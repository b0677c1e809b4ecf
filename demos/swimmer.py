"""An eel starts from rest and finds its speed: its velocity and its wake, 3 min.

The plane swimmer of Kern & Koumoutsakos, J. Exp. Biol. 209 (2006) 4841, which reaches 0.54 L/T.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.wake import colour_limit, draw_vorticity, window
from pmesh.run.snapshots import read_snapshots

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/swimmer_demo"))
args = options.parse_args()

VISCOSITY = 1.4e-4  # [L^2/T]; lengths in body lengths, times in periods of its wave
NODES = 104 if args.quick else 160  # per length
UNTIL = 0.5 if args.quick else 6.0  # [T]
KNOWN = 0.54  # [L/T]

grid = remesh.Grid(shape=(208, 80), spacing=1 / NODES, origin=(-0.5, -0.25))  # it follows the wake
eel = pmesh.Swimmer.carling(length=1.0, period=1.0)  # free, as heavy as the fluid
flow = pmesh.VortexFlow(grid=grid, viscosity=VISCOSITY, bodies=[eel], domain="follow")
forces, ledger = pmesh.Forces(), pmesh.Ledger()
shots = pmesh.Snapshots(every=UNTIL / 6, dtype="float32")
watch = [forces, ledger, shots, pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

time, series = forces.series["time"], forces.series
place = np.stack([series["body0_x"], series["body0_y"]])
period = [np.interp([UNTIL - min(1.0, UNTIL), UNTIL], time, x) for x in place]
speed = np.hypot(*np.diff(period, axis=1)[:, 0]) / min(1.0, UNTIL)
print(f"speed over the last period: {speed:.3f} L/T, published 0.54 +- 0.04 after many")
work = np.sum(series["body0_power"][1:] * series["dt"][1:])
print(f"work that it gave to the fluid: {work:.4f} L^4/T^2")
impulse = np.hypot(ledger.series["impulse_x"], ledger.series["impulse_y"]).max()
print(f"momentum of fluid and eel, which is none: {impulse / eel.measure.volume:.1e} L/T")


@styled
def draw():
    figure, axes = panels(3, 1, (7.2, 7.2), height_ratios=(1.0, 1.1, 1.1))
    speeds, *fields = axes[:, 0]
    speeds.plot(time, -series["body0_u"], color=OURS, label="forwards")
    speeds.plot(time, series["body0_v"], color=OTHERS[0], lw=1.2, label="to the side")
    speeds.axhline(KNOWN, color=REFERENCE, ls="--", lw=1.2, label="Kern & Koumoutsakos 2006")
    speeds.set(title="Velocity", xlabel="$t / T$", ylabel="$[L/T]$", xlim=(0, UNTIL))
    speeds.legend(loc="best")
    seen = [read_snapshots(args.out)[k] for k in (3, 6)]
    limit, part = colour_limit(seen), window(seen)
    for panel, shot in zip(fields, seen, strict=True):
        draw_vorticity(panel, shot["vorticity"], shot.grid, limit, chi=shot["chi"])
        panel.set(title=f"Vorticity at $t$ = {shot.time:g}", xlim=part[:2], ylim=part[2:])
    return figure


draw().savefig(args.out / "eel.png", dpi=200)
