"""Zalesak's disk turns once: 814 particles keep it, remeshing at every step wears it off: 10 s.

The seed of particle level sets: rigid motion needs no remeshing. Where a flow does, kernels that
keep more moments keep more of the slot. Body: Zalesak, J. Comput. Phys. 31 (1979) 335.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np

import pmesh
import remesh
from levelset.contour import contour
from levelset.laws import Rotation
from levelset.shapes import SlottedDisk
from levelset.surface import contours
from levelset.transport import ParticleLevelSet
from pmesh.cases.interface_error import mean_error
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a quarter of a turn")
options.add_argument("--out", type=Path, default=Path("out/zalesak_disk_demo"))
args = options.parse_args()

STEPS = 628  # per turn
TURNS = 0.25 if args.quick else 1.0
WAYS = {  # remeshing, kernel, half width of the band in spacings
    "no remeshing": ("never", "L6,4", 3.0),
    "L6,4": ("always", "L6,4", 6.0),
    "M6'": ("always", "M6'", 6.0),
    "M4'": ("always", "M4'", 6.0),
}

disk = SlottedDisk(center=(50, 75))  # radius 15, slot 5 wide and 25 deep [L]
law = Rotation(center=(50, 50), rate=2 * np.pi)  # a turn per unit of time
grid = remesh.Grid((101, 101), spacing=1.0)
exact = disk.moved((-50, -50)).moved(angle=2 * np.pi * TURNS).moved((50, 50))
lines = {}
for name, (often, kernel, width) in WAYS.items():
    flow = ParticleLevelSet(grid=grid, velocity=law, remeshing=often, kernel=kernel, width=width)
    end = pmesh.run(flow, flow.start(disk), until=TURNS, dt=1 / STEPS)
    fine = remesh.Grid((391, 391), 0.1, np.subtract(exact.bounds()[0], 2.0))
    distance = exact.distance(fine.points())
    near = np.abs(distance) < 0.7 * width
    ours = np.array(distance)
    ours[near] = flow.rebuild(end, fine.points()[:, near].T)
    apart = mean_error(exact, partial(flow.rebuild, end), grid.spacing, reach=0.7 * width)
    area = flow.ledger(end)["volume"] / disk.area - 1
    print(f"{name:12}: {end.size:4} particles, area {100 * area:+.3f} %, {apart:.3f} cells away")
    lines[name] = contours(ours, fine)


@styled
def draw():
    figure, (row,) = panels(1, len(lines), (3.0 * len(lines), 3.5), sharex=True, sharey=True)
    for panel, (name, found), colour in zip(row, lines.items(), (OURS, *OTHERS), strict=True):
        for line in contour(exact, cells=1200):
            panel.fill(*line.T, color=REFERENCE, alpha=0.25, lw=0)
        for line in found:
            panel.plot(*line.T, color=colour, lw=1.3)
        panel.set(title=name)
        panel.set_axis_off()
        panel.set_aspect("equal")
    figure.suptitle(f"Zalesak's disk after {360 * TURNS:g} degrees in {TURNS * STEPS:g} steps")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "disk.png", dpi=200)
