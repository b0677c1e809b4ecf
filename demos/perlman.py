"""Velocity errors of Green's functions of order 2 to 10 fall as claimed: 5 s.

Repeats the patch of Perlman (1985), with the Green's functions of Hejlesen et al. (2013).
The patch is only C^6 at its edge, which holds order 10 back at about 8.5.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, panels, styled
from pmesh.vortex.exact import PerlmanPatch

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="three coarse meshes")
options.add_argument("--out", type=Path, default=Path("out/perlman"))
args = options.parse_args()

ORDERS = (2, 4, 6, 8, 10)
CELLS = (8, 16, 32) if args.quick else (16, 32, 64, 128)  # per radius

exact = PerlmanPatch(p=7)  # w = (1 - r^2)^7 inside r = 1
errors = np.zeros((len(ORDERS), len(CELLS)))
for j, cells in enumerate(CELLS):
    half = round(1.1 * cells)
    grid = remesh.Grid((2 * half + 1,) * 2, spacing=1 / cells, origin=(-half / cells,) * 2)
    points = grid.points()
    known = exact.velocity(points)
    for i, order in enumerate(ORDERS):
        ours = pmesh.velocity(exact.vorticity(points), grid, order=order)
        errors[i, j] = np.linalg.norm(ours - known) / np.linalg.norm(known)

slopes = np.log2(errors[:, -2] / errors[:, -1])
for order, error, slope in zip(ORDERS, errors, slopes, strict=True):
    print(
        f"order {order:2d}: error {error[-1]:.1e} at h = 1/{CELLS[-1]}, measured order {slope:.2f}"
    )


@styled
def draw():
    figure, ((panel,),) = panels(1, 1, (5.2, 4.0))
    for order, error, colour in zip(
        ORDERS, errors, ("#08306b", "#2171b5", "#6baed6", "#9e9ac8", "#6a51a3"), strict=True
    ):
        panel.loglog(CELLS, error, "o-", color=colour, label=f"order {order}")
    panel.axhline(1e-3, color=OTHERS[2], lw=0.9, ls=(0, (4, 3)), label="asked at 1/64")
    panel.set_xticks(CELLS, labels=[f"1/{n}" for n in CELLS])
    panel.minorticks_off()
    panel.set(title="Perlman's patch: relative L2 error of the velocity", xlabel="spacing $h$")
    panel.legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "orders.png", dpi=200)
