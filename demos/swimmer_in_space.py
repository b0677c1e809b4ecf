"""An eel in space starts from rest: its velocity and the vortices that it sheds, 3 min.

The swimmer of Kern & Koumoutsakos, J. Exp. Biol. 209 (2006) 4841, which reaches 0.40 L/T.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.swimmer_picture import draw_vortices
from pmesh.cases.track import Track
from pmesh.run.snapshots import read_snapshots

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/swimmer_in_space_demo"))
args = options.parse_args()

VISCOSITY = 1.4e-4  # [L^2/T]; lengths in body lengths, times in periods of its wave
NODES = 52 if args.quick else 64  # per length
UNTIL = 0.04 if args.quick else 1.0  # [T]
KNOWN = 0.40  # [L/T]

grid = remesh.Grid(shape=(96, 32, 32), spacing=1 / NODES, origin=(-0.75, -0.25, -0.25))
planar = pmesh.Free(locked=("z", "turn_x", "turn_y"))  # symmetry leaves these at rest
eel = pmesh.Swimmer.carling(ndim=3, motion=planar)  # half as wide as tall, as heavy as the fluid
held = pmesh.Penalisation(strength=1e4, width=1.0, tolerance=1e-4, thinnest=4)
flow = pmesh.VortexFlow(
    grid=grid, viscosity=VISCOSITY, bodies=[eel], domain="follow", penalisation=held,
    radius=1.5, dtype="float32",
)  # fmt: skip
forces, ledger = pmesh.Forces(), pmesh.Ledger()
shots = pmesh.Snapshots(every=UNTIL / 2, fields=("vorticity", "chi"), dtype="float32")
watch = [forces, ledger, shots, pmesh.Progress()]
end = pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

track = Track.read(forces.series)
first = max(UNTIL - 1.0, 0.0)
print(f"speed from t = {first:g} to {UNTIL:g}: {track.way(first, UNTIL)[1]:.3f} L/T, "
      f"published {KNOWN:.2f} after many periods")  # fmt: skip
impulse = np.linalg.norm([ledger.series[f"impulse_{axis}"] for axis in "xyz"], axis=0).max()
print(f"momentum of fluid and eel, which is none: {impulse / eel.measure.volume:.1e} L/T")


@styled
def draw():
    figure, axes = panels(2, 1, (6.4, 6.4), height_ratios=(1.0, 1.7))
    speeds, vortices = axes[:, 0]
    speeds.plot(track.time, -track.velocity[:, 0], color=OURS, label="forwards")
    speeds.plot(track.time, track.velocity[:, 1], color=OTHERS[0], lw=1.2, label="to the side")
    speeds.axhline(KNOWN, color=REFERENCE, ls="--", lw=1.2, label="Kern & Koumoutsakos 2006")
    speeds.set(title="Velocity", xlabel="$t / T$", ylabel="$[L/T]$", xlim=(0, UNTIL))
    speeds.legend(loc="best")
    draw_vortices([vortices], read_snapshots(args.out)[-1:], eel, track)
    return figure


draw().savefig(args.out / "eel.png", dpi=200)
