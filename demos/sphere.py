"""A sphere is set in motion at once; its first drag is that of unsteady Stokes flow: 2 min.

The law is that of Basset, A treatise on hydrodynamics 2 (1888), chapter 22; the force then turns to
that of a wake, of which the first vortex ring is shown.
"""

import argparse
from pathlib import Path

import numpy as np

import levelset
import pmesh
import remesh
from pmesh.cases.sphere import FORCE
from pmesh.cases.sphere_laws import stokes_drag
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.cases.vortices import show_isosurface
from pmesh.run.snapshots import read_snapshots

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a short run")
options.add_argument("--out", type=Path, default=Path("out/sphere_demo"))
args = options.parse_args()

REYNOLDS = 100.0  # U D / nu; lengths in diameters, velocities in the free stream's
CELLS = 22  # per diameter
UNTIL = 0.1 if args.quick else 1.5  # T = U t / D

side = 28  # cells from the centre, which is in the middle of eight nodes, to the window's sides
grid = remesh.Grid((2 * side,) * 3, 1 / CELLS, ((0.5 - side) / CELLS,) * 3)  # it grows behind
sphere = pmesh.RigidBody(levelset.shapes.Sphere(radius=0.5))
flow = pmesh.VortexFlow(
    grid=grid, viscosity=1 / REYNOLDS, freestream=(1.0, 0.0, 0.0), bodies=[sphere],
    domain="follow", dtype="float32", stretching="classical",
    penalisation=pmesh.Penalisation(tolerance=1e-4),
    window=pmesh.Window(lower=(1.2, 1.2, 1.2), upper=(3, 1.2, 1.2), fade=0.5),
)  # fmt: skip
forces = pmesh.Forces()
watch = [forces, pmesh.Progress(), pmesh.Snapshots(every=UNTIL)]
pmesh.run(flow, flow.start(), until=UNTIL, watch=watch, out=args.out, overwrite=True)

end, dt = forces.series["time"][1:], forces.series["dt"][1:]
drag = FORCE * forces.series["body0_force_x"][1:]
law = stokes_drag(REYNOLDS, end - dt, end)  # means over the same steps
early = (end > 0.08) & (end < 0.1 + 1e-9)  # the mesh sees the layer, inertia counts little
off = np.abs(drag[early] / law[early] - 1).max()
print(f"drag off unsteady Stokes flow, 0.08 < T < 0.1: {off:.1%} at most, 5 % allowed")


@styled
def draw():
    figure, ((left, right),) = panels(1, 2, (9.0, 3.6), width_ratios=(1.2, 1))
    left.loglog(end, law, color=REFERENCE, ls=":", label="unsteady Stokes flow, exact")
    left.loglog(end, drag, color=OURS, label="ours")
    left.axhline(1.087, color=OTHERS[0], ls="--", lw=1, label="steady wake, published")
    left.set(title="Drag of a sphere, Re = 100", xlabel="$T = U t / D$", ylabel="$C_D$")
    left.legend()
    shot = read_snapshots(args.out)[-1]
    show_isosurface(right, shot, "lambda2", colour_by="velocity", label="speed / U")
    right.set_title(rf"Surface of $\lambda_2$ at $T$ = {shot.time:g}")
    return figure


draw().savefig(args.out / "sphere.png", dpi=200)
