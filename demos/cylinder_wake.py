"""A cylinder sheds its vortex street, which leaves through the end of a window: 1 min.

Repeats, at Re = 100, the mean drag and the lift of Wu & Shu, J. Comput. Phys. 228 (2009) 1963, and
the frequency of Williamson, Phys. Fluids 31 (1988) 2742.
"""

import argparse
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.cylinder_wake import published
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.wake import draw_vorticity
from pmesh.run.statistics import statistics

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/cylinder_wake_demo"))
args = options.parse_args()

REYNOLDS = 100.0  # U D / nu; lengths in diameters, velocities in the free stream's
CELLS = 12 if args.quick else 16  # per diameter
UNTIL = 10.0 if args.quick else 70.0  # [D/U]


def eddy(points):
    """An eddy without circulation behind the cylinder: shedding need not wait for round-off."""
    x, y = points[0] - 1.2, points[1]
    return -300 * x * np.exp(-50 * (x**2 + y**2))


start = 0.5 / CELLS - 1  # the centre in the middle of four nodes
grid = remesh.Grid((3 * CELLS, 2 * CELLS), spacing=1 / CELLS, origin=(start, start))  # it grows
cylinder = pmesh.RigidBody(levelset.shapes.Disk(radius=0.5))
window = pmesh.Window(lower=(3, 4), upper=(12, 4))  # in diameters around the cylinder
flow = pmesh.VortexFlow(
    grid=grid, viscosity=1 / REYNOLDS, freestream=(1.0, 0.0), bodies=[cylinder],
    domain="follow", window=window, deformation=0.5,
)  # fmt: skip
forces = pmesh.Forces()
watch = [forces, pmesh.Progress()]
end = pmesh.run(
    flow, flow.start(vorticity=eddy), until=UNTIL, watch=watch, out=args.out, overwrite=True
)

time, dt = forces.series["time"], forces.series["dt"]
drag, lift = 2 * forces.series["body0_force_x"], 2 * forces.series["body0_force_y"]
known, found = published(REYNOLDS), statistics(time, lift, dt)
print(f"mean drag {statistics(time, drag, dt).mean}, {known['drag'].source}: {known['drag'].value}")
if found.cycle is None:
    print(f"lift: {found.note}")
else:
    print(f"lift amplitude {found.cycle.amplitude}, published {known['lift'].value}")
    print(f"Strouhal number {found.cycle.frequency}, published {known['strouhal'].value}")


@styled
def draw():
    figure, ((top,), (below,)) = panels(2, 1, (9.0, 5.4))
    top.plot(time, drag, color=OURS, label="$C_D$")
    top.plot(time, lift, color=OTHERS[0], label="$C_L$")
    top.axhline(known["drag"].value, color=REFERENCE, ls="--", lw=1, label="mean $C_D$, published")
    for sign in (-1, 1):
        top.axhline(sign * known["lift"].value, color=REFERENCE, ls=":", lw=1)
    top.set(title="Force coefficients", xlabel="$t U / D$", xlim=(0, UNTIL), ylim=(-0.6, 2))
    top.legend(loc="upper right", ncols=3)
    field = flow.fields(end)
    draw_vorticity(below, end.vorticity, end.grid, 2.0, chi=field["chi"], label=r"$\omega D/U$")
    below.set(title=f"Vorticity at $t$ = {end.time:g}", xlim=(-1.5, 12), ylim=(-2.6, 2.6))
    return figure


draw().savefig(args.out / "wake.png", dpi=200)
