"""A vortex ring travels along its axis by its own induction, 2 minutes: its speed beside the law.

The law of thin cores of Saffman, Stud. Appl. Math. 49 (1970) 371, and the exact one at the start.
"""

import argparse
from pathlib import Path

import pmesh
import remesh
from pmesh.cases.coaxial import half_plane_flux, whole_ring
from pmesh.cases.style import styled
from pmesh.cases.vortices import show_isosurface
from pmesh.run.snapshots import Snapshots, read_snapshots
from pmesh.vortex.exact import VortexRing

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/vortex_ring"))
args = options.parse_args()

CORE = 0.25 if args.quick else 0.15  # of the radius, 1 [L]; the circulation is 1 [L^2/T]
SPACING = CORE / 3  # [L]
UNTIL = 0.2 if args.quick else 2.0  # [T]

ring = VortexRing(core=CORE)
half, tall = round((1 + 6 * CORE) / SPACING / 8) * 8, round(6 * CORE / SPACING / 8) * 8
corner = (-half * SPACING, -half * SPACING, -tall * SPACING)
grid = remesh.Grid((2 * half, 2 * half, 2 * tall), SPACING, corner)
flow = pmesh.VortexFlow(grid=grid, kernel="M8'", domain="follow", order=10, radius=1.4,
                        projection=5, dtype="float32")  # fmt: skip

start = flow.start(vorticity=ring.vorticity)
shots = Snapshots(UNTIL / 2, fields=["vorticity"])
end = pmesh.run(flow, start, until=UNTIL, watch=[shots], out=args.out, overwrite=True)

first, last = (whole_ring(state.vorticity, state.grid) for state in (start, end))
print(f"speed {(last.height - first.height) / UNTIL:.4f}, at the start exactly "
      f"{ring.centroid_speed:.4f}, of a thin ring {ring.speed:.4f}")  # fmt: skip
gamma = [half_plane_flux(state.vorticity, state.grid) for state in (start, end)]
print(f"circulation {gamma[1]:.6f}, drift {gamma[1] / gamma[0] - 1:+.1e}")


@styled
def draw():
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    bounds = ((-1.3, -1.3, -0.4), (1.3, 1.3, 0.4 + last.height))
    for panel, shot in zip(figure.subplots(1, 3), read_snapshots(args.out), strict=True):
        show_isosurface(panel, shot, "vorticity", bounds=bounds, box=True, size=(700, 600))
        panel.set_title(f"$t$ = {shot.time:g}")
    figure.suptitle("A vortex ring on its way")
    return figure


draw().savefig(args.out / "ring.png", dpi=200)
